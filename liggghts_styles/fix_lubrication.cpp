#include "liggghts_styles/fix_lubrication.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string_view>

#include "domain.h"
#include "fix_property_atom.h"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/formulas/collision_in_fluid.hpp"
#include "liggghts_styles/formulas/lubrication.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/lost_contacts.hpp"
#include "liggghts_styles/model_scale.hpp"
#include "liggghts_styles/wall_reach.hpp"

namespace bedload {

namespace {
constexpr const char* style_name = "fix lubrication";
constexpr const char* store_id = "lubricationForce";
constexpr double default_range = 2;   // cells; a film at a wall has 0.8 % left there
constexpr double default_gap = 1e-3;  // radii
constexpr double published_gap = 3e-3;
constexpr double tolerance = 1e-8;  // of the films' forces, far below what the formula is good for
constexpr int most_iterations = 200;
constexpr double unresolved_cells = 1.0;  // `./bedload study validation film`
}  // namespace

FixLubrication* find_lubrication(LAMMPS_NS::LAMMPS* lmp) {
  return static_cast<FixLubrication*>(lmp->modify->find_fix_style_strict("lubrication", 0));
}

FixLubrication::FixLubrication(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg)
    : Fix(lammps, narg, arg) {
  comm_forward = 3;
  if (find_fix(*modify, "lubrication") != nullptr) {
    stop_run(lmp, "fix lubrication: there is one already, and one serves all pairs and walls");
  }
  const Arguments given(lmp, help, std::span(arg, narg).subspan(3));
  viscosity_setting_ = given.number("viscosity");
  range_setting_ = given.number("range");
  smallest_gap_setting_ = given.number("gapMin");
  law_ = given.word("law");
  if (!law_.empty() && law_ != "unresolved" && law_ != "published") {
    stop_run(lmp, fmt::format("{}: law is unresolved or published, found '{}'", style_name, law_));
  }
  tangential_setting_ = given.word("tangential");
  if (!tangential_setting_.empty() && tangential_setting_ != "on" && tangential_setting_ != "off")
    stop_run(lmp, fmt::format("{}: tangential is on or off, found '{}'", style_name,
                              tangential_setting_));
  viscosity_now_ = viscosity_setting_;
}

FixLubrication::~FixLubrication() = default;

int FixLubrication::setmask() {
  return LAMMPS_NS::FixConst::PRE_FORCE | LAMMPS_NS::FixConst::PRE_NEIGHBOR |
         LAMMPS_NS::FixConst::PRE_FINAL_INTEGRATE;
}

// Force applied in the last step, its number, the torque, and in how many collisions that bear the
// fluid's load the sphere was; goes into restart files and dumps.
void FixLubrication::post_create() {
  const char* arguments[] = {store_id, "all",    "property/atom",
                             store_id, "vector", "yes",
                             "no",     "no",     "0",
                             "0",      "0",      "-1",
                             "0",      "0",      "0",
                             "0"};
  applied_ = modify->add_fix_property_atom(static_cast<int>(std::size(arguments)),
                                           const_cast<char**>(arguments), style_name);
}

void FixLubrication::pre_delete(bool unfix) {
  if (unfix && applied_ != nullptr) modify->delete_fix(store_id);
}

void FixLubrication::prepare(const LAMMPS_NS::Fix* wall) {
  contact_observers_.add(wall);
  const FluidValue of_fluid = FluidValue::find(lmp, "viscosity", "");
  if (viscosity_setting_ > 0 && of_fluid.live() &&
      !same_as_fluid(viscosity_setting_, of_fluid.get()))
    stop_run(lmp, fmt::format("{}: viscosity is {:g}, and the fluid's is {:g} (its density times "
                              "fluid.kinematic_viscosity); leave the keyword out",
                              style_name, viscosity_setting_, of_fluid.get()));
  viscosity_ = viscosity_setting_ > 0 ? FluidValue::constant(viscosity_setting_)
                                      : FluidValue::find(lmp, "viscosity", "fluidViscosity");
  fluid_cell_ = FluidValue::find(lmp, "cell_size", "fluidCellSize");
  ends_ = find_fluid_ends(lmp);
  const double h = fluid_cell_.known() ? fluid_cell_.get() : 0;
  range_ = range_setting_ > 0 ? range_setting_ : default_range * h;
  cell_size_ = law_ == "published" ? 0 : h;
  if (law_ == "unresolved" && h == 0) {
    stop_run(lmp, fmt::format("{}: law unresolved needs a grid: a fix couple/fluid, or the "
                              "property fluidCellSize",
                              style_name));
  }
  prepare_tangential();
  smallest_gap_ = smallest_gap_setting_ > 0 ? smallest_gap_setting_
                  : cell_size_ > 0          ? default_gap
                                            : published_gap;
  const char* missing = !viscosity_.known() ? "viscosity" : range_ == 0 ? "range" : nullptr;
  if (missing != nullptr) {
    stop_run(lmp,
             fmt::format("{}: the keyword '{} <value>' is missing and there is no fix couple/fluid "
                         "that gives it",
                         style_name, missing));
  }
  const double smallest_gap = smallest_gap_ * force->registry.max_radius();
  if (smallest_gap >= range_)
    stop_run(lmp,
             fmt::format("{}: gapMin of {} radii is a gap of {:.6g}, not below the range {:.6g}: "
                         "the film would be as stiff at every gap",
                         style_name, smallest_gap_, smallest_gap, range_));
  reach_out(lmp, style_name, range_);
  if (wall == nullptr) tell_range();
}

void FixLubrication::prepare_tangential() {
  tangential_on_ = tangential() && cell_size_ > 0;
  if (tangential_on_ || tangential_setting_ != "on") return;
  stop_run(lmp, fmt::format("{}: tangential on adds what a grid lacks, with law unresolved and a "
                            "fix couple/fluid or the property fluidCellSize; {}",
                            style_name,
                            law_ == "published" ? "here law is published" : "here is no grid"));
}

/// The range and where it comes from; a warning where it is shorter than what the grid leaves out.
void FixLubrication::tell_range() const {
  const FluidValue h = FluidValue::find(lmp, "cell_size", "fluidCellSize");
  tell_scale(lmp, {style_name, "range", "range", "cells", range_setting_, default_range}, h);
  if (h.live() && range_ < unresolved_cells * h.get())
    warn(
        lmp, style_name,
        fmt::format("the range {:.4g} is shorter than the gap of {:.4g} ({} cells) below which the "
                    "fluid's grid does not resolve the film",
                    range_, unresolved_cells * h.get(), unresolved_cells));
}

void FixLubrication::init() {
  refuse_neighbor_multi(lmp, style_name);
  refuse_clumps(lmp, style_name);
  if (std::string_view(update->integrate_style) != "verlet")
    stop_run(lmp, fmt::format("{}: films act with run_style verlet alone, and this script has '{}'",
                              style_name, update->integrate_style));
  mobility_ = Mobility(lmp);
  contact_observers_.check_pairs(lmp, style_name);
  refuse_newton(lmp, style_name);
  refuse_projected_spheres();
  fluid_force_ = static_cast<LAMMPS_NS::FixPropertyAtom*>(
      modify->find_fix_property("couple_force", "property/atom", "vector", 3, 0, style, false));
  marker_film_ = find_marker_film(lmp);
  on_walls_ = find_impulse_on_walls(lmp);
  fluid_density_ = FluidValue::find(lmp, "fluid_density", "fluidDensity");
  fluid_step_ = FluidValue::find(lmp, "dt_fluid", "fluidTimeStep");
  loads_received_ = FluidValue::find(lmp, "loads_received", "");
  diffusion_ = FluidDiffusion::find(lmp);
}

void FixLubrication::setup_pre_force(int) {
  loads_stale_ = true;
  pre_force(0);
}

void FixLubrication::pre_force(int) {
  forget();
  diffusion_number_ = diffusion_.number();
  of_pair_ = contact::unresolved_of_pair(diffusion_number_);
  at_wall_ = contact::unresolved_at_wall(diffusion_number_);
  if (!knows_loads()) return;
  if (loads_stale_ || loads_known_ != loads_received_.get()) {
    loads_stale_ = false;
    loads_known_ = loads_received_.get();
    loads_.resize(atom->nlocal + atom->nghost);
    for (int i = 0; i < atom->nlocal; ++i) {
      const double w = inverse_mass(i);
      for (int d = 0; d < 3; ++d) loads_[i][d] = w * fluid_force_->array_atom[i][d];
    }
    send(Sending::loads);
  }
  borne_.resize(atom->nlocal + atom->nghost);
  for (int i = 0; i < atom->nlocal; ++i) borne_[i] = applied_->array_atom[i][borne_column];
  send(Sending::borne);
}

/// Numbers of spheres to their ghosts.
void FixLubrication::send(Sending what) {
  sending_ = what;
  comm->forward_comm_fix(this);
}

double FixLubrication::load_acceleration(int i, int j, const double* normal) const {
  if (!knows_loads()) return 0;
  double sum = 0;
  for (int d = 0; d < 3; ++d) sum += normal[d] * (loads_[i][d] - (j < 0 ? 0.0 : loads_[j][d]));
  return sum;
}

// Films act when all other forces are known, behind the fixes that hold a sphere in its plane or at
// its speed.
void FixLubrication::refuse_projected_spheres() const {
  for (int n = 0; n < modify->nfix; ++n) {
    const Fix& other = *modify->fix[n];
    if (!projects_forces(other.style)) continue;
    const auto is_in_both = [&](int mask) {
      return (mask & groupbit) != 0 && (mask & other.groupbit) != 0 && !mobility_.held(mask);
    };
    const bool mine = std::any_of(atom->mask, atom->mask + atom->nlocal, is_in_both);
    std::array<double, 1> ranks{mine ? 1.0 : 0.0};
    sum_over_ranks(ranks);
    if (ranks[0] > 0)
      stop_run(lmp, fmt::format("{}: the films act behind 'fix {} {}' and would push its spheres "
                                "where they must not go; hold them by fix freeze or nve/noforce, "
                                "or leave them out of the group of {}",
                                style_name, other.id, other.style, style_name));
  }
}

void FixLubrication::forget() {
  films_.clear();
  collisions_.clear();
  tangential_.clear();
}

/// Part of the step during which the surfaces touch.
double FixLubrication::touching(const Surfaces& s, double opening) const {
  const double way = std::abs(opening) * update->dt;
  return way > 0 ? std::clamp(0.5 - s.gap / way, 0.0, 1.0) : 1.0;
}

/// Of a collision that bears the fluid's load [kg/s].
double FixLubrication::damping_in_collision(const Surfaces& s) const {
  const double density = fluid_density_.get(), mass = 1 / mobility_.inverse_mass(*atom, s.i, s.j);
  const double nu = viscosity_.get() / density;
  double share = 0;  // each sphere jumps by m/m_k of the relative jump
  for (const int k : {s.i, s.j}) {
    const double w = k < 0 ? 0.0 : inverse_mass(k);
    if (!(w > 0)) continue;
    const double radius = atom->radius[k], added = contact::added_mass(radius, density);
    // An image comes as fast as its sphere.
    const double image = s.mirrored() ? 2 : 1, closeness = s.effective_radius / radius / image;
    const double lasting = contact::lasting_share(1 / w, added, closeness);
    const double age =
        contact::collision_layer_age(nu, s.collision_time, cell_size_, image * s.speed, lasting);
    const double resolved = contact::resolved_layer(image * s.speed * cell_size_ / nu);
    const double late =
        contact::late_share(1 / w, added, fluid_step_.get(), s.collision_time, closeness);
    share += mass * w *
             contact::paid_share(contact::viscous_share(radius, 1 / w, added, density, nu, age),
                                 resolved, late);
  }
  return contact::collision_damping(mass, s.collision_time, share);
}

/// Whether the fluid, where there is one, has these spheres.
bool FixLubrication::in_fluid(const Surfaces& s) const {
  return marker_film_ == nullptr ||
         (marker_film_->in_fluid(s.i) && (s.j < 0 || marker_film_->in_fluid(s.j)));
}

/// What the fluid's box has at the foot of a wall's normal.
FixLubrication::End FixLubrication::end_at(const Surfaces& s) const {
  constexpr double nearby = 0.5;  // cells
  for (int d = 0; d < 3; ++d) {
    const double foot = atom->x[s.i][d] - (atom->radius[s.i] + s.gap) * s.normal[d];
    const bool lower = s.normal[d] > 0;
    const double end = lower ? domain->boxlo[d] : domain->boxhi[d];
    if (domain->periodicity[d] == 0 && std::abs(s.normal[d]) > 0.5 &&
        std::abs(foot - end) < nearby * fluid_cell_.get())
      return ends_[static_cast<std::size_t>(2 * d + (lower ? 0 : 1))].kind ==
                     FluidEnd::Kind::free_slip
                 ? End::free_slip
                 : End::no_slip;
  }
  return End::none;
}

/// c of this step [kg/s]; may be below 0 in a collision.
double FixLubrication::coefficient(const Surfaces& s, double opening) const {
  // An image is twice as far away as the plane of the mirror, and comes from there twice as fast.
  const double image = s.mirrored() ? 2 : 1, gap = image * s.gap;
  const double way = image * std::abs(opening) * update->dt;
  double per_gap = contact::mean_inverse_gap(gap, way, smallest_gap_ * s.smaller_radius);
  if (cell_size_ > 0) {
    const double part = touching(s, opening);
    // The grid has the spheres in the fluid, and of the walls those where its box ends.
    if (s.end != End::none) {
      const bool wall = s.j < 0 && !s.mirrored();
      const auto& share = wall ? at_wall_ : of_pair_;
      per_gap *= share(std::max(0.0, gap) / cell_size_);
      if (s.colliding) per_gap -= (1 - s.weight) * part * share.resolved_at_touch / cell_size_;
    }
    if (s.enduring) per_gap += part / (smallest_gap_ * s.smaller_radius);
  }
  if (s.mirrored()) per_gap *= contact::mirrored_share;
  double c = per_gap * contact::lubrication_strength(viscosity_.get(), s.effective_radius);
  if (s.weight > 0) c += s.weight * touching(s, opening) * damping_in_collision(s);
  return c;
}

/// What a collision may bear of the load of spheres that are in others, too: together they bear no
/// more than all of it. A load is new with its stage, and so are these numbers.
double FixLubrication::share_of_load(const Surfaces& s) const {
  return 1 / std::max({1.0, borne_[s.i], s.j < 0 ? 0.0 : borne_[s.j]});
}

void FixLubrication::add(const Surfaces& met) {
  Surfaces s = met;
  const auto outside = [&](int k) { return (atom->mask[k] & groupbit) == 0; };
  if (outside(s.i) || (s.j >= 0 && outside(s.j))) return;
  if (!in_fluid(s))
    s.end = End::none;
  else if (s.j < 0 && fluid_cell_.live())
    s.end = end_at(s);
  if (s.weight > 0) s.weight *= share_of_load(s);
  const double* n = s.normal;
  Film film{s.i, s.j, 0,    {n[0], n[1], n[2]}, {0, 0, 0}, 0, s.j >= atom->nlocal ? 0.5 : 1.0,
            0,   0,   false};
  if (inverse_mass(film) == 0) return;  // neither can move
  if (s.wall_velocity != nullptr) std::copy_n(s.wall_velocity, 3, film.wall_velocity.begin());
  const double opening = opening_speed(film);
  film.coefficient = coefficient(s, opening);
  if (film.coefficient != 0) (film.coefficient > 0 ? films_ : collisions_).push_back(film);
  if (s.weight > 0) {
    film.coefficient = 0;
    film.bears = true;
    film.borne = -s.weight * touching(s, opening) / inverse_mass(film) *
                 (load_acceleration(s.i, s.j, s.normal) - s.load);
    collisions_.push_back(film);
  }
  add_tangential(s);
}

/// Of the film of this gap, in an enduring contact of the smallest one, what neither the grid nor
/// FixMarkerFilm gives. In a collision, which has no duration in nature, there is no film.
contact::SlideAndRoll FixLubrication::missing_logarithms(const Surfaces& s) const {
  const double h = fluid_cell_.get(), smallest = smallest_gap_ * s.smaller_radius;
  const bool wall = s.j < 0 && !s.mirrored();
  if (wall) return contact::logarithms_lacking_at_wall(std::max(s.gap, smallest) / h);
  const double apart = s.mirrored() ? 2 * s.gap : s.gap, cells = std::max(apart, smallest) / h;
  const auto all = contact::unresolved_logarithms_of_pair(cells);
  if (marker_film_ == nullptr || !in_fluid(s)) return all;
  return contact::rest_of(
      contact::rest_of(all, contact::logarithms_of_short_steps(cells, diffusion_number_)),
      marker_film_->logarithms(apart));
}

void FixLubrication::add_tangential(const Surfaces& s) {
  if (!tangential_on_ || (s.gap <= 0 && !s.enduring)) return;
  const contact::SlideAndRoll logarithms = missing_logarithms(s);
  TangentialFilms::Film t{s.i,       s.j, {s.normal[0], s.normal[1], s.normal[2]},
                          {0, 0, 0}, {},  s.mirrored()};
  if (s.wall_velocity != nullptr) std::copy_n(s.wall_velocity, 3, t.wall_velocity.begin());
  const double mu = viscosity_.get(), a = atom->radius[s.i];
  const bool wall = s.j < 0 && !s.mirrored();
  const double apart = s.mirrored() ? 2 * s.gap : s.gap;
  t.film = wall ? contact::tangential_film_at_wall(mu, a, apart, logarithms)
                : contact::tangential_film_of_pair(mu, a, s.mirrored() ? a : atom->radius[s.j],
                                                   apart, logarithms);
  tangential_.add(t);
}

double FixLubrication::inverse_mass(int i) const { return mobility_.inverse_mass(*atom, i); }

double FixLubrication::inverse_mass(const Film& film) const {
  return mobility_.inverse_mass(*atom, film.i, film.j);
}

/// One message for all of them.
void FixLubrication::sum_over_ranks(std::span<double> numbers) const {
  if (comm->nprocs > 1)
    MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_DOUBLE,
                  MPI_SUM, world);
}

/// Films of this step here, of all kinds.
double FixLubrication::films_here() const {
  return static_cast<double>(films_.size() + collisions_.size() + tangential_.size());
}

/// n·(a_i - a_j) by all forces but films', the rate at which the gap's speed changes [m/s²].
double FixLubrication::relative(const Film& film) const {
  const Vector& n = film.normal;
  const Vector& a = accelerations_[film.i];
  double r = a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
  if (film.j >= 0) {
    const Vector& b = accelerations_[film.j];
    r -= b[0] * n[0] + b[1] * n[1] + b[2] * n[2];
  }
  return r;
}

/// g_n [m/s].
double FixLubrication::opening_speed(const Film& film) const {
  const double* vi = atom->v[film.i];
  const double* vj = film.j < 0 ? film.wall_velocity.data() : atom->v[film.j];
  double opening = 0;
  for (int d = 0; d < 3; ++d) opening += (vi[d] - vj[d]) * film.normal[d];
  return opening;
}

/// Each film by itself, under the forces that are not films.
void FixLubrication::solve_alone() {
  const int local = atom->nlocal;
  accelerations_.resize(local + atom->nghost);
  for (int i = 0; i < local; ++i) {
    const double w = inverse_mass(i);
    for (int d = 0; d < 3; ++d) accelerations_[i][d] = w * atom->f[i][d];
  }
  send(Sending::accelerations);
  const double dt = update->dt;
  for (Film& film : films_) {
    const double opening = opening_speed(film);
    const double x = film.coefficient * dt * inverse_mass(film);
    film.compliance = contact::lubrication_step_compliance(film.coefficient, dt, x);
    film.force = contact::lubrication_step_force(film.coefficient, opening, relative(film), dt, x);
  }
}

/// Films that share a sphere. On one rank ghosts are images of its own spheres; where these are
/// found by their tags no acceleration has to be sent.
void FixLubrication::solve_together() {
  const bool alone = comm->nprocs == 1 && atom->map_style != 0;
  const auto sphere = [&](int k) {
    return alone && k >= atom->nlocal ? atom->map(atom->tag[k]) : k;
  };
  system_.begin(atom->nlocal + atom->nghost, films_.size());
  for (const Film& film : films_)
    system_.add(film.i, film.j < 0 ? film.j : sphere(film.j), film.normal, inverse_mass(film.i),
                film.j < 0 ? 0.0 : inverse_mass(film.j), film.compliance, film.force, film.share);
  const auto refresh = [&] {
    if (!alone) send(Sending::film_accelerations);
  };
  films_somewhere_ = system_.solve(
      tolerance, most_iterations,
      {.refresh = refresh, .sum = [this](std::span<double> numbers) { sum_over_ranks(numbers); }});
  for (std::size_t k = 0; k < films_.size(); ++k) films_[k].force = system_.force(k);
}

/// Forces and torques against sliding and rolling join the others and lubricationForce.
void FixLubrication::apply_tangential() {
  tangential_.sum_rates(*atom, mobility_);
  send(Sending::rates);
  double** applied = applied_->array_atom;
  tangential_.apply(*atom, mobility_, update->dt, on_walls_,
                    [applied](int k, const Vector& force, const Vector& torque) {
                      for (int d = 0; d < 3; ++d) {
                        applied[k][d] += force[d];
                        applied[k][4 + d] += torque[d];
                      }
                    });
}

void FixLubrication::pre_final_integrate() {
  if (!films_somewhere_) {
    std::array<double, 1> films{films_here()};
    sum_over_ranks(films);
    films_somewhere_ = films[0] > 0;
  }
  if (!films_somewhere_ && !stale_) return;
  const int local = atom->nlocal;
  double** applied = applied_->array_atom;
  for (int i = 0; i < local; ++i) {
    std::fill_n(applied[i], 3, 0.0);
    applied[i][3] = static_cast<double>(update->ntimestep);
    std::fill_n(applied[i] + 4, 3, 0.0);
    applied[i][borne_column] = 0;
  }
  stale_ = films_somewhere_;
  if (!films_somewhere_) return;

  for (Film& film : collisions_) {
    film.force = film.borne - film.coefficient * opening_speed(film);
    if (!film.bears) continue;
    applied[film.i][borne_column] += 1;
    if (film.j >= 0 && film.j < local) applied[film.j][borne_column] += 1;
  }
  apply(collisions_);
  if (tangential_.size() > 0 || comm->nprocs > 1) apply_tangential();
  solve_alone();
  solve_together();
  apply(films_);
}

/// The forces of these films join the others and lubricationForce.
void FixLubrication::apply(const std::vector<Film>& films) {
  double** applied = applied_->array_atom;
  const auto push = [&](int k, double force, const Film& film) {
    if (inverse_mass(k) == 0) return;
    for (int d = 0; d < 3; ++d) {
      applied[k][d] += force * film.normal[d];
      atom->f[k][d] += force * film.normal[d];
    }
  };
  for (const Film& film : films) {
    push(film.i, film.force, film);
    if (film.j >= 0 && film.j < atom->nlocal) push(film.j, -film.force, film);
    if (film.j < 0 && on_walls_ != nullptr)
      on_walls_->take(film.normal.data(), film.force * film.normal[0], update->dt);
  }
}

// At the start of a run the forces of the last step are wanted again.
void FixLubrication::setup(int) {
  contact_observers_.check_walls(lmp, style_name, groupbit);
  const auto now = static_cast<double>(update->ntimestep);
  for (int i = 0; i < atom->nlocal; ++i) {
    const double* applied = applied_->array_atom[i];
    if (applied[3] != now) continue;
    for (int d = 0; d < 3; ++d) {
      atom->f[i][d] += applied[d];
      atom->torque[i][d] += applied[4 + d];
    }
  }
}

/// What send() is about, of one sphere.
FixLubrication::Vector FixLubrication::sent(int i) const {
  switch (sending_) {
    case Sending::rates:
      return {tangential_.rate(i)};
    case Sending::loads:
      return loads_[i];
    case Sending::borne:
      return {borne_[i]};
    case Sending::film_accelerations:
      return system_.acceleration(i);
    case Sending::accelerations:
      break;
  }
  return accelerations_[i];
}

int FixLubrication::pack_comm(int count, int* list, double* buffer, int, int*) {
  const int numbers = sends_one() ? 1 : comm_forward;
  for (int n = 0; n < count; ++n) {
    const Vector values = sent(list[n]);
    buffer = std::copy_n(values.begin(), numbers, buffer);
  }
  return numbers;
}

void FixLubrication::unpack_comm(int count, int first, double* buffer) {
  for (int i = first; i < first + count; ++i) {
    if (sends_one()) {
      (sending_ == Sending::rates ? tangential_.rate(i) : borne_[i]) = *buffer++;
      continue;
    }
    const Vector values{buffer[0], buffer[1], buffer[2]};
    buffer += comm_forward;
    if (sending_ == Sending::film_accelerations)
      system_.set_acceleration(i, values);
    else
      (sending_ == Sending::loads ? loads_ : accelerations_)[i] = values;
  }
}

void* FixLubrication::extract(const char* name, int& dimension) {
  dimension = 0;
  return std::string_view(name) == "viscosity" && viscosity_now_ > 0 ? &viscosity_now_ : nullptr;
}

}  // namespace bedload
