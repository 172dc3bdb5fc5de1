// Momentum and angular momentum of fluid and spheres together, in all directions, against what
// comes from outside: to round-off, in each stage.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "fluid/channel/channel.hpp"
#include "fluid/channel/runge_kutta.hpp"
#include "tests/fluid/flow_case.hpp"

namespace bedload {
namespace {

/// Linear and angular momentum, the latter about the origin.
struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();

  void add(const Vec3& place, const Vec3& momentum, const Vec3& spin = Vec3::Zero()) {
    linear += momentum;
    angular += place.cross(momentum) + spin;
  }
};
Momentum operator-(const Momentum& a, const Momentum& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}

/// Factors of the terms: all 1 unless a test plants a mistake (0 leaves a term out, -1 turns its
/// sign, 2 doubles it).
struct Factors {
  double load = 1.0, torque = 1.0;  ///< what moves the spheres
  double driving = 1.0, fixed = 1.0, seams = 1.0, levers = 1.0;
  double inside = 1.0, inside_angular = 1.0;  ///< fluid inside that stands for the spheres
};

/// Spheres in a flow that fills a box without walls, moved by their loads as LIGGGHTS does it: a
/// load is constant over its stage, x += v t + F t^2/2m, v += F t/m. One rank.
class Moving {
 public:
  Moving(const Settings& s, std::vector<SphereState> all, double density_ratio,
         const Factors& factor = {})
      : all_(std::move(all)),
        channel_(s, MPI_COMM_SELF, all_),
        ratio_(density_ratio),
        factor_(factor) {
    const double h = channel_.grid().h, wave = 2.0 * std::numbers::pi / (20.0 * h);
    channel_.set_velocity([wave](int c, const Vec3& x) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      return 0.3 + std::sin(wave * x[a] + 0.4 * c) + 0.5 * std::cos(wave * (x[b] - x[c]));
    });
  }

  /// One stage; returns by how much fluid and spheres change beyond what is known to come from
  /// outside: driving, fixed spheres, and flow and stress through the seams of the box.
  Momentum stage(int number) {
    const Stage& rk = runge_kutta[static_cast<std::size_t>(number)];
    const double whole = channel_.time_step(), dt = rk.two_alpha * whole;
    const Momentum before = total();
    const Vec3 seams = turned_through_seams();
    Momentum given;
    given.angular = factor_.seams * whole * (rk.gamma * seams + rk.zeta * seams_before_);
    seams_before_ = seams;

    channel_.predict(number);
    const std::vector<SphereLoad> loads = channel_.force_spheres(number);
    const double pushed = dt * channel_.settings().flow.pressure_gradient;
    const auto& length = channel_.grid().length;
    given.add(0.5 * Vec3(length[0], length[1], length[2]),
              factor_.driving * Vec3(pushed * channel_.grid().volume(), 0.0, 0.0));
    given.linear += factor_.fixed * dt * channel_.forcing().force_of_fixed;
    channel_.project(number);

    // What is inside a sphere now belongs to where the sphere was when the load was found.
    const std::vector<SphereAccount> accounts = channel_.immersed_boundary()->accounts();
    std::vector<SphereState> moved;
    Vec3 levers = Vec3::Zero();
    for (std::size_t n = 0; n < loads.size(); ++n) {
      SphereState& s = sphere(loads[n].tag);
      EXPECT_GT(loads[n].force.norm(), 0.05) << "a load that vanishes would balance anything";
      const Vec3 start = s.position, impulse = factor_.load * dt * loads[n].force;
      if (!accounts_.empty())  // the account moved with the sphere since
        levers -= (start - places_[n]).cross(accounts_[n].linear);
      s.position += dt * s.velocity + 0.5 * dt * impulse / mass(s);
      s.velocity += impulse / mass(s);
      s.angular_velocity +=
          factor_.torque * dt * loads[n].torque / (0.4 * mass(s) * s.radius * s.radius);
      // The sphere moves under the load, the fluid felt it where it was.
      levers += 0.5 * (s.position - start).cross(impulse);
      if (places_.size() <= n) places_.resize(n + 1);
      places_[n] = start;
      moved.push_back(s);
    }
    accounts_ = accounts;
    channel_.move_spheres(moved, channel_.time_step());
    given.angular += factor_.levers * levers;
    return total() - before - given;
  }

  /// Of fluid and mobile spheres, without what is counted twice: the fluid inside the spheres.
  Momentum total() const {
    Momentum sum;
    const Grid& grid = channel_.grid();
    const double mass_of_cell = channel_.settings().fluid.density * grid.cell_volume();
    for (int j = 0; j < grid.cells[1]; ++j)
      for (int k = 0; k < grid.cells[2]; ++k)
        for (int i = 0; i < grid.cells[0]; ++i)
          for (int c = 0; c < 3; ++c) {
            Vec3 place(grid.centre(i), grid.centre(j), grid.centre(k));
            place[c] += 0.5 * grid.h;
            sum.add(place, mass_of_cell * channel_.velocity().row(j, k, c)[i] * Vec3::Unit(c));
          }
    for (const SphereState& s : all_)
      if (s.mobile)
        sum.add(s.position, mass(s) * s.velocity,
                0.4 * mass(s) * s.radius * s.radius * s.angular_velocity);
    for (std::size_t n = 0; n < accounts_.size(); ++n)
      sum.add(places_[n], -factor_.inside * accounts_[n].linear,
              -factor_.inside_angular * accounts_[n].angular);
    return sum;
  }

  void finish_step() { channel_.finish_step(); }

 private:
  double mass(const SphereState& s) const {
    return ratio_ * channel_.settings().fluid.density * 4.0 / 3.0 * std::numbers::pi *
           std::pow(s.radius, 3);
  }
  SphereState& sphere(std::int64_t tag) {
    for (SphereState& s : all_)
      if (s.tag == tag) return s;
    throw std::out_of_range("no such sphere");
  }
  double u(int c, std::array<int, 3> at) const {
    for (std::size_t d = 0; d < 3; ++d) at[d] %= channel_.grid().cells[d];
    return channel_.velocity().row(at[1], at[2], c)[at[0]];
  }
  /// Flow and viscous stress of component c through the seam of direction b: per area and density,
  /// (u_b u_c - nu du_c/dx_b), summed over the seam.
  double through_seam(int c, int b) const {
    const Grid& grid = channel_.grid();
    const auto direction = static_cast<std::size_t>(b), normal = static_cast<std::size_t>(c);
    double sum = 0.0;
    std::array<int, 3> at{}, most = grid.cells;
    most[direction] = 1;
    for (at[0] = 0; at[0] < most[0]; ++at[0])
      for (at[1] = 0; at[1] < most[1]; ++at[1])
        for (at[2] = 0; at[2] < most[2]; ++at[2]) {
          std::array<int, 3> lower = at, beside = at;
          lower[direction] = grid.cells[direction] - 1;
          beside = lower;
          ++beside[normal];
          const double below = u(c, lower), above = u(c, at);
          sum += 0.25 * (u(b, lower) + u(b, beside)) * (below + above) -
                 channel_.settings().fluid.kinematic_viscosity * (above - below) / grid.h;
        }
    return sum;
  }
  /// Torque by what leaves the box at one end and comes in at the other, a box length away:
  ///   dL_a/dt = rho h^2 (L_c sum F_bc - L_b sum F_cb),   (a, b, c) cyclic.
  Vec3 turned_through_seams() const {
    const Grid& grid = channel_.grid();
    Vec3 torque;
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      torque[a] = grid.length[static_cast<std::size_t>(c)] * through_seam(b, c) -
                  grid.length[static_cast<std::size_t>(b)] * through_seam(c, b);
    }
    return channel_.settings().fluid.density * grid.h * grid.h * torque;
  }

  std::vector<SphereState> all_;
  Channel<double> channel_;
  double ratio_;
  Factors factor_;
  std::vector<SphereAccount> accounts_;
  std::vector<Vec3> places_;  ///< of the spheres when the accounts were made
  Vec3 seams_before_ = Vec3::Zero();
};

Settings without_walls() {
  Settings s = box({22, 20, 20}, 0.1, 0.01, 0.01);
  set_y_ends(s, Wall::periodic, Wall::periodic);
  s.fluid.density = 1.7;
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.8;
  s.spheres.forcing_loops = 2;
  return s;
}

SphereState sphere(std::int64_t tag, const Vec3& position, double radius, bool mobile) {
  return {.tag = tag,
          .position = position,
          .velocity = mobile ? Vec3(0.2, -0.1, 0.3) : Vec3::Zero(),
          .angular_velocity = mobile ? Vec3(1.0, 0.5, -2.0) : Vec3::Zero(),
          .radius = radius,
          .mobile = mobile};
}

// Momenta are of order 1 to 10 and sums of 2.6e4 terms: round-off 1e-13. Any term that is left out,
// doubled or turned in sign shows as 1e-4 or more (the loads alone as 1e-3 and above).
constexpr double round_off = 1e-11;

TEST(Budget, MomentumOfFluidAndSpheresIsThatFromOutside) {
  for (const double ratio : {0.8, 2.5}) {
    Moving all(without_walls(),
               {sphere(1, {0.65, 0.98, 0.71}, 0.4, true), sphere(2, {1.5, 1.1, 1.2}, 0.35, true),
                sphere(3, {2.05, 0.2, 0.1}, 0.3, false)},
               ratio);
    all.stage(0);  // what is inside at the very start belongs to nobody's motion yet
    for (int stage = 1; stage < 9; ++stage) {
      const Momentum left = all.stage(stage % 3);
      EXPECT_LT(left.linear.norm(), round_off) << "stage " << stage;
      if (stage % 3 == 2) all.finish_step();
    }
  }
}

TEST(Budget, AngularMomentumOfFluidAndSpheresIsThatFromOutside) {
  for (const double ratio : {0.8, 2.5}) {
    Moving all(without_walls(),
               {sphere(1, {0.65, 0.98, 0.71}, 0.4, true), sphere(2, {1.5, 1.1, 1.2}, 0.35, true)},
               ratio);
    all.stage(0);
    for (int stage = 1; stage < 9; ++stage) {
      const Momentum left = all.stage(stage % 3);
      EXPECT_LT(left.linear.norm(), round_off) << "stage " << stage;
      EXPECT_LT(left.angular.norm(), round_off) << "stage " << stage;
      if (stage % 3 == 2) all.finish_step();
    }
  }
}

TEST(Budget, ReportsEveryTermThatIsLeftOutDoubledOrTurned) {
  struct Term {
    const char* name;
    double Factors::*factor;
    bool angular;  ///< shows in the angular momentum, whose balance is without fixed spheres
  };
  for (const Term& term : {Term{"load", &Factors::load, false},
                           {"torque", &Factors::torque, true},
                           {"driving", &Factors::driving, false},
                           {"fixed", &Factors::fixed, false},
                           {"seams", &Factors::seams, true},
                           {"levers", &Factors::levers, true},
                           {"inside", &Factors::inside, false},
                           {"inside, angular", &Factors::inside_angular, true}})
    for (const double planted : {0.0, 2.0, -1.0}) {
      Factors factors;
      factors.*term.factor = planted;
      std::vector<SphereState> spheres{sphere(1, {0.65, 0.98, 0.71}, 0.4, true),
                                       sphere(2, {1.5, 1.1, 1.2}, 0.35, true)};
      if (!term.angular) spheres.push_back(sphere(3, {2.05, 0.2, 0.1}, 0.3, false));
      Moving all(without_walls(), spheres, 2.5, factors);
      all.stage(0);
      double largest = 0.0;
      for (int stage = 1; stage < 3; ++stage) {
        const Momentum left = all.stage(stage);
        largest = std::max(largest, term.angular ? left.angular.norm() : left.linear.norm());
      }
      EXPECT_GT(largest, 1e5 * round_off) << term.name << " times " << planted;
    }
}

}  // namespace
}  // namespace bedload
