#pragma once

#include "lmptype.h"
#include "pointers.h"

namespace bedload {

/// Warns once where neighbour lists outlive the way for which they are made: LIGGGHTS finds
/// contacts among the pairs that were nearer than the skin when it built its lists, and
/// `neigh_modify` may let it build them as seldom as one likes.
class OldLists : protected LAMMPS_NS::Pointers {
 public:
  explicit OldLists(LAMMPS_NS::LAMMPS* lmp) : Pointers(lmp) {}

  /// After a fluid step of length `fluid_time_step` [T]. Collective.
  void look(double fluid_time_step);

 private:
  bool outlived(double fluid_time_step);
  double largest_speed() const;

  LAMMPS_NS::bigint built_at_ = -1;  ///< step of LIGGGHTS in which the lists were made
  bool moved_far_ = false;           ///< a sphere had moved half a skin one fluid step before
  double way_ = 0.0;                 ///< longest a sphere may have moved since [L], `check no`
  bool told_ = false;
};

}  // namespace bedload
