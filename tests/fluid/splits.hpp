#pragma once

#include <mpi.h>

#include <vector>

namespace bedload {

/// Every way to divide `ranks` ranks along y and z: the numbers of blocks along z.
inline std::vector<int> splits(int ranks) {
  std::vector<int> all;
  for (int z_parts = 1; z_parts <= ranks; ++z_parts)
    if (ranks % z_parts == 0) all.push_back(z_parts);
  return all;
}

}  // namespace bedload
