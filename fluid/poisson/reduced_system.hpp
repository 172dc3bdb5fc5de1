#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/poisson/slab_elimination.hpp"

namespace bedload {

/// The coupling between the slabs of the y system, exactly, for any number of ranks.
///
/// With X_r the last plane of slab r, W_r an amount that the slab above has to see added to X_r
/// (its share of the right-hand side that rank r knows, see PoissonSolver), d'_r the last
/// eliminated right-hand side and g_r the first-plane functional (slab_elimination.hpp), each
/// Fourier mode obeys
///
///   f_r (X_r-1 + W_r-1) + X_r + c_r Y_r+1 = d'_r,
///   Y_r = g_r + alpha_r (X_r-1 + W_r-1) + beta_r X_r          (first plane of slab r),
///
/// a tridiagonal system in r, cyclic where y is periodic. The modes are distributed over the ranks
/// by one all-to-all message, solved in double, and sent back by another. The pressure's mean mode
/// leaves its level open; X of the last slab is set to zero there, on whatever number of ranks.
template <class Real>
class ReducedSystem {
 public:
  /// A mode has `parts` values: 2, real and imaginary, or 1.
  ReducedSystem(const Grid& grid, const Decomposition& decomposition, std::size_t modes, int parts);

  /// Coefficients of one slab, one of each per own mode, and its row of the factorised system.
  struct Row {
    std::vector<double> c, f, alpha, beta;            // see eliminate_slab
    std::vector<double> lower, inverse_pivot, upper;  // Thomas elimination of all but the last
    std::vector<double> response;                     // of X_r to the last slab's X
  };
  struct Factors {
    std::vector<Row> rows;             ///< [slab]
    std::vector<double> inverse_last;  ///< [own mode], last pivot; 0 pins the mean mode
  };
  /// Takes each mode's coefficients of this slab, hands them to the mode's owner and factorises;
  /// `open`: the pressure's mean mode. Collective.
  Factors factorise(std::span<const SlabCoupling> own, std::optional<std::size_t> open) const;

  /// What a rank knows after its elimination, one mode's parts after the other.
  struct Known {
    const Real* last;    ///< d' of its last plane
    const Real* first;   ///< g
    const Real* excess;  ///< W; not read beside the upper wall
  };
  /// What it needs for the way back.
  struct Wanted {
    Real* below;  ///< X + W of the rank below; not written beside the lower wall
    Real* last;   ///< its own X
    Real* above;  ///< first plane of the rank above; not written beside the upper wall
  };
  /// Collective.
  void solve(const Factors& factors, const Known& known, const Wanted& wanted);

 private:
  /// Values of one slab for some neighbouring modes at a time, few enough for the first-level
  /// cache.
  static constexpr std::size_t batch = 64;
  struct Values {
    std::array<double, 2 * batch> last, first, excess, x;
  };

  std::size_t share_begin(int rank) const {
    return modes_ * static_cast<std::size_t>(rank) / static_cast<std::size_t>(ranks_);
  }
  std::size_t own_share() const { return share_begin(rank_ + 1) - share_begin(rank_); }
  void factorise_mode(Factors& factors, std::size_t mode) const;
  template <int parts>
  void solve_modes(const Factors& factors, std::size_t begin, std::size_t count);
  void count_messages();

  MPI_Comm comm_;
  int rank_, ranks_;
  bool cyclic_;
  std::size_t modes_, parts_;
  std::vector<Values> values_;  // [slab] of the modes in work
  std::vector<Real> to_owner_, at_owner_;
  std::vector<int> rank_counts_, rank_offsets_, owner_counts_, owner_offsets_;
};

}  // namespace bedload
