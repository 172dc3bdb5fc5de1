#include "liggghts_styles/fix_marker_film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "group.h"
#include "liggghts_styles/contact_observers.hpp"
#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/model_scale.hpp"

namespace bedload {

namespace {
constexpr contact::SlideAndRoll none{0, 0};
}

FixMarkerFilm* find_marker_film(LAMMPS_NS::LAMMPS* lmp) {
  return static_cast<FixMarkerFilm*>(
      lmp->modify->find_fix_style_strict(FixMarkerFilm::style_name, 0));
}

FixMarkerFilm::FixMarkerFilm(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg)
    : Fix(lammps, narg, arg) {
  comm_forward = 1;
  if (find_fix(*modify, "couple/fluid") == nullptr || find_fix(*modify, style_name) != nullptr)
    stop_run(lmp, "fix marker/film belongs to fix couple/fluid, which makes it; leave it out");
}

FixMarkerFilm::~FixMarkerFilm() = default;

int FixMarkerFilm::setmask() { return LAMMPS_NS::FixConst::PRE_FORCE; }

void FixMarkerFilm::prepare() {
  cell_ = FluidValue::find(lmp, "cell_size", "");
  reach_ = contact::left_by_markers_to * cell_.get();
  pairs_told_ = true;
  if (const double smallest = force->registry.min_radius(); smallest > 0)
    neighbor->register_contact_dist_factor(1 + reach_ / smallest);
}

void FixMarkerFilm::init() {
  mobility_ = Mobility(lmp);
  viscosity_ = FluidValue::find(lmp, "viscosity", "");
  cell_ = FluidValue::find(lmp, "cell_size", "");
  diffusion_ = FluidDiffusion::find(lmp);
  ends_ = find_fluid_ends(lmp);
  on_walls_ = find_impulse_on_walls(lmp);
  if (!pairs_told_ && (force->pair != nullptr || group->count(igroup) > 1))
    warn(lmp, "fix couple/fluid",
         std::string(force->pair != nullptr
                         ? fmt::format("the pairs' contact model is none that bedload knows ({})",
                                       known_models)
                         : "there is no pair_style") +
             ", and only such a pair tells which spheres are close: those that slide or roll past "
             "each other lack the part of the fluid's resistance that the grid leaves out");
  pairs_told_ = false;  // the next run's have to report again
}

contact::SlideAndRoll FixMarkerFilm::logarithms(double gap) const {
  const double cells = gap / cell_.get();
  if (cells > contact::left_by_markers_to) return none;
  return contact::logarithms_left_by_markers(cells, diffusion_number_);
}

contact::LeftAtWall FixMarkerFilm::left_at_wall(double gap, double radius) const {
  const double cell = cell_.get(), cells = gap / cell;
  if (cells > contact::left_by_markers_to) return {};
  return contact::left_by_markers_at_wall(cells, 0.5 * cell / radius, diffusion_number_);
}

void FixMarkerFilm::pre_force(int) {
  films_.clear();
  diffusion_number_ = diffusion_.number();
}

void FixMarkerFilm::add(int i, int j, double gap, const double* normal) {
  if (mobility_.inverse_mass(*atom, i, j) == 0) return;  // neither can move
  const contact::SlideAndRoll left = logarithms(gap);
  films_.add({i,
              j,
              {normal[0], normal[1], normal[2]},
              {},
              contact::tangential_film_of_pair(viscosity_.get(), atom->radius[i], atom->radius[j],
                                               gap, left),
              false});
}

/// Spheres beside the ends of the box, where no wall of the script need stand.
void FixMarkerFilm::add_ends() {
  const double reach = contact::left_by_markers_to * cell_.get();
  for (std::size_t end = 0; end < ends_.size(); ++end) {
    const auto d = static_cast<int>(end / 2);
    const FluidEnd& here = ends_[end];
    if (here.kind == FluidEnd::Kind::periodic) continue;
    const bool lower = end % 2 == 0;
    contact::Vector3 normal{};
    normal[static_cast<std::size_t>(d)] = lower ? 1 : -1;
    const double position = (lower ? domain->boxlo : domain->boxhi)[d];
    for (int i = 0; i < atom->nlocal; ++i) {
      const double gap = (lower ? 1 : -1) * (atom->x[i][d] - position) - atom->radius[i];
      if (gap > reach || !in_fluid(i) || mobility_.held(atom->mask[i])) continue;
      if (here.kind == FluidEnd::Kind::free_slip)
        add_image(i, normal, gap);
      else
        add_wall(i, normal, gap, here.velocity);
    }
  }
}

/// A free-slip end is a plane of symmetry: the image is twice as far away.
void FixMarkerFilm::add_image(int i, const contact::Vector3& normal, double gap) {
  const contact::SlideAndRoll left = logarithms(2 * gap);
  if (left.slide + left.roll == 0) return;
  const double a = atom->radius[i];
  films_.add({i,
              -1,
              normal,
              {},
              contact::tangential_film_of_pair(viscosity_.get(), a, a, 2 * gap, left),
              true});
}

void FixMarkerFilm::add_wall(int i, const contact::Vector3& normal, double gap,
                             const contact::Vector3& velocity) {
  const double a = atom->radius[i];
  films_.add(
      {i, -1, normal, velocity,
       contact::tangential_film_at_wall(viscosity_.get(), a, gap, none, left_at_wall(gap, a)),
       false});
}

void FixMarkerFilm::act(double** loads) {
  add_ends();
  for (int i = 0; i < atom->nlocal; ++i) std::fill_n(loads[i], 6, 0.0);
  films_.sum_rates(*atom, mobility_);
  if (comm->nprocs > 1 || films_.size() > 0) comm->forward_comm_fix(this);
  films_.apply(*atom, mobility_, update->dt, on_walls_,
               [loads](int k, const contact::Vector3& force, const contact::Vector3& torque) {
                 for (int d = 0; d < 3; ++d) {
                   loads[k][d] += force[d];
                   loads[k][3 + d] += torque[d];
                 }
               });
}

int FixMarkerFilm::pack_comm(int count, int* list, double* buffer, int, int*) {
  for (int n = 0; n < count; ++n) buffer[n] = films_.rate(list[n]);
  return 1;
}

void FixMarkerFilm::unpack_comm(int count, int first, double* buffer) {
  for (int i = 0; i < count; ++i) films_.rate(first + i) = buffer[i];
}

}  // namespace bedload
