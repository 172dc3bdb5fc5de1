#include "fluid/channel/diagnostics.hpp"

#include <algorithm>
#include <cmath>

#include "fluid/channel/projection.hpp"
#include "fluid/kernels/compensated_sum.hpp"

namespace bedload {
namespace {

double all_ranks(double value, MPI_Op operation, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, operation, comm);
  return value;
}

}  // namespace

template <class Real>
double kinetic_energy_integral(const Field<Real>& velocity, const Grid& grid,
                               const Decomposition& decomposition) {
  double sum = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    for (int c = 0; c < 3; ++c) {
      double plane = 0.0;
      for (int k = 0; k < velocity.nz(); ++k) {
        const Real* q = velocity.row(j, k, c);
        plane += row_total(velocity.nx(), [q](int i) { return double(q[i]) * double(q[i]); });
      }
      const int global = decomposition.first() + j;
      sum += plane * (c == 1 ? grid.gap(global) : grid.thickness(global));
    }
  }
  return 0.5 * grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

template <class Real>
double product_integral(const Field<Real>& a, const Field<Real>& b, const Grid& grid,
                        const Decomposition& decomposition) {
  double sum = 0.0;
  for (int j = 0; j < a.planes(); ++j)
    for (int c = 0; c < 3; ++c) {
      double plane = 0.0;
      for (int k = 0; k < a.nz(); ++k) {
        const Real *p = a.row(j, k, c), *q = b.row(j, k, c);
        plane += row_total(a.nx(), [p, q](int i) { return double(p[i]) * double(q[i]); });
      }
      const int global = decomposition.first() + j;
      sum += plane * (c == 1 ? grid.gap(global) : grid.thickness(global));
    }
  return grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

// a_c (u_{i+1} - 2 u_i + u_{i-1} + the same along z) w + a_c (difference of d u/dy above and
// below), w the height of the cell of u_c in h.
template <class Real>
double viscous_power_integral(const Field<Real>& a, const Field<Real>& velocity, const Grid& grid,
                              const Decomposition& decomposition) {
  double sum = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    const int global = decomposition.first() + j;
    for (int c = 0; c < 3; ++c) {
      const bool at_face = c == 1;
      const double height = at_face ? grid.gap(global) : grid.thickness(global);
      const double above = 1.0 / (at_face ? grid.thickness(global + 1) : grid.gap(global));
      const double below = 1.0 / (at_face ? grid.thickness(global) : grid.gap(global - 1));
      for (int k = 0; k < velocity.nz(); ++k) {
        const Real *moved = a.row(j, k, c), *q = velocity.row(j, k, c);
        const Real *up = velocity.row(j + 1, k, c), *down = velocity.row(j - 1, k, c);
        const Real *front = velocity.row(j, k + 1, c), *back = velocity.row(j, k - 1, c);
        sum += row_total(velocity.nx(), [&](int i) {
          const double here = double(q[i]);
          const double level =
              double(q[i - 1]) + double(q[i + 1]) + double(front[i]) + double(back[i]) - 4.0 * here;
          return double(moved[i]) * (height * level + above * (double(up[i]) - here) -
                                     below * (here - double(down[i])));
        });
      }
    }
  }
  return grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

// A wall between the value q beside it and g beyond has the velocity (g + q)/2 and the gradient
// (g - q) over their distance; at a free surface g = q. Values on another wall, at the last place
// along their own direction, are none of the flow's.
template <class Real>
double wall_power_integral(const Field<Real>& velocity, const Grid& grid,
                           const Decomposition& decomposition) {
  const int nx = grid.cells[0], nz = decomposition.rows(), top = decomposition.planes() - 1;
  const auto work = [](Real beyond, Real beside) {
    return 0.5 * (double(beyond) * double(beyond) - double(beside) * double(beside));
  };
  const auto inside = [&](int c, int j, int k) {
    if (c == 1) return j < top || !decomposition.at_upper_wall();
    return c != 2 || k < nz - 1 || !decomposition.at_front_wall();
  };
  double sum = 0.0;
  const auto add_row = [&](int c, int ghost_plane, int ghost_row, int j, int k, double area) {
    const Real *g = velocity.row(ghost_plane, ghost_row, c), *q = velocity.row(j, k, c);
    const int count = c == 0 && !grid.periodic(0) ? nx - 1 : nx;
    if (inside(c, j, k)) sum += area * row_total(count, [&](int i) { return work(g[i], q[i]); });
  };
  for (int k = 0; k < nz; ++k)
    for (const int c : {0, 2}) {
      if (decomposition.at_lower_wall()) add_row(c, -1, k, 0, k, 1.0 / grid.gap(-1));
      if (decomposition.at_upper_wall())
        add_row(c, top + 1, k, top, k, 1.0 / grid.gap(grid.cells[1] - 1));
    }
  for (int j = 0; j <= top; ++j) {
    const int global = decomposition.first() + j;
    const auto height = [&](int c) { return c == 1 ? grid.gap(global) : grid.thickness(global); };
    for (const int c : {0, 1}) {
      if (decomposition.at_back_wall()) add_row(c, j, -1, j, 0, height(c));
      if (decomposition.at_front_wall()) add_row(c, j, nz, j, nz - 1, height(c));
    }
    if (grid.periodic(0)) continue;
    for (int k = 0; k < nz; ++k)
      for (const int c : {1, 2}) {
        const Real* q = velocity.row(j, k, c);
        if (inside(c, j, k)) sum += height(c) * (work(q[-1], q[0]) + work(q[nx], q[nx - 1]));
      }
  }
  return grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

// -1/4 a_c [(A + A_next) (q + q_next) - the same one face back], summed over the three directions
// d, q = u_c, A = u_d and A_next the same one place along c. Through faces above and below the
// difference counts as it is, through the others times the height of the cell of u_c; over the two
// half cells of v, A and A_next count by their heights.
template <class Real>
double convective_power_integral(const Field<Real>& a, const Field<Real>& velocity,
                                 const Grid& grid, const Decomposition& decomposition) {
  double sum = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    const int global = decomposition.first() + j;
    for (int k = 0; k < velocity.nz(); ++k)
      for (int c = 0; c < 3; ++c)
        for (int d = 0; d < 3; ++d) {
          // component n at the cell `along_c` places along c and `along_d` along d away
          const auto at = [&](int n, int along_c, int along_d) {
            const auto away = [&](int direction) {
              return (c == direction ? along_c : 0) + (d == direction ? along_d : 0);
            };
            return velocity.row(j + away(1), k + away(2), n) + away(0);
          };
          const Real *moved = a.row(j, k, c), *q = at(c, 0, 0);
          const Real *next = at(c, 0, 1), *last = at(c, 0, -1);
          const Real *through = at(d, 0, 0), *through_next = at(d, 1, 0);
          const Real *back = at(d, 0, -1), *back_next = at(d, 1, -1);
          const bool halves = c == 1 && d != 1;
          const double here = halves ? grid.thickness(global) / grid.gap(global) : 1.0;
          const double ahead = halves ? grid.thickness(global + 1) / grid.gap(global) : 1.0;
          const double height = d == 1 ? 1.0 : c == 1 ? grid.gap(global) : grid.thickness(global);
          sum -= 0.25 * height * row_total(velocity.nx(), [&](int i) {
                   return double(moved[i]) *
                          ((here * double(through[i]) + ahead * double(through_next[i])) *
                               (double(q[i]) + double(next[i])) -
                           (here * double(back[i]) + ahead * double(back_next[i])) *
                               (double(last[i]) + double(q[i])));
                 });
        }
  }
  return grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

template <class Real>
double largest_divergence(const Field<Real>& velocity, const Grid& grid,
                          const Decomposition& decomposition) {
  double largest = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    const double stretch = 1.0 / grid.thickness(decomposition.first() + j);
    for (int k = 0; k < velocity.nz(); ++k) {
      const Real *u = velocity.row(j, k, 0), *v = velocity.row(j, k, 1), *w = velocity.row(j, k, 2);
      const Real *v_below = velocity.row(j - 1, k, 1), *w_back = velocity.row(j, k - 1, 2);
      for (int i = 0; i < velocity.nx(); ++i) {
        const double d = (double(u[i]) - double(u[i - 1])) +
                         stretch * (double(v[i]) - double(v_below[i])) +
                         (double(w[i]) - double(w_back[i]));
        largest = std::max(largest, std::abs(d));
      }
    }
  }
  return all_ranks(largest, MPI_MAX, decomposition.comm()) / grid.h;
}

template <class Real>
double streamwise_sum(const Field<Real>& velocity, const Grid& grid,
                      const Decomposition& decomposition) {
  CompensatedSum sum;
  for (int j = 0; j < velocity.planes(); ++j)
    for (int k = 0; k < velocity.nz(); ++k)
      sum +=
          row_sum(velocity.nx(), velocity.row(j, k, 0)) * grid.thickness(decomposition.first() + j);
  return all_ranks(sum.value(), MPI_SUM, decomposition.comm());
}

template <class Real>
double largest_local_speed(const Field<Real>& velocity, const Grid& grid,
                           const Decomposition& decomposition) {
  Real largest = 0;
  for (int j = 0; j < velocity.planes(); ++j) {
    const Real stretch = static_cast<Real>(stretch_at(grid, decomposition.first() + j));
    for (int k = 0; k < velocity.nz(); ++k)
      largest = std::max(largest, largest_speed(velocity.nx(), stretch, velocity.component_stride(),
                                                velocity.row(j, k)));
  }
  return static_cast<double>(largest);
}

template <class Real>
BadPlace find_not_finite(const Field<Real>& velocity, const Decomposition& decomposition) {
  for (int j = 0; j < velocity.planes(); ++j)
    for (int k = 0; k < velocity.nz(); ++k)
      for (int c = 0; c < 3; ++c) {
        const Real* q = velocity.row(j, k, c);
        for (int i = 0; i < velocity.nx(); ++i)
          if (!std::isfinite(q[i]))
            return {.found = true,
                    .i = i,
                    .j = decomposition.first() + j,
                    .k = decomposition.first_row() + k,
                    .component = c};
      }
  return {};
}

template <class Real>
std::array<int, 3> find_fastest(const Field<Real>& velocity, const Grid& grid,
                                const Decomposition& decomposition) {
  struct {
    double speed;
    int rank;
  } best{-1.0, decomposition.rank()};
  std::array<int, 3> cell{};
  for (int j = 0; j < velocity.planes(); ++j) {
    const double stretch = stretch_at(grid, decomposition.first() + j);
    for (int k = 0; k < velocity.nz(); ++k) {
      const Real *u = velocity.row(j, k, 0), *v = velocity.row(j, k, 1), *w = velocity.row(j, k, 2);
      for (int i = 0; i < velocity.nx(); ++i) {
        const double speed =
            std::abs(double(u[i])) + stretch * std::abs(double(v[i])) + std::abs(double(w[i]));
        if (speed <= best.speed) continue;
        best.speed = speed;
        cell = {i, decomposition.first() + j, decomposition.first_row() + k};
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, decomposition.comm());
  MPI_Bcast(cell.data(), 3, MPI_INT, best.rank, decomposition.comm());
  return cell;
}

template <class Real>
double local_wall_sum(const Field<Real>& velocity, const Grid& grid,
                      const Decomposition& decomposition) {
  const int nx = grid.cells[0], nz = decomposition.rows(), top = decomposition.planes() - 1;
  double sum = 0.0;
  const auto across = [&](int ghost_plane, int ghost_row, int plane, int row) {
    return row_sum(nx, velocity.row(ghost_plane, ghost_row)) -
           row_sum(nx, velocity.row(plane, row));
  };
  for (int k = 0; k < nz; ++k) {
    if (decomposition.at_lower_wall()) sum += across(-1, k, 0, k) / grid.gap(-1);
    if (decomposition.at_upper_wall())
      sum += across(top + 1, k, top, k) / grid.gap(grid.cells[1] - 1);
  }
  for (int j = 0; j <= top; ++j) {
    const double thickness = grid.thickness(decomposition.first() + j);
    if (decomposition.at_back_wall()) sum += thickness * across(j, -1, j, 0);
    if (decomposition.at_front_wall()) sum += thickness * across(j, nz, j, nz - 1);
  }
  return sum;
}

template <class Real>
std::array<double, 2> mean_wall_stress(const Field<Real>& velocity, const Grid& grid,
                                       const Decomposition& decomposition,
                                       double dynamic_viscosity) {
  const double factor =
      dynamic_viscosity / grid.h / (double(grid.cells[0]) * double(grid.cells[2]));
  std::array<double, 2> stress{};
  const auto add = [&](std::size_t end, int ghost, int inner, double gap) {
    for (int k = 0; k < decomposition.rows(); ++k)
      stress[end] += factor / gap *
                     (row_sum(grid.cells[0], velocity.row(inner, k)) -
                      row_sum(grid.cells[0], velocity.row(ghost, k)));
  };
  if (decomposition.at_lower_wall()) add(0, -1, 0, grid.gap(-1));
  if (decomposition.at_upper_wall())
    add(1, decomposition.planes(), decomposition.planes() - 1, grid.gap(grid.cells[1] - 1));
  MPI_Allreduce(MPI_IN_PLACE, stress.data(), 2, MPI_DOUBLE, MPI_SUM, decomposition.comm());
  return stress;
}

#define BEDLOAD_INSTANTIATE(Real)                                                                 \
  template double kinetic_energy_integral(const Field<Real>&, const Grid&, const Decomposition&); \
  template double product_integral(const Field<Real>&, const Field<Real>&, const Grid&,           \
                                   const Decomposition&);                                         \
  template double viscous_power_integral(const Field<Real>&, const Field<Real>&, const Grid&,     \
                                         const Decomposition&);                                   \
  template double wall_power_integral(const Field<Real>&, const Grid&, const Decomposition&);     \
  template double convective_power_integral(const Field<Real>&, const Field<Real>&, const Grid&,  \
                                            const Decomposition&);                                \
  template double largest_divergence(const Field<Real>&, const Grid&, const Decomposition&);      \
  template double streamwise_sum(const Field<Real>&, const Grid&, const Decomposition&);          \
  template double largest_local_speed(const Field<Real>&, const Grid&, const Decomposition&);     \
  template double local_wall_sum(const Field<Real>&, const Grid&, const Decomposition&);          \
  template std::array<double, 2> mean_wall_stress(const Field<Real>&, const Grid&,                \
                                                  const Decomposition&, double);                  \
  template BadPlace find_not_finite(const Field<Real>&, const Decomposition&);                    \
  template std::array<int, 3> find_fastest(const Field<Real>&, const Grid&, const Decomposition&);
BEDLOAD_INSTANTIATE(float)
BEDLOAD_INSTANTIATE(double)
#undef BEDLOAD_INSTANTIATE

}  // namespace bedload
