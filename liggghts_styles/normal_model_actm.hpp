#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/actm.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/material_values.hpp"
#include "liggghts_styles/mobility.hpp"

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
template <>
class NormalModel<BEDLOAD_ACTM> : public NormalModelBase {
 public:
  static constexpr bedload::NumberKeyword keywords[] = {
      {"collisionSteps", 0, false, bedload::no_limit, 10, "", "fluid time steps",
       "Duration T_c of a collision."},
      {"criticalStokes", 0, true, bedload::no_limit, 5, "", "-",
       "Stokes number of the impact below which a contact counts as enduring."},
      {"restingOverlap", 0, false, 1, 1e-3, "", "radii of the smaller sphere",
       "Overlap under the own weight in an enduring contact."}};
  static constexpr bedload::StyleHelp help{
      "normal model actm",
      "Adaptive collision time: each collision is stretched to T_c and rebounds with "
      "coefficientRestitution.",
      "pair_style gran model actm [tangential haff_werner|history|off] "
      "[rolling_friction cdt|epsd2|off] [keyword value ...]\n"
      "fix ID group wall/gran model actm [tangential ...] primitive|mesh ... [keyword value ...]",
      keywords};

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
  }

  void registerSettings(Settings& settings) override {
    bedload::read_setting(settings, keywords[0], collision_steps_);
    bedload::read_setting(settings, keywords[1], critical_stokes_);
    bedload::read_setting(settings, keywords[2], resting_overlap_);
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
    fluid_step_ = bedload::require_fluid_time_step(lmp, "normal model actm");
    viscosity_ = bedload::find_viscosity(lmp);
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
    const bool advancing = s.computeflag && s.shearupdate;
    const auto now = static_cast<double>(update->ntimestep);

    // Where the integrator asks again for the forces of a step that was made (start of a run,
    // output), it gets what was applied; asked for them at a step not made, the contact is read
    // only.
    // Shipped tangential and rolling models scale with the normal stiffness: they get the secant
    // stiffness and the damping, the tangential ones by the usual 2/7.
    double force = 0;
    if (advancing) {
      force = advance(s, h, now);
    } else {
      if (h.step == now && now > 0) force = h.force;
      s.kn = h.stiffness * std::sqrt(std::max(0.0, s.deltan - h.birth_overlap));
    }

    s.Fn = force;
    s.gamman = h.damping;
    s.kt = 2.0 / 7.0 * s.kn;
    s.gammat = 2.0 / 7.0 * s.gamman;

    const double scale = s.is_wall ? s.area_ratio : 1.0;
    for (int d = 0; d < 3; ++d) i_forces.delta_F[d] += scale * force * s.en[d];
    if (s.is_wall) return;
    for (int d = 0; d < 3; ++d) j_forces.delta_F[d] -= force * s.en[d];
  }

  void surfacesClose(SurfacesCloseData&, ForceData&, ForceData&) override {}

 private:
  struct History {
    double stiffness, damping, birth_overlap, speed, force, step, settling, lost;
  };

  /// One step of a contact: birth if there is none, force, memory of both. Sets s.kn.
  [[gnu::always_inline]] double advance(SurfacesIntersectData& s, History& h, double now) {
    const double approach = -s.vn;
    const bool alive = h.stiffness > 0 && h.step == now - 1 && s.deltan > h.birth_overlap;
    h.force = s.kn = 0;
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
      h.settling = now;
      h.lost = 0;
    } else if (h.settling >= 0 && update->ntimestep % settling_stride == 0) {
      settle(s, mass, now, h);
    }
    const bedload::contact::ActmStep done = bedload::contact::actm_step(
        {h.stiffness, h.damping}, s.deltan - h.birth_overlap, approach, mass, update->dt, !alive);
    if (h.settling >= 0) {
      const double middle = approach - 0.5 * done.force * update->dt / mass;
      h.lost += h.damping * middle * middle * update->dt;
    }
    s.kn = done.secant_stiffness;
    if (done.last) h.stiffness = 0;
    h.force = done.force;
    h.step = now;
    return h.force;
  }

  /// k and d of a contact that begins with (or is hit at) the speed u.
  void calibrate(const SurfacesIntersectData& s, double mass, double u, History& h) {
    if (!gravity_known_) {  // not yet at connectToProperties: fixes are initialised after the pair
      gravity_ = bedload::find_gravity(lmp);
      fluid_density_ = bedload::find_fluid_density(lmp);
      gravity_known_ = true;
    }
    const double collision_time = collision_steps_ * fluid_step_.get();
    if (!(collision_time > 0)) {
      error->one(FLERR, "normal model actm: the coupling has not set a fluid time step above 0");
    }
    const Partner heavier = heavier_partner(s);
    const double g = submerged_gravity(heavier);

    // Enduring contact: impact speed below St_crit, or so low that weight turns the sphere round
    // within one collision time.
    double critical = 0.5 * g * collision_time;
    if (viscosity_.known()) {
      critical = std::max(critical,
                          bedload::contact::speed_at_stokes(critical_stokes_, viscosity_.get(),
                                                            2 * heavier.density * heavier.radius));
    }
    h.speed = std::max(u, critical);
    set(h, bedload::contact::actm_coefficients(mass, h.speed, collision_time, calibration(s)));
    if (u < critical) stiffen(s, mass, bearing_stiffness(s), h);
  }

  /// A contact that is still there after twice the collision time is no collision: other forces
  /// hold it. It becomes stiff enough to bear the weight, by no more than an e-fold per collision
  /// time, and pays the elastic energy for that from what its damping has taken, so that no energy
  /// is made.
  void settle(const SurfacesIntersectData& s, double mass, double now, History& h) {
    const double collision_time = collision_steps_ * fluid_step_.get();
    if ((now - h.settling) * update->dt < 2 * collision_time) return;
    const double target = bearing_stiffness(s);
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

  static void set(History& h, const bedload::contact::ActmCoefficients& c) {
    h.stiffness = c.stiffness;
    h.damping = c.damping;
  }

  /// k that lets the submerged weight of the heavier partner press in by restingOverlap times the
  /// smaller radius, or by as much as the step resolves: the frequency sqrt(1.5 g/δ) of a sphere
  /// that rests at δ is kept below 0.3/Δt. 0 without gravity.
  double bearing_stiffness(const SurfacesIntersectData& s) const {
    const Partner heavier = heavier_partner(s);
    const double g = submerged_gravity(heavier);
    if (g == 0) return 0;
    const double resolved = 1.5 * g * update->dt * update->dt / (0.3 * 0.3);
    const double smaller = s.is_wall ? s.radi : std::min(s.radi, s.radj);
    return bedload::contact::stiffness_bearing(heavier.mass * g,
                                               std::max(resting_overlap_ * smaller, resolved));
  }

  const bedload::contact::ActmCalibration& calibration(const SurfacesIntersectData& s) const {
    return calibrations_[(s.itype - 1) * restitution_.types() + s.jtype - 1];
  }

  struct Partner {
    double mass, radius, density;
  };

  double submerged_gravity(const Partner& p) const {
    return gravity_ * std::abs(1 - fluid_density_ / p.density);
  }

  Partner heavier_partner(const SurfacesIntersectData& s) const {
    const bool first = s.is_wall || mobility_.held(atom->mask[s.j]) ||
                       (!mobility_.held(atom->mask[s.i]) && s.mi >= s.mj);
    const double mass = first ? s.mi : s.mj;
    const double radius = first ? s.radi : s.radj;
    return {mass, radius, mass / (4.0 / 3.0 * std::numbers::pi * radius * radius * radius)};
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

  int first_ = 0;
  double collision_steps_ = 10, critical_stokes_ = 5, resting_overlap_ = 1e-3;
  bedload::PairTable restitution_;
  std::vector<bedload::contact::ActmCalibration> calibrations_;
  bedload::FluidValue fluid_step_, viscosity_;
  bedload::Mobility mobility_;
  bool gravity_known_ = false;
  double gravity_ = 0, fluid_density_ = 0;
};

}  // namespace LIGGGHTS::ContactModels
