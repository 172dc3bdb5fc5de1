#include "fluid/settings_sense.hpp"

#include <fmt/format.h>

#include "fluid/errors.hpp"

namespace bedload {
namespace {

constexpr double most_cells = 1e12;
constexpr double most_steps = 1e12;
constexpr double fields = 8.0;  // numbers per cell

double cell_count(const Settings& s) {
  return static_cast<double>(s.grid.cells[0]) * s.grid.cells[1] * s.grid.cells[2];
}

}  // namespace

void check_sense(const Settings& s) {
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

double least_field_bytes(const Settings& s) {
  return cell_count(s) * fields * (s.accuracy.precision == "single" ? 4.0 : 8.0);
}

}  // namespace bedload
