#include "fluid/output/doubts.hpp"

#include <fmt/format.h>

namespace bedload {
namespace {

/// Beyond this height of the lowest cells in wall units [u_tau dy / nu] near-wall turbulence falls
/// through the grid: its smallest eddies measure a few wall units.
constexpr double highest_cell = 5.0;
/// Courant number of the first step that leaves room for gusts below the scheme's limit of sqrt(3).
constexpr double brisk_courant = 1.0;

}  // namespace

std::vector<std::string> doubts(const Settings& s, const DerivedNumbers& numbers) {
  std::vector<std::string> found;
  const auto no_effect = [&](const char* key, const char* condition) {
    found.push_back(
        fmt::format("{}: '{}' is set, but has no effect without {}.", s.file, key, condition));
  };
  if (s.flow.driving != Driving::none && numbers.cell_wall_units > highest_cell)
    found.push_back(fmt::format(
        "{}: the lowest cells are {:.2g} wall units high (Re_tau = {:.3g}), and turbulence near "
        "the bed "
        "is not resolved above about {}; take more 'grid.cells' or a smaller Reynolds number.",
        s.file, numbers.cell_wall_units, numbers.reynolds_friction, highest_cell));
  if (s.time.cfl == 0.0 && s.flow.driving != Driving::none && numbers.cfl_at_start > brisk_courant)
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
  if (s.spheres.slip_tolerance > 0.0 && s.spheres.forcing_loops == 1)
    no_effect("spheres.slip_tolerance", "'spheres.forcing_loops' above 1");
  if (s.statistics.every > 0 && s.statistics.from >= s.time.end)
    found.push_back(
        fmt::format("{}: 'statistics.from' = {} is not before 'time.end' = {}: none will be taken.",
                    s.file, s.statistics.from, s.time.end));
  return found;
}

}  // namespace bedload
