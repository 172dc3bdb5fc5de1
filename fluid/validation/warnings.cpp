#include "fluid/validation/warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "fluid/grid/diffusion_limit.hpp"

namespace bedload {
namespace {

/// Beyond this height of the lowest cells in wall units [u_tau dy / nu] near-wall turbulence falls
/// through the grid: its smallest eddies measure a few wall units.
constexpr double highest_cell = 5.0;
/// Courant number of the first step that leaves room for gusts below the scheme's limit of sqrt(3).
constexpr double brisk_courant = 1.0;
/// Ratio of masses from which on a contact is entered deeper than it should be where one DEM step
/// to a time step leaves no room for hardening: 3 is well, 8 is not; and from which on a light
/// sphere may be shot out at a speed that time.step does not carry: 20 is well, 64 is not at a
/// Courant number of 0.3 (the cases pinned and size_ratio of the study of stability).
constexpr double masses_apart = 8.0, masses_far_apart = 64.0;

/// Cells in the boundary layer D/sqrt(Re) of a falling sphere below which drag has not been
/// validated: settling at Ga 144 with 0.59 is within 0.3 % of what it is with 1.1
/// (`./bedload study validation choices`).
constexpr double thinnest_layer = 0.5;

/// Limits that the study of stability has found (density_ratio, impact_1_step, narrow; in brackets
/// what still holds and what does not): a light sphere [0.3 holds up to 0.6 cells a step, not at
/// 1.0; 0.5 holds], one DEM step to a time step [0.3 cells a step, 0.6], a sphere beside its own
/// images [2.0 diameters at 0.1 cells a step; 1.5 at 0.3, not at 0.1].
constexpr double light = 0.4, light_and_fast = 0.8;
constexpr double fast_for_one_dem_step = 0.45;
constexpr double narrow = 1.75, slow_beside_images = 0.2;

void warn_of_long_diffusion(const Settings& s, const SphereExtremes& spheres,
                            std::vector<std::string>& found) {
  const Grid grid = make_grid(s);
  const double number = s.fluid.kinematic_viscosity * spheres.time_step / (grid.h * grid.h);
  const double longest = longest_diffusion(spheres.lightest_ratio);
  if (spheres.widest == 0.0 || number <= longest || !diffusion_is_implicit(s, grid)) return;
  found.push_back(fmt::format(
      "{}: a step of {:.3g} is a diffusion number nu dt/h^2 of {:.2g}, and spheres of {:.2g} times "
      "the fluid's density may swing from step to step beyond {:.2g}, one alone and, more so, "
      "those "
      "that lie close to each other; with 'time.step' = {:.2g} they do not.",
      s.file, spheres.time_step, number, spheres.lightest_ratio, longest,
      longest * grid.h * grid.h / s.fluid.kinematic_viscosity));
}

void warn_of_speed(const Settings& s, const SphereExtremes& spheres,
                   std::vector<std::string>& found) {
  if (spheres.fastest_light > light_and_fast)
    found.push_back(fmt::format(
        "{}: a mobile sphere of {:.2g} times the fluid's density goes {:.2g} cells in a step; from "
        "about {} on it loses its speed 15 % off theory (./bedload study stability --case "
        "density_ratio); reduce 'time.step'.",
        s.file, spheres.lightest_ratio, spheres.fastest_light, light_and_fast));
  if (s.coupling.dem_steps == 1 && spheres.fastest > fast_for_one_dem_step)
    found.push_back(fmt::format(
        "{}: a mobile sphere goes {:.2g} cells in a step, and with 'coupling.dem_steps' = 1 it "
        "rebounds by some per cent of its speed where the film should stop it (./bedload study "
        "stability --case impact_1_step); set it to 15 or reduce 'time.step'.",
        s.file, spheres.fastest));
  const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
  for (std::size_t d = 0; d < 3; ++d)
    if (ends[d][0] == Wall::periodic && s.grid.length[d] < narrow * spheres.widest &&
        spheres.fastest > 0.0 && spheres.fastest < slow_beside_images)
      found.push_back(fmt::format(
          "{}: the box is {:.3g} diameters of a mobile sphere wide along {}; beside its own images "
          "and with steps as short as these its speed may rise by 1 % at times (./bedload study "
          "stability --case narrow).",
          s.file, s.grid.length[d] / spheres.widest, "xyz"[d]));
}

/// A contact of actm is as stiff as its own two spheres ask for, and hardens under what leans on
/// them as far as the DEM step resolves.
void warn_of_unequal_masses(const Settings& s, const SphereExtremes& spheres,
                            std::vector<std::string>& found) {
  const bool hardens = s.coupling.dem_steps > 1;
  const double limit = (hardens ? masses_far_apart : masses_apart) * (1.0 - 1e-9);
  if (spheres.heaviest < limit * spheres.lightest) return;
  const char* const what =
      hardens ? "shot out at up to three times the heavy one's speed (./bedload study stability "
                "--case size_ratio); reduce 'time.step' where the CFL limit ends the run"
              : "entered up to four times as deep as in a collision of equals; set "
                "'coupling.dem_steps' to 15";
  found.push_back(
      fmt::format("{}: the heaviest mobile sphere has {:.3g} times the mass of the lightest; one "
                  "that gets between such a sphere and a wall or the bed is {}.",
                  s.file, spheres.heaviest / spheres.lightest, what));
}

/// Of x, y and z, those periodic directions that gravity has a part along, but x where `driving` is
/// what moves the flow.
std::vector<std::size_t> falling_through(const Settings& s, Driving driving) {
  const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
  std::vector<std::size_t> directions;
  for (std::size_t d = 0; d < 3; ++d)
    if (s.fluid.gravity[d] != 0.0 && ends[d][0] == Wall::periodic &&
        (d != 0 || s.flow.driving != driving))
      directions.push_back(d);
  return directions;
}

/// Whether one of the box's six ends is of this kind.
bool has_end(const Settings& s, Wall kind) {
  const std::array ends{s.boundary.x, s.boundary.y, s.boundary.z};
  return std::any_of(ends.begin(), ends.end(),
                     [kind](const auto& e) { return e[0] == kind || e[1] == kind; });
}

/// Along a periodic direction nothing can hold the fluid up against gravity but a pressure gradient
/// that nobody asked for. In a box without walls, where spheres settle, it is what is meant.
void warn_of_slope(const Settings& s, std::vector<std::string>& found) {
  if (!has_end(s, Wall::no_slip) && !has_end(s, Wall::free_slip)) return;
  for (const std::size_t d : falling_through(s, Driving::gravity))
    found.push_back(fmt::format(
        "{}: 'fluid.gravity' has the part {} along {}, which is periodic: the fluid's own weight "
        "moves nothing there, as if a pressure gradient held it, and gives the spheres buoyancy{}.",
        s.file, s.fluid.gravity[d], "xyz"[d],
        d == 0 ? "; for a flow down a slope set 'flow.driving' = \"gravity\"" : ""));
}

/// Where no wall, no fixed sphere and no driving holds a box back, spheres and fluid fall together.
void warn_of_free_fall(const Settings& s, const SphereExtremes& spheres,
                       std::vector<std::string>& found) {
  if (!spheres.weigh || spheres.held || s.fringe.rate > 0.0 || has_end(s, Wall::no_slip)) return;
  for (const std::size_t d : falling_through(s, Driving::bulk_velocity))
    found.push_back(fmt::format(
        "{}: 'fluid.gravity' acts along {}, where nothing holds the box back: the spheres' weight "
        "accelerates them and the fluid together for as long as the run lasts; only velocities "
        "relative to the fluid's mean become steady. Along x 'flow.driving' = \"bulk_velocity\" "
        "with 'flow.bulk_velocity' = 0 holds it.",
        s.file, "xyz"[d]));
}

/// Transforms take a line of points for one period.
void warn_of_spectra_between_walls(const Settings& s, std::vector<std::string>& found) {
  if (s.statistics.spectra_heights.empty()) return;
  for (const auto& [name, ends] : {std::pair{'x', s.boundary.x}, {'z', s.boundary.z}})
    if (ends[0] != Wall::periodic)
      found.push_back(fmt::format(
          "{}: 'statistics.spectra_heights' asks for spectra, and those along {}, between walls, "
          "hold the jump from one wall to the other; only along periodic directions are they what "
          "the flow has.",
          s.file, name));
}

std::optional<std::string> thin_layer(const SphereExtremes& spheres) {
  if (spheres.thinnest_layer >= thinnest_layer) return std::nullopt;
  return fmt::format(
      "falling freely a mobile sphere would have Re = {:.3g} and a boundary layer D/sqrt(Re) of "
      "{:.2g} cells; with 0.6 its drag has been found right (./bedload study validation choices); "
      "take more 'grid.cells' or a smaller Reynolds number.",
      spheres.reynolds, spheres.thinnest_layer);
}

/// The laminar start knows the straight line between moving walls along one direction: y, or z
/// where no y end (nor a bed) holds the flow.
void warn_of_walls_left_out_of_the_start(const Settings& s, std::vector<std::string>& found) {
  if (s.start.from != Start::laminar) return;
  const auto holds = [](const auto& ends) {
    return ends[0] == Wall::no_slip || ends[1] == Wall::no_slip;
  };
  const auto moves = [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return a != std::array<double, 3>{} || b != std::array<double, 3>{};
  };
  const bool y_holds = holds(s.boundary.y) || s.start.height > 0.0;
  if (y_holds && moves(s.boundary.z_lower_velocity, s.boundary.z_upper_velocity))
    found.push_back(fmt::format(
        "{}: 'start.from' = \"laminar\" is the flow of the y walls alone: what the z walls move "
        "has to develop.",
        s.file));
  if (!y_holds && holds(s.boundary.z) && s.start.velocity != 0.0)
    found.push_back(
        fmt::format("{}: 'start.velocity' = {} is even over the box: 'start.from' = \"laminar\" "
                    "knows the parabola "
                    "over a y wall, and that between z walls has to develop.",
                    s.file, s.start.velocity));
}

}  // namespace

double longest_diffusion(double density_ratio) {
  return std::min(8.0, 2.0 * density_ratio * density_ratio);
}

SphereExtremes extremes_of(const Settings& s, std::span<const SphereState> spheres,
                           double time_step) {
  const auto& g = s.fluid.gravity;
  const double gravity = std::hypot(g[0], g[1], g[2]), h = s.grid.length[0] / s.grid.cells[0];
  SphereExtremes found{.time_step = time_step};
  const SphereState* before = nullptr;  // grains of one kind come one after the other
  for (const SphereState& sphere : spheres) {
    found.held = found.held || !sphere.mobile;
    if (!sphere.mobile || sphere.density == 0.0) continue;
    const double ratio = sphere.density / s.fluid.density;
    const double cells_a_step = sphere.velocity.norm() * time_step / h;
    found.fastest = std::max(found.fastest, cells_a_step);
    if (ratio < light) found.fastest_light = std::max(found.fastest_light, cells_a_step);
    found.lightest_ratio = std::min(found.lightest_ratio, ratio);
    found.weigh = found.weigh || ratio != 1.0;
    found.heaviest_ratio = std::max(found.heaviest_ratio, ratio);
    found.widest = std::max(found.widest, 2.0 * sphere.radius);
    found.narrowest = std::min(found.narrowest, 2.0 * sphere.radius);
    if (before != nullptr && sphere.radius == before->radius && sphere.density == before->density)
      continue;
    before = &sphere;
    const double mass = std::pow(sphere.radius, 3) * sphere.density;
    found.lightest = std::min(found.lightest, mass);
    found.heaviest = std::max(found.heaviest, mass);
    const double diameter = 2.0 * sphere.radius;
    const double re = falling_reynolds(sphere.density / s.fluid.density, gravity, diameter,
                                       s.fluid.kinematic_viscosity);
    const double cells = cells_per_layer(diameter / h, re);
    if (cells >= found.thinnest_layer) continue;
    found.thinnest_layer = cells;
    found.reynolds = re;
  }
  return found;
}

std::vector<std::string> warnings(const Settings& s, const DerivedNumbers& numbers) {
  std::vector<std::string> found;
  const auto no_effect = [&](const char* key, const char* condition) {
    found.push_back(
        fmt::format("{}: '{}' is set, but has no effect without {}.", s.file, key, condition));
  };
  const bool turbulent = numbers.friction && numbers.friction->source != FrictionSource::laminar;
  if (turbulent && numbers.friction->cell_wall_units > highest_cell)
    found.push_back(fmt::format(
        "{}: the cells beside the wall are {:.2g} wall units high (Re_tau = {:.3g}), and "
        "turbulence near the bed is not resolved above about {}; take more 'grid.cells' or a "
        "smaller Reynolds number.",
        s.file, numbers.friction->cell_wall_units, numbers.friction->reynolds, highest_cell));
  const bool at_rest = s.flow.driving == Driving::none ||
                       (s.flow.driving == Driving::bulk_velocity && s.flow.bulk_velocity == 0.0);
  if (s.fluid.convection && s.time.cfl == 0.0 && !at_rest && numbers.cfl_at_start > brisk_courant)
    found.push_back(
        fmt::format("{}: 'time.step' = {} carries the flow {:.2g} cells a step, and gusts go "
                    "further: the limit is 1.7; take a shorter step or 'time.cfl'.",
                    s.file, s.time.step, numbers.cfl_at_start));
  if (s.flow.bulk_velocity != 0.0 && s.flow.driving != Driving::bulk_velocity)
    no_effect("flow.bulk_velocity", "flow.driving = \"bulk_velocity\"");
  if (s.flow.pressure_gradient != 0.0 && s.flow.driving != Driving::pressure_gradient)
    no_effect("flow.pressure_gradient", "flow.driving = \"pressure_gradient\"");
  const bool profile = s.start.from == Start::laminar || s.start.from == Start::logarithmic;
  if (s.start.disturbance != 0.0 && !profile)
    no_effect("start.disturbance", "start.from = \"laminar\" or \"logarithmic\"");
  else if (s.start.disturbance != 0.0 && s.start.velocity == 0.0)
    no_effect("start.disturbance", "'start.velocity', whose share it is");
  if (s.start.seed != Settings::Start_{}.seed && s.start.disturbance == 0.0)
    no_effect("start.seed", "'start.disturbance' above 0");
  if (!s.start.file.empty() && s.start.from != Start::state)
    no_effect("start.file", "start.from = \"state\"");
  if (s.start.velocity != 0.0 && !profile)
    no_effect("start.velocity", "start.from = \"laminar\" or \"logarithmic\"");
  // Between two walls it says how high the bed is that the flow leaves free (driven_height()).
  const bool two_walls = s.boundary.y[0] == Wall::no_slip && s.boundary.y[1] == Wall::no_slip;
  if (s.start.height != 0.0 && !profile && !two_walls)
    no_effect("start.height", "start.from = \"laminar\" or \"logarithmic\"");
  if (s.start.velocity != 0.0 && profile && s.boundary.x[0] != Wall::periodic)
    found.push_back(
        fmt::format("{}: 'start.velocity' = {} is along x and the same from one x wall to the "
                    "other: what of it would go through them is taken away before the first step.",
                    s.file, s.start.velocity));
  warn_of_walls_left_out_of_the_start(s, found);
  if (s.fringe.rate == 0.0) {
    if (s.fringe.begin != 0.0) no_effect("fringe.begin", "'fringe.rate' above 0");
    if (s.fringe.velocity != 0.0) no_effect("fringe.velocity", "'fringe.rate' above 0");
  }
  if (s.fringe.rate > 0.0 && s.output.energy_work)
    found.push_back(fmt::format(
        "{}: 'output.energy_work' is \"on\", but what the fringe takes from the flow is in none of "
        "its columns, so that they do not add up to what its kinetic energy changes by.",
        s.file));
  warn_of_slope(s, found);
  if (s.spheres.slip_tolerance > 0.0 && s.spheres.forcing_loops == 1)
    no_effect("spheres.slip_tolerance", "'spheres.forcing_loops' above 1");
  if (s.spheres.deferred_impulse_share > 0.0 && !s.spheres.interior_term)
    no_effect("spheres.deferred_impulse_share", "'spheres.interior_term' = \"on\"");
  if (s.statistics.every == 0 && s.statistics.from != 0.0)
    no_effect("statistics.from", "'statistics.every' above 0");
  if (s.statistics.spectra_every != 1 && s.statistics.spectra_heights.empty())
    no_effect("statistics.spectra_every", "'statistics.spectra_heights'");
  warn_of_spectra_between_walls(s, found);
  if (s.time.cfl == 0.0 && s.time.end > 0.0 && s.time.end < 0.5 * s.time.step)
    found.push_back(fmt::format(
        "{}: 'time.end' = {} is less than half of 'time.step' = {}: no step will be made.", s.file,
        s.time.end, s.time.step));
  if (s.statistics.every > 0 && s.statistics.from >= s.time.end)
    found.push_back(
        fmt::format("{}: 'statistics.from' = {} is not before 'time.end' = {}: none will be taken.",
                    s.file, s.statistics.from, s.time.end));
  return found;
}

std::vector<std::string> warnings(const Settings& s, const SphereExtremes& spheres) {
  std::vector<std::string> found;
  warn_of_unequal_masses(s, spheres, found);
  warn_of_speed(s, spheres, found);
  warn_of_long_diffusion(s, spheres, found);
  warn_of_free_fall(s, spheres, found);
  if (const auto sentence = thin_layer(spheres)) found.push_back(s.file + ": " + *sentence);
  return found;
}

std::vector<std::string> warnings_of_reference(const Settings& s, const SphereExtremes& spheres) {
  std::vector<std::string> found;
  if (spheres.widest == 0.0) return found;
  const auto compare = [&](const char* key, double value, double least, double most,
                           const char* what) {
    constexpr double typed = 1e-6;  // digits of a number in a script
    if (value >= (1.0 - typed) * least && value <= (1.0 + typed) * most) return;
    const std::string theirs = most - least <= typed * most
                                   ? fmt::format("{:.6g}", most)
                                   : fmt::format("{:.6g} to {:.6g}", least, most);
    found.push_back(
        fmt::format("{}: '{}' = {:.6g}, but the mobile spheres have {}: the derived numbers and "
                    "studies of this "
                    "run take the first for {}.",
                    s.file, key, value, theirs, what));
  };
  compare("reference.diameter", s.reference.diameter, spheres.narrowest, spheres.widest,
          "their diameter");
  if (s.reference.sphere_density > 0.0)
    compare("reference.sphere_density", s.reference.sphere_density,
            spheres.lightest_ratio * s.fluid.density, spheres.heaviest_ratio * s.fluid.density,
            "their density");
  return found;
}

std::vector<std::string> warnings_without_spheres(const Settings& s, bool fixed) {
  const auto is_of_spheres = [&](const std::string& key) {
    const bool of_mobile = key.starts_with("coupling.") || key.starts_with("spheres.deferred_") ||
                           key == "spheres.interior_term" || key == "output.spheres_every";
    return of_mobile || (!fixed && (key.starts_with("spheres.") || key == "output.fixed_every"));
  };
  const auto defaults = settings_as_pairs({}), values = settings_as_pairs(s);
  std::vector<std::string> keys;
  for (std::size_t n = 0; n < values.size(); ++n)
    if (is_of_spheres(values[n].first) && values[n].second != defaults[n].second)
      keys.push_back("'" + values[n].first + "'");
  if (keys.empty()) return {};
  return {fmt::format("{}: {} {} set, but {} no effect without {}spheres.", s.file,
                      fmt::join(keys, ", "), keys.size() == 1 ? "is" : "are",
                      keys.size() == 1 ? "has" : "have", fixed ? "mobile " : "")};
}

}  // namespace bedload
