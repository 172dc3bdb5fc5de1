#pragma once

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "fluid/channel/channel.hpp"
#include "fluid/settings/settings.hpp"
#include "tests/fluid/splits.hpp"

namespace bedload {

/// A box of cubic cells of edge h for the tests, otherwise as the defaults: open channel, no
/// driving, at rest.
inline Settings box(std::array<int, 3> cells, double h, double viscosity, double dt) {
  Settings s;
  s.file = "test.toml";
  s.grid.cells = cells;
  for (std::size_t d = 0; d < 3; ++d) s.grid.length[d] = cells[d] * h;
  s.fluid.kinematic_viscosity = viscosity;
  s.time.step = dt;
  s.time.end = 1e9;
  return s;
}

inline void set_y_ends(Settings& s, Wall lower, Wall upper) { s.boundary.y = {lower, upper}; }

/// Both ends of x, y and z.
using Ends = std::array<std::array<Wall, 2>, 3>;

inline void set_ends(Settings& s, const Ends& ends) {
  s.boundary.x = ends[0];
  s.boundary.y = ends[1];
  s.boundary.z = ends[2];
}

inline constexpr std::array<Wall, 2> periodic{Wall::periodic, Wall::periodic};
inline constexpr std::array<Wall, 2> no_slip{Wall::no_slip, Wall::no_slip};
inline constexpr std::array<Wall, 2> free_slip{Wall::free_slip, Wall::free_slip};
inline constexpr std::array<Wall, 2> open_channel{Wall::no_slip, Wall::free_slip};
inline constexpr std::array<Wall, 2> under_a_lid{Wall::free_slip, Wall::no_slip};

inline std::string name_of(const Ends& ends) {
  std::string name;
  for (std::size_t d = 0; d < 3; ++d)
    for (const Wall wall : ends[d])
      name += wall == Wall::periodic ? 'p' : wall == Wall::no_slip ? 'n' : 'f';
  return name;
}

/// Share of the time step that a stage takes.
inline double two_alpha(int stage) {
  return runge_kutta[static_cast<std::size_t>(stage)].two_alpha;
}

/// A developed-looking start: logarithmic profile with rolls and random modes.
inline void disturb(Settings& s, double velocity, double amplitude) {
  s.start.from = Start::logarithmic;
  s.start.velocity = velocity;
  s.start.disturbance = amplitude;
}

template <class Real>
void advance(Channel<Real>& channel, int steps) {
  for (int n = 0; n < steps; ++n) {
    for (int stage = 0; stage < stage_count; ++stage) {
      channel.predict(stage);
      channel.project(stage);
    }
    channel.finish_step();
  }
}

/// The same with all planes predicted before the projection.
template <class Real>
void advance_in_parts(Channel<Real>& channel, int steps) {
  for (int n = 0; n < steps; ++n) {
    for (int stage = 0; stage < stage_count; ++stage) {
      channel.predict(stage, true);
      channel.force_spheres(stage);
      channel.project(stage);
    }
    channel.finish_step();
  }
}

inline double all_max(double value, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, comm);
  return value;
}

/// Calls use(velocity - value(component, place)) for all own faces.
template <class Real, class Use>
void for_errors(const Channel<Real>& channel, const std::function<double(int, const Vec3&)>& value,
                Use use) {
  const Grid& grid = channel.grid();
  for (int j = 0; j < channel.decomposition().planes(); ++j)
    for (int k = 0; k < channel.decomposition().rows(); ++k)
      for (int c = 0; c < 3; ++c) {
        const Real* row = channel.velocity().row(j, k, c);
        for (int i = 0; i < grid.cells[0]; ++i) {
          const int plane = channel.decomposition().first() + j;
          const int line = channel.decomposition().first_row() + k;
          const Vec3 place(c == 0 ? grid.face(i) : grid.centre(i),
                           c == 1 ? grid.y_face(plane) : grid.y_centre(plane),
                           c == 2 ? grid.face(line) : grid.centre(line));
          use(static_cast<double>(row[i]) - value(c, place));
        }
      }
}

/// Largest difference of the velocity from value(component, place) over all own faces.
template <class Real>
double largest_error(const Channel<Real>& channel,
                     const std::function<double(int, const Vec3&)>& value) {
  double largest = 0.0;
  for_errors(channel, value, [&](double e) { largest = std::max(largest, std::abs(e)); });
  return all_max(largest, channel.comm());
}

/// Root of the mean square of the same.
template <class Real>
double rms_error(const Channel<Real>& channel,
                 const std::function<double(int, const Vec3&)>& value) {
  double sum = 0.0;
  for_errors(channel, value, [&](double e) { sum += e * e; });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, channel.comm());
  return std::sqrt(sum / (3.0 * channel.grid().cell_count()));
}

/// Largest difference, over all own values and ghosts that are not beyond a wall's edge, between
/// this rank's part of `parallel` and the same place of `whole`, which lives on this rank alone.
template <class Real>
double largest_difference(const Field<Real>& parallel, const Decomposition& decomposition,
                          const Field<Real>& whole, bool with_ghosts) {
  double largest = 0.0;
  const int edge = with_ghosts ? 1 : 0;
  const int all = whole.planes();
  for (int j = -edge; j < decomposition.planes() + edge; ++j) {
    int there = decomposition.first() + j;  // ghosts of the whole field's own ends are its ghosts
    there = std::clamp(there, -1, all);
    const auto row = [&](int k) {
      return std::clamp(decomposition.first_row() + k, -1, whole.nz());
    };
    for (int k = -edge; k < decomposition.rows() + edge; ++k)
      for (int c = 0; c < parallel.components(); ++c)
        for (int i = -1; i <= parallel.nx(); ++i)
          largest = std::max(largest, std::abs(double(parallel.row(j, k, c)[i]) -
                                               double(whole.row(there, row(k), c)[i])));
  }
  return all_max(largest, decomposition.comm());
}

inline int world_size() {
  int ranks = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  return ranks;
}

template <class Real>
double epsilon() {
  return static_cast<double>(std::numeric_limits<Real>::epsilon());
}

}  // namespace bedload
