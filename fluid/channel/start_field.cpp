#include "fluid/channel/start_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace bedload {
namespace {

constexpr double pi = std::numbers::pi;

/// One divergence-free disturbance with the vector potential (a_x, 0, a_z) S(eta) cos(theta),
/// theta = kx x + kz z + phase, S = sin(pi eta) sin(order pi eta): velocity and wall velocity
/// vanish at both ends of the depth.
///   u = a_z S' cos,   v = (a_z kx - a_x kz) S sin,   w = -a_x S' cos
struct Mode {
  double a_x, a_z, kx, kz, phase;
  int order;
};

/// A number in [0, 1) from the bits themselves: the same with every standard library.
double uniform(std::mt19937_64& bits) { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

/// cos(kx x) and sin(kx x) along a row, so that cos(kx x + a) takes no further cosine.
struct WaveTable {
  std::vector<double> cosine, sine;

  WaveTable(double kx, double first, double h, int count) {
    for (int i = 0; i < count; ++i) {
      cosine.push_back(std::cos(kx * (first + i * h)));
      sine.push_back(std::sin(kx * (first + i * h)));
    }
  }
  /// sum += size cos(kx x + angle)
  void add_cosine(double size, double angle, std::vector<double>& sum) const {
    const double c = size * std::cos(angle), s = size * std::sin(angle);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += c * cosine[i] - s * sine[i];
  }
  /// sum += size sin(kx x + angle)
  void add_sine(double size, double angle, std::vector<double>& sum) const {
    add_cosine(size, angle - 0.5 * pi, sum);
  }
};

std::vector<Mode> disturbance_modes(const Settings& settings, const Grid& grid) {
  constexpr int random_modes = 32;
  const double amplitude = settings.start.disturbance * settings.start.velocity;
  std::vector<Mode> modes;
  if (amplitude == 0.0) return modes;
  const double depth = grid.length[1] - settings.start.height;
  const double lx = grid.length[0], lz = grid.length[2];

  const double rolls = std::max(1.0, std::round(lz / (2.0 * depth)));
  const double k_roll = 2.0 * pi * rolls / lz;
  modes.push_back(
      {.a_x = amplitude / k_roll, .a_z = 0.0, .kx = 0.0, .kz = k_roll, .phase = 0.0, .order = 1});

  std::mt19937_64 bits(static_cast<std::uint64_t>(settings.start.seed));
  const auto highest = [depth](double length, int cells) {
    return std::clamp(static_cast<int>(std::lround(3.0 * length / depth)), 1,
                      std::max(1, cells / 6));
  };
  const int highest_x = highest(lx, grid.cells[0]), highest_z = highest(lz, grid.cells[2]);
  for (int n = 0; n < random_modes; ++n) {
    const double mx = std::floor(1.0 + highest_x * uniform(bits));
    const double mz = std::floor((2 * highest_z + 1) * uniform(bits)) - highest_z;
    const int order = 1 + static_cast<int>(3.0 * uniform(bits));
    const double kx = 2.0 * pi * mx / lx, kz = 2.0 * pi * mz / lz;
    const double k = std::sqrt(kx * kx + kz * kz + std::pow((order + 1) * pi / depth, 2));
    const double size = 2.0 * amplitude / (k * std::sqrt(double(random_modes)));
    const double direction = 2.0 * pi * uniform(bits);
    modes.push_back({.a_x = size * std::cos(direction),
                     .a_z = size * std::sin(direction),
                     .kx = kx,
                     .kz = kz,
                     .phase = 2.0 * pi * uniform(bits),
                     .order = order});
  }
  return modes;
}

}  // namespace

StartProfile::Couette::Couette(const Grid& grid, std::size_t direction)
    : lower(grid.walls[direction][0] == Wall::no_slip),
      upper(grid.walls[direction][1] == Wall::no_slip),
      lower_velocity(grid.wall_velocity[direction][0]),
      upper_velocity(grid.wall_velocity[direction][1]) {}

double StartProfile::Couette::at(double share, std::size_t component) const {
  const double from = lower ? lower_velocity[component] : upper_velocity[component];
  const double to = upper ? upper_velocity[component] : lower_velocity[component];
  return lower || upper ? from + (to - from) * share : 0.0;
}

StartProfile::StartProfile(const Settings& settings, const Grid& grid)
    : kind_(settings.start.from),
      y_walls_(grid, 1),
      width_(grid.length[2]),
      y_is_periodic_(grid.periodic(1)),
      bottom_(settings.start.height),
      depth_(grid.length[1] - settings.start.height),
      velocity_(settings.start.velocity),
      viscosity_(settings.fluid.kinematic_viscosity) {
  if (bottom_ > 0.0) {  // a bed, at rest
    y_walls_.lower = true;
    y_walls_.lower_velocity = {};
  }
  const bool held = y_walls_.lower || y_walls_.upper;
  if (!held) z_walls_ = Couette(grid, 2);
  if (kind_ != Start::logarithmic || velocity_ == 0.0 || !held) return;
  double low = 0.0, high = std::abs(velocity_);  // u_tau from the mean velocity, by bisection
  const auto too_slow = [&](double u_tau) {
    friction_velocity_ = u_tau;
    return mean() < std::abs(velocity_);
  };
  while (too_slow(high)) high *= 2.0;  // slow flows: u_tau is above their velocity
  for (int n = 0; n < 100; ++n) {
    const double middle = 0.5 * (low + high);
    (too_slow(middle) ? low : high) = middle;
  }
}

double StartProfile::law_of_the_wall(double s) const {
  const double y_plus = s * friction_velocity_ / viscosity_;
  return friction_velocity_ *
         (std::log(1.0 + 0.4 * y_plus) / 0.4 +
          7.8 * (1.0 - std::exp(-y_plus / 11.0) - y_plus / 11.0 * std::exp(-y_plus / 3.0)));
}

double StartProfile::mean() const {
  constexpr int points = 2000;
  double sum = 0.0;
  for (int n = 0; n < points; ++n) sum += std::abs(shape((n + 0.5) / points));
  return sum / points;
}

/// The profile at the share s of the depth.
double StartProfile::shape(double s) const {
  const bool lower = y_walls_.lower, upper = y_walls_.upper;
  if (kind_ == Start::logarithmic) {
    if (!lower && !upper) return velocity_;
    double distance = depth_ * (lower ? s : 1.0 - s);
    if (lower && upper) distance = depth_ * std::min(s, 1.0 - s);
    return std::copysign(law_of_the_wall(distance), velocity_);
  }
  const double parabola = lower && upper ? 6.0 * s * (1.0 - s)
                          : lower        ? 1.5 * s * (2.0 - s)
                          : upper        ? 1.5 * (1.0 - s) * (1.0 + s)
                                         : 1.0;
  return velocity_ * parabola + y_walls_.at(s, 0);
}

double StartProfile::operator()(double y) const {
  if (kind_ == Start::rest || kind_ == Start::state || y < bottom_) return 0.0;
  return shape((y - bottom_) / depth_);
}

double StartProfile::across(double y) const {
  if (kind_ != Start::laminar || y < bottom_) return 0.0;
  return y_walls_.at((y - bottom_) / depth_, 2);
}

std::array<double, 2> StartProfile::between_z_walls(double z) const {
  if (kind_ != Start::laminar) return {};
  const double s = z / width_;
  return {z_walls_.at(s, 0), y_is_periodic_ ? z_walls_.at(s, 1) : 0.0};
}

template <class Real>
void write_start_field(Field<Real>& velocity, const Settings& settings, const Grid& grid,
                       const Decomposition& decomposition) {
  const StartProfile profile(settings, grid);
  const bool with_modes =
      settings.start.from == Start::laminar || settings.start.from == Start::logarithmic;
  const std::vector<Mode> modes =
      with_modes ? disturbance_modes(settings, grid) : std::vector<Mode>{};
  const double bottom = settings.start.height, depth = grid.length[1] - bottom;
  const int nx = grid.cells[0];
  std::vector<WaveTable> at_centres, at_faces;
  for (const Mode& m : modes) {
    at_centres.emplace_back(m.kx, grid.centre(0), grid.h, nx);
    at_faces.emplace_back(m.kx, grid.face(0), grid.h, nx);
  }

  std::vector<double> u(static_cast<std::size_t>(nx)), v(u.size()), w(u.size());
  for (int j = 0; j < decomposition.planes(); ++j) {
    const double y = grid.y_centre(decomposition.first() + j),
                 y_face = grid.y_face(decomposition.first() + j);
    const double at_centre = pi * std::clamp((y - bottom) / depth, 0.0, 1.0);
    const double at_face = pi * std::clamp((y_face - bottom) / depth, 0.0, 1.0);
    for (int k = 0; k < decomposition.rows(); ++k) {
      const double z = grid.centre(decomposition.first_row() + k),
                   z_up = grid.face(decomposition.first_row() + k);
      const std::array<double, 2> sideways = profile.between_z_walls(z);
      std::fill(u.begin(), u.end(), profile(y) + sideways[0]);
      std::fill(v.begin(), v.end(), sideways[1]);
      std::fill(w.begin(), w.end(), profile.across(y));
      for (std::size_t n = 0; n < modes.size(); ++n) {
        const Mode& m = modes[n];
        const double slope = pi / depth *
                             (std::cos(at_centre) * std::sin(m.order * at_centre) +
                              m.order * std::sin(at_centre) * std::cos(m.order * at_centre));
        const double value = std::sin(at_face) * std::sin(m.order * at_face);
        const double z_centre = m.kz * z + m.phase;
        const double z_face = m.kz * z_up + m.phase;
        at_faces[n].add_cosine(m.a_z * slope, z_centre, u);
        at_centres[n].add_sine((m.a_z * m.kx - m.a_x * m.kz) * value, z_centre, v);
        at_centres[n].add_cosine(-m.a_x * slope, z_face, w);
      }
      const auto store = [&](int c, const std::vector<double>& values) {
        std::transform(values.begin(), values.end(), velocity.row(j, k, c),
                       [](double number) { return static_cast<Real>(number); });
      };
      store(0, u);
      store(1, v);
      store(2, w);
    }
  }
}

template void write_start_field(Field<float>&, const Settings&, const Grid&, const Decomposition&);
template void write_start_field(Field<double>&, const Settings&, const Grid&, const Decomposition&);

}  // namespace bedload
