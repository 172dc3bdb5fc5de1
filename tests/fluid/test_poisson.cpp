#include <gtest/gtest.h>

#include <random>

#include "fluid/poisson.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

struct Case {
  std::array<int, 3> cells;
  std::array<bool, 3> walls;       // along x, y, z; else periodic
  std::vector<double> plane_cost;  // uneven slabs
};

/// Solves for the divergence of a random field that is zero on the walls and returns the largest
/// residual of the seven-point equation, evaluated on the solution of this rank and its
/// neighbours'.
template <class Real>
double residual(const Case& test, int z_parts) {
  Settings s = box(test.cells, 0.1, 1e-3, 0.01);
  const auto ends = [&](std::size_t d) {
    const Wall wall = test.walls[d] ? Wall::no_slip : Wall::periodic;
    return std::array{wall, wall};
  };
  s.boundary.x = ends(0);
  s.boundary.y = ends(1);
  s.boundary.z = ends(2);
  const Grid grid = make_grid(s);
  Cuts cuts = even_cuts(grid, world_size(), z_parts);
  if (!test.plane_cost.empty()) cuts.y = divide_evenly(test.plane_cost, cuts.y_parts());
  const Decomposition slabs(grid, MPI_COMM_WORLD, cuts);
  const int nx = grid.cells[0], ny = grid.cells[1], nz = slabs.rows(), planes = slabs.planes();

  Field<Real> flow(grid, slabs.extent(), 3);
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < nz; ++k)
      for (int c = 0; c < 3; ++c) {
        std::mt19937 bits(static_cast<unsigned>(
            ((slabs.first() + j) * grid.cells[2] + slabs.first_row() + k) * 3 + c));
        std::uniform_real_distribution<double> random(-1.0, 1.0);
        for (int i = 0; i < nx; ++i) flow.row(j, k, c)[i] = static_cast<Real>(random(bits));
      }
  const WallGhosts<Real> walls(grid, slabs);
  for (int j = 0; j < planes; ++j) {
    for (int k = 0; k < nz; ++k)
      for (int c = 0; c < 3; ++c) walls.close_row(flow.row(j, k, c), c);
    walls.close_plane(flow, j);
  }
  slabs.exchange(flow);
  walls.close_block(flow);

  PoissonSolver<Real> poisson(grid, slabs);
  Field<Real> rhs(grid, slabs.extent(), 1), phi(grid, slabs.extent(), 1);
  for (int j = 0; j < planes; ++j) {
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i) {
        const Real in_plane = flow.row(j, k, 0)[i] - flow.row(j, k, 0)[i - 1] +
                              flow.row(j, k, 2)[i] - flow.row(j, k - 1, 2)[i] +
                              flow.row(j, k, 1)[i];
        rhs.row(j, k)[i] = in_plane - flow.row(j - 1, k, 1)[i];
        poisson.rhs_row(k)[i] = j == 0 ? in_plane : rhs.row(j, k)[i];
        if (k == 0 && poisson.gives_to_front()) poisson.rhs_row(0)[i] += flow.row(j, -1, 2)[i];
        if (k == nz - 1 && poisson.gives_to_front()) poisson.rhs_row(nz)[i] = -flow.row(j, k, 2)[i];
        poisson.excess_row(k)[i] = flow.row(j, k, 1)[i];
      }
    poisson.eliminate(j);
  }
  poisson.couple();
  for (int j = slabs.at_upper_wall() ? planes - 1 : planes; j >= 0; --j) {
    poisson.substitute(j);
    for (int k = 0; k <= nz; ++k) std::copy_n(poisson.solution_row(j, k), nx, phi.row(j, k));
  }
  std::vector<Real> front;  // as the solver gave it, before the exchange
  for (int j = 0; j < planes; ++j) front.insert(front.end(), phi.row(j, nz), phi.row(j, nz) + nx);
  std::vector<Real> above;  // as the solver gave it, before the exchange
  if (!slabs.at_upper_wall()) above.assign(phi.plane(planes), phi.plane(planes) + phi.plane_size());
  for (int j = 0; j < planes; ++j) walls.close_scalar(phi, j);
  slabs.exchange(phi);

  double largest = 0.0;
  for (int j = 0; j < planes; ++j)
    for (int k = 0; k < nz; ++k)
      for (int i = 0; i < nx; ++i) {
        const int global = slabs.first() + j;
        const double p = phi.row(j, k)[i];
        double laplacian = phi.row(j, k)[i - 1] + phi.row(j, k)[i + 1] + phi.row(j, k - 1)[i] +
                           phi.row(j, k + 1)[i] - 4.0 * p;
        if (global > 0 || grid.periodic(1)) laplacian += phi.row(j - 1, k)[i] - p;
        if (global < ny - 1 || grid.periodic(1)) laplacian += phi.row(j + 1, k)[i] - p;
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

/// The largest of all ways to divide the ranks along y and z.
template <class Real>
double residual(const Case& test) {
  double largest = 0.0;
  for (const int z_parts : splits(world_size())) {
    if (world_size() / z_parts > test.cells[1] || z_parts > test.cells[2]) continue;
    largest = std::max(largest, residual<Real>(test, z_parts));
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
    for (const std::array<int, 3> cells : {std::array{16, 12, 8}, {8, 32, 16}, {12, 20, 10}}) {
      SCOPED_TRACE(testing::Message() << cells[0] << 'x' << cells[1] << 'x' << cells[2] << " walls "
                                      << walls[0] << walls[1] << walls[2]);
      EXPECT_LT(residual<double>({cells, walls, {}}), bound<double>);
      EXPECT_LT(residual<float>({cells, walls, {}}), bound<float>);
    }
}

TEST(Poisson, TakesOddAndPrimeSizes) {
  for (const auto& walls : all_walls())
    for (const std::array<int, 3> cells : {std::array{15, 12, 8}, {16, 7, 9}, {13, 11, 17}}) {
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

}  // namespace
}  // namespace bedload
