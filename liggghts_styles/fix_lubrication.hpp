#pragma once

#include <array>
#include <vector>

#include "fix.h"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/mobility.hpp"

namespace LAMMPS_NS {
class FixPropertyAtom;
}

namespace bedload {

/// fix ID group lubrication [viscosity μ] [range δ] [gapMin a]
///
/// Lubrication between spheres of the group, and between them and walls of fix wall/gran. Formula
/// in formulas/lubrication.hpp; user page doc/fix_lubrication.md.
///
/// The contact models of our pair styles and walls hand over the surfaces that are in range (they
/// meet them anyway, so no search is made here). The force is applied at the end of the step, when
/// all other forces are known, because a stiff lubrication film has to answer to them.
class FixLubrication : public LAMMPS_NS::Fix {
 public:
  FixLubrication(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg);
  ~FixLubrication() override;

  int setmask() override;
  void post_create() override;
  void pre_delete(bool unfix) override;
  void init() override;
  void setup_pre_force(int) override { films_.clear(); }
  void pre_force(int) override { films_.clear(); }
  void setup(int) override;
  void pre_final_integrate() override;
  void* extract(const char* name, int& dimension) override;

  int pack_comm(int count, int* list, double* buffer, int, int*) override;
  void unpack_comm(int count, int first, double* buffer) override;

  /// Called by the contact models of pairs and walls before a run: settles range and viscosity.
  void prepare();

  /// Surfaces that do not touch, `gap` apart. @param j other sphere (local index), -1 for a wall
  /// @param normal unit vector towards i  @param wall_velocity velocity of the wall [m/s]
  void add(int i, int j, double gap, double effective_radius, double smaller_radius,
           const double* normal, const double* wall_velocity);

  double range() const { return range_; }

 private:
  struct Film {
    int i, j;
    double coefficient;  // c [kg/s]
    std::array<double, 3> normal, wall_velocity;
  };
  /// Of a sphere: sum of its films' c [kg/s], acceleration by all other forces [m/s²].
  using Load = std::array<double, 4>;

  double inverse_mass(int i) const;
  void load_spheres();

  double viscosity_setting_ = 0, range_setting_ = 0, smallest_gap_ = 3e-3, unresolved_ = 0;
  double viscosity_now_ = 0, range_ = 0;
  FluidValue viscosity_;
  Mobility mobility_;
  bool used_by_pairs_ = false;
  std::vector<Film> films_;
  std::vector<Load> loads_;
  LAMMPS_NS::FixPropertyAtom* applied_ = nullptr;
};

}  // namespace bedload
