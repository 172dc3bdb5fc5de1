#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "fluid/kernels/tiles.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {

/// compute(grid, decomposition, tiles) gives the same numbers, to the last digit, with planes taken
/// some at a time, tile by tile, as one after the other, on every kind of box and split along z.
template <class Compute>
void expect_equal_tiles(Compute compute) {
  for (const Ends& ends : {Ends{periodic, open_channel, periodic}, Ends{no_slip, no_slip, no_slip},
                           Ends{periodic, periodic, periodic}})
    for (const int z_parts : splits(world_size())) {
      Settings s = box({18, 24, 22}, 0.1, 1e-3, 0.01);
      set_ends(s, ends);
      const Grid grid = make_grid(s);
      const Decomposition decomposition(grid, MPI_COMM_WORLD,
                                        even_cuts(grid, world_size(), z_parts));
      const auto one_by_one = compute(grid, decomposition, Tiles{1, decomposition.rows()});
      for (const Tiles tiles : {Tiles{2, 1}, Tiles{3, 2}, Tiles{8, 5}, Tiles{30, 2}, Tiles{4, 22}})
        EXPECT_EQ(compute(grid, decomposition, tiles), one_by_one)
            << tiles.planes << " planes, " << tiles.rows << " rows";
    }
}

}  // namespace bedload
