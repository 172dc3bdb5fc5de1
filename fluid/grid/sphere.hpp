#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace bedload {

using Vec3 = Eigen::Vector3d;

/// The motion of one sphere as the fluid needs it: the record that the two programs share.
/// All quantities in the units of the scene (length L, time T).
struct SphereState {
  std::int64_t tag = 0;                  ///< LIGGGHTS' atom tag, unique in the run
  Vec3 position = Vec3::Zero();          ///< centre [L], inside the periodic box
  Vec3 velocity = Vec3::Zero();          ///< of the centre [L/T]
  Vec3 angular_velocity = Vec3::Zero();  ///< [1/T]
  double radius = 0.0;                   ///< [L]
  bool mobile = true;                    ///< false: never moves; its marker weights are kept
  double density = 0.0;                  ///< of a mobile one [M/L^3]; 0: not known, not needed
  /// How far its centre has moved into what it touches [L]. A collision is stretched in time until
  /// its steps resolve it, and the overlap with it; the fluid sees the sphere at
  /// position - overlap, where it only touches.
  Vec3 overlap = Vec3::Zero();
  bool is_new = false;  ///< whatever is known of another one with this tag is not of this sphere
};

/// What the fluid does to one sphere during one Runge-Kutta stage.
struct SphereLoad {
  std::int64_t tag = 0;
  Vec3 force = Vec3::Zero();   ///< hydrodynamic force on the sphere, buoyancy included [M L/T^2]
  Vec3 torque = Vec3::Zero();  ///< about its centre [M L^2/T^2]
};

}  // namespace bedload
