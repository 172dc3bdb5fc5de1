#include "fluid/channel/implicit_diffusion.hpp"

#include <algorithm>

#include "fluid/kernels/prefetch.hpp"

namespace bedload {

template <class Real>
ImplicitDiffusion<Real>::ImplicitDiffusion(bool on, double viscosity, const Grid& grid,
                                           const Decomposition& decomposition,
                                           const WallGhosts<Real>& walls)
    : viscosity_(viscosity), grid_(grid), decomposition_(decomposition), walls_(walls) {
  if (!on) return;
  solvers_.reserve(3);
  for (int c = 0; c < 3; ++c) solvers_.emplace_back(grid, decomposition, c);
}

template <class Real>
void ImplicitDiffusion<Real>::solve(Predictor<Real>& predictor, Field<Real>& velocity,
                                    double after_dt, const Kick& kick, PhaseClock& clock) {
  const double shift = grid_.h * grid_.h / (after_dt * viscosity_);
  for (PoissonSolver<Real>& solver : solvers_) solver.set_shift(shift);
  for (int j = 0; j < decomposition_.planes(); ++j)
    eliminate_plane(predictor, j, shift, kick, clock);
  for (PoissonSolver<Real>& solver : solvers_) solver.couple();
  for (int j = decomposition_.planes() - 1; j >= 0; --j) {
    for (PoissonSolver<Real>& solver : solvers_) solver.substitute(j, j + 1);
    add_increment(velocity, j);
    clock.lap(FlowPhase::substitution);
  }
  walls_.close_block(velocity);
}

template <class Real>
void ImplicitDiffusion<Real>::eliminate_plane(Predictor<Real>& predictor, int j, double shift,
                                              const Kick& kick, PhaseClock& clock) {
  const int nx = grid_.cells[0], nz = decomposition_.rows(), planes = decomposition_.planes();
  const auto rhs_row = [&](int c, int k) {
    return solvers_[static_cast<std::size_t>(c)].rhs_row(j, k);
  };
  predictor.implicit_plane(j, rhs_row);
  for (int c = 0; j < kick.planes && c < 3; ++c)
    for (int k = 0; k < nz; ++k) {
      Real* rhs = rhs_row(c, k);
      const Real* change = kick.change->row(j, k, c);
      for (int i = 0; i < nx; ++i) rhs[i] += change[i];
    }
  // What flows through walls does not change.
  if (!grid_.periodic(0))
    for (int k = 0; k < nz; ++k) rhs_row(0, k)[nx - 1] = Real(0);
  if (decomposition_.at_front_wall()) std::fill_n(rhs_row(2, nz - 1), nx, Real(0));
  if (decomposition_.at_upper_wall() && j == planes - 1)
    for (int k = 0; k < nz; ++k) std::fill_n(rhs_row(1, k), nx, Real(0));
  if (decomposition_.divides_rows())  // nothing for the block in front
    for (int c = 0; c < 3; ++c) std::fill_n(rhs_row(c, nz), nx, Real(0));
  clock.lap(FlowPhase::momentum);
  const double cell = grid_.thickness(decomposition_.first() + j),
               face = grid_.gap(decomposition_.first() + j);
  solvers_[0].eliminate(j, j + 1, -shift * cell);
  solvers_[1].eliminate(j, j + 1, -shift * face);
  solvers_[2].eliminate(j, j + 1, -shift * cell);
  clock.lap(FlowPhase::elimination);
}

template <class Real>
void ImplicitDiffusion<Real>::add_increment(Field<Real>& velocity, int j) {
  const int nz = decomposition_.rows();
  for (int k = 0; k < nz; ++k) {
    if (k + 1 < nz) ask_to_write(velocity.row_block(j, k + 1), velocity.row_size());
    for (int c = 0; c < 3; ++c) {
      Real* q = velocity.row(j, k, c);
      const Real* d = solvers_[static_cast<std::size_t>(c)].solution_row(j, k);
      for (int i = 0; i < grid_.cells[0]; ++i) q[i] += d[i];
      walls_.close_row(q, c);
    }
  }
  walls_.close_plane(velocity, j);
}

template class ImplicitDiffusion<float>;
template class ImplicitDiffusion<double>;

}  // namespace bedload
