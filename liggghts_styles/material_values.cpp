#include "liggghts_styles/material_values.hpp"

#include <fmt/format.h>

#include "atom.h"
#include "fix_property_global.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "modify.h"

namespace bedload {

PairTable read_pair_property(LAMMPS_NS::LAMMPS* lmp, const std::string& style,
                             const std::string& name, double lower, double upper) {
  const int types = lmp->atom->ntypes;
  auto* fix = static_cast<LAMMPS_NS::FixPropertyGlobal*>(lmp->modify->find_fix_property(
      name.c_str(), "property/global", "peratomtypepair", types, types, style.c_str(), false));
  if (fix == nullptr) {
    stop_run(lmp, fmt::format("{} needs the line 'fix ID all property/global {} peratomtypepair {} "
                              "<values>'",
                              style, name, types));
  }
  std::vector<double> values;
  for (int i = 0; i < types; ++i) {
    for (int j = 0; j < types; ++j) {
      const double value = fix->compute_array(i, j);
      if (!(value >= lower && value <= upper)) {
        stop_run(lmp,
                 fmt::format("{}: {} has to lie between {} and {}, found {} for types {} and {}",
                             style, name, lower, upper, value, i + 1, j + 1));
      }
      values.push_back(value);
    }
  }
  return PairTable(types, std::move(values));
}

}  // namespace bedload
