#pragma once

#include <span>

#include "fix.h"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/tangential_films.hpp"

namespace bedload {

/// What markers that stand back from the cells that two spheres share, or a sphere and a wall of
/// the fluid, leave of its resistance to sliding and rolling (fluid/immersed_boundary/README.md,
/// "Surfaces in the same cells"): between the spheres of the group, at their images behind
/// free-slip ends and at no-slip ends of the box, with any contact model, in contact, too. It
/// belongs to the fluid's force and not to a model's film: fix couple/fluid makes this fix and
/// calls it with its own loads; no script needs to.
///
/// Formulas: contact::logarithms_left_by_markers, contact::left_by_markers_at_wall. Per-atom
/// values: f_couple_film[1..3] force, [4..6] torque, mean over the DEM step, which fix couple/fluid
/// keeps.
class FixMarkerFilm : public LAMMPS_NS::Fix {
 public:
  static constexpr const char* style_name = "marker/film";

  FixMarkerFilm(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixMarkerFilm() override;

  int setmask() override;
  void init() override;
  void setup_pre_force(int) override { pre_force(0); }
  void pre_force(int) override;
  int pack_comm(int count, int* list, double* buffer, int, int*) override;
  void unpack_comm(int count, int first, double* buffer) override;

  /// Adds forces and torques to those of the spheres, and notes them.
  /// @param loads of the local spheres, six numbers each
  void act(double** loads);

  /// Called by the pairs' contact models before a run.
  void prepare();

  /// Whether markers of both spheres can have stood back from each other.
  /// @param rsq distance of the centres squared  @param touch that at which they would touch
  bool reaches(int i, int j, double rsq, double touch) const {
    const double far = touch + reach_;
    return rsq <= far * far && both_in_fluid(i, j);
  }

  /// Two spheres that reaches() holds for, as a contact model meets them.
  /// @param gap below 0 in overlap [m]  @param normal unit vector towards i
  void add(int i, int j, double gap, const double* normal);

  /// Λ that it gives to two spheres in the fluid, or to one and its image, with `gap` [m] between
  /// them.
  contact::SlideAndRoll logarithms(double gap) const;
  /// What it gives to a sphere in the fluid of that radius [m] at a no-slip end.
  contact::LeftAtWall left_at_wall(double gap, double radius) const;

  bool in_fluid(int i) const { return (atom->mask[i] & groupbit) != 0; }
  bool both_in_fluid(int i, int j) const { return in_fluid(i) && in_fluid(j); }

 private:
  void add_ends();
  void add_image(int i, const contact::Vector3& normal, double gap);
  void add_wall(int i, const contact::Vector3& normal, double gap,
                const contact::Vector3& velocity);

  TangentialFilms films_;
  Mobility mobility_;
  FluidValue viscosity_, cell_;
  FluidDiffusion diffusion_;
  double diffusion_number_ = contact::usual_diffusion_number;  ///< λ in this step
  std::span<const FluidEnd> ends_;                             ///< of the fluid's box
  ImpulseOnWalls* on_walls_ = nullptr;
  double reach_ = 0;  ///< widest gap [m]
  bool pairs_told_ = false;
};

/// The one of the coupling; nullptr without a fluid.
FixMarkerFilm* find_marker_film(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
