#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "coupling/job/roles.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/kernels/fnv.hpp"

namespace bedload {

/// Raised whenever a record below, or who sends it when, changes.
inline constexpr std::int32_t protocol_number = 15;

using Triple = std::array<double, 3>;
using Bytes = std::vector<std::byte>;

/// Motion of one sphere on the wire, LIGGGHTS -> fluid. Position wrapped into the periodic box.
struct StateRecord {
  std::int64_t tag;
  Triple position;
  Triple velocity;
  Triple spin;
  double radius;
  double density;
  std::int64_t mobile;
  Triple overlap;       ///< SphereState::overlap
  std::int64_t is_new;  ///< SphereState::is_new
};

/// Force and torque on one sphere on the wire, fluid -> LIGGGHTS.
struct LoadRecord {
  std::int64_t tag;
  Triple force;
  Triple torque;
};

enum class Order : std::int32_t { advance, checkpoint, stop };

/// Heads the loads of one stage.
struct LoadHeader {
  std::int64_t step;   ///< fluid step that is being made, from 0
  std::int32_t stage;  ///< 0, 1, 2
  Order order;         ///< checkpoint: no loads, a CheckpointHeader follows; stop: the run is over
  double fluid_time_step;  ///< [T]
  std::int32_t last;       ///< 1: the fluid makes no step after this one
  std::int32_t spare;
};

/// Heads the states of one stage.
struct MotionHeader {
  std::int64_t step;
  std::int64_t stage;
  // To one of the partners; zero to the others.
  Triple impulse;          ///< sum over this rank's spheres and sub-steps of force dt [M L/T]
  Triple angular_impulse;  ///< the same of the torque [M L^2/T]
  Triple lost,
      angular_lost;  ///< what spheres that were deleted would have got in the rest of the stage
  double on_lower_walls, on_upper_walls;  ///< ImpulseOnWalls of this rank [M L/T]
  std::int64_t collisions;  ///< finished so far, all on rank 0's record; -1 there: not counted
  std::int64_t renewed;     ///< 1: the script may change spheres now; their motion comes once more
  double began, ended;      ///< clock [s] around the sub-steps, for the time line
};

enum class EndKind : std::int32_t { periodic, no_slip, free_slip };

/// What the fluid knows of the scene: sent as soon as fluid.toml is read. The path of the grains'
/// half of the checkpoint to start from follows as text.
struct FluidSceneInfo {
  Triple length;  ///< box from the origin [L]
  std::array<std::int32_t, 3> periodic;
  std::array<std::int32_t, 3> dem_steps;  ///< stages.hpp
  std::array<EndKind, 6> ends;            ///< lower and upper end of x, of y, of z
  std::array<Triple, 6> end_velocities;   ///< of no-slip ones [L/T]
  Triple gravity;                         ///< [L/T^2]
  double density;                         ///< [M/L^3]
  double kinematic_viscosity;             ///< [L^2/T]
  double time_step;                       ///< [T]
  double cell_size;                       ///< [L]
  std::int64_t forcing_loops;
  std::int64_t restart_step = -1;  ///< fluid steps made when the checkpoint was written; -1: none
  std::int64_t end_step = -1;  ///< steps at the fluid's end of time; -1: the step's length varies
};

/// How the fluid has divided the box, as soon as it knows: followed by the first planes of the
/// parts along y, the first rows of those along z, and the numbers of planes and rows behind each.
struct DivisionHeader {
  std::int32_t y_parts, z_parts;
};

/// Which fluid ranks are partners of a rank of LIGGGHTS: followed by their numbers.
struct PartnersHeader {
  std::int32_t rank;  ///< of LIGGGHTS, which the fluid asserts
};

/// Follows an order to write a checkpoint; LIGGGHTS' file follows as text.
struct CheckpointHeader {
  std::int64_t id;  ///< the number that both halves carry
};

/// What LIGGGHTS knows of it: sent at the first coupled_run; a text (one effect per line:
/// name, state, reason, separated by tabs) follows.
struct DemSceneInfo {
  Triple box_low, box_high;  ///< [L]
  std::array<std::int32_t, 3> periodic;
  std::int32_t has_gravity;  ///< a fix gravity exists
  Triple gravity;            ///< [L/T^2]
  double force_factor;       ///< LIGGGHTS' ftm2v: 1 in units where force = mass * acceleration
  std::int64_t mobile, fixed;
  std::int64_t inserts;  ///< fixes that may insert spheres while it runs
  double density,
      viscosity;  ///< the fluid's (dynamic), as the script states them; NaN: it does not
};

template <class T>
concept Record = std::is_trivially_copyable_v<T> && std::is_standard_layout_v<T>;

static_assert(Record<DivisionHeader> && Record<PartnersHeader> && Record<CheckpointHeader> &&
              Record<StateRecord> && Record<LoadRecord> && Record<LoadHeader> &&
              Record<MotionHeader> && Record<FluidSceneInfo> && Record<DemSceneInfo>);

/// A number that differs when sizes or places of the records' members differ; both programs compare
/// theirs before the first message.
constexpr std::uint64_t layout_fingerprint() {
  std::uint64_t hash = fnv_start;
  for (const std::size_t number : {sizeof(StateRecord),
                                   offsetof(StateRecord, spin),
                                   offsetof(StateRecord, mobile),
                                   sizeof(LoadRecord),
                                   offsetof(LoadRecord, torque),
                                   sizeof(LoadHeader),
                                   offsetof(LoadHeader, fluid_time_step),
                                   sizeof(MotionHeader),
                                   offsetof(MotionHeader, lost),
                                   offsetof(MotionHeader, on_lower_walls),
                                   offsetof(MotionHeader, collisions),
                                   offsetof(MotionHeader, renewed),
                                   sizeof(FluidSceneInfo),
                                   offsetof(FluidSceneInfo, gravity),
                                   offsetof(FluidSceneInfo, restart_step),
                                   offsetof(FluidSceneInfo, end_step),
                                   sizeof(DemSceneInfo),
                                   offsetof(DemSceneInfo, gravity),
                                   offsetof(DemSceneInfo, mobile),
                                   offsetof(DemSceneInfo, viscosity)})
    hash = fnv_mixed(hash, number);
  return hash;
}

inline Protocol exchange_protocol() { return {protocol_number, layout_fingerprint()}; }

/// Header and items one behind the other.
template <Record Header, Record Item>
Bytes pack(const Header& header, std::span<const Item> items) {
  Bytes bytes(sizeof(Header) + items.size_bytes());
  std::memcpy(bytes.data(), &header, sizeof(Header));
  if (!items.empty()) std::memcpy(bytes.data() + sizeof(Header), items.data(), items.size_bytes());
  return bytes;
}

template <Record Header>
Header unpack_header(const Bytes& bytes) {
  assert(bytes.size() >= sizeof(Header));
  Header header;
  std::memcpy(&header, bytes.data(), sizeof(Header));
  return header;
}

/// Appends the items behind the header to `items`.
template <Record Header, Record Item>
void unpack_items(const Bytes& bytes, std::vector<Item>& items) {
  const std::size_t body = bytes.size() - sizeof(Header);
  assert(bytes.size() >= sizeof(Header) && body % sizeof(Item) == 0);
  const std::size_t before = items.size();
  items.resize(before + body / sizeof(Item));
  if (body > 0) std::memcpy(items.data() + before, bytes.data() + sizeof(Header), body);
}

inline Triple triple(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline Triple triple(const double* v) { return {v[0], v[1], v[2]}; }
inline Vec3 vec3(const Triple& t) { return {t[0], t[1], t[2]}; }

inline SphereState sphere_state(const StateRecord& r) {
  return {r.tag,         vec3(r.position), vec3(r.velocity), vec3(r.spin), r.radius,
          r.mobile != 0, r.density,        vec3(r.overlap),  r.is_new != 0};
}
/// Radius around its centre within which the fluid may look for a sphere [L]: it sees it where it
/// will be at the end of a stage, out of its overlap, at most a `cell` [L] further.
/// @param time at least the stage's length [T]
inline double reach_of(const StateRecord& r, double cell,
                       double time = std::numeric_limits<double>::infinity()) {
  const double speed = vec3(r.velocity).norm();
  return r.radius + vec3(r.overlap).norm() + (speed > 0.0 ? std::min(cell, time * speed) : 0.0);
}

inline LoadRecord load_record(const SphereLoad& l) {
  return {l.tag, triple(l.force), triple(l.torque)};
}

}  // namespace bedload
