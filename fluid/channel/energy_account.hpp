#pragma once

#include <limits>

#include "fluid/grid/decomposition.hpp"
#include "fluid/grid/field.hpp"
#include "fluid/grid/grid.hpp"

namespace bedload {

/// Mean power per mass of the box in a step [L^2/T^3]; not a number where it is not followed.
struct EnergyWork {
  double forcing = std::numeric_limits<double>::quiet_NaN();     ///< of what acts between predictor
                                                                 ///< and projection
  double viscous = std::numeric_limits<double>::quiet_NaN();     ///< of explicit diffusion
  double convective = std::numeric_limits<double>::quiet_NaN();  ///< zero but for the time scheme
};

/// Who gives kinetic energy to the flow and who takes it. A stage changes u by a sum of parts,
///
///   u_k+1 - u_k = dt (gamma N(u_k) + zeta N(u_k-1)) + dt nu (gamma L u_k + zeta L u_k-1) + kick
///                 + driving - grad(...),
///
/// and the energy by each of them times the mean of both ends, (u_k + u_k+1)/2: exactly, so that no
/// product of two parts is left over that would belong to neither. Gradients of pressure, old and
/// new, do no work then, for both ends are free of divergence. Convection does none where it is
/// taken at the same velocity that it acts on. It is taken at u_k and u_k-1: in a smooth motion its
/// work vanishes at least as fast as dt^2 (dt^3 where nothing else acts), but only as dt where u
/// goes to and fro between the stages, as it does beside markers, whose slip is made anew in each.
template <class Real>
class EnergyAccount {
 public:
  EnergyAccount(const Grid& grid, const Decomposition& decomposition);

  /// In the order of a stage, each with the velocity as it is then. At the begin and the end of a
  /// stage all ghosts are valid. Between predicted() and forced() lies what counts as forcing;
  /// where nothing does, both may be left out.
  void begin_stage(const Field<Real>& velocity, int stage);
  void predicted(const Field<Real>& velocity);
  void forced(const Field<Real>& velocity);
  /// Collective. Convection does no work where it is off. With implicit diffusion its work is not
  /// followed, nor that of the forcing, a part of which stands in its equation
  /// (immersed_boundary/marker_force.hpp).
  void end_stage(const Field<Real>& velocity, int stage, double dt, const Settings::Fluid& fluid,
                 bool implicit);

  /// Of the last step.
  const EnergyWork& work() const { return work_; }

 private:
  const Grid& grid_;
  const Decomposition& decomposition_;
  Field<Real> before_, earlier_;  ///< at the begin of this stage and of the one before
  Field<Real> kick_;              ///< what forcing added; then the mean of both ends
  bool forced_ = false;
  EnergyWork work_;
};

}  // namespace bedload
