#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "fluid/poisson/fftw.hpp"
#include "fluid/poisson/poisson.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

struct Case {
  std::array<int, 3> cells;
  std::array<bool, 3> walls;       // along x, y, z; else periodic
  std::vector<double> plane_cost;  // uneven slabs
  double stretching = 0.0;         // of y, between walls
};

/// Solves for the divergence of a random field that is zero on the walls and returns the largest
/// residual of the seven-point equation, evaluated on the solution of this rank and its
/// neighbours'.
template <class Real>
double residual(const Case& test, int z_parts, std::size_t cached) {
  Settings s = box(test.cells, 0.1, 1e-3, 0.01);
  const auto ends = [&](std::size_t d) {
    const Wall wall = test.walls[d] ? Wall::no_slip : Wall::periodic;
    return std::array{wall, wall};
  };
  s.boundary.x = ends(0);
  s.boundary.y = ends(1);
  s.boundary.z = ends(2);
  s.grid.y_stretching = test.stretching;
  const Grid grid = make_grid(s);
  Cuts cuts = even_cuts(grid, world_size(), z_parts);
  if (!test.plane_cost.empty()) cuts.y = divide_evenly(test.plane_cost, cuts.y_parts());
  const Decomposition decomposition(grid, MPI_COMM_WORLD, cuts);
  const int nx = grid.cells[0], ny = grid.cells[1], nz = decomposition.rows(),
            planes = decomposition.planes();

  Field<Real> flow(grid, decomposition.extent(), 3);
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < nz; ++k)
      for (int c = 0; c < 3; ++c) {
        std::mt19937 bits(static_cast<unsigned>(
            ((decomposition.first() + j) * grid.cells[2] + decomposition.first_row() + k) * 3 + c));
        std::uniform_real_distribution<double> random(-1.0, 1.0);
        for (int i = 0; i < nx; ++i) flow.row(j, k, c)[i] = static_cast<Real>(random(bits));
      }
  const WallGhosts<Real> walls(grid, decomposition);
  for (int j = 0; j < planes; ++j) {
    for (int k = 0; k < nz; ++k)
      for (int c = 0; c < 3; ++c) walls.close_row(flow.row(j, k, c), c);
    walls.close_plane(flow, j);
  }
  decomposition.exchange(flow);
  walls.close_block(flow);

  constexpr int at_once = 3;
  PoissonSolver<Real> poisson(grid, decomposition, pressure_component, at_once, cached);
  Field<Real> rhs(grid, decomposition.extent(), 1), phi(grid, decomposition.extent(), 1);
  for (int j = 0; j < planes; ++j) {
    const Real thickness = static_cast<Real>(grid.thickness(decomposition.first() + j));
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i) {
        const Real in_plane = thickness * (flow.row(j, k, 0)[i] - flow.row(j, k, 0)[i - 1] +
                                           flow.row(j, k, 2)[i] - flow.row(j, k - 1, 2)[i]) +
                              flow.row(j, k, 1)[i];
        rhs.row(j, k)[i] = in_plane - flow.row(j - 1, k, 1)[i];
        poisson.rhs_row(j, k)[i] = j == 0 ? in_plane : rhs.row(j, k)[i];
        if (k == 0 && poisson.gives_to_front())
          poisson.rhs_row(j, 0)[i] += thickness * flow.row(j, -1, 2)[i];
        if (k == nz - 1 && poisson.gives_to_front())
          poisson.rhs_row(j, nz)[i] = -thickness * flow.row(j, k, 2)[i];
        if (j == planes - 1)
          poisson.excess_row(k)[i] =
              flow.row(j, k, 1)[i] * static_cast<Real>(grid.gap(decomposition.first() + j));
      }
    if ((j + 1) % at_once == 0 || j == planes - 1) poisson.eliminate(j / at_once * at_once, j + 1);
  }
  poisson.couple();
  const auto substitute = [&](int first, int end) {
    poisson.substitute(first, end);
    for (int j = first; j < end; ++j)
      for (int k = 0; k <= nz; ++k) std::copy_n(poisson.solution_row(j, k), nx, phi.row(j, k));
  };
  if (!decomposition.at_upper_wall()) substitute(planes, planes + 1);
  for (int end = planes; end > 0; end -= at_once) substitute(std::max(end - at_once, 0), end);
  std::vector<Real> front;  // as the solver gave it, before the exchange
  for (int j = 0; j < planes; ++j) front.insert(front.end(), phi.row(j, nz), phi.row(j, nz) + nx);
  std::vector<Real> above;  // as the solver gave it, before the exchange
  if (!decomposition.at_upper_wall())
    above.assign(phi.plane(planes), phi.plane(planes) + phi.plane_size());
  for (int j = 0; j < planes; ++j) walls.close_scalar(phi, j);
  decomposition.exchange(phi);

  double largest = 0.0;
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i) {
        const int global = decomposition.first() + j;
        const double p = phi.row(j, k)[i];
        double laplacian = phi.row(j, k)[i - 1] + phi.row(j, k)[i + 1] + phi.row(j, k - 1)[i] +
                           phi.row(j, k + 1)[i] - 4.0 * p;
        laplacian *= grid.thickness(global);
        if (global > 0 || grid.periodic(1))
          laplacian += (phi.row(j - 1, k)[i] - p) / grid.gap(global - 1);
        if (global < ny - 1 || grid.periodic(1))
          laplacian += (phi.row(j + 1, k)[i] - p) / grid.gap(global);
        largest = std::max(largest, std::abs(laplacian - double(rhs.row(j, k)[i])));
      }
  // The plane above that the solver gives must be the neighbour's.
  for (int k = 0; k < nz && !above.empty(); ++k)
    for (int i = 0; i < nx; ++i) {
      const Real* place = phi.row(planes, k) + i;
      const double given = above[static_cast<std::size_t>(place - phi.plane(planes))];
      largest = std::max(largest, std::abs(given - double(*place)));
    }
  for (int j = 0; j < planes; ++j)  // and the row in front
    for (int i = 0; i < nx; ++i)
      largest = std::max(largest, std::abs(double(front[static_cast<std::size_t>(j * nx + i)]) -
                                           double(phi.row(j, nz)[i])));
  return all_max(largest, MPI_COMM_WORLD);
}

/// The largest of all ways to divide the ranks along y and z, with what the way up leaves in and
/// beyond the caches.
template <class Real>
double residual(const Case& test) {
  double largest = 0.0;
  for (const int z_parts : splits(world_size())) {
    if (world_size() / z_parts > test.cells[1] || z_parts > test.cells[2]) continue;
    for (const std::size_t cached : {cached_bytes, std::size_t{0}})
      largest = std::max(largest, residual<Real>(test, z_parts, cached));
  }
  return largest;
}

/// Right-hand sides are of order 4 and the solution of order 10 (long waves, up to 32 planes); the
/// transforms add a few roundings of that.
template <class Real>
constexpr double bound = 300.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());

/// Every pair of ends: the pressure cannot tell a no-slip wall from a free-slip one.
std::vector<std::array<bool, 3>> all_walls() {
  std::vector<std::array<bool, 3>> all;
  for (const bool x : {false, true})
    for (const bool y : {false, true})
      for (const bool z : {false, true}) all.push_back({x, y, z});
  return all;
}

TEST(Poisson, ResidualIsRoundOffForEveryBoundaryPair) {
  for (const auto& walls : all_walls())
    for (const std::array<int, 3> cells :
         {std::array{16, 12, 8}, {8, 32, 16}, {12, 20, 10}, {10, 12, 30}}) {
      SCOPED_TRACE(testing::Message() << cells[0] << 'x' << cells[1] << 'x' << cells[2] << " walls "
                                      << walls[0] << walls[1] << walls[2]);
      EXPECT_LT(residual<double>({cells, walls, {}}), bound<double>);
      EXPECT_LT(residual<float>({cells, walls, {}}), bound<float>);
    }
}

TEST(Poisson, ResidualIsRoundOffOnStretchedY) {
  for (const auto& walls : all_walls()) {
    if (!walls[1]) continue;
    EXPECT_LT(residual<double>({{12, 20, 10}, walls, {}, 1.8}), bound<double>);
    EXPECT_LT(residual<float>({{12, 20, 10}, walls, {}, 1.8}), bound<float>);
  }
}

/// Largest residual of mass (h^2 Laplacian - shift) x = rhs for a velocity component, rhs random,
/// evaluated with the ghosts that a flow between resting walls has.
template <class Real>
double helmholtz_residual(const Ends& ends, int component, double shift, double stretching,
                          int z_parts) {
  Settings s = box({10, 14, 12}, 0.1, 1e-3, 0.01);
  set_ends(s, ends);
  s.grid.y_stretching = stretching;
  const Grid grid = make_grid(s);
  const Decomposition decomposition(grid, MPI_COMM_WORLD, even_cuts(grid, world_size(), z_parts));
  const WallGhosts<Real> walls(grid, decomposition);
  const int nx = grid.cells[0], nz = decomposition.rows(), planes = decomposition.planes();
  PoissonSolver<Real> solver(grid, decomposition, component);
  solver.set_shift(2.0 * shift);  // and another one after that
  solver.set_shift(shift);
  Field<Real> rhs(grid, decomposition.extent(), 3), x(grid, decomposition.extent(), 3);
  const auto is_wall = [&](int j, int k, int i) {
    const std::array<int, 3> cell{i, decomposition.first() + j, decomposition.first_row() + k};
    const auto d = static_cast<std::size_t>(component);
    return !grid.periodic(component) && cell[d] == grid.cells[d] - 1;
  };
  for (int j = 0; j < planes; ++j) {
    for (int k = 0; k < nz; ++k) {
      std::mt19937 bits(static_cast<unsigned>((decomposition.first() + j) * grid.cells[2] +
                                              decomposition.first_row() + k));
      std::uniform_real_distribution<double> random(-1.0, 1.0);
      Real* row = rhs.row(j, k, component);
      for (int i = 0; i < nx; ++i) {
        row[i] = static_cast<Real>(random(bits));
        if (is_wall(j, k, i)) row[i] = Real(0);
      }
      std::copy_n(row, nx, solver.rhs_row(j, k));
    }
    if (solver.gives_to_front()) std::fill_n(solver.rhs_row(j, nz), nx, Real(0));
    solver.eliminate(j, j + 1, 0.5);
  }
  solver.couple();
  for (int j = planes - 1; j >= 0; --j) {
    solver.substitute(j, j + 1);
    for (int k = 0; k < nz; ++k) {
      std::copy_n(solver.solution_row(j, k), nx, x.row(j, k, component));
      for (int c = 0; c < 3; ++c) walls.close_row(x.row(j, k, c), c);
    }
    walls.close_plane(x, j);
  }
  decomposition.exchange(x);
  walls.close_block(x);
  double largest = 0.0;
  for (int j = 0; j < planes; ++j) {
    const int global = decomposition.first() + j;
    const bool v = component == 1;
    const double mass = v ? grid.gap(global) : grid.thickness(global);
    const double above = v ? grid.thickness(global + 1) : grid.gap(global);
    const double below = v ? grid.thickness(global) : grid.gap(global - 1);
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i) {
        if (is_wall(j, k, i)) continue;
        const auto at = [&](int dj, int dk, int di) {
          return double(x.row(j + dj, k + dk, component)[i + di]);
        };
        const double q = at(0, 0, 0);
        const double in_plane = at(0, 0, -1) + at(0, 0, 1) + at(0, -1, 0) + at(0, 1, 0) - 4.0 * q;
        const double left =
            mass * (in_plane - shift * q) + (at(1, 0, 0) - q) / above - (q - at(-1, 0, 0)) / below;
        largest = std::max(largest, std::abs(left - 0.5 * double(rhs.row(j, k, component)[i])));
      }
  }
  return all_max(largest, MPI_COMM_WORLD);
}

/// Every kind of end once along each direction, for each component. Right-hand sides of order 1/2,
/// solutions of order 1; stretching makes cells and coefficients differ by 10.
TEST(Poisson, HelmholtzResidualIsRoundOffForEveryBoundaryPair) {
  const std::array kinds{periodic, no_slip, free_slip, open_channel, under_a_lid};
  for (std::size_t n = 0; n < kinds.size(); ++n)
    for (int component = 0; component < 3; ++component) {
      const Ends ends{kinds[n], kinds[(n + 2) % 5], kinds[(n + 4) % 5]};
      const bool no_slip_y = ends[1][0] == Wall::no_slip || ends[1][1] == Wall::no_slip;
      SCOPED_TRACE(name_of(ends) + " component " + "uvw"[component]);
      for (const double shift : {0.3, 40.0})
        for (const double stretching : {0.0, 1.5}) {
          if (stretching > 0.0 && !no_slip_y) continue;
          if (world_size() > 2 && shift > 1.0) continue;  // the other one couples blocks more
          for (const int z_parts : splits(world_size()))
            EXPECT_LT(helmholtz_residual<double>(ends, component, shift, stretching, z_parts),
                      100 * epsilon<double>());
          EXPECT_LT(helmholtz_residual<float>(ends, component, shift, stretching, 1),
                    100 * epsilon<float>());
        }
    }
}

TEST(Poisson, TakesOddAndPrimeSizes) {
  for (const auto& walls : all_walls())
    for (const std::array<int, 3> cells :
         {std::array{15, 12, 8}, {16, 7, 9}, {13, 11, 17}, {9, 12, 18}}) {
      SCOPED_TRACE(testing::Message() << cells[0] << 'x' << cells[1] << 'x' << cells[2] << " walls "
                                      << walls[0] << walls[1] << walls[2]);
      EXPECT_LT(residual<double>({cells, walls, {}}), bound<double>);
    }
}

TEST(Poisson, TakesUnevenSlabsDownToOnePlane) {
  for (const auto& walls : all_walls()) {
    std::vector<double> bed(12, 1.0), lid(12, 1.0);
    bed[0] = bed[1] = 100.0;
    lid[11] = lid[10] = lid[9] = 100.0;
    EXPECT_LT(residual<double>({{8, 12, 8}, walls, bed}), bound<double>);
    EXPECT_LT(residual<double>({{8, 12, 8}, walls, lid}), bound<double>);
    EXPECT_LT(residual<double>({{8, 4, 8}, walls, {}}),
              bound<double>);  // one plane each of 4
  }
}

TEST(Poisson, FullSizeStaysAtRoundOff) {
  EXPECT_LT(residual<double>({{64, 96, 64}, {false, true, false}, {}}), 1e3 * epsilon<double>());
  EXPECT_LT(residual<double>({{64, 96, 64}, {true, true, true}, {}}), 1e3 * epsilon<double>());
}

/// Ranks with columns of different numbers plan different transforms. What a checkpoint keeps of
/// one rank has to hold the others' as well, or a run that goes on measures anew and takes other
/// digits.
TEST(Poisson, AllRanksKnowWhatAnyHasLearned) {
  const Settings s =
      box({20, 8, 24}, 0.1, 1e-3, 0.01);  // 11 columns: uneven for any number of ranks
  const Grid grid = make_grid(s);
  for (const int z_parts : splits(world_size())) {
    const Decomposition decomposition(grid, MPI_COMM_WORLD, even_cuts(grid, world_size(), z_parts));
    const PoissonSolver<float> poisson(grid, decomposition);
    const std::string mine = wisdom_in_order<float>();
    int length = static_cast<int>(mine.size());
    MPI_Bcast(&length, 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::string first = mine;
    first.resize(static_cast<std::size_t>(length));
    MPI_Bcast(first.data(), length, MPI_CHAR, 0, MPI_COMM_WORLD);
    EXPECT_EQ(mine, first);
    EXPECT_GT(std::count(mine.begin(), mine.end(), '\n'), 2);
  }
}

/// A run in single precision has spectra in double, and its checkpoint what both have learned.
TEST(Poisson, WisdomOfBothPrecisionsIsLearnedAgain) {
  AlignedArray<double> twice(120), twice_out(120);
  AlignedArray<float> single(120), single_out(120);
  const FftwShape shape{{60}, 1};
  const auto twice_plan =
      FourierPlan<double>::complex(shape, twice.data(), twice_out.data(), FFTW_FORWARD);
  const auto single_plan =
      FourierPlan<float>::complex(shape, single.data(), single_out.data(), FFTW_FORWARD);
  const std::string learned = all_wisdom(), of_double = wisdom_in_order<double>(),
                    of_single = wisdom_in_order<float>();
  Fftw<double>::forget();
  Fftw<float>::forget();
  EXPECT_NE(wisdom_in_order<double>(), of_double);
  EXPECT_NE(wisdom_in_order<float>(), of_single);
  learn_all(learned);
  EXPECT_EQ(wisdom_in_order<double>(), of_double);
  EXPECT_EQ(wisdom_in_order<float>(), of_single);
}

}  // namespace
}  // namespace bedload
