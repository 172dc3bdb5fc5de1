#include "liggghts_styles/model_scale.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <string>

#include "comm.h"
#include "error.h"
#include "lammps.h"
#include "update.h"

namespace bedload {
namespace {

/// The launcher's runs may go without a screen or a log.
void print_line(std::FILE* out, const std::string& line) {
  if (out == nullptr) return;
  std::fputs((line + '\n').c_str(), out);
}

/// A rebound at e = 1 is 0.94 to 1.07 with three steps, up to 2.4 with two.
constexpr double fewest_steps = 3;

}  // namespace

bool is_resolved(const LAMMPS_NS::LAMMPS& lmp, double collision_time) {
  return collision_time > fewest_steps * lmp.update->dt * (1 - 1e-9);
}

void warn_of_unresolved(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double collision_time) {
  if (!(collision_time > 0) || is_resolved(*lmp, collision_time)) return;
  warn(lmp, style,
       fmt::format(
           "a collision of {:.4g} lasts {:.3g} of LIGGGHTS' steps of {:.4g}, but has to last "
           "{:g}: the run ends at the first one; give it longer or the fluid step more DEM "
           "steps",
           collision_time, collision_time / lmp->update->dt, lmp->update->dt, fewest_steps));
}

void require_resolved(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double collision_time) {
  const double steps = collision_time / lmp->update->dt;
  if (is_resolved(*lmp, collision_time)) return;
  const std::string sentence = fmt::format(
      "{}: a collision of {:.4g} lasts {:.3g} of LIGGGHTS' steps of {:.4g}, but has to last {:g}; "
      "give it longer or the fluid step more DEM steps",
      style, collision_time, steps, lmp->update->dt, fewest_steps);
  lmp->error->one(FLERR, sentence.c_str());
}

void tell_scale(LAMMPS_NS::LAMMPS* lmp, const ModelScale& scale, const FluidValue& of_fluid) {
  if (lmp->comm->me != 0) return;
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
  if (lmp->comm->me != 0) return;
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
