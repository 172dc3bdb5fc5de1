#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

/// A wall moves in its own plane, and only one that holds the fluid can be felt to.
void check_wall_velocities(const Settings& s) {
  const Settings::Boundary& b = s.boundary;
  struct End {
    std::string_view key;
    std::size_t direction;
    Wall wall;
    const std::array<double, 3>& velocity;
  };
  for (const End& end : {End{"x_lower_velocity", 0, b.x[0], b.x_lower_velocity},
                         {"x_upper_velocity", 0, b.x[1], b.x_upper_velocity},
                         {"y_lower_velocity", 1, b.y[0], b.y_lower_velocity},
                         {"y_upper_velocity", 1, b.y[1], b.y_upper_velocity},
                         {"z_lower_velocity", 2, b.z[0], b.z_lower_velocity},
                         {"z_upper_velocity", 2, b.z[1], b.z_upper_velocity}}) {
    const std::string found =
        fmt::format("{}: 'boundary.{}' is [{}]", s.file, end.key, fmt::join(end.velocity, ", "));
    if (end.velocity[end.direction] != 0.0)
      throw UserError(
          fmt::format("{}, but a wall moves in its own plane: its {} component must be 0.", found,
                      "xyz"[end.direction]));
    if (end.wall != Wall::no_slip && end.velocity != std::array<double, 3>{})
      throw UserError(
          fmt::format("{}, but only a wall that is \"no_slip\" moves the fluid.", found));
  }
}

/// Cells that grow by more than this ratio lose accuracy.
constexpr double most_growth = 1.2;

void check_stretching(const Settings& s) {
  const auto fail = [&s](const std::string& sentence) {
    throw UserError(fmt::format("{}: {}", s.file, sentence));
  };
  const auto& y = s.boundary.y;
  const double stretching = s.grid.y_stretching, uniform = s.grid.y_uniform;
  if (stretching == 0.0 && uniform == 0.0) return;
  if (stretching > 0.0 && uniform > 0.0)
    fail("'grid.y_stretching' and 'grid.y_uniform' are two ways to stretch y; set one of them.");
  if (y[0] == Wall::periodic)
    fail("y is stretched between walls only, but 'boundary.y' is \"periodic\".");
  if (stretching > 0.0) {
    if (y[0] != Wall::no_slip && y[1] != Wall::no_slip)
      fail("'grid.y_stretching' draws cells to no-slip walls, but 'boundary.y' has none.");
    return;
  }
  const double h = s.grid.length[0] / s.grid.cells[0], cubes = std::min(uniform / h, 1e9);
  const int above = s.grid.cells[1] - static_cast<int>(std::lround(cubes));
  if (std::abs(cubes - std::round(cubes)) > 1e-6 || cubes < 0.5 || above < 1)
    fail(
        fmt::format("'grid.y_uniform' is {}, but must be a whole number of cells, each {} high, "
                    "from 1 to {} of them.",
                    uniform, h, s.grid.cells[1] - 1));
  const double ratio = growth_ratio(above, s.grid.length[1] - uniform, h);
  if (ratio < 1.0 || ratio > most_growth)
    fail(fmt::format(
        "the {} cells above 'grid.y_uniform' = {} would have to grow by {:.3g} from one "
        "to the next to reach the height {}, but 1 to {} is allowed.",
        above, uniform, ratio, s.grid.length[1], most_growth));
}

constexpr double most_cells = 1e12;
/// With less a run makes no progress, and such accuracy in time is not needed.
constexpr double least_courant = 1e-3;
constexpr double fields = 8.0;  // numbers per cell

double cell_count(const Settings& s) {
  return static_cast<double>(s.grid.cells[0]) * s.grid.cells[1] * s.grid.cells[2];
}

/// What no machine can do.
void check_size(const Settings& s) {
  if (cell_count(s) > most_cells)
    throw UserError(
        fmt::format("{}: 'grid.cells' makes {:.3g} cells in all, but at most {:.0e} "
                    "are allowed.",
                    s.file, cell_count(s), most_cells));
  if (s.time.end / s.time.step > most_steps)
    throw UserError(fmt::format(
        "{}: 'time.end' = {} takes {:.3g} steps of 'time.step' = {}, but at most {:.0e} are "
        "allowed.",
        s.file, s.time.end, s.time.end / s.time.step, s.time.step, most_steps));
}

/// Keys against each other.
void check_together(const Settings& s) {
  const auto fail = [&s](const std::string& sentence) {
    throw UserError(fmt::format("{}: {}", s.file, sentence));
  };
  const auto is_periodic = [](const std::array<Wall, 2>& ends) {
    return ends[0] == Wall::periodic || ends[1] == Wall::periodic;
  };
  for (const auto& [name, ends] : {std::pair{"boundary.x", s.boundary.x},
                                   {"boundary.y", s.boundary.y},
                                   {"boundary.z", s.boundary.z}})
    if (is_periodic(ends) && ends[0] != ends[1])
      fail(fmt::format("'{}' is periodic at one end only; set both ends.", name));
  const double h = s.grid.length[0] / s.grid.cells[0];
  for (std::size_t d = 1; d < 3; ++d) {
    const double other = s.grid.length[d] / s.grid.cells[d];
    if (d == 1 && (s.grid.y_stretching > 0.0 || s.grid.y_uniform > 0.0)) continue;
    if (std::abs(other - h) > 1e-9 * h)
      fail(
          fmt::format("grid.length / grid.cells is {} along x but {} along {}; cells must be "
                      "cubes.",
                      h, other, d == 1 ? "y" : "z"));
  }
  check_wall_velocities(s);
  check_stretching(s);
  if (s.flow.driving != Driving::none && !is_periodic(s.boundary.x))
    fail("'flow.driving' needs 'boundary.x' = \"periodic\".");
  if (s.flow.driving == Driving::gravity && s.fluid.gravity[0] == 0.0)
    fail("'flow.driving' is \"gravity\", but 'fluid.gravity' has no x part.");
  if (s.time.cfl > 0.0 && s.time.cfl < least_courant)
    fail(fmt::format("'time.cfl' is {}, but must be 0 (time.step throughout) or at least {}.",
                     s.time.cfl, least_courant));
  if (s.fringe.rate > 0.0) {
    if (!is_periodic(s.boundary.x)) fail("'fringe.rate' needs 'boundary.x' = \"periodic\".");
    if (!(s.fringe.begin < s.fringe.end && s.fringe.end <= s.grid.length[0]))
      fail(
          fmt::format("the fringe reaches from 'fringe.begin' = {} to 'fringe.end' = {}, but must "
                      "lie within [0, {}] along x.",
                      s.fringe.begin, s.fringe.end, s.grid.length[0]));
  } else if (s.fringe.end > 0.0) {
    fail("'fringe.end' is set, but 'fringe.rate' is 0, so that there is no fringe.");
  }
  if (s.coupling.exchange == Exchange::stage && s.coupling.dem_steps % 15 != 0)
    fail(fmt::format(
        "'coupling.dem_steps' is {}, but must be a multiple of 15 (stages of 8/15, 2/15 "
        "and 5/15 of a step) or go with 'coupling.exchange' = \"step\".",
        s.coupling.dem_steps));
  if (s.time.cfl > 0.0 && !s.fluid.convection)
    fail("'time.cfl' needs the convective term, but 'fluid.convection' is \"off\".");
  if (s.statistics.every == 0 && !s.statistics.spectra_heights.empty())
    fail("'statistics.spectra_heights' needs 'statistics.every' above 0.");
  for (const double height : s.statistics.spectra_heights)
    if (height >= s.grid.length[1])
      fail(fmt::format("'statistics.spectra_heights' holds {}, but the box is {} high.", height,
                       s.grid.length[1]));
  if (s.start.height >= s.grid.length[1])
    fail(fmt::format("'start.height' is {}, but the box is {} high.", s.start.height,
                     s.grid.length[1]));
  if (s.start.from == Start::state && s.start.file.empty())
    fail("'start.from' is \"state\", but 'start.file' is missing.");
}

}  // namespace

void check_explicit_diffusion(const Settings& s, const Grid& grid) {
  const double limit = explicit_diffusion_limit(grid, s.fluid.kinematic_viscosity);
  if (!diffusion_is_implicit(s, grid) && s.time.cfl == 0.0 && s.time.step > limit)
    throw UserError(fmt::format(
        "{}: 'time.step' is {}, but explicit diffusion is stable only up to {:.4g} with "
        "this viscosity and cell size; 'fluid.diffusion' = \"implicit\" is stable with any step.",
        s.file, s.time.step, limit));
}

void validate(const Settings& settings) {
  check_together(settings);
  check_size(settings);
  check_explicit_diffusion(settings, make_grid(settings));
}

double least_field_bytes(const Settings& s) {
  return cell_count(s) * fields * (s.accuracy.precision == "single" ? 4.0 : 8.0);
}

}  // namespace bedload
