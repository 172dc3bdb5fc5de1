#pragma once

#include <vector>

#include "coupling/exchange/message.hpp"

namespace LAMMPS_NS {
class Atom;
class Fix;
class Modify;
}  // namespace LAMMPS_NS

namespace bedload {

/// Forces and torques on this rank's own atoms.
struct ForcesOnAtoms {
  std::vector<Triple> force, torque;
};

/// The fixes behind the one at `place` that take components out of the forces they find (a sphere
/// held in its plane, say), in their order.
std::vector<LAMMPS_NS::Fix*> projecting_fixes(const LAMMPS_NS::Modify& modify, int place);

/// What `fixes` leave of the loads `force` and `torque` of the rank's own atoms, as if there were
/// no other force.
ForcesOnAtoms projected_loads(LAMMPS_NS::Atom& atom, double** force, double** torque,
                              const std::vector<LAMMPS_NS::Fix*>& fixes);

}  // namespace bedload
