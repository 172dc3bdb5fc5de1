#include <gmock/gmock.h>

#include <cstdlib>

#include "fluid/output/checksum.hpp"
#include "fluid/output/derived_numbers.hpp"
#include "fluid/output/effects_table.hpp"
#include "fluid/output/progress.hpp"
#include "fluid/output/timing.hpp"
#include "test_output_helpers.hpp"

namespace bedload::test {
namespace {

using testing::HasSubstr;

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

TEST(OutputDerivedNumbers, AreThoseOfSetupTwo) {
  // Re_tau = 219 as printed: u_tau = 219/3010 = 0.0727575 u_b = 0.145515, and the force that drives
  // it.
  Settings s = setup_two();
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 5.0 * std::pow(2.0 * 219.0 / 3010.0, 2) / 3.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_NEAR(n.reynolds_bulk, 3010.0, 1e-9);
  EXPECT_NEAR(n.reynolds_friction, 219.0, 1e-9);
  EXPECT_NEAR(n.cells_per_diameter, 20.0, 1e-9);
  EXPECT_NEAR(*n.density_ratio, 1.2, 1e-12);
  EXPECT_NEAR(*n.froude, 1.98, 1e-9);
  // 0.145515^2 / (0.2 * 13.2 / 3) = 0.0211746 / 0.88 = 0.024062; printed 0.024.
  EXPECT_NEAR(*n.shields, 0.024062, 1e-6);
  // 219/9 = 24.33 and a twentieth of it; the paper prints 25 and 1.25, rounded: 3 %.
  EXPECT_NEAR(n.diameter_wall_units, 219.0 / 9.0, 1e-9);
  EXPECT_NEAR(n.diameter_wall_units, 25.0, 0.03 * 25.0);
  EXPECT_NEAR(n.cell_wall_units, 219.0 / 180.0, 1e-9);
  EXPECT_NEAR(n.cfl_at_start, 2.0 * 0.003 * 60.0, 1e-12);
  EXPECT_NEAR(n.diffusion, 6.0 / 3010.0 * 0.003 * 60.0 * 60.0, 1e-12);
  EXPECT_EQ(n.u_tau_source, FrictionSource::driving);
}

/// Moser, Kim & Mansour: Re_tau = 180 at a bulk Reynolds number of 5600 over two half heights, that
/// is u_b H / nu = 2800. Dean's law is a fit to within a few percent.
TEST(OutputDerivedNumbers, EstimateTheFrictionOfASmoothWall) {
  Settings s = setup_two();
  s.fluid.kinematic_viscosity = 2.0 * 3.0 / 2800.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_EQ(n.u_tau_source, FrictionSource::smooth_wall);
  EXPECT_NEAR(n.reynolds_friction, 180.0, 0.03 * 180.0);
}

TEST(OutputDerivedNumbers, TakeTheFrictionFromAConstantDrivingForce) {
  Settings s = setup_two();
  s.fluid.density = 2.0;
  s.reference.height = 0.5;
  s.flow.driving = Driving::pressure_gradient;
  s.flow.pressure_gradient = 0.16;
  EXPECT_NEAR(derive_numbers(s).u_tau, 0.2, 1e-14);  // sqrt(0.16 * 0.5 / 2)
}

TEST(OutputDerivedNumbers, LeaveOutWhatDoesNotApply) {
  Settings s = setup_two();
  s.reference.sphere_density = 0.0;
  const DerivedNumbers n = derive_numbers(s);
  EXPECT_FALSE(n.froude || n.shields || n.density_ratio);
  s.reference.sphere_density = 6.0;
  s.fluid.gravity = {};
  EXPECT_FALSE(derive_numbers(s).froude);
}

TEST(OutputChecksum, SeesExchangedAndAddedWords) {
  const auto sum = [](std::uint64_t a, std::uint64_t b) {
    return checksum_term(a, 0) + checksum_term(b, 1);
  };
  EXPECT_NE(sum(1, 2), sum(2, 1));
  EXPECT_NE(sum(0, 0), checksum_term(0, 0));
  const Folder folder;
  if (world_rank() == 0) std::ofstream(folder / "f") << std::string(1000, 'a') << "0123456789abc";
  MPI_Barrier(MPI_COMM_WORLD);
  const std::uint64_t together = file_checksum(folder / "f", 5, MPI_COMM_WORLD);
  EXPECT_EQ(together, file_checksum(folder / "f", 5, MPI_COMM_SELF));
  EXPECT_NE(together, file_checksum(folder / "f", 4, MPI_COMM_SELF));
}

void wait_for(double seconds) {
  const double end = MPI_Wtime() + seconds;
  while (MPI_Wtime() < end) {
  }
}

/// Times are compared with each other only, never with the clock of a machine under load.
TEST(OutputTiming, AddsUpPhasesOverRanks) {
  Timing timing;
  const std::size_t sweep = timing.add_phase("sweep"), idle = timing.add_phase("idle");
  for (int n = 0; n < 3; ++n) timing.measure(sweep, [] { wait_for(0.002); });
  timing.record_step();
  EXPECT_EQ(timing.measure(sweep, [] { return 7; }), 7);
  timing.measure(idle, [] { wait_for(0.001); });
  const auto entries = timing.stop_recording();
  timing.measure(idle, [] {});
  ASSERT_EQ(entries.size(), 2u);
  EXPECT_EQ(timing.name(entries[1].phase), "idle");
  EXPECT_GE(entries[0].start, 0.0);
  EXPECT_GE(entries[1].start, entries[0].end);
  EXPECT_GE(entries[1].end - entries[1].start, 0.001);

  const auto rows = timing.reduce(MPI_COMM_WORLD);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].calls, 4);
  EXPECT_EQ(rows[1].calls, 2);
  EXPECT_EQ(rows[2].part, "rest");
  EXPECT_GE(rows[0].seconds_mean, 0.006);
  EXPECT_GE(rows[0].seconds_max, rows[0].seconds_mean);
  EXPECT_NEAR(rows[0].share + rows[1].share + rows[2].share, 1.0, 1e-9);
  EXPECT_THAT(timing_table(rows), testing::ContainsRegex("sweep +[0-9.]+ +[0-9.]+ +[0-9.]+% +4\n"));

  const Folder folder;
  if (world_rank() == 0) {
    write_timing(folder.name(), rows);
    EXPECT_THAT(
        content(folder / "timing.csv"),
        testing::StartsWith("part,seconds_mean_over_ranks,seconds_max,share,calls\nsweep,"));
  }
  timing.restart();
  EXPECT_EQ(timing.reduce(MPI_COMM_WORLD)[0].calls, 0);
}

TEST(OutputProgress, SaysWhereARunIs) {
  EXPECT_EQ(clock_text(7.4), "0:07");
  EXPECT_EQ(clock_text(3600 + 120 + 3), "1:02:03");
  ProgressState s;
  s.step = 50;
  s.time = 2.5;
  s.end = 10;
  s.cfl = 0.456;
  s.bulk_velocity = 1;
  EXPECT_EQ(progress_line(s, 0.25, 83),
            "[#####...............]  25%  1:23 left  step 50  t 2.5/10  CFL 0.46  u_b 1");
  s.last_step = 60;
  s.slip = 0.0123;
  s.mobile_spheres = 2;
  s.collisions = 17;
  EXPECT_EQ(progress_line(s, 1, -1),
            "[####################] 100%  - left  step 50/60  t 2.5/10  CFL 0.46  u_b 1  slip "
            "1.2e-02  mobile 2  collisions 17");
}

TEST(OutputProgress, WritesPlainLinesWhereThereIsNoTerminal) {
  std::FILE* log = std::tmpfile();
  ProgressState s;
  s.end = 1.0;
  Progress progress(s, log);
  for (int n = 1; n <= 1000; ++n) {
    s.step = n;
    s.time = 0.001 * n;
    progress.update(s);  // far under ten seconds: silent
  }
  progress.finish(s);
  std::rewind(log);
  char text[400] = {};
  const std::size_t length = std::fread(text, 1, sizeof text - 1, log);
  std::fclose(log);
  EXPECT_THAT(std::string(text, length), testing::AllOf(HasSubstr("100%"), HasSubstr("step 1000"),
                                                        testing::Not(HasSubstr("\r"))));
  EXPECT_EQ(std::count(text, text + length, '\n'), 1);
}

TEST(OutputEffectsTable, LinesUpEffectStateShareAndReason) {
  EXPECT_EQ(effects_table({{"convection", "on", "fluid.convection", {}}, {"spin", "off", "", {}}}),
            "effect      state  why\n"
            "convection  on     fluid.convection\n"
            "spin        off    \n");
  EXPECT_EQ(effects_table({{"spheres", "on", "two", 0.125}, {"spin", "off", "none", {}}}),
            "effect   state    time  why\n"
            "spheres  on      12.5%  two\n"
            "spin     off            none\n");
}

}  // namespace
}  // namespace bedload::test
