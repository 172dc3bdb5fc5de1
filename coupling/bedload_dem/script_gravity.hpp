#pragma once

#include <functional>
#include <optional>

#include "coupling/exchange/message.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// What the fixes gravity of a LIGGGHTS script, any number of them and each for its group, come to.
struct ScriptGravity {
  bool stated;   ///< there is such a fix
  Triple value;  ///< on the sphere of the lowest tag that counts; of all fixes if none does [L/T^2]
  std::optional<int> other;  ///< tag of a sphere that counts and has another gravity than that one
};

/// When a script is looked at. Before a run fixes are let act to be asked, and their forces are
/// cleared before the first step; during one they have acted, and must not once more.
enum class Moment : bool { before_run, during_run };

/// Collective.
/// @param counts whether the gravity of the rank's own atom i matters
ScriptGravity script_gravity(LAMMPS_NS::LAMMPS* lmp, const std::function<bool(int i)>& counts,
                             Moment moment = Moment::before_run);

}  // namespace bedload
