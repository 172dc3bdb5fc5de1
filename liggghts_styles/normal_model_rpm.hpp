#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/rpm.hpp"
#include "liggghts_styles/gravity_fixes.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/lost_contacts.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/model_scale.hpp"
#include "liggghts_styles/wall_reach.hpp"

namespace LIGGGHTS::ContactModels {

inline constexpr int BEDLOAD_RPM = 21;

/// normal model rpm: the repulsive potential model, which acts before the surfaces touch. Formulas
/// in formulas/rpm.hpp; user page doc/normal_rpm.md.
template <>
class NormalModel<BEDLOAD_RPM> : public NormalModelBase {
 public:
  static constexpr double not_given = -1;
  static constexpr bedload::NumberKeyword keywords[] = {
      {"range", 0, true, bedload::no_limit, 0,
       "0: 2 h, from fix couple/fluid or the property fluidCellSize", "L",
       "Gap S at which the repulsion begins."},
      {"strength", 0, false, bedload::no_limit, 0,
       "such that a collision at sqrt(g D) between equal spheres lasts collisionTime", "-",
       "Repulsion at the touch in weights of the sphere."},
      {"collisionTime", 0, true, bedload::no_limit, 0, "0: collisionSteps", "T",
       "Duration of a collision that the default of strength aims at, the same on any grid."},
      {"collisionSteps", 0, false, bedload::no_limit, not_given, "5 without collisionTime",
       "fluid time steps", "The same duration where it follows the grid."}};
  static constexpr bedload::StyleHelp help{
      "normal model rpm",
      "Repulsive potential: surfaces are pushed apart before they touch, without loss of energy.",
      "pair_style gran model rpm [tangential haff_werner|off] [keyword value ...]\n"
      "fix ID group wall/gran model rpm [tangential haff_werner|off] primitive|mesh ... "
      "[keyword value ...]",
      keywords};

  NormalModel(LAMMPS* lammps, IContactHistorySetup* hsetup, ContactModelBase* cmb)
      : NormalModelBase(lammps, hsetup, cmb) {}

  void registerSettings(Settings& settings) override {
    bedload::read_setting(settings, keywords[0], range_setting_);
    bedload::read_setting(settings, keywords[1], strength_setting_);
    bedload::read_setting(settings, keywords[2], time_setting_);
    bedload::read_setting(settings, keywords[3], steps_setting_);
  }

  void postSettings(IContactHistorySetup*, ContactModelBase*) override {}

  void connectToProperties(PropertyRegistry& registry) override {
    bedload::refuse_neighbor_multi(lmp, style);
    bedload::refuse_clumps(lmp, style);
    mobility_ = bedload::Mobility(lmp);
    if (modify->find_fix_style_strict("gravity", 0) == nullptr) {
      bedload::stop_run(lmp,
                        "normal model rpm measures its force in weights and needs a fix gravity");
    }
    const bedload::FluidValue h = bedload::FluidValue::find(lmp, "cell_size", "fluidCellSize");
    if (range_setting_ == 0) {
      if (!h.known()) {
        bedload::stop_run(
            lmp,
            "normal model rpm needs its range: write the keyword 'range <m>' behind the "
            "model, or add a fix couple/fluid, whose grid spacing gives it");
      }
    }
    const bedload::ModelScale scale{style, "range", "range", "cells", range_setting_, 2};
    range_ = scale.value(h);
    bedload::tell_scale(lmp, scale, h);
    if (h.live() && range_ < h.get()) warn_of_cells(h.get());
    settle_duration();
    largest_radius_ = registry.max_radius();
    bedload::reach_out(lmp, "normal model rpm", range_);
    phase_ = Phase::unknown;
  }

  double stressStrainExponent() override { return 2.0; }

  void beginPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}
  void endPass(SurfacesIntersectData&, ForceData&, ForceData&) override {}

  void surfacesIntersect(SurfacesIntersectData& s, ForceData& i_forces,
                         ForceData& j_forces) override {
    if (s.contact_flags) *s.contact_flags |= CONTACT_NORMAL_MODEL;
    const double force = repel(s, -s.deltan, s.en, i_forces, j_forces);
    s.Fn = force;
    s.kn = 2 * force / (range_ + s.deltan);
    s.kt = 2.0 / 7.0 * s.kn;
    s.gamman = s.gammat = 0;
  }

  void surfacesClose(SurfacesCloseData& s, ForceData& i_forces, ForceData& j_forces) override {
    const double r = std::sqrt(s.rsq);
    const double gap = r - s.radsum;
    if (gap >= range_) return;
    const double en[3] = {s.delta[0] / r, s.delta[1] / r, s.delta[2] / r};
    if (repel(s, gap, en, i_forces, j_forces) > 0) s.has_force_update = true;
  }

 private:
  double repel(const SurfacesCloseData& s, double gap, const double* en, ForceData& i_forces,
               ForceData& j_forces) {
    if (phase_ != Phase::running) begin(s, gap);
    const double force = bedload::contact::rpm_force(gap, range_, strength_, mass(s) * gravity_);
    for (int d = 0; d < 3; ++d) {
      i_forces.delta_F[d] += force * en[d];
      if (!s.is_wall) j_forces.delta_F[d] -= force * en[d];
    }
    return force;
  }

  /// The mass m_p of the formula: twice the reduced mass of two spheres (m_p for equal ones), the
  /// mobile one's mass against a wall or a held sphere.
  double mass(const SurfacesCloseData& s) const {
    const double wi = mobility_.inverse_mass(*atom, s.i);
    const double wj = s.is_wall ? 0.0 : mobility_.inverse_mass(*atom, s.j);
    if (wi + wj == 0) return 0;
    return (wi > 0 && wj > 0 ? 2.0 : 1.0) / (wi + wj);
  }

  /// The first forces: settles what is not known before, and in the first step of all notes who
  /// starts where the repulsion acts.
  void begin(const SurfacesCloseData& s, double gap) {
    if (phase_ == Phase::unknown) {
      settle_strength();
      phase_ = Phase::starting;
    }
    if (update->ntimestep == 0) {
      note_start(s, gap);
    } else {
      if (thrown_.speed > 0) warn_of_start();
      phase_ = Phase::running;
    }
  }

  /// Gravity is known only after the fixes have been initialised, thus at the first force.
  /// Default strength: two equal spheres that meet at sqrt(g D) part after collisionSteps fluid
  /// steps.
  void settle_strength() {
    gravity_ = bedload::GravityFixes(lmp).largest();
    if (!(gravity_ > 0))
      error->one(FLERR, "normal model rpm measures its force in weights, and fix gravity has none");
    strength_ = strength_setting_;
    if (strength_ == 0) {
      const double collision_time = duration_.value(fluid_step_);
      bedload::require_resolved(lmp, style, collision_time);
      strength_ =
          bedload::contact::rpm_strength(usual_speed(), collision_time, range_, gravity_, 0.5);
    } else {
      warn_of_strength();
    }
  }

  double usual_speed() const { return std::sqrt(2 * gravity_ * largest_radius_); }

  /// Of a strength that is given nothing else says how long collisions last.
  void warn_of_strength() const {
    const double time =
        bedload::contact::rpm_duration(usual_speed(), strength_, range_, gravity_, 0.5);
    if (bedload::is_resolved(*lmp, time)) return;
    bedload::warn_of_own(
        lmp, style,
        fmt::format("with the strength {:.4g} a collision at sqrt(g D) lasts {:.3g} of LIGGGHTS' "
                    "steps, a faster one less, and below three spheres gain energy; take a smaller "
                    "strength or more DEM steps to a fluid step",
                    strength_, time / update->dt));
  }

  static constexpr const char* style = "normal model rpm";

  /// A grain that is put where the repulsion acts is thrown off, and the faster the stiffer the
  /// model is: with shorter steps, where its strength follows them.
  void note_start(const SurfacesCloseData& s, double gap) {
    if (mass(s) == 0) return;
    if (!s.is_wall && atom->tag[s.i] == atom->tag[s.j]) return;  // its own image pushes back evenly
    const bool i_moves = mobility_.inverse_mass(*atom, s.i) > 0;
    const bool j_moves = !s.is_wall && mobility_.inverse_mass(*atom, s.j) > 0;
    const double speed = bedload::contact::rpm_parting_speed(gap, range_, strength_, gravity_,
                                                             i_moves && j_moves ? 0.5 : 1.0);
    // A grain that rests on the repulsion leaves more slowly: E = m g S depth/3 there.
    if (speed > std::sqrt(2 * gravity_ * largest_radius_) && speed > thrown_.speed)
      thrown_ = {speed, range_ - gap, atom->tag[i_moves ? s.i : s.j]};
  }

  void warn_of_start() {
    bedload::warn_of_own(
        lmp, style,
        fmt::format("sphere {} stands {:.3g} inside the range of the repulsion ({:.3g}) at the "
                    "start and is thrown off at {:.3g} or more; start it farther off",
                    thrown_.tag, thrown_.depth, range_, thrown_.speed));
    thrown_ = {};
  }

  /// Duration that the default of strength aims at.
  void settle_duration() {
    if (time_setting_ > 0 && steps_setting_ != not_given)
      bedload::stop_run(lmp,
                        "normal model rpm: collisionTime and collisionSteps both say how long "
                        "a collision lasts; leave out one of them (collisionTime 0)");
    if (strength_setting_ != 0) {
      if (time_setting_ > 0 || steps_setting_ != not_given)
        bedload::warn(lmp, style,
                      "with a strength, collisionTime and collisionSteps have no effect");
      return;
    }
    fluid_step_ = bedload::require_fluid_time_step(lmp, style);
    const double steps = steps_setting_ == not_given ? 5 : steps_setting_;
    duration_ = {style, "collision time", "collisionTime", "time steps", time_setting_, steps};
    bedload::tell_scale(lmp, duration_, fluid_step_);
    bedload::warn_of_unresolved(lmp, style, duration_.value(fluid_step_));
  }

  void warn_of_cells(double h) const {
    bedload::warn(
        lmp, style,
        fmt::format("the range {:.4g} is shorter than a cell of the fluid ({:.4g}), which "
                    "does not resolve the flow in that gap",
                    range_, h));
  }

  double range_setting_ = 0, strength_setting_ = 0;
  double time_setting_ = 0, steps_setting_ = not_given;
  bedload::ModelScale duration_{};
  double range_ = 0, strength_ = 0, gravity_ = 0, largest_radius_ = 0;
  bedload::FluidValue fluid_step_;
  bedload::Mobility mobility_;
  struct Thrown {
    double speed, depth;
    int tag;
  };
  Thrown thrown_{};  ///< the fastest one that starts where the repulsion acts
  enum class Phase { unknown, starting, running } phase_ = Phase::unknown;
};

}  // namespace LIGGGHTS::ContactModels
