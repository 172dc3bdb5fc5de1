#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "fluid/block_map.hpp"
#include "fluid/decomposition.hpp"
#include "fluid/field.hpp"
#include "fluid/grid.hpp"
#include "fluid/settings.hpp"
#include "fluid/sphere.hpp"
#include "fluid/spheres/interior.hpp"
#include "fluid/spheres/marker_halo.hpp"
#include "fluid/spheres/marker_layout.hpp"
#include "fluid/spheres/marker_list.hpp"
#include "fluid/spheres/sphere_bins.hpp"

namespace bedload {

/// Difference between the spheres' surface velocity and the fluid's at the markers [L/T].
struct Slip {
  double max = 0.0;  ///< largest of any component at any marker
  double rms = 0.0;  ///< root of the mean over markers of the squared slip vector
};

/// What the last call of force() did, over all ranks.
struct ForcingReport {
  int loops = 0;
  Slip before;  ///< of the predicted velocity, before the first loop
  Slip after;  ///< after the last loop; the last measured: `before` with one loop, unless asked for
  Vec3 force_on_fluid = Vec3::Zero();  ///< of all markers, mean over the stage [M L/T^2]
  Vec3 force_of_fixed = Vec3::Zero();  ///< the fixed spheres' part of it
};

/// Wall clock that this rank has spent so far [s].
struct MarkerSeconds {
  double placing = 0.0;      ///< finding and weighing the mobile spheres' markers
  double first_loops = 0.0;  ///< forcing
  double extra_loops = 0.0;
  double interior = 0.0;  ///< momentum inside the mobile spheres
};

/// Momentum of the fluid inside a sphere that stands for the sphere's own: what was inside after
/// the last forcing, less what the sphere is still owed. The momentum of fluid and spheres less
/// this changes only by what comes from outside.
struct SphereAccount {
  std::int64_t tag = 0;
  Vec3 linear = Vec3::Zero();   ///< [M L/T]
  Vec3 angular = Vec3::Zero();  ///< about the centre as it was then [M L^2/T]
};

/// Spheres in the flow by direct forcing at Lagrangian markers (Uhlmann 2005) with repeated forcing
/// and the momentum of the fluid inside (Kempe and Froehlich 2012); README.md has the equations and
/// the reasons. Every call is collective over the decomposition's ranks. A rank keeps the spheres
/// that its block is near (BlockMap) and computes the loads of those whose centre it holds; what
/// its neighbours know of these comes to it in one message each. Once per Runge-Kutta stage, in
/// this order:
///
///   move_spheres(...)       after the grains have moved
///   start_stage(velocity)   before the momentum predictor
///   force(velocity, dt)     on the predicted velocity
///   loads(dt)               then the pressure may be solved
template <class Real>
class ImmersedBoundary {
 public:
  /// `grid` and `slabs` must outlive this object.
  ImmersedBoundary(const Settings& settings, const Grid& grid, const Decomposition& slabs);

  /// All spheres of the run, the same list on every rank; fixed ones' weights are computed here,
  /// once. Throws UserError when a tag comes twice or a radius is not positive.
  void set_spheres(std::span<const SphereState> all);

  /// The mobile spheres as they are now: all that are near this rank's block; others may be among
  /// them. New ones may have come and old ones be gone; those that stay keep what is remembered of
  /// them, by tag, also where they change rank. Markers are found and weighed anew unless no mobile
  /// sphere of the run has moved. Throws UserError as set_spheres().
  void move_spheres(std::span<const SphereState> mobile);

  /// Takes the momentum inside the mobile spheres from the velocity before the predictor.
  void start_stage(const Field<Real>& velocity);

  /// This rank's planes from the lowest up to the highest that force() may read or change, on any
  /// rank: the velocity of those above need not be there yet.
  int planes_reached() const {
    // Where spheres belong to two ranks the higher one has work of its own to do meanwhile.
    return halo_.crosses_planes() ? slabs_.planes() : planes_reached_;
  }

  /// Adds the forcing of a stage of length `stage_step` [T] to the velocity (three components).
  /// Ghosts of ranks and of x are made valid near spheres, other ones, and those beyond walls, are
  /// neither used nor changed. With `measure` the slip that is left is measured, at half a loop's
  /// cost. Ranks wait only for neighbours that have spheres in common with them, unless a tolerance
  /// is set.
  void force(Field<Real>& velocity, double stage_step, bool measure = false);

  /// How often the mobile spheres' markers were found and weighed.
  int placings() const { return placings_; }
  /// Loops of the last forcing; the same on every rank.
  int loops() const { return given_.loops; }
  /// Force of this rank's markers on the fluid, mean over the last forcing's stage [M L/T^2]; their
  /// sum over the ranks is the report's.
  Vec3 force_on_fluid() const { return given_.by_mobile + given_.by_fixed; }
  /// Collective.
  ForcingReport report() const;

  /// Slip of any velocity field, for instance the projected one; only reads.
  Slip slip(const Field<Real>& velocity) const;

  /// Hydrodynamic force (buoyancy included) and torque on each mobile sphere whose centre lies in
  /// this rank's block, mean over the stage whose force() came last; ascending tags.
  std::vector<SphereLoad> loads(double stage_step);

  /// Of the mobile spheres whose centre lies in this rank's block, ascending tags.
  std::vector<SphereAccount> accounts() const;

  /// What is remembered of the mobile spheres between stages, complete on every rank, and the same
  /// put back after a restart; rows of `numbers_remembered`, the tag first. Spheres that are not
  /// named begin anew, tags that are no longer there are passed over. Collective.
  static constexpr std::size_t numbers_remembered = 17;
  std::vector<double> remembered() const;
  void set_remembered(std::span<const double> rows);

  const MarkerSeconds& seconds() const { return seconds_; }

 private:
  using Lists = std::array<MarkerList<Real>, 3>;
  /// A rank's share of a Slip.
  struct SlipSums {
    double max = 0.0, squares = 0.0, markers = 0.0;
  };
  /// What force() gave, this rank's share.
  struct Given {
    int loops = 0;
    SlipSums before, after;
    Vec3 by_mobile = Vec3::Zero(), by_fixed = Vec3::Zero();  ///< force on the fluid [M L/T^2]
  };
  /// Momentum inside a mobile sphere that its motion has not got yet, per fluid density; kept by
  /// the rank that holds its centre.
  struct Memory {
    InteriorMomentum forced;  ///< inside after the last forcing
    InteriorMomentum owed;
    Vec3 turn_due = Vec3::Zero();  ///< angular momentum on its way to the sphere [L^5/T]
    bool fresh = true;
  };
  /// What the ranks near a sphere add up for it.
  struct Share {
    std::array<InteriorSums, 3> before, after;
    std::array<double, 3> given{};  ///< velocity times cells
    std::array<double, 3> given_moment{};
  };
  struct Mobile {
    SphereState state;
    int home = 0;  ///< rank that holds its centre
    Memory memory;
    Share share;  ///< this rank's
  };
  /// By rank: indices of the spheres that are near both that rank and this one.
  using Partners = std::map<int, std::vector<int>>;

  bool set_mobile(std::span<const SphereState> all);
  bool all_stay(bool here) const;
  void hand_over_memories(std::vector<Mobile>& now) const;
  void find_partners();
  std::vector<Share> complete_shares() const;
  int layout_of(double radius);
  void place_fixed();
  void place_mobile();
  void find_planes_reached();
  std::span<const int> all_of(const MarkerList<Real>& list);
  void weigh_fixed();
  void find_near_mobile();
  void restore_near_mobile();
  void weigh_mobile();
  template <class Use>
  SlipSums local_slip(const Field<Real>& velocity, Use use) const;
  SlipSums find_changes(const Field<Real>& velocity);
  bool within_tolerance(double local_max) const;
  void sum_given(double stage_step);

  Grid grid_;
  const Decomposition& slabs_;
  BlockMap blocks_;
  double density_, retraction_, tolerance_;
  Vec3 gravity_;
  int most_loops_;

  std::vector<MarkerLayout> layouts_;  ///< one per radius
  std::unordered_map<double, std::size_t> layout_by_radius_;
  std::vector<SphereState> fixed_;  ///< near this rank's block
  std::uint64_t fixed_fingerprint_ = 0;
  std::vector<Mobile> mobile_;  ///< near this rank's block, ascending tags
  Partners homes_;              ///< where shares go to
  Partners guests_;             ///< where shares come from
  Lists fixed_lists_, mobile_lists_;
  InteriorCells interior_;  ///< of the mobile spheres, three components each
  std::array<std::vector<Real>, 3> fixed_row_sums_;  ///< of fixed markers among themselves
  std::optional<SphereBins> fixed_bins_;
  double largest_fixed_ = 0.0;                   ///< radius [L]
  std::array<std::vector<int>, 3> near_mobile_;  ///< fixed markers within reach of mobile ones
  MarkerHalo halo_;                              ///< rows of all spheres
  MarkerHalo mobile_halo_;                       ///< rows of mobile spheres
  std::vector<int> indices_;                     ///< 0, 1, 2, ...
  Field<Real> scratch_;  ///< planes up to the highest sphere; zero between calls
  int planes_reached_ = 0;
  int placings_ = 0;
  bool stage_started_ = false;
  Given given_;
  MarkerSeconds seconds_;
};

}  // namespace bedload
