#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// A region of the box in which the flow is drawn to a uniform stream U e_x, so that what leaves a
/// periodic box does not come back: flow past spheres as in an unbounded stream (the fringe method,
/// Nordstrom, Nordin and Henningson, SIAM J. Sci. Comput. 20 (1999)). In each stage, of length dt,
///
///   u* <- (u* + lambda(x) dt U e_x) / (1 + lambda(x) dt),
///   lambda = rate sin^2(pi (x - begin) / (end - begin))   for begin < x < end,
///
/// which is stable for any rate.
template <class Real>
class Fringe {
 public:
  Fringe(const Settings::Fringe& settings, const Grid& grid)
      : on_(settings.rate > 0.0), velocity_(settings.velocity), grid_(grid) {
    if (!on_) return;
    const auto nx = static_cast<std::size_t>(grid.cells[0]);
    const auto strength = [&](double x) {
      const double place = (x - settings.begin) / (settings.end - settings.begin);
      if (place <= 0.0 || place >= 1.0) return 0.0;
      const double sine = std::sin(std::numbers::pi * place);
      return settings.rate * sine * sine;
    };
    for (std::size_t i = 0; i < nx; ++i) {
      on_faces_.push_back(strength(grid.face(static_cast<int>(i))));
      at_centres_.push_back(strength(grid.centre(static_cast<int>(i))));
    }
  }

  bool on() const { return on_; }

  /// Draws the own planes of the velocity, the first of which is plane `first` of the grid, x
  /// ghosts included; returns what the sum of u times the plane's thickness over them gained.
  double apply(Field<Real>& velocity, int first, double dt) {
    if (!on_) return 0.0;
    set_shares(on_faces_, dt, face_share_);
    set_shares(at_centres_, dt, centre_share_);
    double gained = 0.0;
    for (int j = 0; j < velocity.planes(); ++j) {
      const double thickness = grid_.thickness(first + j);
      for (int k = 0; k < velocity.nz(); ++k) {
        gained +=
            thickness * draw(velocity.row(j, k, 0), face_share_, static_cast<Real>(velocity_));
        draw(velocity.row(j, k, 1), centre_share_, Real(0));
        draw(velocity.row(j, k, 2), centre_share_, Real(0));
      }
      wrap_x_ghosts(velocity, j);
    }
    return gained;
  }

 private:
  static void set_shares(const std::vector<double>& lambda, double dt, std::vector<Real>& share) {
    share.resize(lambda.size());
    std::transform(lambda.begin(), lambda.end(), share.begin(),
                   [dt](double l) { return static_cast<Real>(l * dt / (1.0 + l * dt)); });
  }
  static double draw(Real* row, const std::vector<Real>& share, Real target) {
    double gained = 0.0;
    for (std::size_t i = 0; i < share.size(); ++i) {
      const Real before = row[i];
      row[i] += share[i] * (target - before);
      gained += static_cast<double>(row[i]) - static_cast<double>(before);
    }
    return gained;
  }

  bool on_;
  double velocity_;
  const Grid& grid_;
  std::vector<double> on_faces_, at_centres_;  ///< lambda where u, and where v and w live
  std::vector<Real> face_share_, centre_share_;
};

}  // namespace bedload
