#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "fix.h"
#include "liggghts_styles/contact_observers.hpp"
#include "liggghts_styles/film_system.hpp"
#include "liggghts_styles/fix_marker_film.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/formulas/lubrication.hpp"
#include "liggghts_styles/keywords.hpp"
#include "liggghts_styles/mobility.hpp"
#include "liggghts_styles/tangential_films.hpp"

namespace LAMMPS_NS {
class FixPropertyAtom;
}

namespace bedload {

/// Lubrication between spheres of the group, and between them and walls of fix wall/gran. Formulas
/// in formulas/lubrication.hpp and tangential_lubrication.hpp; user page doc/fix_lubrication.md.
///
/// The contact models of our pair styles and walls hand over the surfaces that are in range (they
/// meet them anyway, so no search is made here). The force is applied at the end of the step, when
/// all other forces are known, because a stiff film has to answer to them, those of the other films
/// of its spheres included: the films of a step are solved for together (conjugate gradients over
/// all ranks, from the forces that the films would have alone). What the films do to sliding and
/// rolling is no stiffer than the logarithm of the gap and is computed from the velocities alone.
class FixLubrication : public LAMMPS_NS::Fix {
 public:
  static constexpr NumberKeyword keywords[] = {
      {"viscosity", 0, false, no_limit, 0, "from fix couple/fluid or the property fluidViscosity",
       "M/(L T)", "Dynamic viscosity of the fluid."},
      {"range", 0, true, no_limit, 0, "0: 2 h, from fix couple/fluid or the property fluidCellSize",
       "L", "Largest gap with a film."},
      {"gapMin", 0, false, 1, 0, "0.001; with law published 0.003", "radii of the smaller sphere",
       "Smallest gap in the formula."}};
  static constexpr WordKeyword words[] = {
      {"law", "unresolved where a cell size h is known, else published",
       "unresolved: what a fluid grid of spacing h lacks of the film; published: the whole film."},
      {"tangential", "on with law unresolved, else off",
       "on: also what the grid lacks of the film's force and torques against sliding and rolling "
       "(law unresolved)."}};
  static constexpr StyleHelp help{
      "fix lubrication",
      "Lubrication between spheres that do not touch, and between them and walls of fix "
      "wall/gran.",
      "fix ID group lubrication [keyword value ...]", keywords, words};

  FixLubrication(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixLubrication() override;

  int setmask() override;
  void post_create() override;
  void pre_delete(bool unfix) override;
  void init() override;
  void setup_pre_force(int) override;
  void pre_force(int) override;
  void pre_neighbor() override { stale_ = loads_stale_ = true; }
  void setup(int) override;
  void pre_final_integrate() override;
  void* extract(const char* name, int& dimension) override;

  int pack_comm(int count, int* list, double* buffer, int, int*) override;
  void unpack_comm(int count, int first, double* buffer) override;

  /// Called by the contact models of pairs and walls before a run: settles range and viscosity.
  /// @param wall fix of the wall; none: the pairs
  void prepare(const LAMMPS_NS::Fix* wall);

  /// What the fluid's box has where a wall of the script stands; no_slip without a fluid, too.
  enum class End { none, no_slip, free_slip };

  /// Two surfaces in range, as a contact model meets them.
  struct Surfaces {
    int i, j;                                 ///< local indices; j = -1: a wall
    double gap;                               ///< below 0 in overlap [m]
    double effective_radius, smaller_radius;  ///< [m]
    const double* normal;                     ///< unit vector towards i
    const double* wall_velocity;              ///< [m/s]; nullptr for a pair
    bool colliding;                           ///< in a collision, which is stretched
    bool enduring;                            ///< in a contact that is no collision
    double weight = 0;          ///< w of a collision (formulas/collision_in_fluid.hpp)
    double speed = 0;           ///< at the touch [m/s]
    double load = 0;            ///< load_acceleration when it began [m/s²]
    double collision_time = 0;  ///< T_c [s]
    /// Of a wall, and none where the fluid does not have both surfaces; add() finds it.
    End end = End::no_slip;
    /// Whether surface j is the image of i behind a free-slip end.
    bool mirrored() const { return end == End::free_slip; }
  };
  void add(const Surfaces& s);

  /// Whether there is a grid that resolves films, and the fluid's loads are known.
  bool knows_loads() const {
    return cell_size_ > 0 && fluid_force_ != nullptr && loads_received_.live();
  }

  /// n·(L_i/m_i - L_j/m_j), L the fluid's load on a sphere; j = -1: a wall [m/s²].
  double load_acceleration(int i, int j, const double* normal) const;

  /// Whether films act against sliding and rolling, too, where there is a grid.
  bool tangential() const {
    return tangential_setting_.empty() ? law_ != "published" : tangential_setting_ == "on";
  }

  /// Ends the run where another fix holds spheres of this one to a plane or a speed. Collective.
  void refuse_projected_spheres() const;

  /// Whether surfaces whose distance squared is `rsq` are in range; `touch` is the distance at
  /// which they would touch.
  bool reaches(double rsq, double touch) const {
    const double reach = touch + range_;
    return rsq <= reach * reach;
  }

 private:
  using Vector = contact::Vector3;
  enum class Sending { accelerations, film_accelerations, rates, loads, borne };

  struct Film {
    int i, j;
    double coefficient;  // c [kg/s]
    Vector normal, wall_velocity;
    double compliance;  // D_k [1/kg], see formulas/lubrication.hpp
    double share;       // 1/2 where another rank (or image) holds the same film, else 1
    double force;       // mean over the step [N]
    double borne;       // what a collision bears of the fluid's load [N]
    bool bears;         // whether it may bear some
  };
  /// In applied_: in how many collisions a sphere was that bear its load.
  static constexpr int borne_column = 7;
  bool sends_one() const { return sending_ == Sending::rates || sending_ == Sending::borne; }
  void send(Sending what);
  Vector sent(int i) const;
  void prepare_tangential();
  void add_tangential(const Surfaces& s);
  contact::SlideAndRoll missing_logarithms(const Surfaces& s) const;
  bool in_fluid(const Surfaces& s) const;
  void apply_tangential();
  double opening_speed(const Film& film) const;
  void apply(const std::vector<Film>& films);
  double inverse_mass(int i) const;
  double inverse_mass(const Film& film) const;
  double films_here() const;
  void tell_range() const;
  void forget();
  double touching(const Surfaces& s, double opening) const;
  End end_at(const Surfaces& s) const;
  double coefficient(const Surfaces& s, double opening) const;
  double damping_in_collision(const Surfaces& s) const;
  double share_of_load(const Surfaces& s) const;
  void solve_alone();
  void solve_together();
  double relative(const Film& film) const;
  void sum_over_ranks(std::span<double> numbers) const;

  std::string law_;
  std::string tangential_setting_;
  bool tangential_on_ = false;
  double viscosity_setting_ = 0, range_setting_ = 0, smallest_gap_setting_ = 0;
  double smallest_gap_ = 0;  // radii
  double viscosity_now_ = 0, range_ = 0;
  double cell_size_ = 0;            // of the grid that resolves a part of the films; 0: none does
  FluidValue fluid_cell_;           // live: there is a fluid, whose box ends where LIGGGHTS' does
  std::span<const FluidEnd> ends_;  // of its box
  FluidValue viscosity_;
  Mobility mobility_;
  ContactObservers contact_observers_;
  std::vector<Film> films_;
  std::vector<Film> collisions_;  // what the grid resolves and should not, or the contact bears
  TangentialFilms tangential_;
  FilmSystem system_;                     // films_, solved for together
  std::vector<Vector> accelerations_;     // by all but films, of local and ghost spheres [m/s²]
  FixMarkerFilm* marker_film_ = nullptr;  // of fix couple/fluid
  ImpulseOnWalls* on_walls_ = nullptr;
  LAMMPS_NS::FixPropertyAtom* fluid_force_ = nullptr;  // of it, too
  FluidValue fluid_density_, fluid_step_, loads_received_;
  FluidDiffusion diffusion_;
  double diffusion_number_ = contact::usual_diffusion_number;  // in this step, and
  contact::UnresolvedShare of_pair_ = contact::unresolved_of_pair(diffusion_number_);
  contact::UnresolvedShare at_wall_ = contact::unresolved_at_wall(diffusion_number_);
  std::vector<Vector> loads_;  // accelerations of local and ghost spheres by the fluid [m/s²]
  std::vector<double> borne_;  // of local and ghost spheres, borne_column() when loads_ was made
  double loads_known_ = 0;     // loads_received_ when loads_ was made
  bool loads_stale_ = true;
  Sending sending_ = Sending::accelerations;  // what pack_comm sends
  bool films_somewhere_ = false;              // on some rank, in the last step that has asked
  bool stale_ = true;  // lubricationForce holds something that is not of this step
  LAMMPS_NS::FixPropertyAtom* applied_ = nullptr;
};

/// The one of the script; nullptr without.
FixLubrication* find_lubrication(LAMMPS_NS::LAMMPS* lmp);

}  // namespace bedload
