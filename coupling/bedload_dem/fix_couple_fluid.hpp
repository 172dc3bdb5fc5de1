#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "coupling/bedload_dem/coupled_spheres.hpp"
#include "coupling/bedload_dem/scene_checks.hpp"
#include "coupling/checkpoint/script_atoms.hpp"
#include "coupling/exchange/dem_side.hpp"
#include "fix.h"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/impulse_on_walls.hpp"
#include "liggghts_styles/keywords.hpp"

namespace LAMMPS_NS {
class FixPropertyAtom;
}

namespace bedload {

class FixMarkerFilm;

/// fix ID group couple/fluid [fixed GROUP]
///
/// The spheres of `group` are in the fluid. Those that are in the group behind `fixed` as well
/// never move: the fluid receives them once. The others carry the force and torque that the fluid
/// sends, constant over one Runge-Kutta stage; they are kept per atom, migrate with it, and are
/// added after the contact forces of each step. The command coupled_run drives it.
///
/// Global vector: sum of force and torque on the mobile spheres, f_ID[1..6] its mean over the last
/// whole fluid step, f_ID[7..12] of the present stage. Per-atom values, of the present stage:
/// f_couple_force[1..3], f_couple_torque[1..3].
class FixCoupleFluid : public LAMMPS_NS::Fix {
 public:
  static constexpr WordKeyword words[] = {
      {"fixed", "none: all are mobile",
       "Group of the spheres that never move; the fluid receives them once."}};
  static constexpr StyleHelp help{"fix couple/fluid",
                                  "Puts the spheres of the group into the fluid of bedload-fluid.",
                                  "fix ID group couple/fluid [fixed GROUP]",
                                  {},
                                  words};

  FixCoupleFluid(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg);

  void post_create() override;
  void pre_delete(bool unfixflag) override;
  int setmask() override;
  void init() override;
  void setup(int vflag) override;
  void post_integrate() override;
  void pre_neighbor() override;
  void post_force(int vflag) override;
  double compute_vector(int n) override;
  void write_restart(std::FILE* file) override;
  void restart(char* buffer) override;

  /// For contact models: pointers to doubles that stay valid as long as the fix lives. "dt_fluid"
  /// [T], "viscosity" (dynamic) [M/(L T)], "fluid_density" [M/L^3], "cell_size" [L],
  /// "forcing_loops"; "impulse_on_walls", which takes what walls get; "goes_on": not null where the
  /// run goes on from a checkpoint.
  void* extract(const char* name, int& dim) override;

  // What coupled_run calls. Collective.

  /// Tells the fluid about the scene, the first time only.
  void shake_hands();
  double fluid_time_step() const { return dt_fluid_; }
  /// Holds the fluid's time step: LIGGGHTS' own becomes its part, everywhere.
  void set_time_step(double fluid_time_step);
  /// Waits for the next stage's loads, or for another order of the fluid. `first`: atoms may have
  /// changed rank since the last motion was sent.
  Order receive_loads(bool first);
  /// Sends the motion to the fluid. `changes_follow`: the script may change spheres now, and the
  /// motion is to be sent again when it has.
  void send_motion(bool changes_follow = false);
  /// Sends it again at the begin of the next coupled run, where that was announced.
  void renew_motion();

  DemSide& side() { return *side_; }
  /// Stores the forces of the step just made with the spheres, to go into a checkpoint.
  void keep_forces();
  /// Sets them again, after LIGGGHTS has computed others while it was set up.
  void put_back_forces();

  const LoadHeader& stage() const { return stage_.header; }
  /// Ends LIGGGHTS or the job with a sentence where lines of the script before a coupled run have
  /// made what the fluid cannot go on with (SceneChecks). Collective.
  void check_before_run();
  /// What a fix has inserted during a run meets the rules of what was there at its begin.
  /// Collective where there is something new.
  void check_inserted();
  /// The same where fixes have changed the fixed spheres during it. Collective.
  void check_fixed_during_run() const { checks_.check_fixed_during_run(); }
  /// Whether the script names a group of fixed spheres.
  bool names_fixed() const { return spheres_.names_fixed(); }
  /// Keeps what the script has made, the first time; and that. Collective.
  void note_script_atoms() {
    if (!made_by_script_) made_by_script_ = ScriptAtoms::of(lmp);
  }
  const ScriptAtoms& made_by_script() const { return *made_by_script_; }
  /// Only coupled_run may move the spheres while this fix exists: `allowed` from its begin to its
  /// end, whose step is noted.
  void allow_run(bool allowed);

 private:
  void refuse_moves_of_varying_steps() const;
  void check_spheres(std::string_view since, Moment moment);
  void add_loads();
  /// What markers leave, as in the step just made.
  void add_films_again();
  void hand_on_loads();
  void book_lost(const LoadRecord& load);
  void hold_loads();
  int place_of(std::int64_t tag) const;
  double& told_tag(int i) const;
  void note_tags();
  /// Stores with the spheres what they overlap now, to be sent and to go into a checkpoint.
  void note_overlaps();
  void take_mean();
  /// As fix collision/table counts them; -1: there is none. Collective.
  std::int64_t finished_collisions() const;

  DemSide* side_;
  CoupledSpheres spheres_;
  SceneChecks checks_;
  std::optional<ScriptAtoms> made_by_script_;
  bool run_allowed_ = false;
  std::optional<std::int64_t> ended_at_;  ///< step of LIGGGHTS at the end of a coupled_run
  bool must_send_motion_ = false;         ///< the fluid waits for what the script has changed
  std::int64_t checked_inserted_ = 0;  ///< spheres that fixes had inserted when all were looked at
  LAMMPS_NS::FixPropertyAtom* force_ = nullptr;
  LAMMPS_NS::FixPropertyAtom* torque_ = nullptr;
  LAMMPS_NS::FixPropertyAtom* kept_ =
      nullptr;  ///< total force and torque, tag that the fluid was told
  LAMMPS_NS::FixPropertyAtom* overlap_ = nullptr;  ///< as the fluid was told
  LAMMPS_NS::FixPropertyAtom* film_ = nullptr;     ///< what marker_film_ gave
  FixMarkerFilm* marker_film_ = nullptr;
  StageLoads stage_;
  MotionHeader done_{};
  int substeps_ = 0;                      ///< of the present stage so far
  std::array<double, 6> step_impulse_{};  ///< of force and torque in the present fluid step so far
  /// Force and torque, mean over the last whole one; after a restart rank 0 has all of it.
  std::array<double, 6> step_mean_{};
  bool tags_noted_ = false;
  std::int64_t collisions_ = -1;
  double dt_fluid_ = 0.0, viscosity_ = 0.0, fluid_density_ = 0.0, cell_size_ = 0.0;
  double forcing_loops_ = 1.0;
  std::array<FluidEnd, 6> ends_{};  ///< of the box: of x, y, z, lower, upper
  ImpulseOnWalls on_walls_;         ///< in the present stage so far
  double loads_received_ = 0.0;  // how often; fix lubrication sends loads to ghosts when it changes
};

}  // namespace bedload
