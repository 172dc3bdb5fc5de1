#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/haff_werner.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/lost_contacts.hpp"
#include "liggghts_styles/material_values.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/model_scale.hpp"

namespace LIGGGHTS::ContactModels {

inline constexpr int BEDLOAD_HAFF_WERNER = 20;

/// tangential model haff_werner. Formulas in formulas/haff_werner.hpp; user page
/// doc/tangential_haff_werner.md. Acts wherever the normal model does, also before touch (rpm).
///
/// The contact history holds the force of the last step (hw_fx, hw_fy, hw_fz on sphere i) and the
/// number of that step. The law has no memory; this is for a run that is split or restarted. With
/// the keyword stickAfter or stickTime also the step at which the contact began (hw_since) and the
/// spring of an enduring contact (hw_sx, hw_sy, hw_sz [m]).
template <>
class TangentialModel<BEDLOAD_HAFF_WERNER> : public TangentialModelBase {
 public:
  static constexpr bedload::NumberKeyword keywords[] = {
      {"tangentialDamping", 0, false, bedload::no_limit, 0, "from slipTime", "M/T",
       "Damping d_t of the slip."},
      {"slipTime", 0, true, bedload::no_limit, 0, "0: a fluid time step, less in viscous fluid",
       "T", "Time in which slip dies away, not less than four DEM steps."},
      {"stickAfter", 0, true, bedload::no_limit, 0, "0: never, the published law",
       "fluid time steps", "Age from which a contact bears tangential loads at rest."},
      {"stickTime", 0, true, bedload::no_limit, 0, "0: as stickAfter says", "T",
       "The same age as a time."}};
  static constexpr bedload::StyleHelp help{
      "tangential model haff_werner",
      "Friction that damps the slip and is cut at coefficientFriction times the normal force.",
      "pair_style gran model actm|rpm|hertz|hooke tangential haff_werner [keyword value ...]\n"
      "fix ID group wall/gran model ... tangential haff_werner primitive|mesh ... "
      "[keyword value ...]",
      keywords};

  TangentialModel(LAMMPS* lammps, IContactHistorySetup* hsetup, ContactModelBase* cmb)
      : TangentialModelBase(lammps, hsetup, cmb) {
    force_ = hsetup->add_history_value("hw_fx", "1");
    hsetup->add_history_value("hw_fy", "1");
    hsetup->add_history_value("hw_fz", "1");
    step_ = hsetup->add_history_value("hw_step", "0");
  }

  void registerSettings(Settings& settings) override {
    bedload::read_setting(settings, keywords[0], damping_setting_);
    bedload::read_setting(settings, keywords[1], slip_time_);
    bedload::read_setting(settings, keywords[2], stick_after_);
    bedload::read_setting(settings, keywords[3], stick_time_);
  }

  void postSettings(IContactHistorySetup* hsetup, ContactModelBase*) override {
    if (!sticks()) return;
    since_ = hsetup->add_history_value("hw_since", "0");
    hsetup->add_history_value("hw_sx", "1");
    hsetup->add_history_value("hw_sy", "1");
    hsetup->add_history_value("hw_sz", "1");
  }

  void connectToProperties(PropertyRegistry&) override {
    friction_ = bedload::read_pair_property(lmp, "tangential model haff_werner",
                                            "coefficientFriction", 0.0, 1e3);
    fluid_step_ =
        sticks() && stick_time_ == 0
            ? bedload::require_fluid_time_step(lmp, "tangential model haff_werner stickAfter")
            : bedload::FluidValue::find(lmp, "dt_fluid", "fluidTimeStep");
    if (damping_setting_ > 0 && slip_time_ > 0)
      bedload::stop_run(lmp,
                        "tangential model haff_werner: tangentialDamping and slipTime both say "
                        "how fast slip dies away; leave out one of them (slipTime 0)");
    if (damping_setting_ == 0 && (slip_time_ > 0 || fluid_step_.known())) {
      scale_ = {"tangential model haff_werner",
                slip_time_ > 0 ? "slip time" : "longest slip time",
                "slipTime",
                "time step",
                slip_time_,
                1};
      bedload::tell_scale(lmp, scale_, fluid_step_);
    }
    stick_age_ = {"tangential model haff_werner",
                  "age of a contact at rest",
                  "stickTime",
                  "time steps",
                  stick_time_,
                  stick_after_};
    if (sticks()) bedload::tell_scale(lmp, stick_age_, fluid_step_);
    viscosity_ = bedload::find_viscosity(lmp);
    kept_for_dt_ = 0;  // the script may have changed the viscosity since the run before
    bedload::refuse_neighbor_multi(lmp, "tangential model haff_werner");
    bedload::refuse_clumps(lmp, "tangential model haff_werner");
    mobility_ = bedload::Mobility(lmp);
  }

  void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}
  void endPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}

  void surfacesIntersect(const SurfacesIntersectData& s, ForceData& i_forces,
                         ForceData& j_forces) override {
    const double slip[3] = {s.vtr1, s.vtr2, s.vtr3};
    const double mass = mobility_.all_free() ? s.meff : effective_mass(s);
    act(s, s.en, slip, pressing_force(s, mass), s.kt, mass, s.cri, s.is_wall ? 0.0 : s.crj,
        i_forces, j_forces);
  }

  void surfacesClose(SurfacesCloseData& s, ForceData& i_forces, ForceData& j_forces) override {
    if (!s.has_force_update) return;  // the normal model does not act at this distance
    const double* f = i_forces.delta_F;
    const double normal_force = std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
    const double r = std::sqrt(s.rsq);
    const double half_gap = 0.5 * (r - s.radsum);
    const double n[3] = {s.delta[0] / r, s.delta[1] / r, s.delta[2] / r};
    const double arm_i = s.radi + half_gap;
    const double arm_j = s.is_wall ? 0.0 : s.radj + half_gap;

    // g_t = (v_i - v_j) - ((v_i - v_j).n) n + n x (a_i ω_i + a_j ω_j) ... with the arms a.
    const double* wi = atom->omega[s.i];
    const double* wj = s.is_wall ? nullptr : atom->omega[s.j];
    double v[3], w[3];
    double vn = 0;
    for (int d = 0; d < 3; ++d) {
      v[d] = s.v_i[d] - s.v_j[d];
      w[d] = arm_i * wi[d] + (wj ? arm_j * wj[d] : 0.0);
      vn += v[d] * n[d];
    }
    const double slip[3] = {v[0] - vn * n[0] + n[1] * w[2] - n[2] * w[1],
                            v[1] - vn * n[1] + n[2] * w[0] - n[0] * w[2],
                            v[2] - vn * n[2] + n[0] * w[1] - n[1] * w[0]};
    act(s, n, slip, normal_force, 0.0, effective_mass(s), arm_i, arm_j, i_forces, j_forces);
  }

 private:
  /// The normal force that friction rests on [N]: the spring's, kn δ. Over a collision the damping
  /// has no impulse, ∫ d (dδ/dt) dt = 0, so that friction of a contact that slides gets μ times the
  /// normal impulse. With μ |F_n| it would rub at the end, too, where the damping pulls. At rest
  /// F_n is the load and the spring's force d Δt/(2 m) more, since damping acts in the middle of
  /// the kick (formulas/actm.hpp).
  double pressing_force(const SurfacesIntersectData& s, double mass) const {
    if (s.gamman == 0) return std::abs(s.Fn);  // nothing but a spring, as rpm
    if (s.Fn == 0) return 0;                   // where a model has cut off the pull
    const double spring = s.kn * s.deltan;
    const bool at_rest = std::abs(s.Fn - spring) * mass <= s.gamman * update->dt * spring;
    return at_rest ? s.Fn : spring;
  }

  /// Reduced mass, with held partners and walls infinitely heavy; 0 if nothing can move [kg].
  double effective_mass(const SurfacesCloseData& s) const {
    const double inverse = mobility_.inverse_mass(*atom, s.i, s.is_wall ? -1 : s.j);
    return inverse > 0 ? 1 / inverse : 0.0;
  }

  [[gnu::always_inline]] void act(const SurfacesCloseData& s, const double* n, const double* slip,
                                  double normal_force, double stiffness, double mass, double arm_i,
                                  double arm_j, ForceData& i_forces, ForceData& j_forces) {
    if (s.contact_flags) *s.contact_flags |= CONTACT_TANGENTIAL_MODEL;
    double* memory = s.contact_history + force_;
    double& step = s.contact_history[step_];
    const auto now = static_cast<double>(update->ntimestep);

    double f[3] = {0, 0, 0};
    if (s.computeflag && (s.shearupdate || bedload::one_step_late(lmp, step))) {
      const double damping = force_per_slip(s, slip, normal_force, mass);
      for (int d = 0; d < 3; ++d) f[d] = -damping * slip[d];
      if (sticks()) stick(s, n, slip, stiffness, normal_force, f);
      std::copy_n(f, 3, memory);
      step = now;
    } else if (step == now && now > 0) {
      std::copy_n(memory, 3, f);  // the step was made: what was applied
    }

    // The torques -arm n x F have the same sense on both partners; the arms add up to the distance
    // of the centres, so that no angular momentum is made.
    const double torque[3] = {n[1] * f[2] - n[2] * f[1], n[2] * f[0] - n[0] * f[2],
                              n[0] * f[1] - n[1] * f[0]};
    for (int d = 0; d < 3; ++d) {
      i_forces.delta_F[d] += f[d];
      i_forces.delta_torque[d] -= arm_i * torque[d];
    }
    if (s.is_wall) return;
    for (int d = 0; d < 3; ++d) {
      j_forces.delta_F[d] -= f[d];
      j_forces.delta_torque[d] -= arm_j * torque[d];
    }
  }

  bool sticks() const { return stick_after_ > 0 || stick_time_ > 0; }

  /// stickAfter and stickTime: age of the contact, and once it endures a spring beside the damping
  /// that already is in f. Without a stiffness (rpm before touch) there is none.
  void stick(const SurfacesCloseData& s, const double* n, const double* slip, double stiffness,
             double normal_force, double* f) const {
    double& since = s.contact_history[since_];
    double* spring = s.contact_history + since_ + 1;
    const auto now = static_cast<double>(update->ntimestep);
    if (s.contact_history[step_] != now - 1) {  // a new contact
      since = now;
      std::fill_n(spring, 3, 0.0);
    }
    const double dt = update->dt;
    if (stiffness == 0 || (now - since) * dt < stick_age_.value(fluid_step_)) return;
    for (int d = 0; d < 3; ++d) spring[d] += slip[d] * dt;
    const double along = spring[0] * n[0] + spring[1] * n[1] + spring[2] * n[2];
    for (int d = 0; d < 3; ++d) {
      spring[d] -= along * n[d];  // the plane of contact has turned
      f[d] -= stiffness * spring[d];
    }
    const double cut = bedload::contact::coulomb_cut(f[0] * f[0] + f[1] * f[1] + f[2] * f[2],
                                                     friction_(s.itype, s.jtype) * normal_force);
    if (cut == 1) return;
    for (int d = 0; d < 3; ++d) {
      f[d] *= cut;
      spring[d] = -f[d] / stiffness;
    }
  }

  /// -F_t/g_t of this step [kg/s].
  [[gnu::always_inline]] double force_per_slip(const SurfacesCloseData& s, const double* slip,
                                               double normal_force, double mass) {
    if (mass == 0) return 0;  // neither can move
    const double felt = bedload::contact::tangential_mass(mass);
    const double damping = damping_setting_ > 0 ? bedload::contact::haff_werner_step_damping(
                                                      damping_setting_, felt, update->dt)
                                                : relaxing_damping(s, felt);
    return bedload::contact::haff_werner_force_per_slip(
        damping, slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2],
        friction_(s.itype, s.jtype) * normal_force);
  }

  /// d_t from the time T in which slip dies away: slipTime; without it a fluid step, or less where
  /// viscosity drives the slip faster. Not less than four DEM steps, which is stable for a sphere
  /// that touches twelve others.
  [[gnu::always_inline]] double relaxing_damping(const SurfacesCloseData& s, double felt) {
    const double fluid_step = fluid_step_.known() ? fluid_step_.get() : 0.0;
    if (update->dt != kept_for_dt_ || fluid_step != kept_for_fluid_step_) keep(fluid_step);
    // Σ 1/R >= 1/(R_p + R_q) tells most contacts apart from viscous ones without a division.
    const double distance = s.radi + (s.is_wall ? 0.0 : s.radj);
    if (felt >= inertial_from_ * distance) return felt * kept_damping_;
    return viscous_damping(s, felt);
  }

  /// What the contacts of a step have in common: M_t/(T + Δt) of unit mass, and the M_t Σ 1/R from
  /// which viscosity neither shortens T nor is worth a warning.
  void keep(double fluid_step) {
    const double dt = kept_for_dt_ = update->dt;
    kept_for_fluid_step_ = fluid_step;
    relaxation_ = slip_time_ > 0 ? slip_time_ : fluid_step;
    const double longest = std::max(relaxation_, 4 * dt);
    kept_damping_ = bedload::contact::haff_werner_relaxing_damping(longest, 1.0, dt);
    if (!viscosity_.known()) return;
    const double of_unit = bedload::contact::viscous_slip_resistance(viscosity_.get(), 1.0);
    inertial_from_ =
        std::max(relaxation_ / bedload::contact::haff_werner_viscous_relaxation(1.0, of_unit),
                 weak_ * of_unit * (longest + dt));
  }

  double viscous_damping(const SurfacesCloseData& s, double felt) {
    const double dt = update->dt;
    const double resistance =
        bedload::contact::viscous_slip_resistance(viscosity_.get(), inverse_radii(s));
    double relaxation = relaxation_;
    if (slip_time_ == 0)
      relaxation =
          std::min(relaxation, bedload::contact::haff_werner_viscous_relaxation(felt, resistance));
    const double damping =
        bedload::contact::haff_werner_relaxing_damping(std::max(relaxation, 4 * dt), felt, dt);
    if (!told_ && weak_ * resistance > damping) tell_weak(felt, resistance, damping);
    return damping;
  }

  /// Σ 1/R over the partners that can move [1/m]; one at least can.
  double inverse_radii(const SurfacesCloseData& s) const {
    double sum = mobility_.held(atom->mask[s.i]) ? 0.0 : 1 / s.radi;
    if (!s.is_wall && !mobility_.held(atom->mask[s.j])) sum += 1 / s.radj;
    return sum;
  }

  /// Says once that more than a fifth of a slip that viscosity drives is left, and what would help.
  void tell_weak(double felt, double resistance, double damping) {
    told_ = true;
    const double wanted = bedload::contact::haff_werner_viscous_relaxation(felt, resistance);
    std::string remedy;
    if (slip_time_ > wanted) remedy = fmt::format("a slipTime of {:.3g} (or 0)", wanted);
    if (4 * update->dt > wanted)
      remedy += fmt::format("{}DEM steps of {:.3g} (coupling.dem_steps)",
                            remedy.empty() ? "" : " and ", wanted / 4);
    bedload::warn_of_own(lmp, "tangential model haff_werner",
                         fmt::format("friction is slow to stop what the fluid's viscosity drives: "
                                     "{:.0f} % of such a slip is "
                                     "left at a contact; {} would leave {:.0f} %",
                                     100 * resistance / (resistance + damping), remedy,
                                     100 * bedload::contact::slip_left_to_viscosity));
  }

  int force_ = 0, step_ = 0;
  int since_ = 0;
  double damping_setting_ = 0, slip_time_ = 0, stick_after_ = 0, stick_time_ = 0;
  bedload::ModelScale scale_{}, stick_age_{};
  // d_t/ζ below which more than a fifth of the slip is left.
  static constexpr double weak_ = 4;
  double kept_for_dt_ = 0, kept_for_fluid_step_ = 0, relaxation_ = 0;
  double kept_damping_ = 0, inertial_from_ = 0;
  bool told_ = false;
  bedload::PairTable friction_;
  bedload::FluidValue fluid_step_, viscosity_;
  bedload::Mobility mobility_;
};

}  // namespace LIGGGHTS::ContactModels
