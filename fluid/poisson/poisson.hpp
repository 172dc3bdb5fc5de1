#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/kernels/past_caches.hpp"
#include "fluid/poisson/mode_coefficients.hpp"
#include "fluid/poisson/plane_transform.hpp"
#include "fluid/poisson/reduced_system.hpp"
#include "fluid/poisson/slab_elimination.hpp"
#include "fluid/poisson/y_row.hpp"

namespace bedload {

/// Direct solver, plane by plane, of
///
///   mass_j (h^2 Laplacian - shift) phi = rhs
///
/// for the pressure (shift 0, Poisson's equation) or for a velocity component whose diffusion is
/// implicit (shift h^2/(nu dt'), Helmholtz' equation), with that quantity's conditions at walls,
/// homogeneous. mass_j is the height of the cells about plane j over h (y_row.hpp): on cubes
///
///   phi_i-1 + phi_i+1 + phi_j-1 + phi_j+1 + phi_k-1 + phi_k+1 - (6 + shift) phi = rhs.
///
/// Upwards, some planes at a time: write the right-hand side of planes first .. end-1 into
/// rhs_row(j, 0..nz-1), call eliminate(first, end). Then couple(). Downwards, likewise some at a
/// time: substitute(planes, planes+1) (the first plane of the slab above, unless there is a wall),
/// .., substitute(0, ..), after each of which solution_row(first .. end, k) are valid. Planes that
/// do not fit into the caches are taken row by row of all, so that what one of them leaves for the
/// next is still there.
///
/// The pressure's right-hand side of plane 0 lacks an amount that only the rank below knows, -v.
/// That rank gives v over 1/gap (the coefficient of the plane below in that row) in excess_row()
/// before couple(): to the elimination it is the same as a change of the plane below the slab.
/// Where planes are divided along z, row 0 may likewise lack what only the block behind knows; that
/// one gives it in rhs_row(j, nz).
template <class Real>
class PoissonSolver {
 public:
  /// For a velocity component or the pressure; at most `planes_at_once` planes are eliminated or
  /// substituted at a time; `stays_in_caches` bytes are found in the caches again on the way down.
  /// Collective.
  PoissonSolver(const Grid& grid, const Decomposition& decomposition,
                int component = pressure_component, int planes_at_once = 1,
                std::size_t stays_in_caches = cached_bytes);

  /// Changes the shift (0 at first for the pressure, none for a velocity). A new one costs about as
  /// much as eliminate() and substitute() without their transforms, one of the last three nothing
  /// on uniform y. Not between the two sweeps. Collective.
  void set_shift(double shift);

  Real* rhs_row(int j, int k) { return real_row(real_plane(j), k); }
  Real* excess_row(int k) { return real_row(excess_, k); }
  /// Valid for i = 0 .. nx and k = 0 .. nz, the last ones being the periodic neighbours or, beyond
  /// a wall, the values before it.
  const Real* solution_row(int j, int k) const {
    if (k == nz() && !gives_to_front()) k = transform_->periodic_z() ? 0 : k - 1;
    return real_planes_[static_cast<std::size_t>(j) % real_planes_.size()].data() +
           transform_->real_place(k);
  }
  /// Whether the planes are divided along z: then rhs_row(j, nz) takes what belongs to the first
  /// row of the block in front.
  bool gives_to_front() const { return transform_->has_row_in_front(); }

  /// Takes `scale` times what stands in rhs_row(j) as the right-hand side.
  void eliminate(int first, int end, double scale = 1.0);
  void couple();
  void substitute(int first, int end);

 private:
  AlignedArray<Real>& real_plane(int j) {
    return real_planes_[static_cast<std::size_t>(j) % real_planes_.size()];
  }
  Real* real_row(AlignedArray<Real>& plane, int k) {
    return plane.data() + transform_->real_place(k);
  }
  /// Place of a spectral row among the modes.
  std::size_t at(int j, int row) const {
    return (static_cast<std::size_t>(j) * static_cast<std::size_t>(transform_->rows()) +
            static_cast<std::size_t>(row)) *
           transform_->pitch();
  }
  /// What a shift makes of the system: coefficients of the elimination, f only where the plane
  /// below the slab is carried along.
  struct System {
    double shift;
    ModeCoefficients<Real> c;
    EndModes<Real> f;
    typename ReducedSystem<Real>::Factors coupling;
  };
  System make_system(double shift);
  void end_elimination();
  void begin_substitution(int j);
  void end_substitution(int j);
  void eliminate_rows(int first, int end, double scale);
  void ask_to_eliminate(int j, int kz);
  template <int parts>
  void eliminate_row(int j, int kz, double scale);
  void substitute_rows(int first, int end);
  void ask_to_substitute(int j, int kz);
  template <int parts>
  void substitute_row(int j, int kz);

  int nz() const { return transform_->nz(); }

  std::unique_ptr<PlaneTransform<Real>> transform_;
  ReducedSystem<Real> reduced_;
  bool of_pressure_;
  int planes_;
  bool coupled_below_, coupled_above_;
  std::vector<double> eigenvalue_;     // of h^2 times the differences along x and z
  std::vector<YRow> rows_;             // of the own planes, upwards
  std::vector<PlaneFactors> factors_;  // of the own planes
  std::size_t kept_systems_;
  std::vector<System> systems_;      // of the last shifts
  std::size_t system_ = 0;           // the one in use
  AlignedArray<Real> eliminated_;    // d', [plane][row][mode][part]
  AlignedArray<Real> arriving_;      // d of one row
  AlignedArray<Real> first_;         // g
  AlignedArray<Real> outside_;       // X + W of the rank below
  AlignedArray<Real> last_, above_;  // x_j on the way down, first plane of the rank above
  bool past_caches_ = false;         // is eliminated_ written
  // Right-hand sides on the way up, solutions on the way down: of one plane more than at a time.
  std::vector<AlignedArray<Real>> real_planes_;
  AlignedArray<Real> excess_;

  /// A plane whose transform has begun and not ended: while its messages are under way the next
  /// one is worked on.
  struct Begun {
    int j;
    double scale;
  };
  std::optional<Begun> begun_;
};

}  // namespace bedload
