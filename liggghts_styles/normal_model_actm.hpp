#pragma once

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "liggghts_styles/choice_setting.hpp"
#include "liggghts_styles/fix_lubrication.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/actm.hpp"
#include "liggghts_styles/formulas/collision_in_fluid.hpp"
#include "liggghts_styles/gravity_fixes.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/lost_contacts.hpp"
#include "liggghts_styles/material_values.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/model_scale.hpp"

namespace LIGGGHTS::ContactModels {

inline constexpr int BEDLOAD_ACTM = 20;

/// normal model actm: the adaptive collision time model. Formulas in formulas/actm.hpp; user page
/// doc/normal_actm.md.
///
/// Contact history, zero while there is no contact:
/// - actm_k, actm_d: stiffness and damping of this contact
/// - actm_birth_overlap: overlap from which it counts (0 but for spheres put into overlap)
/// - actm_speed: speed that it was calibrated for
/// - actm_force: normal force of the last step
/// - actm_step: number of the last step in contact
/// - actm_settling: step at which it began, -1 once it is stiff enough to bear the weight
/// - actm_lost: energy that its damping has dissipated and no stiffening has used
/// - actm_impact: 1 if it began as a collision and has not hardened, 0 as an enduring contact
/// - actm_onset, actm_slope: its hardening (formulas/actm_hardening.hpp)
/// - actm_load: acceleration of its gap by the fluid's loads when it began
template <>
class NormalModel<BEDLOAD_ACTM> : public NormalModelBase {
 public:
  static constexpr double not_given = -1;
  static constexpr bedload::NumberKeyword keywords[] = {
      {"collisionTime", 0, true, bedload::no_limit, 0, "0: collisionSteps", "T",
       "Duration T_c of a collision, the same on any grid."},
      {"collisionSteps", 0, false, bedload::no_limit, not_given, "10 without collisionTime",
       "fluid time steps", "Duration T_c of a collision that follows the grid."},
      {"criticalStokes", 0, true, bedload::no_limit, not_given,
       "5 with biegert, 1 with kempe_froehlich", "-",
       "Stokes number of the impact below which a contact counts as enduring."},
      {"restingOverlap", 0, false, 1, not_given, "0.001 with biegert",
       "radii of the smaller sphere", "Overlap under the own weight in an enduring contact."}};
  static constexpr std::string_view rules[] = {"plain", "kempe_froehlich", "biegert"};
  enum Rule { plain, kempe_froehlich, biegert };
  static constexpr std::string_view switches[] = {"off", "on"};
  enum Switch { off, on };
  static constexpr bedload::ChoiceKeyword choices[] = {
      {"enduring", rules, biegert, "Rule for slow impacts and contacts that last."},
      {"hardening", switches, on,
       "A stiffer spring beyond the overlap that the impact can reach, for loads of others."}};
  static constexpr bedload::StyleHelp help{
      "normal model actm",
      "Adaptive collision time: each collision is stretched to T_c and rebounds with "
      "coefficientRestitution.",
      "pair_style gran model actm [tangential haff_werner|history|off] "
      "[rolling_friction cdt|epsd2|off] [keyword value ...]\n"
      "fix ID group wall/gran model actm [tangential ...] primitive|mesh ... [keyword value ...]",
      keywords,
      {},
      choices};

  NormalModel(LAMMPS* lammps, IContactHistorySetup* hsetup, ContactModelBase* cmb)
      : NormalModelBase(lammps, hsetup, cmb) {
    first_ = hsetup->add_history_value("actm_k", "0");
    hsetup->add_history_value("actm_d", "0");
    hsetup->add_history_value("actm_birth_overlap", "0");
    hsetup->add_history_value("actm_speed", "0");
    hsetup->add_history_value("actm_force", "0");
    hsetup->add_history_value("actm_step", "0");
    hsetup->add_history_value("actm_settling", "0");
    hsetup->add_history_value("actm_lost", "0");
    hsetup->add_history_value("actm_impact", "0");
    hsetup->add_history_value("actm_onset", "0");
    hsetup->add_history_value("actm_slope", "0");
    hsetup->add_history_value("actm_load", "0");
  }

  void registerSettings(Settings& settings) override {
    bedload::read_setting(settings, keywords[0], time_setting_);
    bedload::read_setting(settings, keywords[1], steps_setting_);
    bedload::read_setting(settings, keywords[2], stokes_setting_);
    bedload::read_setting(settings, keywords[3], overlap_setting_);
    bedload::read_choice(settings, choices[0], rule_);
    bedload::read_choice(settings, choices[1], hardening_);
  }

  void postSettings(IContactHistorySetup*, ContactModelBase*) override {}

  void connectToProperties(PropertyRegistry&) override {
    // Shipped tangential and rolling models forget a contact when its surfaces are close by.
    neighbor->register_contact_dist_factor(close_by);
    restitution_ = bedload::read_pair_property(lmp, "normal model actm", "coefficientRestitution",
                                               bedload::contact::minimum_restitution, 1.0);
    calibrations_.clear();
    std::map<double, bedload::contact::ActmCalibration> done;
    for (int i = 1; i <= restitution_.types(); ++i) {
      for (int j = 1; j <= restitution_.types(); ++j) {
        const double e = restitution_(i, j);
        if (!done.contains(e)) done[e] = bedload::contact::calibrate_actm(e);
        calibrations_.push_back(done[e]);
      }
    }
    settle_settings();
    viscosity_ = bedload::find_viscosity(lmp);
    warn_of_unknown_viscosity();
    lubrication_ = bedload::find_lubrication(lmp);
    bedload::refuse_neighbor_multi(lmp, "normal model actm");
    bedload::refuse_clumps(lmp, "normal model actm");
    mobility_ = bedload::Mobility(lmp);
    gravity_known_ = false;
  }

  double stressStrainExponent() override { return 1.5; }

  void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}
  void endPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}

  void surfacesIntersect(SurfacesIntersectData& s, ForceData& i_forces,
                         ForceData& j_forces) override {
    if (s.contact_flags) *s.contact_flags |= CONTACT_NORMAL_MODEL;
    History& h = *reinterpret_cast<History*>(s.contact_history + first_);
    const auto now = static_cast<double>(update->ntimestep);
    const bool advancing =
        s.computeflag &&
        (s.shearupdate || (h.stiffness > 0 && bedload::one_step_late(lmp, h.step)));

    // Where the integrator asks again for the forces of a step that was made (start of a run,
    // output), it gets what was applied; asked for them at a step not made, the contact is read
    // only.
    // kn times the overlap is the spring's force, as with hertz and hooke. Tangential and rolling
    // models scale with the normal stiffness: they get 2/7 of the secant stiffness, hardening
    // aside, and of the damping.
    double force = 0;
    if (advancing) {
      force = advance(s, h, now);
    } else {
      if (h.step == now && now > 0) force = h.force;
      tell_stiffness(
          s, h,
          bedload::contact::actm_spring(h.stiffness, s.deltan - h.birth_overlap, h.hardening));
    }

    s.Fn = force;
    s.gamman = h.damping;
    s.gammat = 2.0 / 7.0 * s.gamman;

    const double scale = s.is_wall ? s.area_ratio : 1.0;
    for (int d = 0; d < 3; ++d) i_forces.delta_F[d] += scale * force * s.en[d];
    if (s.is_wall) return;
    for (int d = 0; d < 3; ++d) j_forces.delta_F[d] -= force * s.en[d];
  }

  void surfacesClose(SurfacesCloseData&, ForceData&, ForceData&) override {}

 private:
  /// T_c and the numbers of the rule, from what the script gives.
  void settle_settings() {
    constexpr const char* name = "normal model actm";
    if (time_setting_ > 0 && steps_setting_ != not_given)
      bedload::stop_run(lmp,
                        "normal model actm: collisionTime and collisionSteps both say how long "
                        "a collision lasts; leave out one of them (collisionTime 0)");
    if (rule_ == plain && stokes_setting_ != not_given)
      bedload::stop_run(lmp,
                        "normal model actm: criticalStokes has no effect with enduring plain, "
                        "which calibrates at every impact");
    if (rule_ != biegert && overlap_setting_ != not_given)
      bedload::stop_run(lmp, "normal model actm: restingOverlap belongs to enduring biegert");
    fluid_step_ = bedload::require_fluid_time_step(lmp, name);
    const double steps = steps_setting_ == not_given ? 10 : steps_setting_;
    scale_ = {name, "collision time", "collisionTime", "time steps", time_setting_, steps};
    bedload::tell_scale(lmp, scale_, fluid_step_);
    bedload::warn_of_unresolved(lmp, name, scale_.value(fluid_step_));
    constexpr double of_rule[] = {0, 1, 5};
    critical_stokes_ = stokes_setting_ == not_given ? of_rule[rule_] : stokes_setting_;
    resting_overlap_ = overlap_setting_ == not_given ? 1e-3 : overlap_setting_;
  }

  /// A Stokes number that somebody asked for tells nothing without a viscosity, as in a dry start.
  void warn_of_unknown_viscosity() const {
    if (viscosity_.known()) return;
    if (rule_ == kempe_froehlich || (stokes_setting_ != not_given && stokes_setting_ > 0))
      bedload::warn(
          lmp, "normal model actm",
          fmt::format("{} has no effect without the fluid's viscosity; give the property "
                      "fluidViscosity, a fix lubrication or a fix couple/fluid",
                      rule_ == kempe_froehlich ? "enduring kempe_froehlich" : "criticalStokes"));
  }

  struct Partner {
    double mass, radius, density;
    int groups;  ///< atom->mask
  };

  struct History {
    double stiffness, damping, birth_overlap, speed, force, step, settling, lost, impact;
    bedload::contact::ActmHardening hardening;
    double load;
  };

  /// One step of a contact: birth if there is none, force, memory of both. Sets s.kn and s.kt.
  [[gnu::always_inline]] double advance(SurfacesIntersectData& s, History& h, double now) {
    const double approach = -s.vn;
    const bool alive = h.stiffness > 0 && h.step == now - 1 && s.deltan > h.birth_overlap;
    h.force = s.kn = s.kt = 0;
    if (!alive) {
      h.stiffness = 0;
      if (approach <= 0) return 0;  // only approaching surfaces begin a contact
      // Surfaces that met within this step overlap by no more than they came closer in it. Any
      // further overlap was put there, and a contact counts from it: no energy from nowhere.
      h.birth_overlap = std::max(0.0, s.deltan - approach * update->dt);
    }
    const double mass = effective_mass(s);
    if (mass == 0) return 0;  // neither can move
    if (!alive || approach > softening * h.speed) {
      calibrate(s, mass, approach, h);
      // What pushes together is borne as a whole: most of it is the answer to the film's push just
      // before the touch, and gone with it.
      if (lubrication_ != nullptr)
        h.load = std::max(0.0, lubrication_->load_acceleration(s.i, s.is_wall ? -1 : s.j, s.en));
      harden(s, mass, alive, h);
      h.settling = now;
      h.lost = 0;
    } else if (rule_ == biegert && h.settling >= 0 && update->ntimestep % settling_stride == 0) {
      settle(s, mass, now, h);
    }
    if (h.hardening.slope > 0 && s.deltan - h.birth_overlap > h.hardening.onset)
      h.hardening.slope = std::min(
          h.hardening.slope,
          bedload::contact::resolved_slope(h.hardening.onset, h.stiffness, mass, update->dt));
    const bedload::contact::ActmStep done =
        bedload::contact::actm_step({h.stiffness, h.damping}, s.deltan - h.birth_overlap, approach,
                                    mass, update->dt, !alive, h.hardening);
    if (h.settling >= 0) {
      const double middle = approach - 0.5 * done.force * update->dt / mass;
      h.lost += h.damping * middle * middle * update->dt;
    }
    tell_stiffness(s, h, done.spring);
    if (bedload::contact::hardening_force(h.hardening, s.deltan - h.birth_overlap) > 0)
      h.impact = 0;
    if (lubrication_ != nullptr) tell_film(s, now, h);
    if (done.last) h.stiffness = 0;
    h.force = done.force;
    h.step = now;
    return h.force;
  }

  static void tell_stiffness(SurfacesIntersectData& s, const History& h, double spring) {
    s.kn = spring / s.deltan;
    s.kt = 2.0 / 7.0 * h.stiffness * std::sqrt(std::max(0.0, s.deltan - h.birth_overlap));
  }

  /// In a collision the film is over, but what the grid resolves of it is not. In an enduring
  /// contact the surfaces lie on their roughness, and the film stays at its smallest gap.
  void tell_film(const SurfacesIntersectData& s, double now, const History& h) {
    find_out_gravity();
    const double longest = longest_collision * scale_.value(fluid_step_);
    const bool colliding = h.impact > 0 && (now - h.settling) * update->dt < longest;
    const double effective = s.is_wall ? s.radi : s.radi * s.radj / s.radsum;
    const double smaller = s.is_wall ? s.radi : std::min(s.radi, s.radj);
    bedload::FixLubrication::Surfaces surfaces{s.i,
                                               s.is_wall ? -1 : s.j,
                                               -s.deltan,
                                               effective,
                                               smaller,
                                               s.en,
                                               s.is_wall ? s.v_j : nullptr,
                                               colliding,
                                               rule_ == biegert && !colliding};
    if (colliding && lubrication_->knows_loads()) meet_in_fluid(s, h, surfaces);
    lubrication_->add(surfaces);
  }

  /// What this collision bears of the fluid's load (formulas/collision_in_fluid.hpp).
  void meet_in_fluid(const SurfacesIntersectData& s, const History& h,
                     bedload::FixLubrication::Surfaces& surfaces) const {
    const Partner heavier = heavier_partner(s);
    const double stokes = heavier.density * h.speed * 2 * heavier.radius / (9 * viscosity_.get());
    surfaces.weight = bedload::contact::collision_weight(stokes);
    surfaces.speed = h.speed;
    surfaces.load = h.load;
    surfaces.collision_time = scale_.value(fluid_step_);
  }

  /// Not yet known at connectToProperties: fixes are initialised after the pair. Asked for by new
  /// contacts and by those that settle, which after a restart may come first.
  void find_out_gravity() {
    if (gravity_known_) return;
    gravity_ = bedload::GravityFixes(lmp);
    fluid_density_ = bedload::find_fluid_density(lmp);
    gravity_known_ = true;
  }

  /// k and d of a contact that begins with (or is hit at) the speed u.
  void calibrate(const SurfacesIntersectData& s, double mass, double u, History& h) {
    find_out_gravity();
    const double collision_time = scale_.value(fluid_step_);
    if (!(collision_time > 0)) {
      error->one(FLERR, "normal model actm: the coupling has not set a fluid time step above 0");
    }
    bedload::require_resolved(lmp, "normal model actm", collision_time);
    const Partner heavier = heavier_partner(s);
    const double g = submerged_gravity(heavier);

    // Enduring contact: impact speed below St_crit, or (biegert) so low that weight turns the
    // sphere round within one collision time.
    double critical = rule_ == biegert ? 0.5 * g * collision_time : 0.0;
    if (critical_stokes_ > 0 && viscosity_.known()) {
      critical = std::max(critical,
                          bedload::contact::speed_at_stokes(critical_stokes_, viscosity_.get(),
                                                            2 * heavier.density * heavier.radius));
    }
    h.speed = std::max(u, critical);
    h.impact = u < critical ? 0 : 1;
    set(h, bedload::contact::actm_coefficients(mass, h.speed, collision_time, calibration(s)));
    if (rule_ == biegert && u < critical) stiffen(s, mass, bearing_stiffness(s, mass), h);
    if (rule_ != biegert) soften_to_resolved(s, mass, h);
  }

  /// The second spring of a contact that begins, or is hit anew: then it must not gain energy.
  void harden(const SurfacesIntersectData& s, double mass, bool alive, History& h) const {
    const double before = h.hardening.slope;
    h.hardening = {};
    if (hardening_ == off) return;
    const double expected = bedload::contact::largest_overlap_expected(
        mass, h.speed, submerged_gravity(heavier_partner(s)), h.stiffness,
        calibration(s).largest_overlap);
    h.hardening = bedload::contact::actm_hardening(expected, h.stiffness, mass, update->dt);
    if (alive) h.hardening.slope = std::min(h.hardening.slope, before);
  }

  /// A contact that is still there after twice the collision time is no collision: other forces
  /// hold it. It becomes stiff enough to bear the weight, by no more than an e-fold per collision
  /// time, and pays the elastic energy for that from what its damping has taken, so that no energy
  /// is made.
  void settle(const SurfacesIntersectData& s, double mass, double now, History& h) {
    const double collision_time = scale_.value(fluid_step_);
    if ((now - h.settling) * update->dt < 2 * collision_time) return;
    find_out_gravity();
    const double target = bearing_stiffness(s, mass);
    const double overlap = s.deltan - h.birth_overlap;
    const double per_stiffness = bedload::contact::elastic_energy(1.0, overlap);
    const double rise = std::min(
        std::min(target, h.stiffness * (1 + settling_stride * update->dt / collision_time)) -
            h.stiffness,
        h.lost / per_stiffness);
    if (rise > 0) {
      h.lost -= rise * per_stiffness;
      stiffen(s, mass, h.stiffness + rise, h);
    }
    if (h.stiffness >= target) h.settling = -1;
  }

  /// Raises k to the given value, if it is below, with the d that keeps e.
  void stiffen(const SurfacesIntersectData& s, double mass, double stiffness, History& h) {
    if (stiffness <= h.stiffness) return;
    set(h,
        bedload::contact::actm_coefficients_of_stiffness(mass, h.speed, stiffness, calibration(s)));
  }

  /// Keeps k to what the step resolves under the weight: without a rule for enduring contact it
  /// grows without bound as u -> 0.
  void soften_to_resolved(const SurfacesIntersectData& s, double mass, History& h) const {
    const Partner heavier = heavier_partner(s);
    const double g = submerged_gravity(heavier);
    if (g == 0) return;
    const double most =
        bedload::contact::stiffness_bearing(heavier.mass * g, resolved_overlap(heavier, g, mass));
    if (h.stiffness <= most) return;
    set(h, bedload::contact::actm_coefficients_of_stiffness(mass, h.speed, most, calibration(s)));
  }

  /// Overlap at rest under the heavier partner's weight whose frequency the step resolves. The
  /// spring moves the contact's (reduced) mass: ω² = 1.5 M g/(m δ).
  double resolved_overlap(const Partner& heavier, double g, double mass) const {
    const double shortest = update->dt / bedload::contact::resolved_phase;
    return 1.5 * g * heavier.mass / mass * shortest * shortest;
  }

  static void set(History& h, const bedload::contact::ActmCoefficients& c) {
    h.stiffness = c.stiffness;
    h.damping = c.damping;
  }

  /// k that lets the submerged weight of the heavier partner press in by restingOverlap times the
  /// smaller radius, or by as much as the step resolves. 0 without gravity.
  double bearing_stiffness(const SurfacesIntersectData& s, double mass) const {
    const Partner heavier = heavier_partner(s);
    const double g = submerged_gravity(heavier);
    if (g == 0) return 0;
    const double smaller = s.is_wall ? s.radi : std::min(s.radi, s.radj);
    return bedload::contact::stiffness_bearing(
        heavier.mass * g, std::max(resting_overlap_ * smaller, resolved_overlap(heavier, g, mass)));
  }

  const bedload::contact::ActmCalibration& calibration(const SurfacesIntersectData& s) const {
    return calibrations_[(s.itype - 1) * restitution_.types() + s.jtype - 1];
  }

  double submerged_gravity(const Partner& p) const {
    return gravity_.size_on(p.groups) * std::abs(1 - fluid_density_ / p.density);
  }

  /// Of equally heavy ones the smaller, then that with the lower tag: the same one wherever the
  /// pair is met, as i and j or as j and i (across ranks or periodic ends both happen).
  Partner heavier_partner(const SurfacesIntersectData& s) const {
    const auto is_heavier = [&] {
      if (s.mi != s.mj) return s.mi > s.mj;
      return s.radi != s.radj ? s.radi < s.radj : atom->tag[s.i] < atom->tag[s.j];
    };
    const bool first = s.is_wall || mobility_.held(atom->mask[s.j]) ||
                       (!mobility_.held(atom->mask[s.i]) && is_heavier());
    const double mass = first ? s.mi : s.mj;
    const double radius = first ? s.radi : s.radj;
    return {mass, radius, mass / (4.0 / 3.0 * std::numbers::pi * radius * radius * radius),
            atom->mask[first ? s.i : s.j]};
  }

  /// Reduced mass, with held partners infinitely heavy; 0 if both are held.
  double effective_mass(const SurfacesIntersectData& s) const {
    if (mobility_.all_free()) return s.meff;
    const double inverse = mobility_.inverse_mass(atom->mask[s.i], s.mi) +
                           (s.is_wall ? 0.0 : mobility_.inverse_mass(atom->mask[s.j], s.mj));
    return inverse > 0 ? 1 / inverse : 0.0;
  }

  static constexpr double close_by = 1.01;  ///< distance over that at the touch, as LIGGGHTS' hertz
  static constexpr int settling_stride = 8;  ///< steps between two looks at an enduring contact

  /// A contact that is hit this many times faster than it was calibrated for would last less than
  /// half of T_c (T ~ u^{-1/5}) and may not be resolved: it becomes softer then. That takes elastic
  /// energy away and never adds any.
  static constexpr double softening = 32;

  /// A collision is over after this many T_c, whatever still holds the surfaces together.
  static constexpr double longest_collision = 1.5;

  int first_ = 0;
  bedload::FixLubrication* lubrication_ = nullptr;
  double time_setting_ = 0, steps_setting_ = not_given;
  double stokes_setting_ = not_given, overlap_setting_ = not_given;
  int rule_ = biegert, hardening_ = on;
  bedload::ModelScale scale_{};
  double critical_stokes_ = 0, resting_overlap_ = 0;
  bedload::PairTable restitution_;
  std::vector<bedload::contact::ActmCalibration> calibrations_;
  bedload::FluidValue fluid_step_, viscosity_;
  bedload::Mobility mobility_;
  bool gravity_known_ = false;
  bedload::GravityFixes gravity_;
  double fluid_density_ = 0;
};

}  // namespace LIGGGHTS::ContactModels
