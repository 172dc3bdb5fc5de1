#pragma once

#include <array>
#include <cstdint>
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

  /// Of the present atoms. Collective.
  static ScriptAtoms of(LAMMPS_NS::LAMMPS* lmp);

  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);

  /// The bit of a group; -1: there is none of this name.
  int bit_of(const std::string& name) const;
};

}  // namespace bedload
