#pragma once

#include <cmath>
#include <limits>

namespace bedload {

/// The first of the times next, next + every, next + 2 every, ... that is behind `now`.
inline double next_due(double next, double every, double now) {
  if (next > now) return next;
  next += every * std::fmax(1.0, std::floor((now - next) / every));
  if (next <= now) next += every;
  // An interval below the round-off of the time itself.
  return next > now ? next : std::nextafter(now, std::numeric_limits<double>::infinity());
}

}  // namespace bedload
