#pragma once

namespace bedload {

/// Direction in which a block's planes are gone through.
enum class Sweep : int { down = -1, up = 1 };

/// Distance along y from one plane of a sweep to the next.
constexpr int step_of(Sweep sweep) { return static_cast<int>(sweep); }
constexpr Sweep opposite(Sweep sweep) { return sweep == Sweep::up ? Sweep::down : Sweep::up; }

/// Which of a block's planes a sweep comes to as its n-th, n = 0 .. planes-1; its own inverse.
constexpr int plane_of(Sweep sweep, int n, int planes) {
  return sweep == Sweep::up ? n : planes - 1 - n;
}

}  // namespace bedload
