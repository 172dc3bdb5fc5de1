#include "coupling/bedload_dem/script_gravity.hpp"

#include <mpi.h>

#include "atom.h"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "fix.h"
#include "lammps.h"
#include "liggghts_styles/gravity_fixes.hpp"
#include "modify.h"

namespace bedload {
namespace {

constexpr int everybody = ~0;

/// They know their vectors when they have acted.
void let_gravity_act(LAMMPS_NS::Modify& modify) {
  for (int n = 0; n < modify.n_fixes_style_strict("gravity"); ++n) {
    LAMMPS_NS::Fix* const fix = modify.find_fix_style_strict("gravity", n);
    fix->init();
    fix->post_force(0);
  }
}

}  // namespace

ScriptGravity script_gravity(LAMMPS_NS::LAMMPS* lmp, const std::function<bool(int i)>& counts,
                             Moment moment) {
  if (moment == Moment::before_run) let_gravity_act(*lmp->modify);
  const GravityFixes gravity(lmp);
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  ScriptGravity found{!gravity.none(), gravity.on(everybody), std::nullopt};
  const std::optional<int> first = lowest_tag(*lmp, counts);
  if (!first) return found;
  found.value = {};
  for (int i = 0; i < atom.nlocal; ++i)
    if (atom.tag[i] == *first) found.value = gravity.on(atom.mask[i]);
  // All ranks but the sphere's own add zero.
  MPI_Allreduce(MPI_IN_PLACE, found.value.data(), 3, MPI_DOUBLE, MPI_SUM, lmp->world);
  found.other =
      lowest_tag(*lmp, [&](int i) { return counts(i) && gravity.on(atom.mask[i]) != found.value; });
  return found;
}

}  // namespace bedload
