#include <gmock/gmock.h>

#include <cstdlib>

#include "fluid/output/effects_table.hpp"
#include "fluid/output/printable.hpp"
#include "fluid/output/progress.hpp"
#include "fluid/output/timing.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload::test {
namespace {

using testing::HasSubstr;

TEST(OutputPrintable, LeavesLettersAndTakesControlsOut) {
  EXPECT_EQ(printable("Re_\u03c4 of 5 m\u00b3"), "Re_\u03c4 of 5 m\u00b3");
  EXPECT_EQ(printable("a\x1b[31mb\x7f\n"), "a?[31mb??");
  EXPECT_EQ(printable("a\u009b"
                      "31mb"),
            "a?31mb");  // CSI as one character
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
