#include <gmock/gmock.h>

#include <cmath>

#include "fluid/validation/derived_numbers.hpp"

namespace bedload {
namespace {

/// Setup II of the paper: H/D = 9, D/h = 20, rho_p/rho_f = 1.2, Re_b = 3010; in units in which none
/// of u_b = 2, H = 3 and rho_f = 5 is one, so that a missing factor shows.
Settings setup_two() {
  Settings s;
  s.grid.cells = {1040, 180, 540};
  s.grid.length = {52.0 / 3.0, 3.0, 27.0 / 3.0};
  s.fluid.density = 5.0;
  s.fluid.kinematic_viscosity = 2.0 * 3.0 / 3010.0;
  s.fluid.gravity = {0.0, -13.2, 0.0};  // Fr = 0.2 * 13.2 * 3 / 2^2 = 1.98
  s.time.step = 0.003;
  s.reference.velocity = 2.0;
  s.reference.height = 3.0;
  s.reference.diameter = 1.0 / 3.0;
  s.reference.sphere_density = 6.0;
  return s;
}

TEST(DerivedNumbers, AreThoseOfSetupTwo) {
  // Re_tau = 219 as printed: u_tau = 219/3010 = 0.0727575 u_b = 0.145515, and the force that drives
  // it.
  Settings s = setup_two();
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 5.0 * std::pow(2.0 * 219.0 / 3010.0, 2) / 3.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_NEAR(n.reynolds_bulk, 3010.0, 1e-9);
  EXPECT_NEAR(n.friction->reynolds, 219.0, 1e-9);
  EXPECT_NEAR(n.cells_per_diameter, 20.0, 1e-9);
  EXPECT_NEAR(*n.density_ratio, 1.2, 1e-12);
  EXPECT_NEAR(*n.froude, 1.98, 1e-9);
  // 0.145515^2 / (0.2 * 13.2 / 3) = 0.0211746 / 0.88 = 0.024062; printed 0.024.
  EXPECT_NEAR(*n.shields, 0.024062, 1e-6);
  // 219/9 = 24.33 and a twentieth of it; the paper prints 25 and 1.25, rounded: 3 %.
  EXPECT_NEAR(n.friction->diameter_wall_units, 219.0 / 9.0, 1e-9);
  EXPECT_NEAR(n.friction->diameter_wall_units, 25.0, 0.03 * 25.0);
  EXPECT_NEAR(n.friction->cell_wall_units, 219.0 / 180.0, 1e-9);
  EXPECT_NEAR(n.cfl_at_start, 2.0 * 0.003 * 60.0, 1e-12);
  EXPECT_NEAR(n.diffusion, 6.0 / 3010.0 * 0.003 * 60.0 * 60.0, 1e-12);
  EXPECT_EQ(n.friction.value().source, FrictionSource::driving);
}

/// Moser, Kim & Mansour: Re_tau = 180 at a bulk Reynolds number of 5600 over two half heights, that
/// is u_b H / nu = 2800. Dean's law is a fit to within a few percent.
TEST(DerivedNumbers, EstimateTheFrictionOfASmoothWall) {
  Settings s = setup_two();
  s.flow.driving = Driving::bulk_velocity;
  s.fluid.kinematic_viscosity = 2.0 * 3.0 / 2800.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_EQ(n.friction.value().source, FrictionSource::smooth_wall);
  EXPECT_NEAR(n.friction->reynolds, 180.0, 0.03 * 180.0);
}

TEST(DerivedNumbers, TakeTheFrictionFromAConstantDrivingForce) {
  Settings s = setup_two();
  s.fluid.density = 2.0;
  s.reference.height = 0.5;
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.16;
  EXPECT_NEAR(derive_numbers(s).friction.value().u_tau, 0.2, 1e-14);  // sqrt(0.16 * 0.5 / 2)
}

/// Side walls bear a part of the driving that is not known before the run.
TEST(DerivedNumbers, KnowNoFrictionBetweenSideWalls) {
  Settings s = setup_two();
  for (const Driving driving : {Driving::bulk_velocity, Driving::pressure_gradient}) {
    s.flow.driving = driving;
    s.flow.pressure_gradient = 0.16;
    s.boundary.z = {Wall::periodic, Wall::periodic};
    EXPECT_TRUE(derive_numbers(s).friction);
    s.boundary.z = {Wall::no_slip, Wall::free_slip};
    EXPECT_FALSE(derive_numbers(s).friction || derive_numbers(s).shields);
  }
}

/// At Re_b = 10 Dean's law would give a seventeenth of the stress.
TEST(DerivedNumbers, KnowLaminarFlow) {
  Settings s = setup_two();
  s.flow.driving = Driving::bulk_velocity;
  s.fluid.kinematic_viscosity = 0.6;
  EXPECT_EQ(derive_numbers(s).friction.value().source, FrictionSource::laminar);
  EXPECT_NEAR(derive_numbers(s).friction->u_tau, std::sqrt(1.2), 1e-14);  // 3 * 0.6 * 2/3
  s.boundary.y = {Wall::no_slip, Wall::no_slip};
  EXPECT_NEAR(derive_numbers(s).friction->u_tau, std::sqrt(2.4), 1e-14);
  EXPECT_NEAR(*derive_numbers(s).shields, 2.4 / 0.88, 1e-12);
  // Walls that slide, 3 apart.
  s.flow.driving = Driving::none;
  s.boundary.y_lower_velocity = {-2.5, 0.0, 0.0};
  s.boundary.y_upper_velocity = {0.5, 0.0, 4.0};
  EXPECT_EQ(derive_numbers(s).friction.value().source, FrictionSource::laminar);
  EXPECT_NEAR(derive_numbers(s).friction->u_tau, 1.0, 1e-14);  // sqrt(0.6 * 5/3)
}

/// Each of two walls bears half of what drives the flow between them, and reference.height may be
/// their distance or half of it: Poiseuille flow has u_tau^2 = G L/(2 rho) = 6 nu u/L.
TEST(DerivedNumbers, ShareTheDrivingForceBetweenTwoWalls) {
  Settings s;
  s.grid.cells = {16, 24, 16};
  s.grid.length = {2.0, 3.0, 2.0};
  s.boundary.y = {Wall::no_slip, Wall::no_slip};
  s.fluid.density = 2.0;
  s.fluid.kinematic_viscosity = 0.1;
  s.flow.pressure_gradient = 12.0 * 2.0 * 0.1 / 9.0;  // 12 rho nu u/L^2
  for (const double height : {3.0, 1.5}) {
    s.reference.height = height;
    for (const Driving driving : {Driving::bulk_velocity, Driving::pressure_gradient}) {
      s.flow.driving = driving;
      EXPECT_NEAR(derive_numbers(s).friction.value().u_tau, std::sqrt(0.2), 1e-14) << height;
    }
  }
  // A bed fills the box up to 15.45: 7.05 of the depth are left, and its top is known by 15.5.
  s.grid.length[1] = 22.5;
  s.start.height = 15.5;
  s.reference.height = 7.05;
  EXPECT_NEAR(s.driven_height(), 3.525, 1e-14);
  s.reference.height = 3.525;
  EXPECT_NEAR(s.driven_height(), 3.525, 1e-14);
  s.boundary.y[1] = Wall::free_slip;
  s.reference.height = 7.05;
  EXPECT_NEAR(s.driven_height(), 7.05, 1e-14);
}

/// Of Dean's law the height is half of the walls' distance, whichever of both the scene gives.
TEST(DerivedNumbers, TakeHalfOfTheDistanceForTurbulentFlowBetweenWalls) {
  Settings s = setup_two();
  s.boundary.y = {Wall::no_slip, Wall::no_slip};
  s.flow.driving = Driving::bulk_velocity;
  s.fluid.kinematic_viscosity = 2.0 * 1.5 / 2800.0;
  for (const double height : {3.0, 1.5}) {
    s.reference.height = height;
    EXPECT_EQ(derive_numbers(s).friction.value().source, FrictionSource::smooth_wall);
    EXPECT_NEAR(derive_numbers(s).friction->u_tau / 2.0, 180.0 / 2800.0, 0.03 * 180.0 / 2800.0);
  }
}

/// Nothing drives, or no wall holds back: neither friction nor a Shields number.
TEST(DerivedNumbers, KnowNoFrictionWithoutAWallOrAFlow) {
  Settings s = setup_two();
  EXPECT_FALSE(derive_numbers(s).friction || derive_numbers(s).shields);
  s.flow.driving = Driving::bulk_velocity;
  EXPECT_TRUE(derive_numbers(s).friction && derive_numbers(s).shields);
  s.boundary.y = {Wall::periodic, Wall::periodic};
  EXPECT_FALSE(derive_numbers(s).friction || derive_numbers(s).shields);
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 1.0;
  EXPECT_FALSE(derive_numbers(s).friction || derive_numbers(s).shields);
}

TEST(DerivedNumbers, LeaveOutWhatDoesNotApply) {
  Settings s = setup_two();
  s.flow.driving = Driving::bulk_velocity;
  s.reference.sphere_density = 0.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_FALSE(n.froude || n.shields || n.density_ratio);
  s.reference.sphere_density = 6.0;
  s.fluid.gravity = {};
  EXPECT_FALSE(derive_numbers(s).froude);
}

}  // namespace
}  // namespace bedload
