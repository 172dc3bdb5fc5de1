#pragma once

#include <cmath>
#include <vector>

#include "atom.h"
#include "liggghts_styles/formulas/tangential_lubrication.hpp"
#include "liggghts_styles/impulse_on_walls.hpp"
#include "liggghts_styles/mobility.hpp"

namespace bedload {

/// The films of a step that act against sliding and rolling, each no stiffer than the logarithm of
/// its gap, so that velocities alone say what they do. Formulas in
/// formulas/tangential_lubrication.hpp.
///
/// A step is: clear() and add() as the contact models meet the surfaces; sum_rates(); the owner
/// gives the rates of its spheres to their ghosts (rate()); apply().
class TangentialFilms {
 public:
  using Vector = contact::Vector3;

  struct Film {
    int i, j;       ///< local indices; j = -1: a wall
    Vector normal;  ///< unit vector towards i
    Vector wall_velocity;
    contact::TangentialFilm film;
    bool mirrored;  ///< j is the image of i
  };

  void clear() { films_.clear(); }
  void add(const Film& film) { films_.push_back(film); }
  std::size_t size() const { return films_.size(); }

  /// At what rate all its films slow a sphere down, local or a ghost [1/s].
  double& rate(int i) { return rates_[static_cast<std::size_t>(i)]; }
  double rate(int i) const { return rates_[static_cast<std::size_t>(i)]; }

  /// Sets the rates of the local spheres.
  void sum_rates(const LAMMPS_NS::Atom& atom, const Mobility& mobility) {
    rates_.assign(static_cast<std::size_t>(atom.nlocal + atom.nghost), 0.0);
    for (const Film& f : films_) {
      rate(f.i) += rate_of(f, f.i, atom, mobility);
      if (f.j >= 0 && f.j < atom.nlocal) rate(f.j) += rate_of(f, f.j, atom, mobility);
    }
  }

  /// Adds the films' mean loads over the step `dt` to the forces and torques of the local spheres
  /// that can move, and hands them to push(k, force, torque); what walls get goes to `on_walls`,
  /// which may be null.
  template <class Push>
  void apply(LAMMPS_NS::Atom& atom, const Mobility& mobility, double dt, ImpulseOnWalls* on_walls,
             Push push) {
    for (const Film& f : films_) {
      const bool wall = f.j < 0;
      const Vector vi = vector(atom.v[f.i]), spin = vector(atom.omega[f.i]);
      const Vector vj = f.mirrored ? vi : wall ? f.wall_velocity : vector(atom.v[f.j]);
      const Vector other_spin = f.mirrored ? times(-1, spin)  // across the normal
                                : wall     ? Vector{}
                                           : vector(atom.omega[f.j]);
      const contact::TangentialLoads loads = contact::tangential_loads(
          f.film, f.normal, {vi[0] - vj[0], vi[1] - vj[1], vi[2] - vj[2]}, spin, other_spin);
      const double share =
          contact::tangential_step_share(std::fmax(rate(f.i), wall ? 0.0 : rate(f.j)), dt);
      const auto give = [&](int k, const Vector& force, const Vector& torque) {
        if (mobility.held(atom.mask[k])) return;
        for (int d = 0; d < 3; ++d) {
          atom.f[k][d] += force[d];
          atom.torque[k][d] += torque[d];
        }
        push(k, force, torque);
      };
      give(f.i, times(share, loads.force), times(share, loads.torque_i));
      if (wall && !f.mirrored && on_walls != nullptr && !mobility.held(atom.mask[f.i]))
        on_walls->take(f.normal.data(), share * loads.force[0], dt);
      if (!wall && f.j < atom.nlocal)
        give(f.j, times(-share, loads.force), times(share, loads.torque_j));
    }
  }

 private:
  static Vector vector(const double* p) { return {p[0], p[1], p[2]}; }
  static Vector times(double factor, const Vector& v) {
    return {factor * v[0], factor * v[1], factor * v[2]};
  }
  static double rate_of(const Film& f, int k, const LAMMPS_NS::Atom& atom,
                        const Mobility& mobility) {
    const double w = mobility.inverse_mass(atom, k), a = atom.radius[k];
    return contact::tangential_rate(f.film, k == f.i ? f.film.arm_i : f.film.arm_j, w,
                                    2.5 * w / (a * a));
  }

  std::vector<Film> films_;
  std::vector<double> rates_;
};

}  // namespace bedload
