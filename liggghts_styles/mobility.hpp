#pragma once

#include <string_view>

#include "atom.h"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Which particles answer to forces. A particle is held (infinite mass, infinite inertia) if a fix
/// freeze, move or nve/noforce has it, or if no fix integrates it at all. LIGGGHTS' own effective
/// mass knows only of freeze.
class Mobility {
 public:
  Mobility() = default;

  /// Reads the fixes that stand in the script now.
  explicit Mobility(LAMMPS_NS::LAMMPS* lmp);

  /// Whether all particles answer to forces, so that no mask needs to be looked at.
  bool all_free() const { return (integrated_ & 1) != 0 && held_ == 0; }

  /// @param mask the particle's group mask (atom->mask)
  bool held(int mask) const { return (mask & integrated_) == 0 || (mask & held_) != 0; }

  /// Whether a fix moves it by the forces that it finds on it, none perhaps.
  bool integrated(int mask) const { return (mask & integrated_) != 0; }

  /// Whether no fix moves, freezes or holds it.
  bool left_alone(int mask) const { return (mask & (integrated_ | held_)) == 0; }

  /// 1/mass, 0 for a held particle [1/kg].
  double inverse_mass(int mask, double mass) const { return held(mask) ? 0.0 : 1.0 / mass; }
  double inverse_mass(const LAMMPS_NS::Atom& atom, int i) const {
    return inverse_mass(atom.mask[i], atom.rmass[i]);
  }

  /// That of the reduced mass of two particles, or of one and a wall (j < 0) [1/kg].
  double inverse_mass(const LAMMPS_NS::Atom& atom, int i, int j) const {
    return inverse_mass(atom, i) + (j < 0 ? 0.0 : inverse_mass(atom, j));
  }

 private:
  int integrated_ = 0;  // group bits that a time-integrating fix moves
  int held_ = 0;        // group bits that move as prescribed or not at all
};

/// Whether fixes of this style take components out of the forces that stand when they act, or
/// spread them evenly.
inline bool projects_forces(std::string_view style) {
  return style == "setforce" || style == "lineforce" || style == "planeforce" ||
         style == "aveforce";
}

}  // namespace bedload
