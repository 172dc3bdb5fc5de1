#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "fluid/checkpoint/group.hpp"
#include "fluid/grid/block_map.hpp"
#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"
#include "fluid/grid/sphere.hpp"
#include "fluid/grid/sphere_bins.hpp"
#include "fluid/immersed_boundary/deferred_share.hpp"
#include "fluid/immersed_boundary/dispersion_correction.hpp"
#include "fluid/immersed_boundary/fluid_change.hpp"
#include "fluid/immersed_boundary/interior.hpp"
#include "fluid/immersed_boundary/marker_halo.hpp"
#include "fluid/immersed_boundary/marker_layout.hpp"
#include "fluid/immersed_boundary/marker_list.hpp"
#include "fluid/immersed_boundary/marker_sweep.hpp"
#include "fluid/immersed_boundary/rigid_core.hpp"
#include "fluid/immersed_boundary/sphere_memory.hpp"
#include "fluid/immersed_boundary/surfaces_beside.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {

/// Difference between the spheres' surface velocity and the fluid's at the markers [L/T].
struct Slip {
  double max = 0.0;  ///< largest of any component at any marker that has a volume
  double rms = 0.0;  ///< root of the mean over these of the squared slip vector
};

/// What the last call of force() did, over all ranks.
struct ForcingReport {
  int loops = 0;
  Slip before;  ///< of the predicted velocity, before the first loop
  Slip after;  ///< after the last loop; the last measured: `before` with one loop, unless asked for
  Vec3 force_on_fluid = Vec3::Zero();  ///< of all spheres, mean over the stage [M L/T^2]
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
/// the last forcing, less the impulse deferred. The momentum of fluid and spheres less
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
///   loads(dt, moves)        then the pressure may be solved
template <class Real>
class ImmersedBoundary {
 public:
  /// `grid` and `decomposition` must outlive this object.
  ImmersedBoundary(const Settings& settings, const Grid& grid, const Decomposition& decomposition);

  /// All spheres that are near this rank's block, others may be among them; fixed ones' weights are
  /// computed here, once. Throws UserError when a tag comes twice or a radius is not positive.
  void set_spheres(std::span<const SphereState> spheres);

  /// The mobile spheres as they are now: all that are near this rank's block; others may be among
  /// them. New ones may have come and old ones be gone; those that stay keep their restart data,
  /// by tag, also where they change rank. Markers are found anew unless no mobile sphere of the run
  /// has moved; they are weighed anew, for steps of the length `time_step` [T], where the next
  /// stage `begins_step` or a sphere is new or of another size, and keep their volumes to the end
  /// of the step otherwise. Throws UserError as set_spheres().
  void move_spheres(std::span<const SphereState> mobile, double time_step, bool begins_step = true);

  /// Takes the momentum inside the mobile spheres from the velocity before the predictor.
  void start_stage(const Field<Real>& velocity);

  /// What the markers' kept force (marker_force.hpp) gives to the velocity in a stage of length
  /// `stage_step` of a step of length `time_step` [T], for the right side of implicit diffusion:
  /// in planes_reached_here() of this rank's planes, zero above. Between start_stage() and force();
  /// to be cleared when it has been used.
  const Field<Real>& spread_kept_force(double stage_step, double time_step);
  void clear_kept_force();
  int planes_reached_here() const { return planes_reached_; }

  /// This rank's planes from the lowest up to the highest that force() may read or change, on any
  /// rank: the velocity of those above need not be there yet.
  int planes_reached() const {
    // Where spheres belong to two ranks the higher one has work of its own to do meanwhile.
    return halo_.crosses_planes() ? decomposition_.planes() : planes_reached_;
  }

  /// The box's planes from the lowest up to the highest that a force() may read or change, the same
  /// number on every rank.
  int highest_reached() const { return highest_reached_; }

  /// Share of each stage's pressure correction that the old pressure takes over, by the lightest
  /// mobile sphere on any rank, and by whether there is more than one.
  double pressure_share() const {
    return old_pressure_share(pressure_share_, lightest_density_, density_,
                              exchange_ == Exchange::stage, several_mobile_);
  }

  /// Adds the forcing of a stage of length `stage_step` [T] to the velocity (three components). The
  /// spheres' layers are carried along for `carry_time` [T] before: a whole step in its first
  /// stage, which begins_step in move_spheres(), 0 (not at all) in the others. Ghosts of ranks and
  /// of x are made valid near spheres, other ones, and those beyond walls, are neither used nor
  /// changed. With `measure` the slip that is left is measured, at half a loop's cost. Ranks wait
  /// only for neighbours that have spheres in common with them, unless a tolerance is set.
  void force(Field<Real>& velocity, double stage_step, double carry_time, bool measure = false);

  /// How often the mobile spheres' markers were found, and how often they were weighed.
  int placings() const { return placings_; }
  int weighings() const { return weighings_; }
  /// Layouts of markers that are kept, one per radius.
  std::size_t layouts() const { return layout_by_radius_.size(); }
  /// Loops of the last forcing; the same on every rank.
  int loops() const { return applied_.loops; }
  /// Force of this rank's markers and cores on the fluid, mean over the last forcing's stage
  /// [M L/T^2]; their sum over the ranks is the report's.
  Vec3 force_on_fluid() const { return applied_.by_mobile + applied_.by_fixed; }
  /// Collective.
  ForcingReport report() const;

  /// Slip of any velocity field, for instance the projected one; only reads.
  Slip slip(const Field<Real>& velocity) const;

  /// Hydrodynamic force (buoyancy included) and torque on each mobile sphere whose centre lies in
  /// this rank's block, mean over the stage whose force() came last; ascending tags. Spheres that
  /// move once per step get nothing in the stages without `spheres_move`, and the whole behind
  /// them.
  std::vector<SphereLoad> loads(double stage_step, bool spheres_move = true);

  /// Impulse on the fluid that this rank's part of each fixed sphere near its block has given
  /// since the last call [M L/T], in `force`.
  std::vector<SphereLoad> take_fixed_impulses();

  /// Of the mobile spheres whose centre lies in this rank's block, ascending tags.
  std::vector<SphereAccount> accounts() const;

  /// Restart data: what is kept of the mobile spheres between stages, each from the rank that holds
  /// its centre, the force that markers keep, each from the rank that handles it, and the same
  /// again on any number of ranks: each reads a share of the file, and the spheres go to those that
  /// ask for them. Spheres that are not named begin anew, tags that are no longer there are passed
  /// over. Collective.
  void save(const SaveGroup& group) const;
  void load(const LoadGroup& group);

  const MarkerSeconds& seconds() const { return seconds_; }

 private:
  using Lists = std::array<MarkerList<Real>, 3>;
  /// What force() gave, this rank's share.
  struct Applied {
    int loops = 0;
    SlipSums before, after;
    Vec3 by_mobile = Vec3::Zero(), by_fixed = Vec3::Zero();  ///< force on the fluid [M L/T^2]
  };
  /// What the ranks near a sphere add up for it.
  struct Share {
    std::array<InteriorSums, 3> before, after;
    std::array<double, 3> applied{};  ///< velocity times cells
    std::array<double, 3> applied_moment{};
  };
  struct Mobile {
    SphereState state;
    SphereState imposed;  ///< by its markers: with the excess spin
    int home = 0;         ///< rank that holds its centre
    SphereMemory memory;
    /// Of the markers, in cells, by component and place in the layout; on every rank that is near.
    std::array<std::vector<Real>, 3> volumes;
    std::array<std::vector<Real>, 3> kept_forces;  ///< likewise
    Share share;                                   ///< this rank's
    FluidChange given;                             ///< to this block by the last forcing
  };
  /// By rank: indices of the spheres that are near both that rank and this one.
  using Partners = std::map<int, std::vector<int>>;

  /// What is to be done about the mobile spheres' markers, the more the greater.
  enum class Change : int { none, place, weigh };
  /// Of the mobile spheres near this block, beside those before.
  struct Changes {
    bool moved = false;   ///< one came, went, or is in another place, bit for bit
    bool remade = false;  ///< one is new or of another size
  };
  Changes set_mobile(std::span<const SphereState> all);
  Change most_of_all(Change here);
  double share_in_steps_of(double time_step) const;
  bool goes_on(const SphereState& before, const SphereState& now) const;
  void hand_over_memories(std::vector<Mobile>& now) const;
  bool keep_by_marker(std::vector<Mobile>& now);
  void find_partners();
  std::vector<Share> complete_shares() const;
  double reaction_share(const SphereState& sphere) const;
  void share_excess_spins();
  int layout_of(double radius);
  void drop_layouts();
  void place_fixed();
  double largest_mobile() const;
  void find_order();
  void find_neighbours();
  /// Of the sphere at `place` in order_.
  std::span<const SphereNeighbour> neighbours(std::size_t place) const {
    return std::span(neighbours_)
        .subspan(first_neighbour_[place], first_neighbour_[place + 1] - first_neighbour_[place]);
  }
  void place_mobile(bool weighed);
  int highest_reached_here() const;
  void find_planes_reached();
  std::span<const int> all_of(const MarkerList<Real>& list);
  void weigh_fixed();
  void find_near_mobile();
  void restore_near_mobile();
  void weigh_mobile();
  void weaken_beside_others();
  using ByMarker = std::array<std::vector<Real>, 3>;
  void share_by_marker(ByMarker Mobile::*numbers, std::vector<Real> MarkerList<Real>::*found);
  void take_by_marker(const MarkerList<Real>& list, std::size_t component,
                      ByMarker Mobile::*numbers, std::vector<Real>& here, Real unknown) const;
  void share_volumes();
  void use_volumes();
  void keep_increments();
  void share_kept_forces();
  void use_kept_forces();
  void save_kept_forces(const SaveGroup& group) const;
  void load_kept_forces(const LoadGroup& group);
  template <class Use>
  SlipSums local_slip(const Field<Real>& velocity, Use use) const;
  SlipSums find_increments(const Field<Real>& velocity);
  void spread_all(Field<Real>& velocity);
  bool within_tolerance(double local_max) const;
  /// Radius of a sphere's rigid core [L].
  double core_of(double radius) const {
    return rigid_core_ ? core_radius(radius / grid_.h) * grid_.h : 0.0;
  }
  void carry_cores(Field<Real>& velocity);
  void correct_dispersion(Field<Real>& velocity, double carry_time);
  void sum_applied(double stage_step);

  Grid grid_;
  const Decomposition& decomposition_;
  BlockMap blocks_;
  double density_, retraction_, marker_density_, tolerance_;
  double viscosity_;                                                         ///< kinematic
  double deferred_impulse_share_, deferred_angular_share_, pressure_share_;  ///< settings
  Vec3 gravity_;
  std::vector<BoxEnd> ends_;  ///< those that are not periodic
  Exchange exchange_;
  int most_loops_;
  bool interior_term_;  ///< in the loads of the mobile spheres
  bool rigid_core_;
  bool keeps_force_;              ///< the markers, for implicit diffusion
  double kept_force_gain_ = 0.0;  ///< of the present step [1/T]

  std::vector<MarkerLayout> layouts_;  ///< one per radius
  std::unordered_map<double, std::size_t> layout_by_radius_;
  std::vector<std::size_t> free_layouts_;  ///< places in layouts_
  std::size_t most_layouts_ = 64;          ///< before those of no sphere are dropped
  std::vector<SphereState> fixed_;         ///< near this rank's block
  std::vector<Vec3> fixed_impulse_;        ///< they gave to the fluid since last taken [M L/T]
  std::vector<FluidChange> fixed_given_;   ///< to this block by the last forcing
  std::uint64_t fixed_fingerprint_ = 0;
  std::vector<Mobile> mobile_;  ///< near this rank's block, ascending tags
  Partners homes_;              ///< where shares go to
  Partners guests_;             ///< where shares come from
  Lists fixed_lists_, mobile_lists_;
  /// The mobile spheres in the order in which what lies around them is taken, neighbours in the box
  /// one soon after the other, so that what they share is still in the caches. Tags tell nothing of
  /// places once grains have moved.
  std::vector<std::size_t> order_;
  DispersionCorrection<Real> dispersion_;     ///< around the mobile spheres, in this order
  std::vector<SphereNeighbour> neighbours_;   ///< of the mobile spheres, in this order
  std::vector<std::size_t> first_neighbour_;  ///< of each, and the end
  InteriorCells interior_;  ///< of the mobile spheres, in this order, three components each
  std::array<std::vector<Real>, 3> fixed_row_sums_;  ///< of fixed markers among themselves
  std::optional<SphereBins> fixed_bins_;
  double largest_fixed_ = 0.0;                   ///< radius [L]
  std::array<std::vector<int>, 3> near_mobile_;  ///< fixed markers within reach of mobile ones
  std::array<std::vector<Real>, 3> kept_beside_mobile_;  ///< share of their volume, volume_beside()
  MarkerHalo halo_;                                      ///< rows of all spheres
  MarkerHalo mobile_halo_;                               ///< rows of mobile spheres
  std::vector<int> indices_;                             ///< 0, 1, 2, ...
  Field<Real> scratch_;  ///< planes up to the highest sphere; zero between calls
  int planes_reached_ = 0, highest_reached_ = 0;
  double lightest_density_ = 0.0;  ///< of the mobile spheres on any rank; 0: none is known
  bool several_mobile_ = false;    ///< mobile spheres on all ranks together
  int placings_ = 0, weighings_ = 0;
  bool weighed_here_ = true;  ///< the mobile spheres' markers, where these are now
  double share_at_pores_;     ///< with which they are weighed
  bool stage_started_ = false;
  Applied applied_;
  MarkerSeconds seconds_;
};

}  // namespace bedload
