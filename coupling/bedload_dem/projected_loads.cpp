#include "coupling/bedload_dem/projected_loads.hpp"

#include <algorithm>
#include <string_view>

#include "atom.h"
#include "fix.h"
#include "liggghts_styles/mobility.hpp"
#include "modify.h"

namespace bedload {
namespace {

ForcesOnAtoms forces_on(const LAMMPS_NS::Atom& atom) {
  ForcesOnAtoms forces;
  for (int i = 0; i < atom.nlocal; ++i) {
    forces.force.push_back(triple(atom.f[i]));
    forces.torque.push_back(triple(atom.torque[i]));
  }
  return forces;
}

}  // namespace

std::vector<LAMMPS_NS::Fix*> projecting_fixes(const LAMMPS_NS::Modify& modify, int place) {
  std::vector<LAMMPS_NS::Fix*> found;
  for (int n = place + 1; n < modify.nfix; ++n) {
    const std::string_view style(modify.fix[n]->style);
    if (style == "freeze" || projects_forces(style)) found.push_back(modify.fix[n]);
  }
  return found;
}

ForcesOnAtoms projected_loads(LAMMPS_NS::Atom& atom, double** force, double** torque,
                              const std::vector<LAMMPS_NS::Fix*>& fixes) {
  const ForcesOnAtoms all = forces_on(atom);
  for (int i = 0; i < atom.nlocal; ++i) {
    std::copy_n(force[i], 3, atom.f[i]);
    std::copy_n(torque[i], 3, atom.torque[i]);
  }
  for (LAMMPS_NS::Fix* const fix : fixes) fix->post_force(0);
  ForcesOnAtoms loads = forces_on(atom);
  for (int i = 0; i < atom.nlocal; ++i) {
    const auto n = static_cast<std::size_t>(i);
    std::copy(all.force[n].begin(), all.force[n].end(), atom.f[i]);
    std::copy(all.torque[n].begin(), all.torque[n].end(), atom.torque[i]);
  }
  return loads;
}

}  // namespace bedload
