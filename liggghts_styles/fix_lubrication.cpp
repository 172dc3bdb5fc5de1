#include "liggghts_styles/fix_lubrication.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string_view>

#include "fix_property_atom.h"
#include "liggghts_styles/formulas/lubrication.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/wall_reach.hpp"

namespace bedload {

namespace {
constexpr const char* style_name = "fix lubrication";
constexpr const char* store_id = "lubricationForce";
constexpr double unbounded = std::numeric_limits<double>::infinity();
}  // namespace

FixLubrication::FixLubrication(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg)
    : Fix(lammps, narg, arg) {
  comm_forward = 4;
  if (modify->find_fix_style_strict("lubrication", 0) != nullptr) {
    stop_run(lmp, "fix lubrication: there is one already, and one serves all pairs and walls");
  }
  const struct {
    NumberKeyword rule;
    double* value;
  } keywords[] = {{{"viscosity", 0, false, unbounded}, &viscosity_setting_},
                  {{"range", 0, false, unbounded}, &range_setting_},
                  {{"gapMin", 0, false, 1}, &smallest_gap_},
                  {{"unresolved", 0, false, unbounded}, &unresolved_}};
  for (int n = 3; n < narg; n += 2) {
    const auto* k = std::find_if(std::begin(keywords), std::end(keywords),
                                 [&](const auto& known) { return known.rule.name == arg[n]; });
    if (k == std::end(keywords)) {
      stop_run(
          lmp,
          fmt::format("{}: unknown keyword '{}', there are viscosity, range, gapMin and unresolved",
                      style_name, arg[n]));
    }
    if (n + 1 == narg) {
      stop_run(lmp, fmt::format("{}: {} needs a number behind it", style_name, arg[n]));
    }
    *k->value = read_number(lmp, style_name, arg[n], arg[n + 1]);
    check_number(lmp, style_name, k->rule, *k->value);
  }
  if (unresolved_ > 0 && range_setting_ > 0) {
    stop_run(lmp,
             fmt::format("{}: unresolved gives the range itself; leave out range", style_name));
  }
  viscosity_now_ = viscosity_setting_;
}

FixLubrication::~FixLubrication() = default;

int FixLubrication::setmask() {
  return LAMMPS_NS::FixConst::PRE_FORCE | LAMMPS_NS::FixConst::PRE_FINAL_INTEGRATE;
}

// Force applied in the last step and its number, per sphere; goes into restart files and dumps.
void FixLubrication::post_create() {
  const char* arguments[] = {
      store_id, "all", "property/atom", store_id, "vector", "yes", "no", "no", "0", "0", "0", "-1"};
  applied_ = modify->add_fix_property_atom(12, const_cast<char**>(arguments), style_name);
}

void FixLubrication::pre_delete(bool unfix) {
  if (unfix && applied_ != nullptr) modify->delete_fix(store_id);
}

void FixLubrication::prepare() {
  used_by_pairs_ = true;
  viscosity_ = viscosity_setting_ > 0 ? FluidValue::constant(viscosity_setting_)
                                      : FluidValue::find(lmp, "viscosity", "fluidViscosity");
  range_ = range_setting_;
  if (range_ == 0) {
    const FluidValue h = FluidValue::find(lmp, "cell_size", "fluidCellSize");
    if (h.known()) range_ = (unresolved_ > 0 ? unresolved_ : 2) * h.get();
  }
  const char* missing = !viscosity_.known() ? "viscosity" : range_ == 0 ? "range" : nullptr;
  if (missing != nullptr) {
    stop_run(lmp,
             fmt::format("{}: the keyword '{} <value>' is missing and there is no fix couple/fluid "
                         "that gives it",
                         style_name, missing));
  }
  reach_out(lmp, style_name, range_);
}

void FixLubrication::init() {
  mobility_ = Mobility(lmp);
  if (!used_by_pairs_) {
    stop_run(lmp,
             "fix lubrication works with pair_style gran and a contact model that bedload knows: "
             "normal actm, rpm, hertz or hooke");
  }
}

void FixLubrication::add(int i, int j, double gap, double effective_radius, double smaller_radius,
                         const double* n, const double* wall_velocity) {
  const auto outside = [&](int k) { return (atom->mask[k] & groupbit) == 0; };
  if (gap > range_ || outside(i) || (j >= 0 && outside(j))) return;
  const auto coefficient = [&](double at) {
    return contact::lubrication_coefficient(viscosity_.get(), effective_radius, at,
                                            smallest_gap_ * smaller_radius);
  };
  // What the grid resolves of the film is in the fluid's force already.
  const double c = coefficient(gap) - (unresolved_ > 0 ? coefficient(range_) : 0);
  if (c <= 0) return;
  Film film{i, j, c, {n[0], n[1], n[2]}, {0, 0, 0}};
  if (wall_velocity != nullptr) std::copy_n(wall_velocity, 3, film.wall_velocity.begin());
  films_.push_back(film);
}

double FixLubrication::inverse_mass(int i) const {
  return mobility_.inverse_mass(atom->mask[i], atom->rmass[i]);
}

void FixLubrication::load_spheres() {
  const int local = atom->nlocal;
  loads_.resize(local + atom->nghost);
  for (int i = 0; i < local; ++i) {
    const double w = inverse_mass(i);
    const double* f = atom->f[i];
    loads_[i] = {0, w * f[0], w * f[1], w * f[2]};
  }
  for (const Film& film : films_) {
    loads_[film.i][0] += film.coefficient;
    if (film.j >= 0 && film.j < local) loads_[film.j][0] += film.coefficient;
  }
  comm->forward_comm_fix(this);
}

void FixLubrication::pre_final_integrate() {
  const int local = atom->nlocal;
  double** applied = applied_->array_atom;
  for (int i = 0; i < local; ++i) {
    std::fill_n(applied[i], 3, 0.0);
    applied[i][3] = static_cast<double>(update->ntimestep);
  }
  if (films_.empty() && comm->nprocs == 1) return;
  load_spheres();

  const double dt = update->dt;
  for (const Film& film : films_) {
    const int i = film.i, j = film.j;
    const double wi = inverse_mass(i);
    const double wj = j < 0 ? 0.0 : inverse_mass(j);
    const double* vj = j < 0 ? film.wall_velocity.data() : atom->v[j];
    double opening = 0, acceleration = 0;
    for (int d = 0; d < 3; ++d) {
      opening += (atom->v[i][d] - vj[d]) * film.normal[d];
      acceleration += (loads_[i][d + 1] - (j < 0 ? 0.0 : loads_[j][d + 1])) * film.normal[d];
    }
    const double x = dt * (wi * loads_[i][0] + (j < 0 ? 0.0 : wj * loads_[j][0]));
    const double force =
        contact::lubrication_step_force(film.coefficient, opening, acceleration, dt, x);
    for (int d = 0; d < 3; ++d) {
      if (wi > 0) applied[i][d] += force * film.normal[d];
      if (wj > 0 && j < local) applied[j][d] -= force * film.normal[d];
    }
  }
  for (int i = 0; i < local; ++i) {
    for (int d = 0; d < 3; ++d) atom->f[i][d] += applied[i][d];
  }
}

// At the start of a run the forces of the last step are wanted again.
void FixLubrication::setup(int) {
  const auto now = static_cast<double>(update->ntimestep);
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* applied = applied_->array_atom[i];
    if (applied[3] != now) continue;
    for (int d = 0; d < 3; ++d) atom->f[i][d] += applied[d];
  }
}

int FixLubrication::pack_comm(int count, int* list, double* buffer, int, int*) {
  int m = 0;
  for (int n = 0; n < count; ++n) {
    for (const double value : loads_[list[n]]) buffer[m++] = value;
  }
  return comm_forward;
}

void FixLubrication::unpack_comm(int count, int first, double* buffer) {
  int m = 0;
  for (int n = first; n < first + count; ++n) {
    for (double& value : loads_[n]) value = buffer[m++];
  }
}

void* FixLubrication::extract(const char* name, int& dimension) {
  dimension = 0;
  return std::string_view(name) == "viscosity" && viscosity_now_ > 0 ? &viscosity_now_ : nullptr;
}

}  // namespace bedload
