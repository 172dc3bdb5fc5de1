#include "coupling/bedload_dem/motion_rules.hpp"

#include <fmt/format.h>

namespace bedload {

std::string describe_flaw(MotionFlaw flaw, const MotionRules& rules, const Vec3& position,
                          double radius) {
  switch (flaw) {
    case MotionFlaw::none:
      return {};
    case MotionFlaw::too_fast:
      return "moves by more than its radius in one step of LIGGGHTS; reduce 'time.step' of "
             "fluid.toml";
    case MotionFlaw::outside:
      return "has left the box; put a 'fix wall/gran' where the box ends, or reduce 'time.step' "
             "of fluid.toml";
    case MotionFlaw::in_wall:
      return fmt::format(
          "reaches {:.3g} out of the box, and at most {} of its radius is allowed; put a 'fix "
          "wall/gran' where the box ends, or reduce 'time.step' of fluid.toml",
          depth_in_walls(rules.box, position, radius), rules.deepest);
  }
  return {};
}

}  // namespace bedload
