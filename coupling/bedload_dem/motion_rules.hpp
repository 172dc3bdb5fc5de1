#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "coupling/exchange/message.hpp"

namespace bedload {

/// LIGGGHTS' box at one moment.
struct Box {
  Triple low, high;                      ///< [L]
  std::array<std::int32_t, 3> periodic;  ///< 0: it has ends there
};

/// Whether a point is between the ends of the box, or on them.
inline bool is_inside(const Box& box, const Vec3& position) {
  for (std::size_t d = 0; d < 3; ++d)
    if (box.periodic[d] == 0 && !(position[d] >= box.low[d] && position[d] <= box.high[d]))
      return false;
  return true;
}

/// How far a sphere is beyond the nearest end of the box [L]; below 0: within.
inline double depth_in_walls(const Box& box, const Vec3& position, double radius) {
  double depth = -std::numeric_limits<double>::infinity();
  for (std::size_t d = 0; d < 3; ++d) {
    if (box.periodic[d] != 0) continue;
    const double way = std::min(position[d] - box.low[d], box.high[d] - position[d]);
    depth = std::max(depth, radius - way);
  }
  return depth;
}

/// What a mobile sphere has to keep to in each step of LIGGGHTS.
struct MotionRules {
  Box box;
  double time_step;  ///< of LIGGGHTS [T]
  double deepest;    ///< in walls, in radii
};

enum class MotionFlaw { none, too_fast, outside, in_wall };

/// The first rule that a sphere breaks. Too fast is what does not keep to
///   (|v| + |omega| R) dt <= R,
/// for then contacts are missed. The rule for walls is that of fluid/validation, which looks at
/// spheres when they come or change.
inline MotionFlaw flaw_of_motion(const MotionRules& rules, const Vec3& position,
                                 const Vec3& velocity, const Vec3& spin, double radius) {
  const double speed = velocity.norm() + spin.norm() * radius;
  if (!(speed * rules.time_step <= radius)) return MotionFlaw::too_fast;
  if (!is_inside(rules.box, position)) return MotionFlaw::outside;
  if (depth_in_walls(rules.box, position, radius) > rules.deepest * radius)
    return MotionFlaw::in_wall;
  return MotionFlaw::none;
}

/// The flaw in words, to stand behind the name of the sphere ("has left the box; ...").
std::string describe_flaw(MotionFlaw flaw, const MotionRules& rules, const Vec3& position,
                          double radius);

}  // namespace bedload
