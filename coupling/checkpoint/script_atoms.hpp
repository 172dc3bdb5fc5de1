#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fluid/checkpoint/group.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// LIGGGHTS has 32 groups, a bit each.
inline constexpr std::size_t most_groups = 32;

/// Name of each of LIGGGHTS' groups, by its bit; empty where there is none.
std::vector<std::string> group_names(LAMMPS_NS::LAMMPS* lmp);

/// The atoms and groups that a script has made by its first coupled_run: fingerprints, the same on
/// any number of ranks, by which a run that goes on sees whether the script makes others now.
struct ScriptAtoms {
  std::vector<std::string> groups;                  ///< by bit
  std::array<std::int64_t, most_groups> members{};  ///< of each: its atoms' numbers
  std::int64_t count = 0;
  std::int64_t sizes = 0;  ///< numbers and radii
  /// Densities and, if LIGGGHTS has made no step yet, places and speeds; none in files of before.
  std::optional<std::int64_t> states;

  /// Of the present atoms. Collective.
  static ScriptAtoms of(LAMMPS_NS::LAMMPS* lmp);

  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);

  /// What of `other` is not as here, as in "a run with [so many spheres, others]"; empty: all is.
  /// Places and speeds after a dry run depend on what it computed, and are not compared.
  std::string what_differs(const ScriptAtoms& other) const;

  /// The bit of a group; -1: there is none of this name.
  int bit_of(const std::string& name) const;
};

}  // namespace bedload
