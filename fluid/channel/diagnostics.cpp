#include "fluid/channel/diagnostics.hpp"

#include <algorithm>
#include <cmath>

#include "fluid/channel/projection.hpp"

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

// -u_c (u_{i+1} - 2 u_i + u_{i-1} + the same along z) w - u_c (difference of d u/dy above and
// below), w the height of the cell of u_c in h.
template <class Real>
double viscous_loss_integral(const Field<Real>& velocity, const Grid& grid,
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
        const Real* q = velocity.row(j, k, c);
        const Real *up = velocity.row(j + 1, k, c), *down = velocity.row(j - 1, k, c);
        const Real *front = velocity.row(j, k + 1, c), *back = velocity.row(j, k - 1, c);
        sum -= row_total(velocity.nx(), [&](int i) {
          const double here = double(q[i]);
          const double level =
              double(q[i - 1]) + double(q[i + 1]) + double(front[i]) + double(back[i]) - 4.0 * here;
          return here * (height * level + above * (double(up[i]) - here) -
                         below * (here - double(down[i])));
        });
      }
    }
  }
  return grid.cell_volume() * all_ranks(sum, MPI_SUM, decomposition.comm());
}

// u (p_{i+1} - p_i) h_y/h + v (p_{j+1} - p_j) + w (p_{k+1} - p_k) h_y/h, h_y the height of the
// cell: times h^2 the sum of u . grad p dV.
template <class Real>
double pressure_power_integral(const Field<Real>& velocity, const Field<Real>& pressure,
                               const Grid& grid, const Decomposition& decomposition) {
  double sum = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    const double height = grid.thickness(decomposition.first() + j);
    for (int k = 0; k < velocity.nz(); ++k) {
      const Real *u = velocity.row(j, k, 0), *v = velocity.row(j, k, 1), *w = velocity.row(j, k, 2);
      const Real *p = pressure.row(j, k), *above = pressure.row(j + 1, k);
      const Real* front = pressure.row(j, k + 1);
      sum += row_total(velocity.nx(), [&](int i) {
        const double here = double(p[i]);
        return height * (double(u[i]) * (double(p[i + 1]) - here) +
                         double(w[i]) * (double(front[i]) - here)) +
               double(v[i]) * (double(above[i]) - here);
      });
    }
  }
  return grid.cell_volume() / grid.h * all_ranks(sum, MPI_SUM, decomposition.comm());
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
  double sum = 0.0;
  for (int j = 0; j < velocity.planes(); ++j) {
    double plane = 0.0;
    for (int k = 0; k < velocity.nz(); ++k) plane += row_sum(velocity.nx(), velocity.row(j, k, 0));
    sum += plane * grid.thickness(decomposition.first() + j);
  }
  return all_ranks(sum, MPI_SUM, decomposition.comm());
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
  template double viscous_loss_integral(const Field<Real>&, const Grid&, const Decomposition&);   \
  template double pressure_power_integral(const Field<Real>&, const Field<Real>&, const Grid&,    \
                                          const Decomposition&);                                  \
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
