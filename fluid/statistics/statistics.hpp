#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fluid/checkpoint/group.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/grid/flow_view.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/poisson/fftw.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/statistics/solid_rows.hpp"

namespace bedload {

/// Flow statistics of a run so far: averages over x, z and time, as functions of y. Values at cell
/// centres have one entry per y plane, values at faces one more, walls included.
struct FlowStatistics {
  std::int64_t samples = 0;
  double begin = 0.0, end = 0.0;  ///< first and last sample [T]
  std::vector<double> y, y_face;  ///< [L]

  /// Share of the points that lie in the fluid. The averages below are intrinsic: over the fluid's
  /// points alone. Times the share they are superficial ones.
  std::vector<double> fluid, fluid_face;
  std::vector<double> u, w, p;         ///< means at centres [L/T], p kinematic [L^2/T^2]
  std::vector<double> v;               ///< at faces
  std::vector<double> uu, ww, uw, pp;  ///< covariances at centres [L^2/T^2], pp [L^4/T^4]
  std::vector<double> vv, uv, vw;      ///< at faces

  /// Spheres, from their exact volume between the planes of cell faces: share of the volume that
  /// all of them and that the mobile ones fill; mean velocity of the mobile spheres' material, the
  /// spin included [L/T], and mean spin about z [1/T], zero where there is none.
  std::vector<double> grains, mobile;
  std::vector<double> grain_u, grain_v, grain_w, grain_spin;

  /// Streamwise momentum per volume, over all points (the solver's flow inside spheres included):
  ///   rho d<u>/dt = driving + d(viscous + turbulent)/dy + spheres
  std::vector<double> viscous;       ///< mu d<u>/dy at faces [M/(L T^2)]
  std::vector<double> turbulent;     ///< -rho <u v> at faces
  std::vector<double> acceleration;  ///< rho d<u>/dt at centres [M/(L^2 T^2)]
  /// What closes the balance: the spheres' force on the fluid, and, where there are, that of side
  /// walls, of the pressure between x walls and of a fringe.
  std::vector<double> spheres;
  double driving = 0.0;  ///< [M/(L^2 T^2)]
  std::array<double, 2>
      wall_stress{};  ///< that the fluid exerts on the y walls along x [M/(L T^2)]
  /// Of the no-slip walls; with spheres of the driving force, or where none drives of the wall that
  /// bears more. None where neither holds the flow: no such wall, and no spheres or y periodic.
  std::optional<double> u_tau;
  std::optional<double> re_tau;  ///< u_tau reference.height / nu
  /// Largest distance of viscous + turbulent from the straight line between the y walls'
  /// stresses, over rho u_tau^2; where nothing but driving and these walls acts on the flow (no
  /// spheres, no other no-slip walls, no fringe).
  std::optional<double> stress_defect;

  /// One-sided spectra [L^3/T^2] of u, v, w at one height each, such that their sum times the
  /// wave-number step is the variance along the lines, of the velocity less its mean over each
  /// line; modes 0 (left out, zero) to n/2. v is that of the face above `height`.
  struct Spectra {
    double height = 0.0;
    std::array<std::vector<double>, 3> x, z;
  };
  std::vector<Spectra> spectra;
  std::array<double, 2> wavenumber_step{};  ///< 2 pi / length along x and z [1/L]
};

/// Gathers statistics while a run goes on. Every call but the constructor is collective. Sums are
/// in double whatever the fields are; they do not depend on the ranks but for round-off.
template <class Real>
class Statistics {
 public:
  Statistics(const Settings& settings, const Grid& grid, const Decomposition& decomposition);

  /// Adds the present flow with the weight `duration`, the time that it stands for [T]. Velocity
  /// with all ghosts valid. `spheres`: at least those that reach into this rank's rows.
  void sample(const FlowView<Real>& flow, std::span<const SphereState> spheres, double duration);

  /// The time that a sample at `time` stands for [T]: since the one before; `first` for the first
  /// one from statistics.from on.
  double duration_at(double time, double first) const {
    return samples_ == 0 ? first : time - end_;
  }

  std::int64_t samples() const { return samples_; }
  FlowStatistics result() const;

  /// All sums, for a run that goes on. save() hands the ranks' shares to the first rank, as load()
  /// does, so that both runs go on adding in the same order: to the same digits on the same ranks.
  /// load() throws UserError when the sums are not those of these settings; where
  /// `statistics.from` lies behind them it takes none, and the averages begin anew.
  void save(const SaveGroup& group);
  void load(const LoadGroup& group);

 private:
  bool begins_after(const LoadGroup& group) const;
  /// What is summed up. Each quantity has the points of one place of the cell; the count of fluid
  /// points of a place is a quantity, too.
  enum Quantity : std::size_t {
    count_u,
    u,
    uu,
    count_w,
    w,
    ww,
    count_p,
    p,
    pp,
    count_uw,
    uw,
    count_v,
    v,
    vv,
    count_uv,
    uv,
    count_vw,
    vw,
    u_all,
    uv_all,  ///< over all points, spheres or not
    grain_volume,
    mobile_volume,
    grain_u,  ///< times volume, as the next three
    grain_v,
    grain_w,
    grain_spin,
    quantities
  };

  /// The sums of all ranks.
  struct Totals {
    std::vector<double> sums, first, last, spectra, wall_jump;
  };
  Totals totals() const;
  /// Points of a plane times the time that the samples stand for.
  double plane_points() const {
    return duration_ * double(grid_.cells[0]) * double(grid_.cells[2]);
  }
  void fill_profiles(FlowStatistics& s, const Totals& total) const;
  void fill_grains(FlowStatistics& s, const Totals& total) const;
  void fill_balance(FlowStatistics& s, const Totals& total) const;
  void fill_friction(FlowStatistics& s) const;
  void fill_spectra(FlowStatistics& s, const Totals& total) const;
  std::vector<double> averages(Quantity sum, Quantity count, std::span<const double> sums) const;
  double* at(Quantity q, int global_plane) {
    return sums_.data() + q * planes_ + static_cast<std::size_t>(global_plane);
  }
  void add_plane(const FlowView<Real>& flow, std::span<const SphereState> spheres, int j,
                 double duration);
  void add_walls(const FlowView<Real>& flow, double duration);
  void add_grains(std::span<const SphereState> spheres, double duration);
  void add_grain(const SphereState& sphere, double duration);
  void add_spectra(const FlowView<Real>& flow, double duration);
  void add_spectrum(std::span<const double> plane, std::size_t height, int component,
                    double duration);
  double* spectrum(std::size_t height, int component, int direction);

  void give_to_first_rank();
  /// Lists of sums by the names that checkpoints know them by.
  std::array<std::pair<const char*, std::vector<double>*>, 4> lists() {
    return {{{"sums", &sums_},
             {"first_sample", &first_},
             {"last_sample", &last_},
             {"spectra", &spectra_}}};
  }

  const Settings& settings_;
  const Grid& grid_;
  const Decomposition& decomposition_;
  BlockMap blocks_;
  std::size_t planes_;
  SolidRows solid_;
  std::vector<int> spectrum_planes_;  ///< global
  FourierPlan<double> along_x_, along_z_;
  AlignedArray<std::complex<double>> line_x_, line_z_, modes_;

  /// This rank's share of the sums; what all ranks know alike is kept by the first alone.
  std::vector<double> sums_;           ///< [quantity][global plane]
  std::vector<double> first_, last_;   ///< sum of u over each plane, first and last sample
  std::vector<double> spectra_;        ///< [height][component][modes along x, then along z]
  std::array<double, 2> wall_jump_{};  ///< sum of u beside the wall minus u beyond it
  double driving_ = 0.0;               ///< times duration
  double duration_ = 0.0, spectra_duration_ = 0.0;
  double begin_ = 0.0, end_ = 0.0;
  std::int64_t samples_ = 0;
};

}  // namespace bedload
