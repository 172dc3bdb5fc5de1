#include "liggghts_styles/model_scale.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "comm.h"
#include "lammps.h"

namespace bedload {
namespace {

/// Only LIGGGHTS' first rank has a screen and a log; the launcher's runs may go without one of
/// them.
void print_line(std::FILE* out, const std::string& line) {
  if (out == nullptr) return;
  std::fputs((line + '\n').c_str(), out);
}

}  // namespace

void tell_scale(LAMMPS_NS::LAMMPS* lmp, const ModelScale& scale, const FluidValue& of_fluid) {
  const double value = scale.value(of_fluid);
  print_line(lmp->logfile, fmt::format("scale: {}: {} = {:.6g}", scale.style, scale.what, value));
  if (!scale.follows_grid() || !of_fluid.live()) return;
  const std::string note = fmt::format(
      "NOTE: {}: the {} of {:.4g} is {:g} {} of the fluid and changes with the grid; {} "
      "gives it absolutely",
      scale.style, scale.what, value, scale.count, scale.unit, scale.keyword);
  print_line(lmp->screen, note);
  print_line(lmp->logfile, note);
}

void warn(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view sentence) {
  const std::string line = fmt::format("WARNING: {}: {}", style, sentence);
  print_line(lmp->screen, line);
  print_line(lmp->logfile, line);
}

void warn_of_own(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view sentence) {
  if (lmp->comm->me == 0) {
    warn(lmp, style, sentence);
  } else {
    print_line(stderr, fmt::format("WARNING: {}: {}", style, sentence));
  }
}

}  // namespace bedload
