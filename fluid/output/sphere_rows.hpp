#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

#include "fluid/grid/sphere.hpp"

namespace bedload {

/// A row of the table of samples on its way into the file: one mobile sphere at one instant, or a
/// share of the load on it that another rank holds (radius 0).
struct SphereRow {
  std::int64_t sample = 0;  ///< number of the instant in the batch
  std::int64_t tag = 0;
  std::int64_t place = 0;  ///< in the batch, ascending instants and tags
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double radius = 0.0;
};

/// This rank's part of a batch, and how many rows each instant has.
struct SphereRows {
  std::vector<SphereRow> mine;
  std::vector<std::uint64_t> of_sample;  ///< on all ranks together
};

/// Puts a batch of rows that lie on the ranks anyhow into the order of instants and tags: even
/// shares, the first rank's first, so that no rank holds more the more ranks there are; all on the
/// first rank where they are no more than `few`. Loads of one sphere are added up; those of a
/// sphere that is gone are left out. Collective.
/// @param rows this rank's, their places open  @param samples instants in the batch
SphereRows ordered_by_tag(MPI_Comm comm, const std::vector<SphereRow>& rows, std::size_t samples,
                          std::uint64_t few);

}  // namespace bedload
