#pragma once

#include <cstddef>

namespace bedload {

/// How a sweep through the planes takes them: `planes` at a time, `rows` rows of all of these
/// before the next rows, so that a plane is still in the cache when its neighbour needs it.
struct Tiles {
  int planes, rows;
};

/// One plane at a time where the third-level cache holds two, which no choice of rows was faster
/// than; else few rows of several planes. A sweep takes some eight numbers a cell.
template <class Real>
constexpr Tiles tiles(int nx, int nz) {
  constexpr std::size_t large_plane = 6 << 20, tile = 5 << 17;
  const std::size_t row = 8 * sizeof(Real) * static_cast<std::size_t>(nx);
  const int most = static_cast<int>(tile / row);
  if (row * static_cast<std::size_t>(nz) <= large_plane || most < 2) return {1, nz};
  const int count = (nz + most - 1) / most;
  return {8, (nz + count - 1) / count};
}

/// The same for the sweeps of the pressure's modes and of the correction, which take fewer numbers:
/// one plane at a time up to larger planes.
template <class Real>
constexpr Tiles pressure_tiles(int nx, int nz) {
  constexpr std::size_t large_plane = 16 << 20;
  const std::size_t row = 8 * sizeof(Real) * static_cast<std::size_t>(nx);
  if (row * static_cast<std::size_t>(nz) <= large_plane) return {1, nz};
  return tiles<Real>(nx, nz);
}

}  // namespace bedload
