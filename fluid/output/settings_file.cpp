#include "fluid/output/settings_file.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "fluid/files/atomic_file.hpp"

namespace bedload {
namespace {

const char* words(FrictionSource source) {
  switch (source) {
    case FrictionSource::driving:
      return "from the driving force";
    case FrictionSource::laminar:
      return "of laminar flow over a smooth wall";
    case FrictionSource::smooth_wall:
      return "estimate for a smooth wall, Dean 1978";
  }
  return "";
}

}  // namespace

std::string derived_as_comments(const DerivedNumbers& n) {
  std::string text;
  const auto line = [&](const char* name, double value, const std::string& meaning) {
    text += fmt::format("# derived.{} = {:.6g}  # {}\n", name, value, meaning);
  };
  line("cell", n.cell, "h [L]");
  line("reynolds_bulk", n.reynolds_bulk, "Re_b = u_b H / nu");
  line("cells_per_diameter", n.cells_per_diameter, "D / h");
  line("cfl_at_start", n.cfl_at_start, "u_b dt / h");
  line("diffusion_number", n.diffusion, "nu dt / h^2");
  if (n.friction) {
    line("u_tau", n.friction->u_tau,
         fmt::format("friction velocity [L/T], {}", words(n.friction->source)));
    line("reynolds_friction", n.friction->reynolds, "Re_tau = u_tau H / nu");
    line("diameter_wall_units", n.friction->diameter_wall_units, "D+ = u_tau D / nu");
    line("cell_wall_units", n.friction->cell_wall_units, "u_tau dy / nu of the lowest cells");
  }
  if (n.density_ratio) line("density_ratio", *n.density_ratio, "rho_p / rho_f");
  if (n.froude) line("froude", *n.froude, "Fr = (rho_p - rho_f) g H / (rho_f u_b^2)");
  if (n.shields) line("shields", *n.shields, "S = rho_f u_tau^2 / ((rho_p - rho_f) g D)");
  if (n.falling_reynolds)
    line("falling_reynolds", *n.falling_reynolds, "u D / nu of a sphere that falls freely");
  if (n.cells_per_layer)
    line("cells_per_layer", *n.cells_per_layer, "D / (h sqrt(Re)) of it: its boundary layer");
  return text;
}

void write_settings_file(const std::string& folder, const Settings& settings,
                         const DerivedNumbers& numbers) {
  Settings moved = settings;
  for (std::string* const file : {&moved.start.file, &moved.spheres.file})
    if (!file->empty())
      *file = std::filesystem::absolute(settings.beside(*file)).lexically_normal().string();
  write_text_file(folder + "/settings.toml",
                  settings_as_toml(moved) + "\n" + derived_as_comments(numbers));
}

}  // namespace bedload
