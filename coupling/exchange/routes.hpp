#pragma once

#include <vector>

#include "coupling/exchange/message.hpp"
#include "fluid/grid/block_map.hpp"

namespace bedload {

/// Which rank of one program sends to which rank of the other. A rank of LIGGGHTS and one of the
/// fluid are partners when a sphere in the one's part of the box can be near the other's block; in
/// every stage partners send each other one message, which holds the spheres that concern the
/// receiver. Who are partners is found once, by LIGGGHTS' ranks, whose parts do not change.

/// Fluid rank that tells rank `dem_rank` of LIGGGHTS what it has to know of the scene.
inline int source_rank(int dem_rank, int fluid_ranks) { return dem_rank % fluid_ranks; }

/// Ranks of LIGGGHTS that fluid rank `fluid_rank` tells.
inline std::vector<int> target_ranks(int fluid_rank, int fluid_ranks, int dem_ranks) {
  std::vector<int> ranks;
  for (int dem = 0; dem < dem_ranks; ++dem)
    if (source_rank(dem, fluid_ranks) == fluid_rank) ranks.push_back(dem);
  return ranks;
}

/// Where a rank of LIGGGHTS has its atoms [L].
struct Region {
  Triple low, high;
  double margin;          ///< how far beyond atoms may be between two exchanges
  double largest_radius;  ///< of the spheres that may come
};

/// The partners of a rank of LIGGGHTS, ascending.
inline std::vector<int> partners_of(const Region& region, const BlockMap& blocks) {
  const Vec3 low = vec3(region.low), high = vec3(region.high);
  std::vector<int> ranks;
  blocks.near(0.5 * (low + high),
              0.5 * (high - low) + Vec3::Constant(region.margin + region.largest_radius),
              [&](int rank) { ranks.push_back(rank); });
  return ranks;
}

}  // namespace bedload
