#include "coupling/bedload_dem/script_gravity.hpp"

#include <mpi.h>

#include <vector>

#include "atom.h"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "fix_gravity.h"
#include "lammps.h"
#include "modify.h"

namespace bedload {
namespace {

constexpr int everybody = ~0;

struct Pull {
  int groupbit;
  Triple vector;
};

std::vector<Pull> pulls_of(LAMMPS_NS::Modify& modify) {
  std::vector<Pull> pulls;
  for (int n = 0; n < modify.n_fixes_style_strict("gravity"); ++n) {
    auto* const fix =
        static_cast<LAMMPS_NS::FixGravity*>(modify.find_fix_style_strict("gravity", n));
    // It knows its vector only after these.
    fix->init();
    fix->post_force(0);
    Pull pull{fix->groupbit, {}};
    fix->get_gravity(pull.vector.data());
    pulls.push_back(pull);
  }
  return pulls;
}

Triple sum_on(int mask, const std::vector<Pull>& pulls) {
  Triple sum{};
  for (const Pull& pull : pulls)
    if ((mask & pull.groupbit) != 0)
      for (std::size_t d = 0; d < 3; ++d) sum[d] += pull.vector[d];
  return sum;
}

}  // namespace

ScriptGravity script_gravity(LAMMPS_NS::LAMMPS* lmp, const std::function<bool(int i)>& counts) {
  const std::vector<Pull> pulls = pulls_of(*lmp->modify);
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  ScriptGravity found{!pulls.empty(), sum_on(everybody, pulls), std::nullopt};
  const std::optional<int> first = lowest_tag(*lmp, counts);
  if (!first) return found;
  found.value = {};
  for (int i = 0; i < atom.nlocal; ++i)
    if (atom.tag[i] == *first) found.value = sum_on(atom.mask[i], pulls);
  // All ranks but the sphere's own add zero.
  MPI_Allreduce(MPI_IN_PLACE, found.value.data(), 3, MPI_DOUBLE, MPI_SUM, lmp->world);
  found.other = lowest_tag(
      *lmp, [&](int i) { return counts(i) && sum_on(atom.mask[i], pulls) != found.value; });
  return found;
}

}  // namespace bedload
