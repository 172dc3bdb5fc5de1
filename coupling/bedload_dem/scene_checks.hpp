#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string_view>

#include "coupling/bedload_dem/coupled_spheres.hpp"
#include "coupling/bedload_dem/script_gravity.hpp"
#include "liggghts_styles/gravity_fixes.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

class DemSide;
struct Box;

/// What neither the lines of a script nor its fixes may do to the scene that the fluid computes
/// with. Each check ends LIGGGHTS with a sentence, on all ranks, where it does not say otherwise;
/// all but check_motion() are collective. What they warn of is said once.
class SceneChecks {
 public:
  /// @param side LIGGGHTS' end of the exchange; has to outlive this
  SceneChecks(LAMMPS_NS::LAMMPS* lmp, const CoupledSpheres& spheres, DemSide* side)
      : lmp_(lmp), spheres_(spheres), side_(side) {}

  /// A sphere has a position, speed, size or density that is not finite.
  void check_finite() const;
  /// Box, gravity or fluid values are no more those that the fluid was told; nothing before that.
  /// @param since what may have changed them: "since the coupled_run before"
  void check_scene(std::string_view since, Moment moment) const;
  /// A mobile sphere has a speed but no fix moves it; warns where it has none, and where a fixed
  /// one has.
  void check_integrated();
  /// Two fixes move the same mobile sphere, twice as far as it should go.
  void check_moved_once() const;
  /// Warns of spheres that are not in the fluid, and of mobile ones that a fix freeze has, which
  /// holds those at rest alone.
  void warn_of_group();
  /// A fix that holds mobile spheres, or keeps them in a plane or line, acts before the fluid's
  /// loads come, which would move them all the same.
  /// @param place of fix couple/fluid among the fixes
  void check_order(int place) const;
  /// A mobile sphere has left the box, is too deep in a wall or moves by more than its radius in a
  /// step, or box or time step are no more those that the fluid computes with. Ends the job, on
  /// the rank that sees it.
  /// @param fluid_time_step [T]
  /// @param deepest in walls, in radii
  void check_motion(double fluid_time_step, double deepest) const;
  /// The script has given mobile spheres other numbers.
  /// @param told_tag number by which the fluid knows this rank's atom i; 0: it does not
  void check_tags(const std::function<double(int i)>& told_tag) const;
  /// A fix moves a fixed sphere, or the fixed ones are no more those that the fluid received.
  void check_fixed() const;
  /// The latter, where no line of the script came between.
  void check_fixed_during_run() const;
  /// A fix gravity is no more what it was when the run began (a variable makes it). Ends the job,
  /// on the rank that sees it.
  void check_gravity_during_run() const;

  /// The fluid receives the fixed spheres as they are now. Collective.
  void note_fixed() { told_fixed_ = spheres_.fingerprint_of_fixed(); }
  /// The run begins with the gravity of now.
  void note_gravity() { gravity_ = GravityFixes(lmp_); }

 private:
  void check_box_and_step(const Box& box, double fluid_time_step) const;
  void check_prescribed() const;
  void warn_once(std::string_view what, std::string_view sentence);

  LAMMPS_NS::LAMMPS* lmp_;
  CoupledSpheres spheres_;
  DemSide* side_;
  std::set<std::string_view> warned_;  ///< of what; string literals
  GravityFixes gravity_;               ///< of the script when the run began
  std::uint64_t told_fixed_ = 0;       ///< fingerprint of the fixed spheres that the fluid received
};

}  // namespace bedload
