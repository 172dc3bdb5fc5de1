#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace bedload {

/// The films of one step that push each other through the spheres that they share
/// (formulas/lubrication.hpp),
///
///     D_k F_k + Σ_{l≠k} A_kl F_l = D_k F_k,alone,
///
/// with A_kl the acceleration of gap k by a unit force of film l. A is never formed: A F is what
/// the accelerations of all spheres by the forces F do to the gaps. Films of this rank; spheres are
/// numbered as LIGGGHTS does, this rank's own first, then ghosts. A ghost may have its own sphere's
/// number where that is on this rank.
class FilmSystem {
 public:
  using Vector = std::array<double, 3>;

  /// What the solution asks of the other ranks.
  struct Ranks {
    std::function<void()> refresh;               ///< accelerations of own spheres to their ghosts
    std::function<void(std::span<double>)> sum;  ///< numbers summed over the ranks, in place
  };

  /// Forgets all films; `spheres` are numbered, `films` will be added.
  void begin(int spheres, std::size_t films);

  /// @param j -1: a wall
  /// @param normal unit vector towards i
  /// @param inverse_mass_i, inverse_mass_j of the spheres, 0 for one that is held [1/kg]
  /// @param compliance D [1/kg]
  /// @param force F_alone [N]
  /// @param share 1/2 where another rank (or image) holds the same film and pushes j, else 1
  void add(int i, int j, const Vector& normal, double inverse_mass_i, double inverse_mass_j,
           double compliance, double force, double share);

  /// Finds the forces, to `tolerance` of all films' in the norm of D. Returns whether there are
  /// films on any rank.
  bool solve(double tolerance, int most_iterations, const Ranks& ranks);

  /// Of film number k in the order in which they were added [N].
  double force(std::size_t k) const { return force_[static_cast<Eigen::Index>(k)]; }

  /// Of a sphere by the forces that were tried last; what Ranks::refresh gives to ghosts [m/s²].
  Vector acceleration(int sphere) const {
    const Eigen::Vector4d& a = accelerations_[static_cast<std::size_t>(sphere)];
    return {a[0], a[1], a[2]};
  }
  void set_acceleration(int sphere, const Vector& a) {
    accelerations_[static_cast<std::size_t>(sphere)] = {a[0], a[1], a[2], 0.0};
  }

 private:
  using Values = Eigen::ArrayXd;  ///< one per film
  /// A unit force of a film, as accelerations of its spheres: w_i n and w_j n, 0 for a ghost, which
  /// its own rank pushes. The last number of a vector, a register's fourth, is 0.
  struct Film {
    Eigen::Vector4d normal;
    double push_i, push_j;  ///< inverse masses [1/kg]
    std::uint32_t i, j;     ///< j of a wall: the place behind all spheres, which does not move
  };

  void accelerate(const Values& forces);
  void find_moved(const Values& forces, const Values& diagonal, const Ranks& ranks);

  std::vector<Film> films_;
  Values force_, compliance_, share_;
  Values own_;  ///< A_kk [1/kg]
  Values direction_, residual_, moved_;
  std::vector<Eigen::Vector4d> accelerations_;
};

}  // namespace bedload
