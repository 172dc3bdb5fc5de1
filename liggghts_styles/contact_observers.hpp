#pragma once

#include <string_view>
#include <vector>

namespace LAMMPS_NS {
class Fix;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace bedload {

/// Contact models that report, in the words of a sentence.
inline constexpr std::string_view known_models =
    "normal actm, rpm, hertz or hooke, the last two with tangential history, haff_werner or none, "
    "without cohesion, and with rolling friction beside haff_werner alone";

/// Which contact models tell a fix of ours what they see: that of the pairs, and those of which
/// walls. They report when a run is initialised, the pairs first.
class ContactObservers {
 public:
  /// @param wall fix of the wall; none: the pairs
  void add(const LAMMPS_NS::Fix* wall);

  /// From the fix's init(): ends the run with one sentence if the pairs have not reported.
  void check_pairs(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

  /// From its setup(), when all walls are initialised: the same for a wall that spheres of the
  /// fix's group may meet. Collective.
  void check_walls(LAMMPS_NS::LAMMPS* lmp, std::string_view style, int groupbit) const;

 private:
  bool pairs_ = false;
  std::vector<const LAMMPS_NS::Fix*> walls_;
};

/// Ends the run where the script leaves LIGGGHTS' `newton on`: a pair across the border of two
/// ranks or a periodic end is listed once then, and a style that acts on each rank's own spheres
/// misses half of it. Models with a history need newton off anyway.
void refuse_newton(LAMMPS_NS::LAMMPS* lmp, std::string_view style);

}  // namespace bedload
