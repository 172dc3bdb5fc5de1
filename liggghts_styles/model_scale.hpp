#pragma once

#include <string_view>

#include "liggghts_styles/fluid_values.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// A length or a time of a collision model: as the script gives it, the same on any grid, or so
/// many of the fluid's cells or steps, which then change with the grid.
struct ModelScale {
  std::string_view style;    ///< "normal model actm"
  std::string_view what;     ///< "collision time", of what
  std::string_view keyword;  ///< that gives it absolutely
  std::string_view unit;     ///< of the fluid: "cells" or "time steps"
  double given;              ///< by that keyword [L or T], 0: not given
  double count;              ///< so many of the fluid's otherwise

  bool follows_grid() const { return given == 0; }
  /// [L or T]. @param of_fluid its cell or step
  double value(const FluidValue& of_fluid) const {
    return follows_grid() ? count * of_fluid.get() : given;
  }
};

/// Whether a collision time [s] has the three of LIGGGHTS' steps that it needs.
bool is_resolved(const LAMMPS_NS::LAMMPS& lmp, double collision_time);

/// Ends the run with one sentence where a collision time [s] has fewer than three of LIGGGHTS'
/// steps: such a contact is over before its force has been looked at often enough, and gains
/// energy.
void require_resolved(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double collision_time);

/// Says the same at the start of a run, which goes on: perhaps nothing touches in it. A
/// collision time that is not known yet is 0.
void warn_of_unresolved(LAMMPS_NS::LAMMPS* lmp, std::string_view style, double collision_time);

/// At the start of a run: writes "scale: STYLE: WHAT = VALUE" to LIGGGHTS' log, and where the scale
/// follows the grid of a coupled fluid a line "NOTE: ..." to screen and log.
void tell_scale(LAMMPS_NS::LAMMPS* lmp, const ModelScale& scale, const FluidValue& of_fluid);

/// A line "WARNING: STYLE: SENTENCE" on screen and log.
void warn(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view sentence);
/// The same of what only this rank knows; a rank without a screen writes to stderr.
void warn_of_own(LAMMPS_NS::LAMMPS* lmp, std::string_view style, std::string_view sentence);

}  // namespace bedload
