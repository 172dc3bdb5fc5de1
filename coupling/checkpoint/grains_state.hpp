#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "coupling/checkpoint/script_atoms.hpp"
#include "coupling/job/run_script.hpp"
#include "fluid/checkpoint/group.hpp"

namespace LAMMPS_NS {
class Fix;
class LAMMPS;
}  // namespace LAMMPS_NS

namespace bedload {

/// LIGGGHTS' half of a checkpoint: all that a sphere takes along when it changes rank (its motion,
/// what every fix keeps of it, its contacts' histories), what fixes keep for themselves (random
/// numbers, counters), and LIGGGHTS' clock. Boxes, groups, models and fixes come from the script,
/// which is run again up to its coupled_run. Every call is collective over LIGGGHTS' ranks.
class GrainsState {
 public:
  /// Takes the state of a LIGGGHTS that has just finished a step. Contact histories have to be with
  /// the spheres (Modify::setup_pre_exchange).
  /// `id`: the number that both halves carry.
  GrainsState(LAMMPS_NS::LAMMPS* lmp, std::int64_t fluid_step, std::int64_t id,
              const RunScript& script, const ScriptAtoms& made);

  /// Reads a file; throws UserError with one sentence when it cannot be trusted or holds another
  /// step.
  GrainsState(LAMMPS_NS::LAMMPS* lmp, const std::string& path, std::int64_t fluid_step);

  /// Writes the file, whole or not at all.
  void write(const std::string& path) const;

  /// Throws UserError where a fix move would take spheres elsewhere: it knows the number of steps
  /// since it began, and one length of them.
  void refuse_moves_of_other_steps() const;

  /// Step number and time. To be set before fixes are initialised.
  void set_clock() const;

  /// Moves the insertion fixes' next step to behind the state's, or they would refuse the clock. To
  /// be called before set_clock().
  void let_insertions_pass() const;

  /// Lets insertion fixes do what they do once, at their first setup: they measure their regions
  /// with random numbers of their own, as in the run that wrote the state. To be called when
  /// LIGGGHTS and its fixes are initialised, before put_back(), which sets the random numbers.
  void set_up_insertions() const;

  /// Says on stderr how script and variables differ from those of the run that wrote the state.
  /// Throws UserError where another script makes other spheres, none of which would be used.
  void compare(const RunScript& script, const ScriptAtoms& made);

  /// Replaces all spheres, and sets the fixes' own states. To be called when LIGGGHTS and its fixes
  /// are initialised, before the integrator's setup(). Throws UserError when the script has other
  /// fixes than the one that wrote the state.
  void put_back();

  /// Sets fixes that draw random numbers to what the state says, so that a run that has written one
  /// and a run that starts from it draw the same.
  void align_random_numbers() const;

 private:
  /// What one fix keeps for itself, as it wrote it.
  struct FixPart {
    std::string id, style;
    std::vector<std::uint8_t> bytes;
  };
  void restore(const FixPart& part) const;
  std::vector<std::string> fixes_of_spheres() const;
  std::vector<LAMMPS_NS::Fix*> fixes_with_restart_alone() const;
  void check_fixes() const;
  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);
  void load_spheres(const LoadGroup& group);
  Part packed_part() const;
  bool same_ranks() const;
  /// Lower and upper end along each direction [L].
  using Region = std::array<std::array<double, 2>, 3>;
  std::vector<Region> regions() const;
  std::size_t owner_of(const double* position, const std::vector<Region>& parts) const;
  void send_to_owners();
  /// The groups of one unpacked sphere as bits of the present script.
  class GroupBits;
  void unpack(const GroupBits& groups);
  void unpack_restart_parts();

  /// Spheres of this rank, one behind the other. LIGGGHTS alone knows what its fixes and contact
  /// models keep of a sphere: that is packed as LIGGGHTS packs it for a change of rank.
  struct Spheres {
    std::vector<std::int64_t> tag;
    std::vector<double> radius, position;
    std::vector<std::int64_t> size;  ///< of each one in `values`
    std::vector<double> values;
  };

  LAMMPS_NS::LAMMPS* lmp_;
  std::string path_;  ///< for messages
  std::int64_t fluid_step_ = 0, id_ = 0, step_ = 0, time_step_of_time_ = 0;
  double step_length_ = 0.0;  ///< of LIGGGHTS' steps [T]; 0: not known
  double time_ = 0.0;
  std::vector<std::int32_t> ranks_;       ///< LIGGGHTS' grid of ranks
  std::vector<std::string> group_names_;  ///< by bit; empty: none
  RunScript script_;
  ScriptAtoms made_;                       ///< by that script
  std::vector<std::string> new_groups_;    ///< of the present script, which says who is in them
  std::vector<std::string> sphere_fixes_;  ///< that keep something per sphere, in order
  std::vector<FixPart> fix_parts_;
  Spheres spheres_;
  std::vector<std::vector<double>> restart_parts_;  ///< of each sphere unpacked, see unpack()
};

}  // namespace bedload
