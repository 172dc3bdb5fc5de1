#include "coupling/bedload_dem/overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "atom.h"
#include "force.h"
#include "lammps.h"
#include "liggghts_styles/mobility.hpp"
#include "neigh_list.h"
#include "pair.h"

namespace bedload {
namespace {

/// Adds the overlap of sphere i, free and of this rank, with the walls along d.
void add_walls(const LAMMPS_NS::Atom& atom, int i, std::size_t d, double length, Triple& overlap) {
  const double below = atom.radius[i] - atom.x[i][d],
               above = atom.x[i][d] + atom.radius[i] - length;
  overlap[d] += std::max(above, 0.0) - std::max(below, 0.0);
}

}  // namespace

std::vector<Triple> overlaps_of(LAMMPS_NS::LAMMPS* lmp, const CoupledSpheres& spheres,
                                const Triple& length, const std::array<bool, 3>& walls) {
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  const auto own = static_cast<std::size_t>(atom.nlocal);
  std::vector<Triple> overlaps(own, Triple{});
  const auto give = [&](int i, double amount, const Vec3& n) {
    if (i >= atom.nlocal || amount == 0.0) return;
    Triple& overlap = overlaps[static_cast<std::size_t>(i)];
    for (std::size_t d = 0; d < 3; ++d) overlap[d] += amount * n[static_cast<Eigen::Index>(d)];
  };
  const Mobility mobility(lmp);
  // What forces move; fixed spheres and those moved as prescribed are meant to be where they are.
  const auto gives_way = [&](int i) {
    return spheres.is_mobile(atom.mask[i]) && !mobility.held(atom.mask[i]);
  };
  const auto inverse_mass = [&](int i) { return gives_way(i) ? 1.0 / atom.rmass[i] : 0.0; };

  for (int i = 0; i < atom.nlocal; ++i)
    for (std::size_t d = 0; d < 3; ++d)
      if (walls[d] && gives_way(i))
        add_walls(atom, i, d, length[d], overlaps[static_cast<std::size_t>(i)]);

  const LAMMPS_NS::Pair* const pair = lmp->force->pair_match("gran", 0);  // of a hybrid, too
  const LAMMPS_NS::NeighList* const list = pair == nullptr ? nullptr : pair->list;
  for (int n = 0; list != nullptr && n < list->inum; ++n) {
    const int i = list->ilist[n];
    if (!spheres.contains(atom.mask[i])) continue;
    const Vec3 x(atom.x[i]);
    for (int m = 0; m < list->numneigh[i]; ++m) {
      const int j = list->firstneigh[i][m] & NEIGHMASK;
      if (!spheres.contains(atom.mask[j])) continue;
      const Vec3 way = Vec3(atom.x[j]) - x;
      const double reach = atom.radius[i] + atom.radius[j], square = way.squaredNorm();
      if (square >= reach * reach || square == 0.0) continue;
      const double by_i = inverse_mass(i), by_j = inverse_mass(j);
      if (by_i + by_j == 0.0) continue;
      const double distance = std::sqrt(square), depth = reach - distance;
      give(i, share_of_overlap(by_i, by_j) * depth, way / distance);
      give(j, share_of_overlap(by_j, by_i) * depth, -way / distance);
    }
  }
  return overlaps;
}

}  // namespace bedload
