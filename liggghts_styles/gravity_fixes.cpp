#include "liggghts_styles/gravity_fixes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fix_gravity.h"
#include "lammps.h"
#include "modify.h"

namespace bedload {

GravityFixes::GravityFixes(LAMMPS_NS::LAMMPS* lmp) {
  for (int n = 0; n < lmp->modify->n_fixes_style_strict("gravity"); ++n) {
    auto* const fix =
        static_cast<LAMMPS_NS::FixGravity*>(lmp->modify->find_fix_style_strict("gravity", n));
    Pull pull{fix->groupbit, {}};
    fix->get_gravity(pull.vector.data());
    pulls_.push_back(pull);
  }
}

std::array<double, 3> GravityFixes::on(int mask) const {
  std::array<double, 3> sum{};
  for (const Pull& pull : pulls_)
    if ((mask & pull.groupbit) != 0)
      for (std::size_t d = 0; d < 3; ++d) sum[d] += pull.vector[d];
  return sum;
}

double GravityFixes::size_on(int mask) const {
  const std::array<double, 3> g = on(mask);
  return std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
}

double GravityFixes::largest() const {
  constexpr int all = 1;  // the group that every sphere is in
  double size = 0;
  for (const Pull& pull : pulls_) size = std::max(size, size_on(pull.groupbit | all));
  return size;
}

}  // namespace bedload
