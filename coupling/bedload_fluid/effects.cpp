#include "coupling/bedload_fluid/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>

#include "fluid/grid/diffusion_limit.hpp"
#include "fluid/immersed_boundary/rigid_core.hpp"

namespace bedload {
namespace {

EffectRow row(const std::string& name, bool on, const std::string& why) {
  return {name, on ? "on" : "off", why, {}};
}

/// The lines that LIGGGHTS sent: name, state and reason, separated by tabs.
std::vector<EffectRow> effects_of_script(const std::string& text) {
  std::vector<EffectRow> effects;
  std::istringstream lines(text);
  std::string name, state, why;
  while (std::getline(lines, name, '\t') && std::getline(lines, state, '\t') &&
         std::getline(lines, why))
    effects.push_back({name, state, why, {}});
  return effects;
}

/// Adds to the rows named in accuracy.verdicts what it says of them.
void add_verdicts(std::vector<EffectRow>& rows, const std::string& verdicts) {
  std::istringstream parts(verdicts);
  for (std::string part; std::getline(parts, part, ';');) {
    const std::size_t begin = part.find_first_not_of(' '), colon = part.find(": ");
    if (colon == std::string::npos) continue;
    const std::string name = part.substr(begin, colon - begin);
    for (EffectRow& row : rows)
      if (row.effect == name) row.why += fmt::format(" ({})", part.substr(colon + 2));
  }
}

EffectRow driving(const Settings& s) {
  switch (s.flow.driving) {
    case Driving::bulk_velocity:
      return row("flow driving", true,
                 fmt::format("bulk velocity kept at {}", s.flow.bulk_velocity));
    case Driving::pressure_gradient:
      return row("flow driving", true,
                 fmt::format("force per volume kept at {}", s.flow.pressure_gradient));
    case Driving::gravity:
      return row("flow driving", true,
                 fmt::format("gravity along x, {} per mass", s.fluid.gravity[0]));
    case Driving::none:
      break;
  }
  return row("flow driving", false, "flow.driving is \"none\"");
}

EffectRow diffusion(const Settings& s) {
  const Grid grid = make_grid(s);
  const bool implicit = diffusion_is_implicit(s, grid);
  const bool asked = s.fluid.diffusion != Diffusion::automatic;
  return row("implicit diffusion", implicit,
             asked ? fmt::format("fluid.diffusion is \"{}\"", implicit ? "implicit" : "explicit")
                   : fmt::format("time.step is {:.3g} of the explicit limit",
                                 s.time.step /
                                     explicit_diffusion_limit(grid, s.fluid.kinematic_viscosity)));
}

EffectRow rigid_core(const Settings& s, const SphereNumbers& spheres) {
  if (!s.spheres.rigid_core) return row("rigid core", false, "spheres.rigid_core is \"off\"");
  const bool known = spheres.widest > 0.0;  // else the script brings spheres later
  const double across = (known ? spheres.widest : s.reference.diameter) / make_grid(s).h;
  return row(
      "rigid core", core_radius(0.5 * across) > 0.0,
      fmt::format("{} is {:.3g} cells, and up to {:g} there is none",
                  known ? "the largest diameter" : "reference.diameter", across, 2.0 * core_depth));
}

bool has_gravity(const Settings& s) {
  return std::any_of(s.fluid.gravity.begin(), s.fluid.gravity.end(),
                     [](double g) { return g != 0.0; });
}

}  // namespace

namespace {

std::vector<EffectRow> effects_without_verdicts(const Settings& s, const SphereNumbers& spheres,
                                                const PartnerScene* dem) {
  const bool convection = s.fluid.convection;
  std::vector<EffectRow> rows{
      row("convection", convection,
          convection ? "the flow has inertia" : "fluid.convection is \"off\""),
      driving(s), diffusion(s),
      row("single precision", s.accuracy.precision == "single",
          fmt::format("accuracy.precision is \"{}\"", s.accuracy.precision))};
  if (s.fringe.rate > 0.0)
    rows.push_back(row("fringe", true,
                       fmt::format("stream of {} from x = {} to {}", s.fringe.velocity,
                                   s.fringe.begin, s.fringe.end)));
  rows.push_back(row("statistics", s.statistics.every > 0,
                     s.statistics.every > 0 ? fmt::format("sampled every {} steps from t = {}",
                                                          s.statistics.every, s.statistics.from)
                                            : "statistics.every is 0"));
  if (spheres.all() == 0 && dem == nullptr) {
    rows.push_back(
        row("spheres", false, "this job has no bedload-dem, and spheres.file names no spheres"));
    return rows;
  }
  // A scene that begins without any is one whose script inserts them while it runs.
  const bool inserted = spheres.all() == 0, mobile = inserted || spheres.mobile > 0;
  const std::string how_many = inserted ? "inserted by the script while it runs"
                               : dem    ? fmt::format("{} mobile spheres", spheres.mobile)
                                        : "fixed spheres only, without LIGGGHTS";
  rows.push_back(row("immersed boundary", true,
                     fmt::format("{} fixed spheres, weights computed once", spheres.fixed)));
  rows.push_back(row("moving boundary", mobile, how_many));
  rows.push_back(
      row("interior term", mobile && s.spheres.interior_term,
          !mobile || s.spheres.interior_term ? how_many : "spheres.interior_term is \"off\""));
  rows.push_back(rigid_core(s, spheres));
  rows.push_back(row("extra forcing loops", s.spheres.forcing_loops > 1,
                     fmt::format("spheres.forcing_loops is {}", s.spheres.forcing_loops)));
  rows.push_back(row("buoyancy", mobile && has_gravity(s) && s.spheres.buoyancy,
                     !mobile              ? how_many
                     : !has_gravity(s)    ? "fluid.gravity is zero"
                     : s.spheres.buoyancy ? "fluid.gravity"
                                          : "spheres.buoyancy is \"off\""));
  rows.push_back(row("output", true,
                     fmt::format("history every {} steps, spheres and fields as [output] says",
                                 s.output.history_every)));
  if (dem == nullptr) return rows;
  rows.push_back(
      row("grain motion", mobile,
          fmt::format("LIGGGHTS, {} steps a time step, loads once a {}", s.coupling.dem_steps,
                      s.coupling.exchange == Exchange::stage ? "stage" : "step")));
  const std::vector<EffectRow> script = effects_of_script(dem->effects);
  rows.insert(rows.end(), script.begin(), script.end());
  return rows;
}

}  // namespace

std::vector<EffectRow> effects_of(const Settings& s, const SphereNumbers& spheres,
                                  const PartnerScene* dem) {
  std::vector<EffectRow> rows = effects_without_verdicts(s, spheres, dem);
  add_verdicts(rows, s.accuracy.verdicts);
  return rows;
}

void add_shares(std::vector<EffectRow>& effects, std::span<const TimingRow> times,
                const MarkerSeconds& markers, double grain_seconds) {
  double total = 0.0;
  std::map<std::string, double> share;
  for (const TimingRow& row : times) {
    total += row.seconds_mean;
    share[row.part] = row.share;
  }
  if (total <= 0.0) return;
  share["immersed boundary"] = markers.first_loops / total;
  share["moving boundary"] = markers.placing / total;
  share["interior term"] = markers.interior / total;
  share["extra forcing loops"] = markers.extra_loops / total;
  share["grain motion"] = grain_seconds / total;
  for (EffectRow& row : effects)
    if (const auto found = share.find(row.effect); found != share.end() && row.state == "on")
      row.share = found->second;
}

}  // namespace bedload
