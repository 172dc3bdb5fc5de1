#include "liggghts_styles/film_system.hpp"

#include <algorithm>
#include <cassert>

namespace bedload {

void FilmSystem::begin(int spheres, std::size_t films) {
  accelerations_.resize(static_cast<std::size_t>(spheres) + 1);
  films_.clear();
  for (Values* values : {&force_, &compliance_, &share_, &own_, &direction_, &residual_, &moved_})
    values->resize(static_cast<Eigen::Index>(films));
}

void FilmSystem::add(int i, int j, const Vector& normal, double inverse_mass_i,
                     double inverse_mass_j, double compliance, double force, double share) {
  const std::size_t first = static_cast<std::size_t>(i), nowhere = accelerations_.size() - 1,
                    second = j < 0 ? nowhere : static_cast<std::size_t>(j);
  const auto k = static_cast<Eigen::Index>(films_.size());
  films_.push_back({.normal = {normal[0], normal[1], normal[2], 0.0},
                    .push_i = inverse_mass_i,
                    .push_j = share == 1.0 ? inverse_mass_j : 0.0,
                    .i = static_cast<std::uint32_t>(first),
                    .j = static_cast<std::uint32_t>(second)});
  own_[k] = inverse_mass_i + inverse_mass_j;
  compliance_[k] = compliance;
  force_[k] = force;
  share_[k] = share;
}

/// Accelerations of all spheres by the given forces of the films. Those of one sphere i come one
/// behind the other, so that its sum stays in a register.
void FilmSystem::accelerate(const Values& forces) {
  std::fill(accelerations_.begin(), accelerations_.end(), Eigen::Vector4d::Zero());
  const double* force = forces.data();
  for (auto film = films_.begin(); film != films_.end();) {
    const std::uint32_t i = film->i;
    Eigen::Vector4d sum = accelerations_[i];
    for (; film != films_.end() && film->i == i; ++film, ++force) {
      sum += film->push_i * *force * film->normal;
      accelerations_[film->j] -= film->push_j * *force * film->normal;
    }
    accelerations_[i] = sum;
  }
}

/// moved = A F + diagonal F.
void FilmSystem::find_moved(const Values& forces, const Values& diagonal, const Ranks& ranks) {
  accelerate(forces);
  ranks.refresh();
  double* moved = moved_.data();
  for (const Film& film : films_)
    *moved++ = film.normal.dot(accelerations_[film.i] - accelerations_[film.j]);
  moved_ += diagonal * forces;
}

/// Conjugate gradients with D as preconditioner, from F = F_alone. A film that shares no sphere has
/// no residual but rounding, and keeps its force to the last bit.
///
/// One sum over the ranks in each iteration: with residual r, direction p and s = (D + A - diag A)
/// p it brings p.s, and what the next square r.r/D is made of before the step alpha = (r.r/D)/p.s
/// is known,
///
///   (r - alpha s).(r - alpha s)/D = r.r/D - 2 alpha r.s/D + alpha^2 s.s/D,
///
/// whose cancellation does not add up, as r.r/D itself is summed anew in each iteration (Meurant,
/// Parallel Computing 5, 267, 1987). The first sum also says whether there are films at all.
bool FilmSystem::solve(double tolerance, int most_iterations, const Ranks& ranks) {
  assert(static_cast<Eigen::Index>(films_.size()) == force_.size());  // as many as begin() was told
  const Values yielding = 1.0 / compliance_, weight = share_ * yielding;
  find_moved(force_, -own_, ranks);
  residual_ = -moved_;
  direction_ = yielding * residual_;
  std::array<double, 3> first{static_cast<double>(films_.size()),
                              (share_ * compliance_ * force_ * force_).sum(),
                              (weight * residual_ * residual_).sum()};  // films; F.F D; r.r/D
  ranks.sum(first);
  const Values slack = compliance_ - own_;
  const double enough = tolerance * tolerance * first[1];
  double square = first[2];
  for (int n = 0; n < most_iterations && square > enough; ++n) {
    find_moved(direction_, slack, ranks);
    std::array<double, 4> sums{(share_ * direction_ * moved_).sum(),  // p.s, r.r/D, r.s/D, s.s/D
                               (weight * residual_ * residual_).sum(),
                               (weight * residual_ * moved_).sum(),
                               (weight * moved_ * moved_).sum()};
    ranks.sum(sums);
    const double step = sums[1] / sums[0];
    square = std::max(0.0, sums[1] - 2.0 * step * sums[2] + step * step * sums[3]);
    force_ += step * direction_;
    residual_ -= step * moved_;
    direction_ = yielding * residual_ + square / sums[1] * direction_;
  }
  return first[0] > 0.0;
}

}  // namespace bedload
