#include "fluid/grid/division.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fluid/grid/block_map.hpp"
#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

// In units of a cell's time in a stage; measured on one rank, but for value_cost (README.md, "On
// many ranks").
constexpr double loop_cost = 5.0;      // a marker in one loop of forcing
constexpr double placing_cost = 25.0;  // a mobile sphere's marker: found and weighed
constexpr double up_share = 0.7;       // of a cell's time: predictor and the way up
constexpr double up_carried = 0.09;    // more in a slab that carries the plane below it along
constexpr double down_carried = 0.10;  // the same on the way down
constexpr double value_cost = 0.4;     // a number packed, sent, received and unpacked

/// Cells along one direction that a sphere covers, with the share of its extent in each.
struct Cover {
  int cell;
  double share;
};

std::vector<Cover> cover(const Grid& grid, const SphereState& sphere, int direction) {
  const int cells = grid.cells[static_cast<std::size_t>(direction)];
  const double diameter = 2.0 * sphere.radius / grid.h;  // in cells
  const double low = sphere.position[direction] / grid.h - 0.5 * diameter, high = low + diameter;
  std::vector<Cover> covered;
  for (int n = static_cast<int>(std::floor(low)); n < high; ++n) {
    const double inside = std::min(high, n + 1.0) - std::max(low, double(n));
    const int cell =
        grid.periodic(direction) ? ((n % cells) + cells) % cells : std::clamp(n, 0, cells - 1);
    covered.push_back({cell, inside / diameter});
  }
  return covered;
}

/// Notes which cuts a sphere concerns on both sides (BlockMap); crossed[n]: the one before cell n.
void note_crossed(const Grid& grid, const SphereState& sphere, int direction,
                  std::vector<char>& crossed) {
  const int cells = grid.cells[static_cast<std::size_t>(direction)];
  const double middle = sphere.position[direction] / grid.h;
  const double width = sphere.radius / grid.h + BlockMap::reach;
  for (int n = static_cast<int>(std::floor(middle - width)) + 1; n < middle + width; ++n) {
    const int cut = grid.periodic(direction) ? ((n % cells) + cells) % cells : n;
    if (grid.periodic(direction) || (cut > 0 && cut < cells))
      crossed[static_cast<std::size_t>(cut)] = 1;
  }
}

/// Whether the slab that begins with this plane carries the plane below along as an unknown
/// (slab_elimination.hpp): all but the one on a lower wall.
bool carries(const Grid& grid, int first) { return first > 0 || grid.periodic(1); }

bool fits(const Grid& grid, int y_parts, int z_parts) {
  return y_parts <= grid.cells[1] && z_parts <= grid.cells[2];
}

/// Whether `z_parts` blocks along z (0: some number of them) give each of `ranks` a block.
bool divisible(const Grid& grid, int ranks, int z_parts = 0) {
  for (int parts = 1; parts <= ranks; ++parts)
    if (ranks % parts == 0 && (z_parts == 0 || parts == z_parts) &&
        fits(grid, ranks / parts, parts))
      return true;
  return false;
}

[[noreturn]] void refuse(const Grid& grid, int ranks, int z_parts) {
  if (z_parts > 0 && ranks % z_parts != 0)
    throw UserError(fmt::format(
        "'ranks.along_z' is {}, but must divide the number of fluid ranks, {}.", z_parts, ranks));
  if (z_parts > 0)
    throw UserError(fmt::format(
        "'ranks.along_z' = {} makes {} x {} blocks (y x z) of {} fluid ranks, but 'grid.cells' has "
        "only {} planes along y and {} rows along z.",
        z_parts, ranks / z_parts, z_parts, ranks, grid.cells[1], grid.cells[2]));
  int fewer = ranks;
  while (!divisible(grid, fewer)) --fewer;
  throw UserError(fmt::format(
      "The fluid runs on {} ranks, but the {} planes along y and {} rows along z of 'grid.cells' "
      "cannot be divided into as many blocks; use {} fluid ranks.",
      ranks, grid.cells[1], grid.cells[2], fewer));
}

}  // namespace

ForcingWork::ForcingWork(const Grid& grid, std::span<const SphereState> spheres,
                         const Settings::Spheres& settings)
    : rows_count_(grid.cells[2]),
      planes_(static_cast<std::size_t>(grid.cells[1]), 0.0),
      rows_(static_cast<std::size_t>(grid.cells[2]), 0.0),
      below_((planes_.size() + 1) * (rows_.size() + 1), 0.0),
      plane_crossed_(planes_.size(), 0),
      row_crossed_(rows_.size(), 0) {
  for (const SphereState& sphere : spheres) {
    const double diameter = 2.0 * sphere.radius / grid.h;
    const double markers = settings.marker_density * std::numbers::pi * diameter * diameter;
    const double work =
        markers * (loop_cost * settings.forcing_loops + (sphere.mobile ? placing_cost : 0.0));
    note_crossed(grid, sphere, 1, plane_crossed_);
    note_crossed(grid, sphere, 2, row_crossed_);
    const std::vector<Cover> across = cover(grid, sphere, 2);
    for (const Cover& y : cover(grid, sphere, 1))
      for (const Cover& z : across) {
        const double here = work * y.share * z.share;
        planes_[static_cast<std::size_t>(y.cell)] += here;
        rows_[static_cast<std::size_t>(z.cell)] += here;
        below_[at(y.cell + 1, z.cell + 1)] += here;
      }
  }
  for (int j = 1; j <= grid.cells[1]; ++j)
    for (int k = 1; k <= grid.cells[2]; ++k)
      below_[at(j, k)] += below_[at(j - 1, k)] + below_[at(j, k - 1)] - below_[at(j - 1, k - 1)];
}

void ForcingWork::add_up_on_first(MPI_Comm comm) {
  const bool is_first = rank_in(comm) == 0;
  const auto add = [&](auto& values, MPI_Datatype type, MPI_Op operation) {
    MPI_Reduce(is_first ? MPI_IN_PLACE : values.data(), values.data(),
               static_cast<int>(values.size()), type, operation, 0, comm);
  };
  add(planes_, MPI_DOUBLE, MPI_SUM);
  add(rows_, MPI_DOUBLE, MPI_SUM);
  add(below_, MPI_DOUBLE, MPI_SUM);
  add(plane_crossed_, MPI_BYTE, MPI_BOR);
  add(row_crossed_, MPI_BYTE, MPI_BOR);
}

std::size_t ForcingWork::at(int j, int k) const {
  return static_cast<std::size_t>(j) * (static_cast<std::size_t>(rows_count_) + 1) +
         static_cast<std::size_t>(k);
}

double ForcingWork::block(int first_plane, int end_plane, int first_row, int end_row) const {
  return below_[at(end_plane, end_row)] - below_[at(first_plane, end_row)] -
         below_[at(end_plane, first_row)] + below_[at(first_plane, first_row)];
}

double stage_time(const Grid& grid, const ForcingWork& forcing, const Cuts& cuts) {
  const double nx = grid.cells[0];
  const auto crosses_plane = [&](int first) { return forcing.crosses_plane(first); };
  const auto crosses_row = [&](int first) { return forcing.crosses_row(first); };
  // Cut 0 is the seam of a periodic direction.
  const bool rows_cross =
      cuts.z_parts() > 1 && std::any_of(cuts.z.begin(), cuts.z.end() - 1, crosses_row);
  const bool seam_crosses = cuts.y_parts() > 1 && forcing.crosses_plane(0);
  double longest_up = 0.0, longest_down = 0.0, most_sent = 0.0;
  for (auto slab = cuts.y.begin(); slab + 1 != cuts.y.end();) {
    // Slabs from here to `end` wait for each other.
    const auto end = std::find_if_not(slab + 1, cuts.y.end() - 1, crosses_plane);
    const bool wait = rows_cross || seam_crosses || end - slab > 1;
    double predictor = 0.0, spheres = 0.0, both = 0.0;
    for (; slab != end; ++slab) {
      const bool carried = carries(grid, *slab);
      const double up = up_share + (carried ? up_carried : 0.0);
      const double down = 1.0 - up_share + (carried ? down_carried : 0.0);
      for (auto part = cuts.z.begin(); part + 1 != cuts.z.end(); ++part) {
        const double planes = slab[1] - slab[0], rows = part[1] - part[0];
        const double cells = nx * planes * rows;
        const double here = forcing.block(slab[0], slab[1], part[0], part[1]);
        predictor = std::max(predictor, up * cells);
        spheres = std::max(spheres, here);
        both = std::max(both, up * cells + here);
        longest_down = std::max(longest_down, down * cells);
        double sent = 0.0;
        if (cuts.y_parts() > 1) sent += nx * rows * (6.0 + 6.0);
        if (cuts.z_parts() > 1)
          sent += nx * planes * (6.0 + 2.0 * rows * (1.0 - 1.0 / cuts.z_parts()));
        most_sent = std::max(most_sent, sent);
      }
    }
    longest_up = std::max(longest_up, wait ? predictor + spheres : both);
  }
  return longest_up + longest_down + value_cost * most_sent;
}

namespace {

/// Of all divisions with `z_parts` blocks along z (0: any number).
Cuts shortest_stage(const Grid& grid, const ForcingWork& forcing, int ranks, int z_parts) {
  constexpr int trials = 30, passes = 3;  // a pass knows the first slab of the one before
  const double nx = grid.cells[0], ny = grid.cells[1], nz = grid.cells[2];
  std::vector<double> planes(static_cast<std::size_t>(grid.cells[1]));
  std::vector<double> rows(static_cast<std::size_t>(grid.cells[2]));
  Cuts best;
  double shortest = std::numeric_limits<double>::infinity();
  for (int parts = 1; parts <= ranks; ++parts) {
    if (ranks % parts != 0 || (z_parts > 0 && parts != z_parts)) continue;
    if (!fits(grid, ranks / parts, parts)) continue;
    for (int trial = 0; trial <= trials; ++trial) {
      const double share = double(trial) / trials;  // 1/2: as for ranks that do not wait
      const auto weighted = [share](double cells, double work) {
        return (1.0 - share) * cells + share * work / up_share;
      };
      for (std::size_t k = 0; k < rows.size(); ++k)
        rows[k] = weighted(nx * ny, forcing.row(static_cast<int>(k)));
      int carried_from = grid.cells[1];  // plane from which on cells cost more
      for (int pass = 0; pass < passes; ++pass) {
        for (int j = 0; j < grid.cells[1]; ++j) {
          const double cost = j < carried_from ? 1.0 : 1.0 + up_carried + down_carried;
          planes[static_cast<std::size_t>(j)] = weighted(cost * nx * nz, forcing.plane(j));
        }
        Cuts cuts{.y = divide_evenly(planes, ranks / parts), .z = divide_evenly(rows, parts)};
        if (!grid.periodic(1)) carried_from = cuts.y[1];
        const double time = stage_time(grid, forcing, cuts);
        if (time >= shortest) continue;
        shortest = time;
        best = std::move(cuts);
      }
    }
  }
  return best;
}

void broadcast(MPI_Comm comm, std::vector<int>& numbers) {
  int count = static_cast<int>(numbers.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  numbers.resize(static_cast<std::size_t>(count));
  MPI_Bcast(numbers.data(), count, MPI_INT, 0, comm);
}

}  // namespace

Cuts choose_cuts(const Grid& grid, std::span<const SphereState> spheres, int ranks, int z_parts,
                 const Settings::Spheres& settings) {
  if (!divisible(grid, ranks, z_parts)) refuse(grid, ranks, z_parts);
  return shortest_stage(grid, ForcingWork(grid, spheres, settings), ranks, z_parts);
}

Cuts choose_cuts_together(MPI_Comm comm, const Grid& grid, std::span<const SphereState> mine,
                          int z_parts, const Settings::Spheres& settings) {
  if (!divisible(grid, size_of(comm), z_parts)) refuse(grid, size_of(comm), z_parts);
  ForcingWork forcing(grid, mine, settings);
  forcing.add_up_on_first(comm);
  Cuts cuts;
  if (rank_in(comm) == 0) cuts = shortest_stage(grid, forcing, size_of(comm), z_parts);
  broadcast(comm, cuts.y);
  broadcast(comm, cuts.z);
  return cuts;
}

}  // namespace bedload
