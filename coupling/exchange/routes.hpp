#pragma once

#include <vector>

#include "coupling/exchange/message.hpp"
#include "fluid/grid/block_map.hpp"

namespace bedload {

/// Which rank of one program sends to which rank of the other. A rank of LIGGGHTS and one of the
/// fluid are partners when a sphere in the one's part of the box can be near the other's block; in
/// every stage partners send each other one message, which holds the spheres that concern the
/// receiver. Who are partners is found once, by LIGGGHTS' ranks, whose parts do not change.

/// What concerns all ranks (the scene, a checkpoint) each rank hears from one rank of the other
/// program; so no rank sends more messages the more ranks there are. This is the one that tells
/// `rank`.
inline int source_rank(int rank, int ranks_of_other) { return rank % ranks_of_other; }

/// The ranks of the other program that `rank` of `ranks` tells.
inline std::vector<int> target_ranks(int rank, int ranks, int ranks_of_other) {
  std::vector<int> targets;
  for (int other = rank; other < ranks_of_other; other += ranks) targets.push_back(other);
  return targets;
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
