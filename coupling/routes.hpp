#pragma once

#include <vector>

namespace bedload {

/// Which rank of one program speaks to which rank of the other. Today every fluid rank knows all
/// spheres and the complete loads, so that loads come from one fluid rank per LIGGGHTS rank and
/// states go to all. Sending a sphere's record only to the fluid ranks that its markers touch
/// replaces these functions; the two ends take the lists as they come.

/// Fluid rank that sends the loads to rank `dem_rank` of LIGGGHTS.
inline int load_sender(int dem_rank, int fluid_ranks) { return dem_rank % fluid_ranks; }

/// LIGGGHTS ranks that fluid rank `fluid_rank` sends the loads to.
inline std::vector<int> load_receivers(int fluid_rank, int fluid_ranks, int dem_ranks) {
  std::vector<int> receivers;
  for (int dem = 0; dem < dem_ranks; ++dem)
    if (load_sender(dem, fluid_ranks) == fluid_rank) receivers.push_back(dem);
  return receivers;
}

/// Fluid ranks that each LIGGGHTS rank sends its states to.
inline std::vector<int> state_receivers(int fluid_ranks) {
  std::vector<int> receivers(static_cast<std::size_t>(fluid_ranks));
  for (int fluid = 0; fluid < fluid_ranks; ++fluid)
    receivers[static_cast<std::size_t>(fluid)] = fluid;
  return receivers;
}

}  // namespace bedload
