#include "coupling/bedload_dem/coupled_spheres.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "atom.h"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "domain.h"
#include "fix.h"
#include "fluid/kernels/fnv.hpp"
#include "lammps.h"
#include "modify.h"

namespace bedload {

std::vector<StateRecord> CoupledSpheres::states(bool with_fixed, const double* const* overlaps,
                                                const std::function<bool(int)>& is_new) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  std::vector<StateRecord> records;
  for (int i = 0; i < atom.nlocal; ++i) {
    const bool mobile = is_mobile(atom.mask[i]);
    if (!mobile && !(with_fixed && is_fixed(atom.mask[i]))) continue;
    Triple position = triple(atom.x[i]);
    lmp_->domain->remap(position.data());
    records.push_back({atom.tag[i], position, triple(atom.v[i]), triple(atom.omega[i]),
                       atom.radius[i], mobile ? atom.density[i] : 0.0, mobile ? 1 : 0,
                       mobile && overlaps != nullptr ? triple(overlaps[i]) : Triple{},
                       mobile && is_new && is_new(i) ? 1 : 0});
  }
  return records;
}

// FNV-1a of each sphere, and their exclusive or.
std::uint64_t CoupledSpheres::fingerprint_of_fixed() const {
  std::uint64_t all = 0;
  for (const StateRecord& sphere : states(true)) {
    if (sphere.mobile != 0) continue;
    std::uint64_t hash = fnv_start;
    for (const std::uint64_t word :
         std::bit_cast<std::array<std::uint64_t, sizeof(StateRecord) / 8>>(sphere))
      hash = fnv_mixed(hash, word);
    all ^= hash;
  }
  return reduced(all, MPI_UINT64_T, MPI_BXOR, lmp_->world);
}

double CoupledSpheres::largest_radius() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  double largest = 0.0;
  for (int i = 0; i < atom.nlocal; ++i)
    if (contains(atom.mask[i])) largest = std::max(largest, atom.radius[i]);
  // As LIGGGHTS itself finds out how far neighbours may be.
  for (int n = 0; n < lmp_->modify->nfix; ++n) {
    LAMMPS_NS::Fix& fix = *lmp_->modify->fix[n];
    if (!fix.use_rad_for_cut_neigh_and_ghost()) continue;
    for (int type = 1; type <= atom.ntypes; ++type) largest = std::max(largest, fix.max_rad(type));
  }
  return reduced(largest, MPI_DOUBLE, MPI_MAX, lmp_->world);
}

}  // namespace bedload
