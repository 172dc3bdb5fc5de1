#include "coupling/bedload_dem/scene_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "atom.h"
#include "comm.h"
#include "coupling/bedload_dem/motion_rules.hpp"
#include "coupling/bedload_dem/over_ranks.hpp"
#include "coupling/bedload_dem/scene_description.hpp"
#include "coupling/exchange/dem_side.hpp"
#include "coupling/exchange/handshake.hpp"
#include "coupling/exchange/stages.hpp"
#include "coupling/job/roles.hpp"
#include "fix.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/model_scale.hpp"
#include "modify.h"
#include "update.h"

namespace bedload {
namespace {

constexpr const char* name = "fix couple/fluid";

bool has_speed(const LAMMPS_NS::Atom& atom, int i) {
  return Vec3(atom.v[i]).norm() > 0.0 || Vec3(atom.omega[i]).norm() > 0.0;
}

/// Groups that a fix freeze holds.
int frozen_groups(const LAMMPS_NS::Modify& modify) {
  int groups = 0;
  for (int n = 0; n < modify.nfix; ++n)
    if (std::string_view(modify.fix[n]->style) == "freeze") groups |= modify.fix[n]->groupbit;
  return groups;
}

}  // namespace

// LIGGGHTS itself looks for the box of such a position for ever.
void SceneChecks::check_finite() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const auto is_flawed = [&](int i) {
    const auto bad = [](double number) { return !std::isfinite(number); };
    const auto any_bad = [&](const double* vector) { return std::any_of(vector, vector + 3, bad); };
    return spheres_.contains(atom.mask[i]) &&
           (any_bad(atom.x[i]) || any_bad(atom.v[i]) || any_bad(atom.omega[i]) ||
            bad(atom.radius[i]) || bad(atom.density[i]));
  };
  if (const auto tag = lowest_tag(*lmp_, is_flawed))
    stop_run(lmp_, fmt::format("fix couple/fluid: atom {} has a position, velocity, diameter or "
                               "density that is no finite number; look at the variables and files "
                               "that the script makes it from",
                               *tag));
}

void SceneChecks::check_scene(std::string_view since, Moment moment) const {
  if (!side_->introduced()) return;
  if (const auto sentence =
          disagreement(side_->scene_info(), describe_scene(lmp_, spheres_, moment)))
    stop_run(lmp_, fmt::format("fix couple/fluid: {}, {}", since, *sentence));
}

void SceneChecks::warn_once(std::string_view what, std::string_view sentence) {
  if (warned_.insert(what).second) warn(lmp_, name, sentence);
}

void SceneChecks::check_integrated() {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const Mobility mobility(lmp_);
  const auto left_alone = [&](int i) {
    return spheres_.is_mobile(atom.mask[i]) && mobility.left_alone(atom.mask[i]);
  };
  const auto moving = lowest_tag(*lmp_, [&](int i) { return left_alone(i) && has_speed(atom, i); });
  if (moving)
    stop_run(lmp_, fmt::format("fix couple/fluid: atom {} is mobile and has a speed, but no fix "
                               "moves it; put it in the group of a 'fix nve/sphere', set its "
                               "velocity to 0, or take it into the group behind 'fixed', where its "
                               "surface goes with that speed for ever",
                               *moving));
  const auto driving = lowest_tag(
      *lmp_, [&](int i) { return spheres_.is_fixed(atom.mask[i]) && has_speed(atom, i); });
  if (driving)
    warn_once(
        "fixed with a speed",
        fmt::format("atom {} (and others perhaps) is fixed and has a speed: it stays in its place, "
                    "and its surface goes with that speed and drives the fluid, as a roller does; "
                    "for a sphere at rest set velocity and omega to 0",
                    *driving));
  if (const auto still = lowest_tag(*lmp_, left_alone))
    warn_once(
        "moved by nothing",
        fmt::format("atom {} (and others perhaps) is mobile, but no fix moves it, so that it stays "
                    "where it is; put it in the group of a 'fix nve/sphere'",
                    *still));
}

void SceneChecks::check_moved_once() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const LAMMPS_NS::Modify& modify = *lmp_->modify;
  const auto moves = [](const LAMMPS_NS::Fix& fix) {
    return fix.time_integrate != 0 && std::string_view(fix.style) != "nve/noforce";
  };
  for (int n = 0; n < modify.nfix; ++n)
    for (int m = n + 1; m < modify.nfix; ++m) {
      const LAMMPS_NS::Fix &one = *modify.fix[n], &other = *modify.fix[m];
      if (!moves(one) || !moves(other)) continue;
      const auto twice = lowest_tag(*lmp_, [&](int i) {
        const int mask = atom.mask[i];
        return spheres_.is_mobile(mask) && (mask & one.groupbit) != 0 &&
               (mask & other.groupbit) != 0;
      });
      if (twice)
        stop_run(lmp_,
                 fmt::format("fix couple/fluid: atom {} is moved by two fixes, {} (id {}) and "
                             "{} (id {}), and would go twice as far; take it out of the group "
                             "of one of them",
                             *twice, one.style, one.id, other.style, other.id));
    }
}

void SceneChecks::warn_of_group() {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const int frozen = frozen_groups(*lmp_->modify);
  if (const auto outside =
          lowest_tag(*lmp_, [&](int i) { return !spheres_.contains(atom.mask[i]); }))
    warn_once(
        "outside the fluid",
        fmt::format("atom {} (and others perhaps) is not in its group: it meets other spheres, but "
                    "the fluid goes through it and does not move it; write 'fix ID all "
                    "couple/fluid' for all of them",
                    *outside));
  const auto has_freeze = [&](int i) {
    return spheres_.is_mobile(atom.mask[i]) && (atom.mask[i] & frozen) != 0;
  };
  const Mobility mobility(lmp_);
  if (const auto going = lowest_tag(*lmp_, [&](int i) {
        return has_freeze(i) && mobility.integrated(atom.mask[i]) && has_speed(atom, i);
      }))
    warn_once(
        "frozen with a speed",
        fmt::format("atom {} (and others perhaps) has a speed and a fix freeze, which takes forces "
                    "away and no speed: it goes on at that; set velocity and omega to 0",
                    *going));
  if (const auto held =
          lowest_tag(*lmp_, [&](int i) { return has_freeze(i) && !has_speed(atom, i); }))
    warn_once(
        "mobile and frozen",
        fmt::format("atom {} (and others perhaps) is mobile and held by a fix freeze: it counts as "
                    "a grain and costs as one; take it into the group behind 'fixed' where it "
                    "never moves",
                    *held));
}

void SceneChecks::check_order(int place) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const Mobility mobility(lmp_);
  for (int n = 0; n < place; ++n) {
    const LAMMPS_NS::Fix& fix = *lmp_->modify->fix[n];
    if (std::string_view(fix.style) != "freeze" && !projects_forces(fix.style)) continue;
    const auto let_go = lowest_tag(*lmp_, [&](int i) {
      const int mask = atom.mask[i];
      return spheres_.is_mobile(mask) && (mask & fix.groupbit) != 0 && mobility.integrated(mask);
    });
    if (let_go)
      stop_run(lmp_, fmt::format("fix couple/fluid: fix {} (id {}) stands before it and would not "
                                 "hold atom {} against the fluid's force; put it behind, or take "
                                 "the sphere into the group behind 'fixed'",
                                 fix.style, fix.id, *let_go));
  }
}

// In each step of LIGGGHTS for each sphere: words are made for one that breaks a rule only.
void SceneChecks::check_motion(double fluid_time_step, double deepest) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const MotionRules rules{box_of(*lmp_->domain), lmp_->update->dt, deepest};
  check_box_and_step(rules.box, fluid_time_step);
  for (int i = 0; i < atom.nlocal; ++i) {
    if (!spheres_.is_mobile(atom.mask[i])) continue;
    const Vec3 x(atom.x[i]), v(atom.v[i]);
    const double radius = atom.radius[i];
    const MotionFlaw flaw = flaw_of_motion(rules, x, v, Vec3(atom.omega[i]), radius);
    if (flaw == MotionFlaw::none) continue;
    end_job(
        Program::dem, lmp_->comm->me,
        fmt::format("fix couple/fluid: step {}: atom {} at ({:.6g}, {:.6g}, {:.6g}) with velocity "
                    "({:.3g}, {:.3g}, {:.3g}) {}.",
                    side_->steps_made() + 1, atom.tag[i], x[0], x[1], x[2], v[0], v[1], v[2],
                    describe_flaw(flaw, rules, x, radius)));
  }
}

// The fluid's grid stands still, and its loads are impulses of its own time step.
void SceneChecks::check_box_and_step(const Box& box, double fluid_time_step) const {
  if (!side_->introduced()) return;  // the hand-shake will compare them
  const double dt = DemSteps{side_->scene_info().dem_steps}.time_step(fluid_time_step);
  const double dt_now = lmp_->update->dt;
  std::string sentence;
  if (const auto other = box_disagreement(side_->scene_info(), describe_box(box)))
    sentence = fmt::format("{} No fix may change it during a coupled_run.", *other);
  else if (!(std::abs(dt_now - dt) <= 1e-12 * dt))
    sentence = fmt::format(
        "the time step of LIGGGHTS is {:.6g}, but fluid.toml (time.step, coupling.dem_steps) makes "
        "it {:.6g}; no fix (dt/reset, say) may change it during a coupled_run.",
        dt_now, dt);
  if (!sentence.empty())
    end_job(Program::dem, lmp_->comm->me,
            fmt::format("fix couple/fluid: step {}: {}", side_->steps_made() + 1, sentence));
}

// The fluid has made the spheres' buoyancy of it, once for all.
void SceneChecks::check_gravity_during_run() const {
  const GravityFixes now(lmp_);
  if (now == gravity_) return;
  constexpr int everybody = ~0;
  const Triple was = gravity_.on(everybody), is = now.on(everybody);
  end_job(
      Program::dem, lmp_->comm->me,
      fmt::format("fix couple/fluid: step {}: the script's gravity was ({:.6g}, {:.6g}, {:.6g}) "
                  "when the run began and is ({:.6g}, {:.6g}, {:.6g}) now, but the fluid "
                  "computes with one gravity; no variable behind 'fix gravity' may change it.",
                  side_->steps_made() + 1, was[0], was[1], was[2], is[0], is[1], is[2]));
}

void SceneChecks::check_tags(const std::function<double(int i)>& told_tag) const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const auto renumbered = lowest_tag(*lmp_, [&](int i) {
    return spheres_.is_mobile(atom.mask[i]) && told_tag(i) != 0.0 && told_tag(i) != atom.tag[i];
  });
  if (renumbered)
    stop_run(lmp_,
             fmt::format("fix couple/fluid: atom {} had another number in the coupled_run before, "
                         "and the fluid knows the spheres by their numbers; delete atoms with "
                         "'delete_atoms ... compress no'",
                         *renumbered));
}

// A fixed sphere that something moves would leave its markers behind.
void SceneChecks::check_fixed() const {
  check_prescribed();
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  const Mobility mobility(lmp_);
  const auto moving = lowest_tag(*lmp_, [&](int i) {
    return spheres_.is_fixed(atom.mask[i]) && !mobility.held(atom.mask[i]);
  });
  if (moving)
    stop_run(lmp_,
             fmt::format("fix couple/fluid: atom {} is in the group behind 'fixed' but is moved "
                         "by an integrating fix; freeze it ('fix ID GROUP freeze') or keep the "
                         "integrating fix to the other atoms",
                         *moving));
  if (side_->introduced() && spheres_.fingerprint_of_fixed() != told_fixed_)
    stop_run(lmp_,
             "fix couple/fluid: the spheres of the group behind 'fixed' are no more those of the "
             "coupled_run before (number, place, speed, size), and the fluid receives them once; "
             "leave them as they are between two coupled_runs (a delete_atoms gives all others new "
             "numbers unless it says 'compress no')");
}

// A fix move, or nve/noforce with a speed, moves spheres that a fix freeze has as well.
void SceneChecks::check_prescribed() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  for (int n = 0; n < lmp_->modify->nfix; ++n) {
    const LAMMPS_NS::Fix& fix = *lmp_->modify->fix[n];
    const std::string_view style(fix.style);
    const bool moves = style == "move", goes_on = style == "nve/noforce";
    if (!moves && !goes_on) continue;
    const auto moving = lowest_tag(*lmp_, [&](int i) {
      return spheres_.is_fixed(atom.mask[i]) && (atom.mask[i] & fix.groupbit) != 0 &&
             (moves || Vec3(atom.v[i]).norm() > 0.0);
    });
    if (moving)
      stop_run(lmp_, fmt::format("fix couple/fluid: fix {} (id {}) moves atom {}, which is in the "
                                 "group behind 'fixed', and the fluid receives those once; take it "
                                 "out of that group, so that it is mobile, or out of the fix's",
                                 fix.style, fix.id, *moving));
  }
}

void SceneChecks::check_fixed_during_run() const {
  if (spheres_.fingerprint_of_fixed() != told_fixed_)
    stop_run(lmp_,
             fmt::format("fix couple/fluid: step {}: the spheres of the group behind 'fixed' "
                         "have changed during this coupled_run (number, place, speed, size), "
                         "and the fluid receives them once; let the fix that changes them "
                         "(insert, adapt, say) do so in a 'run' before fix couple/fluid, or take "
                         "those spheres from its group",
                         side_->steps_made()));
}

}  // namespace bedload
