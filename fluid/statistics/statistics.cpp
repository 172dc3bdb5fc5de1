#include "fluid/statistics/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>

#include "fluid/files/collectively.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/statistics/sphere_layer.hpp"

namespace bedload {
namespace {

/// Adds value(i), N numbers, over the points of a row to `sum`, in double and in eight interleaved
/// parts. `weight` is 0 at points inside spheres; nullptr: all are in the fluid. Returns how many
/// points were counted.
template <std::size_t N, class Value>
double add_row(int nx, const double* weight, std::array<double, N>& sum, Value&& value) {
  constexpr int parts = 8;
  double part[N][parts] = {};
  double count = nx;
  if (weight == nullptr) {
    int i = 0;
    for (; i + parts <= nx; i += parts)
      for (int lane = 0; lane < parts; ++lane) {
        const std::array<double, N> numbers = value(i + lane);
        for (std::size_t n = 0; n < N; ++n) part[n][lane] += numbers[n];
      }
    for (; i < nx; ++i) {
      const std::array<double, N> numbers = value(i);
      for (std::size_t n = 0; n < N; ++n) part[n][0] += numbers[n];
    }
  } else {
    count = 0.0;
    for (int i = 0; i < nx; ++i) {
      const std::array<double, N> numbers = value(i);
      for (std::size_t n = 0; n < N; ++n) part[n][i % parts] += weight[i] * numbers[n];
      count += weight[i];
    }
  }
  for (std::size_t n = 0; n < N; ++n)
    for (const double p : part[n]) sum[n] += p;
  return count;
}

std::vector<double> all_ranks(std::vector<double> values, MPI_Comm comm) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                comm);
  return values;
}

std::size_t modes_of(int cells) { return static_cast<std::size_t>(cells / 2 + 1); }

FourierPlan<double> line_plan(int n, AlignedArray<std::complex<double>>& in,
                              AlignedArray<std::complex<double>>& out) {
  return FourierPlan<double>::complex({{n}, 1}, reinterpret_cast<double*>(in.data()),
                                      reinterpret_cast<double*>(out.data()), FFTW_FORWARD);
}

/// Values at faces from those at the centres beside them, as the scheme takes them; on a wall,
/// where v is zero, any.
double at_face(const std::vector<double>& centre, std::size_t face, bool periodic) {
  const std::size_t n = centre.size();
  if (face > 0 && face < n) return 0.5 * (centre[face - 1] + centre[face]);
  if (periodic) return 0.5 * (centre.back() + centre.front());
  return face == 0 ? centre.front() : centre.back();
}

}  // namespace

template <class Real>
Statistics<Real>::Statistics(const Settings& settings, const Grid& grid,
                             const Decomposition& decomposition)
    : settings_(settings),
      grid_(grid),
      decomposition_(decomposition),
      blocks_(block_map(grid, decomposition)),
      planes_(static_cast<std::size_t>(grid.cells[1])),
      solid_(grid),
      sums_(quantities * planes_),
      first_(planes_),
      last_(planes_) {
  for (const double height : settings.statistics.spectra_heights) {
    int plane = 0;
    while (plane + 1 < grid.cells[1] && grid.y_face(plane) <= height) ++plane;
    spectrum_planes_.push_back(plane);
  }
  if (spectrum_planes_.empty()) return;
  const auto nx = static_cast<std::size_t>(grid.cells[0]),
             nz = static_cast<std::size_t>(grid.cells[2]);
  line_x_ = AlignedArray<std::complex<double>>(nx);
  line_z_ = AlignedArray<std::complex<double>>(nz);
  modes_ = AlignedArray<std::complex<double>>(std::max(nx, nz));
  plan_alike<double>(decomposition.comm(), 0, [&] {
    along_x_ = line_plan(grid.cells[0], line_x_, modes_);
    along_z_ = line_plan(grid.cells[2], line_z_, modes_);
  });
  spectra_.resize(spectrum_planes_.size() * 3 *
                  (modes_of(grid.cells[0]) + modes_of(grid.cells[2])));
}

template <class Real>
void Statistics<Real>::sample(const FlowView<Real>& flow, std::span<const SphereState> spheres,
                              double duration) {
  if (samples_ == 0) begin_ = flow.time;
  std::fill(last_.begin(), last_.end(), 0.0);
  for (int j = 0; j < decomposition_.planes(); ++j) add_plane(flow, spheres, j, duration);
  if (samples_ == 0) first_ = last_;
  add_walls(flow, duration);
  add_grains(spheres, duration);
  if (samples_ % settings_.statistics.spectra_every == 0) add_spectra(flow, duration);
  driving_ += duration * flow.driving;
  duration_ += duration;
  end_ = flow.time;
  ++samples_;
}

/// The products stand where the scheme has its fluxes: u v, for instance, on the edges between u
/// and v points, each the mean of two. So is the stress balance the scheme's own.
template <class Real>
void Statistics<Real>::add_plane(const FlowView<Real>& flow, std::span<const SphereState> spheres,
                                 int j, double duration) {
  const int nx = grid_.cells[0], nz = decomposition_.rows(), global = decomposition_.first() + j;
  const double y = grid_.y_centre(global), y_face = grid_.y_face(global);
  // One place of the cell: its height and offsets, its count, the quantities behind the count.
  const auto add = [&]<std::size_t N>(double height, double offset_x, double offset_z,
                                      Quantity count, std::array<Quantity, N> where,
                                      auto&& value_of_row) {
    if (!spheres.empty()) solid_.cut(spheres, height, offset_x, offset_z);
    const bool cut = !spheres.empty() && solid_.any();
    std::array<double, N> sum{};
    double points = 0.0;
    for (int k = 0; k < nz; ++k)
      points += add_row<N>(nx, cut ? solid_.weights(decomposition_.first_row() + k) : nullptr, sum,
                           value_of_row(k));
    *at(count, global) += duration * points;
    for (std::size_t n = 0; n < N; ++n) *at(where[n], global) += duration * sum[n];
    return cut ? std::nullopt : std::optional(sum[0]);
  };
  const auto square = [](const Real* row) {
    return [row](int i) {
      const double q = row[i];
      return std::array{q, q * q};
    };
  };
  const auto row = [&](int c, int k) { return flow.velocity.row(j, k, c); };
  const auto above = [&](int c, int k) { return flow.velocity.row(j + 1, k, c); };
  // a b at the point where the means of a1, a2 and of b1, b2 meet
  const auto product = [](const Real* a1, const Real* a2, const Real* b1, const Real* b2) {
    return [=](int i) {
      return std::array{0.25 * (double(a1[i]) + double(a2[i])) * (double(b1[i]) + double(b2[i]))};
    };
  };
  const auto uv_row = [&](int k) {
    return product(row(0, k), above(0, k), row(1, k), row(1, k) + 1);
  };
  add(y, 1.0, 0.5, count_u, std::array{u, uu}, [&](int k) { return square(row(0, k)); });
  add(y, 0.5, 1.0, count_w, std::array{w, ww}, [&](int k) { return square(row(2, k)); });
  add(y, 0.5, 0.5, count_p, std::array{p, pp},
      [&](int k) { return square(flow.pressure.row(j, k)); });
  add(y, 1.0, 1.0, count_uw, std::array{uw},
      [&](int k) { return product(row(0, k), row(0, k + 1), row(2, k), row(2, k) + 1); });
  add(y_face, 0.5, 0.5, count_v, std::array{v, vv}, [&](int k) { return square(row(1, k)); });
  const std::optional<double> whole_uv = add(y_face, 1.0, 0.5, count_uv, std::array{uv}, uv_row);
  add(y_face, 0.5, 1.0, count_vw, std::array{vw},
      [&](int k) { return product(row(2, k), above(2, k), row(1, k), row(1, k + 1)); });

  const auto over_all_points = [&](auto&& value_of_row) {
    std::array<double, 1> sum{};
    for (int k = 0; k < nz; ++k) add_row<1>(nx, nullptr, sum, value_of_row(k));
    return sum[0];
  };
  const double sum_u = over_all_points(
      [&](int k) { return [q = row(0, k)](int i) { return std::array{double(q[i])}; }; });
  last_[static_cast<std::size_t>(global)] = sum_u;
  *at(u_all, global) += duration * sum_u;
  *at(uv_all, global) += duration * (whole_uv ? *whole_uv : over_all_points(uv_row));
}

template <class Real>
void Statistics<Real>::add_walls(const FlowView<Real>& flow, double duration) {
  const auto add = [&](std::size_t end, int inner, int ghost) {
    for (int k = 0; k < decomposition_.rows(); ++k) {
      const Real *q = flow.velocity.row(inner, k, 0), *beyond = flow.velocity.row(ghost, k, 0);
      std::array<double, 1> sum{};
      add_row<1>(grid_.cells[0], nullptr, sum,
                 [=](int i) { return std::array{double(q[i]) - double(beyond[i])}; });
      wall_jump_[end] += duration * sum[0];
    }
  };
  if (decomposition_.at_lower_wall()) add(0, 0, -1);
  if (decomposition_.at_upper_wall()) add(1, decomposition_.planes() - 1, decomposition_.planes());
}

/// A sphere counts on the rank that holds its centre.
template <class Real>
void Statistics<Real>::add_grains(std::span<const SphereState> spheres, double duration) {
  for (const SphereState& sphere : spheres)
    if (blocks_.home(sphere.position) == decomposition_.rank()) add_grain(sphere, duration);
}

/// In a layer of the sphere that reaches from below to above its centre by s the mean velocity is
/// U + omega x (0, s, 0) = U + s (-omega_z, 0, omega_x).
template <class Real>
void Statistics<Real>::add_grain(const SphereState& sphere, double duration) {
  const int planes = grid_.cells[1];
  for (const double image : {0.0, -grid_.length[1], grid_.length[1]}) {
    if (image != 0.0 && !grid_.periodic(1)) continue;
    const double y = sphere.position.y() + image;
    // Cells around spheres are cubes of edge h.
    const int first = std::max(0, static_cast<int>(std::floor((y - sphere.radius) / grid_.h)) - 1);
    for (int j = first; j < planes && grid_.y_face(j - 1) < y + sphere.radius; ++j) {
      const auto [volume, moment] =
          sphere_layer(sphere.radius, grid_.y_face(j - 1) - y, grid_.y_face(j) - y);
      *at(grain_volume, j) += duration * volume;
      if (!sphere.mobile) continue;
      const Vec3 momentum =
          volume * sphere.velocity +
          moment * Vec3(-sphere.angular_velocity.z(), 0.0, sphere.angular_velocity.x());
      *at(mobile_volume, j) += duration * volume;
      *at(grain_u, j) += duration * momentum.x();
      *at(grain_v, j) += duration * momentum.y();
      *at(grain_w, j) += duration * momentum.z();
      *at(grain_spin, j) += duration * volume * sphere.angular_velocity.z();
    }
  }
}

/// Each plane is brought together on one rank, another one for each.
template <class Real>
void Statistics<Real>::add_spectra(const FlowView<Real>& flow, double duration) {
  if (spectrum_planes_.empty()) return;
  const auto nx = static_cast<std::size_t>(grid_.cells[0]),
             nz = static_cast<std::size_t>(grid_.cells[2]);
  std::vector<double> plane(nx * nz);
  for (std::size_t height = 0; height < spectrum_planes_.size(); ++height)
    for (int c = 0; c < 3; ++c) {
      std::fill(plane.begin(), plane.end(), 0.0);
      const int global = spectrum_planes_[height];
      if (decomposition_.holds_plane(global))
        for (int k = 0; k < decomposition_.rows(); ++k)
          std::copy_n(flow.velocity.row(global - decomposition_.first(), k, c), nx,
                      plane.data() + static_cast<std::size_t>(decomposition_.first_row() + k) * nx);
      const int root =
          static_cast<int>(height * 3 + static_cast<std::size_t>(c)) % decomposition_.ranks();
      const bool mine = decomposition_.rank() == root;
      MPI_Reduce(mine ? MPI_IN_PLACE : plane.data(), plane.data(), static_cast<int>(plane.size()),
                 MPI_DOUBLE, MPI_SUM, root, decomposition_.comm());
      if (mine) add_spectrum(plane, height, c, duration);
    }
  spectra_duration_ += duration;
}

/// E(k_m) dk = 2 |q_m|^2 / n^2, averaged over the lines; the last mode of an even n counts once.
template <class Real>
void Statistics<Real>::add_spectrum(std::span<const double> plane, std::size_t height,
                                    int component, double duration) {
  const auto nx = static_cast<std::size_t>(grid_.cells[0]),
             nz = static_cast<std::size_t>(grid_.cells[2]);
  const auto add_line = [&](const FourierPlan<double>& transform,
                            AlignedArray<std::complex<double>>& line, std::size_t n,
                            std::size_t lines, double length, double* to) {
    transform(reinterpret_cast<double*>(line.data()), reinterpret_cast<double*>(modes_.data()));
    const double scale = duration * length / (2.0 * M_PI) / (double(n) * double(n) * double(lines));
    for (std::size_t m = 1; m <= n / 2; ++m)
      to[m] += (2 * m == n ? 1.0 : 2.0) * scale * std::norm(modes_[m]);
  };
  for (std::size_t k = 0; k < nz; ++k) {
    std::copy_n(plane.begin() + static_cast<std::ptrdiff_t>(k * nx), nx, line_x_.data());
    add_line(along_x_, line_x_, nx, nz, grid_.length[0], spectrum(height, component, 0));
  }
  for (std::size_t i = 0; i < nx; ++i) {
    for (std::size_t k = 0; k < nz; ++k) line_z_[k] = plane[k * nx + i];
    add_line(along_z_, line_z_, nz, nx, grid_.length[2], spectrum(height, component, 2));
  }
}

template <class Real>
double* Statistics<Real>::spectrum(std::size_t height, int component, int direction) {
  const std::size_t x = modes_of(grid_.cells[0]), z = modes_of(grid_.cells[2]);
  return spectra_.data() + (height * 3 + static_cast<std::size_t>(component)) * (x + z) +
         (direction == 0 ? 0 : x);
}

template <class Real>
void Statistics<Real>::give_to_first_rank() {
  const bool first_rank = decomposition_.rank() == 0;
  const auto give = [&](double* numbers, std::size_t count) {
    MPI_Reduce(first_rank ? MPI_IN_PLACE : numbers, numbers, static_cast<int>(count), MPI_DOUBLE,
               MPI_SUM, 0, decomposition_.comm());
    if (!first_rank) std::fill_n(numbers, count, 0.0);
  };
  for (const auto& [name, list] : lists()) give(list->data(), list->size());
  give(wall_jump_.data(), wall_jump_.size());
}

template <class Real>
void Statistics<Real>::save(const SaveGroup& group) {
  give_to_first_rank();
  group.value("samples", samples_);
  group.value("begin", begin_);
  group.value("end", end_);
  group.value("duration", duration_);
  group.value("spectra_duration", spectra_duration_);
  group.value("driving", driving_);
  group.list<std::int32_t>("spectra_planes", spectrum_planes_);
  for (const auto& [name, list] : lists()) group.list<double>(name, *list);
  group.list<double>("wall_jump", wall_jump_);
}

/// Whether `statistics.from` lies behind all that the run before has averaged, so that it counts
/// from there; a time within cannot be met, as samples are not kept one by one.
template <class Real>
bool Statistics<Real>::begins_after(const LoadGroup& group) const {
  const double from = settings_.statistics.from;
  if (group.value<std::int64_t>("samples") == 0) return true;
  const double begin = group.value<double>("begin"), end = group.value<double>("end");
  const double digits = 1e-5 * std::abs(begin);  // of what the sentence says
  collectively(decomposition_.comm(), [&] {
    if (begin + digits < from && from <= end)
      throw UserError(fmt::format(
          "{}: 'statistics.from' is {}, within the time that the run before has averaged, {:.6g} "
          "to {:.6g}; give {:.6g}, and they go on, or a later time, and they begin anew.",
          settings_.file, from, begin, end, begin));
  });
  return from > end;
}

template <class Real>
void Statistics<Real>::load(const LoadGroup& group) {
  if (begins_after(group)) return;
  const bool first_rank = decomposition_.rank() == 0;
  collectively(decomposition_.comm(), [&] {
    bool fits = group.list<std::int32_t>("spectra_planes") == spectrum_planes_;
    for (const auto& [name, list] : lists()) fits = fits && group.size(name) == list->size();
    if (!fits)
      throw UserError(
          fmt::format("{}: the statistics of the run that is continued were taken with other "
                      "'statistics.spectra_heights' or on another grid.",
                      settings_.file));
    samples_ = group.value<std::int64_t>("samples");
    begin_ = group.value<double>("begin");
    end_ = group.value<double>("end");
    duration_ = group.value<double>("duration");
    spectra_duration_ = group.value<double>("spectra_duration");
    driving_ = group.value<double>("driving");
    if (!first_rank) return;
    for (const auto& [name, list] : lists()) *list = group.list<double>(name);
    const auto jump = group.list<double>("wall_jump");
    std::copy_n(jump.begin(), std::min(jump.size(), wall_jump_.size()), wall_jump_.begin());
  });
}

/// sum/count plane by plane; zero where nothing was counted.
template <class Real>
std::vector<double> Statistics<Real>::averages(Quantity sum, Quantity count,
                                               std::span<const double> sums) const {
  std::vector<double> mean(planes_);
  for (std::size_t j = 0; j < planes_; ++j) {
    const double points = sums[count * planes_ + j];
    if (points > 0.0) mean[j] = sums[sum * planes_ + j] / points;
  }
  return mean;
}

template <class Real>
typename Statistics<Real>::Totals Statistics<Real>::totals() const {
  const MPI_Comm comm = decomposition_.comm();
  return {all_ranks(sums_, comm), all_ranks(first_, comm), all_ranks(last_, comm),
          all_ranks(spectra_, comm), all_ranks({wall_jump_[0], wall_jump_[1]}, comm)};
}

template <class Real>
FlowStatistics Statistics<Real>::result() const {
  const Totals total = totals();
  FlowStatistics s;
  s.samples = samples_;
  s.begin = begin_;
  s.end = end_;
  if (samples_ == 0) return s;
  for (int j = 0; j < grid_.cells[1]; ++j) s.y.push_back(grid_.y_centre(j));
  for (int j = -1; j < grid_.cells[1]; ++j) s.y_face.push_back(grid_.y_face(j));
  fill_profiles(s, total);
  fill_grains(s, total);
  fill_balance(s, total);
  fill_friction(s);
  fill_spectra(s, total);
  return s;
}

template <class Real>
void Statistics<Real>::fill_profiles(FlowStatistics& s, const Totals& total) const {
  const std::vector<double>& sums = total.sums;
  // The lowest face is the lower wall's, where v is zero, or the uppermost one again.
  const auto with_lowest = [&](const std::vector<double>& upper_faces) {
    std::vector<double> all{grid_.periodic(1) ? upper_faces.back() : 0.0};
    all.insert(all.end(), upper_faces.begin(), upper_faces.end());
    return all;
  };
  const auto share = [&](Quantity count) {
    std::vector<double> values;
    for (std::size_t j = 0; j < planes_; ++j) {
      const double part = sums[count * planes_ + j] / plane_points();
      values.push_back(part > 1.0 - 1e-9 ? 1.0 : part);  // one point is more than the round-off
    }
    return values;
  };
  s.fluid = share(count_p);
  s.fluid_face = with_lowest(share(count_v));
  if (!grid_.periodic(1)) s.fluid_face.front() = 1.0;
  s.u = averages(u, count_u, sums);
  s.w = averages(w, count_w, sums);
  s.p = averages(p, count_p, sums);
  s.v = with_lowest(averages(v, count_v, sums));
  // <a'b'> = <a b> - <a><b>, the means brought to where the product stands
  s.uu = averages(uu, count_u, sums);
  s.ww = averages(ww, count_w, sums);
  s.pp = averages(pp, count_p, sums);
  s.uw = averages(uw, count_uw, sums);
  for (std::size_t j = 0; j < planes_; ++j) {
    s.uu[j] -= s.u[j] * s.u[j];
    s.ww[j] -= s.w[j] * s.w[j];
    s.pp[j] -= s.p[j] * s.p[j];
    s.uw[j] -= s.u[j] * s.w[j];
  }
  s.vv = with_lowest(averages(vv, count_v, sums));
  s.uv = with_lowest(averages(uv, count_uv, sums));
  s.vw = with_lowest(averages(vw, count_vw, sums));
  for (std::size_t f = 0; f <= planes_; ++f) {
    s.vv[f] -= s.v[f] * s.v[f];
    s.uv[f] -= s.v[f] * at_face(s.u, f, grid_.periodic(1));
    s.vw[f] -= s.v[f] * at_face(s.w, f, grid_.periodic(1));
  }
}

template <class Real>
void Statistics<Real>::fill_grains(FlowStatistics& s, const Totals& total) const {
  const auto share = [&](Quantity volume) {
    std::vector<double> values;
    for (std::size_t j = 0; j < planes_; ++j) {
      const double layer = (s.y_face[j + 1] - s.y_face[j]) * grid_.length[0] * grid_.length[2];
      values.push_back(total.sums[volume * planes_ + j] / (duration_ * layer));
    }
    return values;
  };
  s.grains = share(grain_volume);
  s.mobile = share(mobile_volume);
  s.grain_u = averages(grain_u, mobile_volume, total.sums);
  s.grain_v = averages(grain_v, mobile_volume, total.sums);
  s.grain_w = averages(grain_w, mobile_volume, total.sums);
  s.grain_spin = averages(grain_spin, mobile_volume, total.sums);
}

/// The fluxes through the faces, the solver's own, and what they do to each plane.
template <class Real>
void Statistics<Real>::fill_balance(FlowStatistics& s, const Totals& total) const {
  const std::size_t n = planes_;
  const double density = settings_.fluid.density;
  const double viscosity = density * settings_.fluid.kinematic_viscosity;
  const double* sum_u = total.sums.data() + u_all * n;
  const double* sum_uv = total.sums.data() + uv_all * n;
  s.driving = driving_ / duration_;
  for (std::size_t end = 0; end < 2; ++end) {
    const double half_cell = end == 0 ? s.y.front() : grid_.length[1] - s.y.back();
    s.wall_stress[end] = viscosity * total.wall_jump[end] / (2.0 * half_cell * plane_points());
  }
  const auto slope = [&](std::size_t below, std::size_t above, double distance) {
    return viscosity * (sum_u[above] - sum_u[below]) / (distance * plane_points());
  };
  s.viscous.resize(n + 1);
  s.turbulent.resize(n + 1);
  for (std::size_t f = 1; f < n; ++f) s.viscous[f] = slope(f - 1, f, s.y[f] - s.y[f - 1]);
  for (std::size_t f = 1; f <= n; ++f) s.turbulent[f] = -density * sum_uv[f - 1] / plane_points();
  if (grid_.periodic(1)) {
    s.viscous[0] = s.viscous[n] = slope(n - 1, 0, s.y[0] + grid_.length[1] - s.y[n - 1]);
    s.turbulent[0] = s.turbulent[n];
  } else {
    s.viscous[0] = s.wall_stress[0];
    s.viscous[n] = -s.wall_stress[1];
  }
  const double points = double(grid_.cells[0]) * double(grid_.cells[2]), passed = end_ - begin_;
  for (std::size_t j = 0; j < n; ++j) {
    const double change = (total.last[j] - total.first[j]) / points;
    s.acceleration.push_back(passed > 0.0 ? density * change / passed : 0.0);
    const double flux = s.viscous[j + 1] + s.turbulent[j + 1] - s.viscous[j] - s.turbulent[j];
    s.spheres.push_back(s.acceleration[j] - s.driving - flux / (s.y_face[j + 1] - s.y_face[j]));
  }
}

template <class Real>
void Statistics<Real>::fill_friction(FlowStatistics& s) const {
  const bool clear = std::all_of(s.fluid.begin(), s.fluid.end(), [](double f) { return f == 1.0; });
  int walls = 0;
  double sum = 0.0, larger = 0.0;
  for (std::size_t end = 0; end < 2; ++end)
    if (grid_.walls[1][end] == Wall::no_slip) {
      ++walls;
      sum += std::abs(s.wall_stress[end]);
      larger = std::max(larger, std::abs(s.wall_stress[end]));
    }
  const bool driven = settings_.flow.driving != Driving::none;
  const bool by_spheres = !clear && driven && !grid_.periodic(1);
  // Of what drives a flow over a bed side walls take a part.
  const bool sides = grid_.walls[2][0] == Wall::no_slip || grid_.walls[2][1] == Wall::no_slip;
  if ((walls == 0 && !by_spheres) || (by_spheres && sides)) return;
  const double stress = by_spheres ? std::abs(s.driving) * settings_.driven_height()
                        : clear    ? sum / walls
                                   : larger;  // a bed shields its wall
  s.u_tau = std::sqrt(stress / settings_.fluid.density);
  s.re_tau = *s.u_tau * settings_.reference.height / settings_.fluid.kinematic_viscosity;
  // Pressure on x walls, side walls and a fringe hold the flow, too: no straight line then.
  const bool held_below_and_above =
      walls > 0 && grid_.periodic(0) && !sides && settings_.fringe.rate == 0.0;
  if (!clear || !held_below_and_above || stress == 0.0) return;
  const auto total = [&](std::size_t f) { return s.viscous[f] + s.turbulent[f]; };
  s.stress_defect = 0.0;
  for (std::size_t f = 0; f <= planes_; ++f) {
    const double line = total(0) + (total(planes_) - total(0)) * s.y_face[f] / grid_.length[1];
    s.stress_defect = std::max(*s.stress_defect, std::abs(total(f) - line) / stress);
  }
}

template <class Real>
void Statistics<Real>::fill_spectra(FlowStatistics& s, const Totals& total) const {
  s.wavenumber_step = {2.0 * M_PI / grid_.length[0], 2.0 * M_PI / grid_.length[2]};
  auto next = total.spectra.begin();
  const auto take = [&](int cells) {
    std::vector<double> values;
    for (std::size_t m = 0; m < modes_of(cells); ++m) values.push_back(*next++ / spectra_duration_);
    return values;
  };
  for (const int plane : spectrum_planes_) {
    FlowStatistics::Spectra at;
    at.height = s.y[static_cast<std::size_t>(plane)];
    for (std::size_t c = 0; c < 3; ++c) {
      at.x[c] = take(grid_.cells[0]);
      at.z[c] = take(grid_.cells[2]);
    }
    s.spectra.push_back(std::move(at));
  }
}

template class Statistics<float>;
template class Statistics<double>;

}  // namespace bedload
