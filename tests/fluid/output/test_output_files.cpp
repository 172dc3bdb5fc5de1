#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <numeric>

#include "fluid/checkpoint/state_file.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/output/field_writer.hpp"
#include "fluid/output/history.hpp"
#include "fluid/output/settings_file.hpp"
#include "fluid/output/sphere_writer.hpp"
#include "fluid/output/timing.hpp"
#include "fluid/statistics/statistics_file.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload::test {
namespace {

using testing::HasSubstr;
using testing::Not;

template <class T>
std::vector<T> all_of(const Hdf5File& file, const std::string& dataset) {
  const auto shape = file.shape(dataset);
  Hyperslab block{shape, std::vector<std::uint64_t>(shape.size(), 0), shape};
  std::vector<T> values(block.size());
  file.read(dataset, block, values.data());
  return values;
}

/// Linear along all directions, so that the mean of two faces is the value at the centre.
double linear(int c, double x, double y, double z) { return c + 2 * x - 3 * y + 5 * z; }

TEST(OutputFields, AreAtTheCellCentresInTheOrderZYX) {
  const Folder folder;
  const Grid grid = channel_grid(8);
  Flow<double> flow(grid, MPI_COMM_WORLD);
  flow.fill(PlaceValue(linear));
  FieldWriter writer(folder.name(), grid, flow.decomposition);
  writer.write(flow.view(0.5, 7));
  const Hdf5File file(folder / "fields.h5", Hdf5File::Access::read, MPI_COMM_SELF);
  EXPECT_EQ(file.attribute<std::int64_t>("step_00000007", "step"), 7);
  EXPECT_EQ(file.attribute<double>("step_00000007", "time"), 0.5);
  EXPECT_THAT(all_of<double>(file, "grid/y"), testing::ElementsAre(0, 0.125, 0.25, 0.375, 0.5));
  for (int c = 0; c < 4; ++c) {
    const std::string name = std::string("step_00000007/") + "uvwp"[c];
    ASSERT_EQ(file.shape(name), (std::vector<std::uint64_t>{8, 4, 8}));
    EXPECT_EQ(file.type(name), NumberType::float32);
    const auto values = all_of<float>(file, name);
    // The first cell along the component's own direction sees a wrapped or wall ghost.
    for (int k = 1; k < 8; ++k)
      for (int j = 1; j < 4; ++j)
        for (int i = 1; i < 8; ++i)
          EXPECT_NEAR(values[static_cast<std::size_t>((k * 4 + j) * 8 + i)],
                      linear(c, grid.centre(i), grid.centre(j), grid.centre(k)), 1e-6);
    // Periodic wrap of u at i = 0: the mean of the first and the last face.
    if (c == 0)
      EXPECT_NEAR(values[static_cast<std::size_t>((1 * 4 + 1) * 8)],
                  0.5 * (linear(0, 0.125, grid.centre(1), grid.centre(1)) +
                         linear(0, 1.0, grid.centre(1), grid.centre(1))),
                  1e-6);
  }
}

TEST(OutputFields, WrittenInPiecesOfAnySizeAreTheWholeArray) {
  const Folder folder;
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const std::uint64_t rows = 13, own_rows = rank == 0 ? 13 - (ranks - 1) : 1;  // uneven shares
  const std::uint64_t first_row = rank == 0 ? 0 : rows - static_cast<std::uint64_t>(ranks - rank);
  const Hyperslab slab{{rows, 3, 2}, {first_row, 0, 0}, {own_rows, 3, 2}};
  for (const std::size_t bytes : {1, 100, 1 << 20}) {
    {
      Hdf5File file(folder / "pieces.h5", Hdf5File::Access::create, MPI_COMM_WORLD);
      file.write_in_pieces<float>(
          "numbers", slab,
          [&](int first, int count, float* to) {
            std::iota(to, to + 6 * count,
                      static_cast<float>(6 * (first_row + std::uint64_t(first))));
          },
          bytes);
      file.close();
    }
    const Hdf5File file(folder / "pieces.h5", Hdf5File::Access::read, MPI_COMM_SELF);
    std::vector<float> wanted(6 * rows);
    std::iota(wanted.begin(), wanted.end(), 0.0f);
    EXPECT_EQ(all_of<float>(file, "numbers"), wanted) << bytes << " bytes";
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

TEST(OutputFields, OfAContinuedRunForgetWhatCameAfter) {
  const Folder folder;
  const Grid grid = channel_grid(8);
  Flow<float> flow(grid, MPI_COMM_WORLD);
  {
    FieldWriter writer(folder.name(), grid, flow.decomposition);
    for (const std::int64_t step : {10, 20, 30}) writer.write(flow.view(0.1 * double(step), step));
    EXPECT_THAT(content(folder / "fields.xdmf"), HasSubstr("step_00000030"));
    MPI_Barrier(MPI_COMM_WORLD);
  }
  FieldWriter writer(folder.name(), grid, flow.decomposition, 20);
  EXPECT_THAT(content(folder / "fields.xdmf"), Not(HasSubstr("step_00000030")));
  MPI_Barrier(MPI_COMM_WORLD);
  writer.write(flow.view(2.5, 25));
  writer.write(flow.view(2.5, 25));  // the same step once more replaces it
  const Hdf5File file(folder / "fields.h5", Hdf5File::Access::read, MPI_COMM_SELF);
  EXPECT_THAT(file.names("/"),
              testing::ElementsAre("grid", "step_00000010", "step_00000020", "step_00000025"));
  EXPECT_THAT(content(folder / "fields.xdmf"), HasSubstr("Time Value=\"2.5\""));
}

std::vector<SphereState> spheres_at(double x) {
  SphereState bed{.tag = 5, .position = {1, 0.5, 2}, .radius = 0.5, .mobile = false};
  SphereState grain{.tag = 9,
                    .position = {x, 1, 2},
                    .velocity = {x, 2 * x, 3 * x},
                    .angular_velocity = {-x, 0, x},
                    .radius = 0.25,
                    .mobile = true};
  return {grain, bed};
}

std::vector<SphereState> spheres_of_last_rank() {
  return world_rank() == world_size() - 1 ? spheres_at(0) : std::vector<SphereState>{};
}

/// The grain is on one rank, by turns on each; `load` acts on it.
void sample_on_one_rank(SphereWriter& writer, std::int64_t step, double x, const SphereLoad& load) {
  const bool is_here = step % world_size() == world_rank();
  writer.sample(step, x, is_here ? spheres_at(x) : std::vector<SphereState>{},
                std::span(&load, is_here ? 1 : 0));
}

TEST(OutputSpheres, AreOneLongTableThatAContinuedRunCutsBack) {
  const Folder folder;
  const auto write = [&](std::int64_t from, std::int64_t to, std::int64_t resume_after) {
    SphereWriter writer(folder.name(), MPI_COMM_WORLD, spheres_of_last_rank(), resume_after, 0.0);
    for (std::int64_t step = from; step <= to; ++step) {
      const double x = 0.1 * static_cast<double>(step);
      const SphereLoad load{.tag = 9, .force = {x, 0, -x}, .torque = {0, x, 0}};
      sample_on_one_rank(writer, step, x, load);
      if (world_rank() == 0 && step == from) {  // readable while it is being written
        const Hdf5File file(folder / "spheres.h5", Hdf5File::Access::read, MPI_COMM_SELF);
        EXPECT_EQ(all_of<std::int64_t>(file, "mobile/step").back(), from);
      }
    }
  };
  write(1, 20, -1);
  MPI_Barrier(MPI_COMM_WORLD);
  write(13, 14, 12);
  MPI_Barrier(MPI_COMM_WORLD);
  const Hdf5File file(folder / "spheres.h5", Hdf5File::Access::read, MPI_COMM_SELF);
  EXPECT_THAT(all_of<std::int64_t>(file, "fixed/tag"), testing::ElementsAre(5));
  EXPECT_THAT(all_of<double>(file, "fixed/position"), testing::ElementsAre(1, 0.5, 2));
  const auto steps = all_of<std::int64_t>(file, "mobile/step");
  ASSERT_EQ(steps.size(), 14u);
  EXPECT_EQ(steps[13], 14);
  EXPECT_EQ(all_of<std::int64_t>(file, "mobile/tag")[13], 9);
  EXPECT_NEAR(all_of<double>(file, "mobile/time")[13], 1.4, 1e-12);
  EXPECT_EQ(all_of<double>(file, "mobile/radius")[13], 0.25);
  ASSERT_EQ(file.shape("mobile/velocity"), (std::vector<std::uint64_t>{14, 3}));
  EXPECT_NEAR(all_of<double>(file, "mobile/velocity")[13 * 3 + 1], 2.8, 1e-12);
  EXPECT_NEAR(all_of<double>(file, "mobile/position")[13 * 3], 1.4, 1e-12);
  EXPECT_NEAR(all_of<double>(file, "mobile/angular_velocity")[13 * 3], -1.4, 1e-12);
  EXPECT_NEAR(all_of<double>(file, "mobile/force")[13 * 3 + 2], -1.4, 1e-12);
  EXPECT_NEAR(all_of<double>(file, "mobile/torque")[13 * 3 + 1], 1.4, 1e-12);
}

/// Grains that come and go, each on another rank at every step; numbers differ from grain to grain.
constexpr std::int64_t crowd = 23;
bool is_there(std::int64_t tag, std::int64_t step) { return (tag + step) % 5 != 0; }
double number_of(std::int64_t tag, std::int64_t step) {
  return static_cast<double>(100 * step + tag);
}

/// This rank's part of them, and of the load on each: three quarters with the grain, the rest on
/// the next rank, that of grains which are gone included.
std::pair<std::vector<SphereState>, std::vector<SphereLoad>> part_of_crowd(std::int64_t step) {
  std::pair<std::vector<SphereState>, std::vector<SphereLoad>> part;
  for (std::int64_t tag = crowd; tag > 0; --tag) {
    const double x = number_of(tag, step);
    const std::int64_t home = (3 * tag + step) % world_size();
    if (home == world_rank()) {
      if (is_there(tag, step))
        part.first.push_back({.tag = tag,
                              .position = {x, 2 * x, 3 * x},
                              .velocity = {-x, x, 0.5 * x},
                              .angular_velocity = {x, 5 * x, -x},
                              .radius = 0.01 * x});
      part.second.push_back(
          {.tag = tag, .force = {0.75 * x, 0, 3 * x}, .torque = {0, 0.75 * x, 0}});
    }
    if ((home + 1) % world_size() == world_rank())
      part.second.push_back({.tag = tag, .force = {0.25 * x, 0, x}, .torque = {0, 0.25 * x, 0}});
  }
  return part;
}

/// Written by the first rank alone, or by all.
class OutputSpheresOfRanks : public testing::TestWithParam<std::uint64_t> {};
INSTANTIATE_TEST_SUITE_P(Few, OutputSpheresOfRanks, testing::Values(0, SphereWriter::few_rows));

TEST_P(OutputSpheresOfRanks, StandByTagWhoeverHasThem) {
  const Folder folder;
  constexpr std::int64_t steps = 5, batch = 3;
  {
    SphereWriter writer(folder.name(), MPI_COMM_WORLD, spheres_of_last_rank(), -1, 1e9, GetParam());
    for (std::int64_t step = 1; step <= steps; ++step) {
      const auto [spheres, loads] = part_of_crowd(step);
      writer.sample(step, 0.1 * double(step), spheres, loads);
      if (step == batch) writer.flush();
    }
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const Hdf5File file(folder / "spheres.h5", Hdf5File::Access::read, MPI_COMM_SELF);
  const auto step_of = all_of<std::int64_t>(file, "mobile/step"),
             tag_of = all_of<std::int64_t>(file, "mobile/tag");
  const auto column = [&](const char* name) {
    return all_of<double>(file, std::string("mobile/") + name);
  };
  const auto time = column("time"), radius = column("radius"), position = column("position"),
             velocity = column("velocity"), spin = column("angular_velocity"),
             force = column("force"), torque = column("torque");
  std::size_t row = 0;
  for (std::int64_t step = 1; step <= steps; ++step)
    for (std::int64_t tag = 1; tag <= crowd; ++tag) {
      if (!is_there(tag, step)) continue;
      ASSERT_LT(row, tag_of.size());
      const double x = number_of(tag, step);
      EXPECT_EQ(step_of[row], step);
      EXPECT_EQ(tag_of[row], tag);
      EXPECT_EQ(time[row], 0.1 * double(step));
      EXPECT_EQ(radius[row], 0.01 * x);
      const auto at = [row](const std::vector<double>& c) { return Vec3(&c[3 * row]); };
      EXPECT_EQ(at(position), Vec3(x, 2 * x, 3 * x));
      EXPECT_EQ(at(velocity), Vec3(-x, x, 0.5 * x));
      EXPECT_EQ(at(spin), Vec3(x, 5 * x, -x));
      EXPECT_EQ(at(force), Vec3(x, 0, 4 * x));
      EXPECT_EQ(at(torque), Vec3(0, x, 0));
      ++row;
    }
  EXPECT_EQ(row, tag_of.size());
  const std::string xdmf = content(folder / "spheres.xdmf");
  for (std::int64_t step = 1; step <= steps; ++step)
    EXPECT_THAT(xdmf, HasSubstr(fmt::format("Time Value=\"{}\"", 0.1 * double(step))));
}

/// A bed whose spheres lie on the ranks by turns, from the highest tag down, and this rank's part
/// of the force on each: three quarters with the sphere, the rest on the next rank.
std::pair<std::vector<SphereState>, std::vector<SphereLoad>> part_of_bed(double force) {
  std::pair<std::vector<SphereState>, std::vector<SphereLoad>> part;
  for (std::int64_t tag = crowd; tag > 0; --tag) {
    const auto x = static_cast<double>(tag);
    if (tag % world_size() == world_rank()) {
      part.first.push_back(
          {.tag = tag, .position = {x, 2 * x, 3 * x}, .radius = 0.5 * x, .mobile = false});
      part.second.push_back({.tag = tag, .force = {0.75 * force * x, 0, 3}});
    }
    if ((tag + 1) % world_size() == world_rank())
      part.second.push_back({.tag = tag, .force = {0.25 * force * x, 0, 1}});
  }
  return part;
}

TEST_P(OutputSpheresOfRanks, FixedStandByTagWithTheForcesOnThem) {
  const Folder folder;
  const auto write = [&](std::int64_t from, std::int64_t to, std::int64_t resume_after) {
    SphereWriter writer(folder.name(), MPI_COMM_WORLD, part_of_bed(0).first, resume_after, 1e9,
                        GetParam());
    for (std::int64_t step = from; step <= to; ++step) {
      const auto [spheres, loads] = part_of_bed(double(step));
      writer.sample_fixed(step, 0.5 * double(step), spheres, loads, false);
    }
  };
  const auto check = [&](const std::vector<std::int64_t>& steps) {
    const Hdf5File file(folder / "spheres.h5", Hdf5File::Access::read, MPI_COMM_SELF);
    EXPECT_EQ(all_of<std::int64_t>(file, "fixed/force_step"), steps);
    const auto tag = all_of<std::int64_t>(file, "fixed/tag");
    const auto position = all_of<double>(file, "fixed/position"),
               radius = all_of<double>(file, "fixed/radius"),
               time = all_of<double>(file, "fixed/force_time"),
               force = all_of<double>(file, "fixed/force");
    ASSERT_EQ(tag.size(), std::size_t{crowd});
    ASSERT_EQ(file.shape("fixed/force"), (std::vector<std::uint64_t>{steps.size(), 3 * crowd}));
    for (std::size_t n = 0; n < tag.size(); ++n) {
      const auto x = static_cast<double>(n + 1);
      EXPECT_EQ(tag[n], static_cast<std::int64_t>(n + 1));
      EXPECT_EQ(Vec3(&position[3 * n]), Vec3(x, 2 * x, 3 * x));
      EXPECT_EQ(radius[n], 0.5 * x);
      for (std::size_t row = 0; row < steps.size(); ++row) {
        EXPECT_EQ(time[row], 0.5 * double(steps[row]));
        EXPECT_EQ(Vec3(&force[3 * (row * tag.size() + n)]), Vec3(double(steps[row]) * x, 0, 4));
      }
    }
  };
  write(1, 4, -1);
  MPI_Barrier(MPI_COMM_WORLD);
  check({1, 2, 3, 4});
  MPI_Barrier(MPI_COMM_WORLD);
  write(3, 3, 2);
  MPI_Barrier(MPI_COMM_WORLD);
  check({1, 2, 3});
  MPI_Barrier(MPI_COMM_WORLD);
  {
    SphereWriter writer(folder.name(), MPI_COMM_WORLD, {}, 3, 1e9, GetParam());
    const auto [spheres, loads] = part_of_bed(7.0);
    writer.sample_fixed(7, 3.5, spheres, loads, true);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  check({7});
}

/// All on one rank at first: no rank keeps more than its share; few of them go to the first rank.
TEST(OutputSpheres, AreSharedEvenlyAmongTheRanksThatWriteThem) {
  std::vector<SphereRow> rows;
  if (world_rank() == world_size() - 1)
    for (std::int64_t tag = 1000; tag > 0; --tag)
      for (std::int64_t sample : {0, 2})
        rows.push_back({.sample = sample, .tag = tag, .radius = 1});
  const SphereRows many = ordered_by_tag(MPI_COMM_WORLD, rows, 3, 1999);
  EXPECT_THAT(many.of_sample, testing::ElementsAre(1000, 0, 1000));
  const auto ranks = static_cast<std::size_t>(world_size());
  EXPECT_GE(many.mine.size(), 2000 / ranks);
  EXPECT_LE(many.mine.size(), 2000 / ranks + 1);
  const SphereRows few = ordered_by_tag(MPI_COMM_WORLD, rows, 3, 2000);
  EXPECT_THAT(few.of_sample, testing::ElementsAre(1000, 0, 1000));
  EXPECT_EQ(few.mine.size(), world_rank() == 0 ? 2000u : 0u);
  // Before the first sphere is inserted instants have no rows (a sum of tags would overflow).
  const SphereRows none = ordered_by_tag(MPI_COMM_WORLD, {}, 2, 2000);
  EXPECT_THAT(none.of_sample, testing::ElementsAre(0, 0));
  EXPECT_TRUE(none.mine.empty());
}

TEST(OutputSpheres, AreGatheredOfRanksThatMeetAMistakeTogether) {
  const Folder folder;
  const auto run = [&] {
    SphereWriter writer(folder.name(), MPI_COMM_WORLD, spheres_of_last_rank(), -1, 1e9);
    const auto [spheres, loads] = part_of_crowd(1);
    writer.sample(1, 0.1, spheres, loads);
    throw UserError("a mistake");
  };
  EXPECT_THROW(run(), UserError);
  MPI_Barrier(MPI_COMM_WORLD);
  const Hdf5File file(folder / "spheres.h5", Hdf5File::Access::read, MPI_COMM_SELF);
  EXPECT_EQ(file.shape("mobile/tag")[0], 19u);
}

TEST(OutputRanks, AMistakeOfOneRankDoesNotWaitForTheOthers) {
  MPI_Comm comm = MPI_COMM_NULL;
  MPI_Comm_dup(MPI_COMM_WORLD, &comm);
  EXPECT_TRUE(all_arrive(comm, 60.0));
  if (world_size() == 1) return;
  if (world_rank() == 0) EXPECT_FALSE(all_arrive(comm, 0.01));
  MPI_Barrier(MPI_COMM_WORLD);
  if (world_rank() != 0) EXPECT_TRUE(all_arrive(comm, 60.0));
  MPI_Barrier(MPI_COMM_WORLD);
}

TEST(OutputHistory, HasOneRowPerCallAndIsCutBackOnRestart) {
  if (world_rank() != 0) return;
  const std::string folder = std::filesystem::temp_directory_path() / "bedload_history_test";
  std::filesystem::create_directories(folder);
  EXPECT_EQ(history_header(),
            "step,time,dt,cfl,bulk_velocity,driving,kinetic_energy,dissipation,"
            "forcing_work,viscous_work,convective_work,u_tau_driving,"
            "wall_stress_lower,wall_stress_upper,grain_stress_lower,grain_stress_upper,"
            "max_divergence,slip_max,slip_rms,forcing_loops,mobile_spheres,momentum_residual,"
            "fixed_force_x,fixed_force_y,fixed_force_z");
  HistoryRow row{1,    1.0 / 3.0, 0.1,  0.2, 0.3, 0.4, 0.5, 0.55, 0.56, 0.57, 0.58, 0.6, 0.61,
                 0.62, 0.63,      0.64, 0.7, 0.8, 0.9, 10,  11,   12.5, 13.5, 14.5, 15.5};
  EXPECT_EQ(history_line(row),
            "1,0.3333333333333333,0.1,0.2,0.3,0.4,0.5,0.55,0.56,0.57,0.58,0.6,0.61,0.62,0.63,0.64,"
            "0.7,0.8,0.9,10,"
            "11,12.5,13.5,14.5,15.5");
  {
    History history(folder);
    for (row.step = 1; row.step <= 5; ++row.step) history.add(row);
    std::ofstream(folder + "/history.csv", std::ios::app) << "6,0.33";  // cut off by a crash
  }
  {
    History history(folder, 4);
    EXPECT_EQ(history.kept_until(), 4);
  }
  { History(folder, 3).add(row); }
  const std::string text = content(folder + "/history.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);  // header, 1, 2, 3 and the new row
  EXPECT_THAT(text, HasSubstr("\n3,"));
  EXPECT_THAT(text, Not(HasSubstr("\n4,")));
  std::ofstream(folder + "/history.csv") << "other,columns\n";
  EXPECT_THAT(complaint([&] { History(folder, 3); }), HasSubstr("other columns"));
  std::filesystem::remove_all(folder);
}

const char* const scene = R"(
title = "a scene"
grid.cells = [16, 8, 8]
grid.length = [2.0, 1.0, 1.0]
fluid.kinematic_viscosity = 1e-3
flow.driving = "bulk_velocity"
flow.bulk_velocity = 0.3333333333333333
time.step = 0.01
time.end = 3
)";

TEST(OutputSettingsFile, ReadsBackAsTheSameSettings) {
  const Folder folder;
  // Named files stand beside the first fluid.toml, so they come back with their whole path.
  Settings settings = parse_settings(scene, "/somewhere/scene.toml",
                                     {"start.from=\"state\"", "start.file=\"../flow.h5\""});
  if (world_rank() == 0) write_settings_file(folder.name(), settings, derive_numbers(settings));
  MPI_Barrier(MPI_COMM_WORLD);
  settings.start.file = "/flow.h5";
  const Settings again = read_settings(folder / "settings.toml");
  EXPECT_EQ(settings_as_toml(again), settings_as_toml(settings));
  EXPECT_EQ(again.flow.bulk_velocity, 0.3333333333333333);
  EXPECT_THAT(content(folder / "settings.toml"), HasSubstr("# derived.reynolds_bulk = 1000 "));
}

TEST(OutputTextFile, IsWholeOrNotThere) {
  if (world_rank() != 0) return;
  EXPECT_EQ(complaint([] { write_text_file("/proc/none/a.txt", "text"); }),
            "/proc/none/a.txt: cannot be written (No such file or directory).");
  EXPECT_THAT(complaint([] { require_space("/tmp/a", std::uint64_t{1} << 60); }),
              HasSubstr("/tmp/a: cannot be written ("));
  EXPECT_FALSE(std::filesystem::exists("/tmp/a.space"));
}

/// Leaves one example of every file behind for check_output_layout.py, which reads them the way a
/// user does.
/// Statistics in which every number differs from all others: entry n of the k-th list is 100 k + n.
FlowStatistics numbered_statistics() {
  FlowStatistics s;
  double list = 0.0;
  for (auto* values : {&s.y,          &s.y_face,  &s.fluid,     &s.fluid_face,   &s.u,
                       &s.v,          &s.w,       &s.p,         &s.uu,           &s.vv,
                       &s.ww,         &s.uv,      &s.uw,        &s.vw,           &s.pp,
                       &s.grains,     &s.mobile,  &s.grain_u,   &s.grain_v,      &s.grain_w,
                       &s.grain_spin, &s.viscous, &s.turbulent, &s.acceleration, &s.spheres}) {
    *values = {list, list + 1, list + 2};
    list += 100.0;
  }
  s.samples = 7;
  s.begin = 0.1;
  s.end = 0.2;
  s.driving = 0.3;
  s.u_tau = 0.4;
  s.re_tau = 0.5;
  s.stress_defect = 0.6;
  s.wall_stress = {0.7, 0.8};
  s.wavenumber_step = {0.9, 1.1};
  FlowStatistics::Spectra spectra{.height = 1.2};
  for (std::size_t c = 0; c < 3; ++c) {
    spectra.x[c] = {list + static_cast<double>(c)};
    spectra.z[c] = {list + 10.0 + static_cast<double>(c)};
  }
  s.spectra = {spectra};
  return s;
}

TEST(OutputExample, IsLeftForPython) {
  const char* wanted = std::getenv("BEDLOAD_OUTPUT_EXAMPLE");
  if (!wanted) GTEST_SKIP() << "BEDLOAD_OUTPUT_EXAMPLE names no folder";
  const std::string folder = wanted;
  if (world_rank() == 0) {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  const Grid grid = channel_grid(8);
  Flow<float> flow(grid, MPI_COMM_WORLD);
  flow.fill(PlaceValue(linear));
  FieldWriter fields(folder, grid, flow.decomposition);
  SphereWriter spheres(folder, MPI_COMM_WORLD, spheres_of_last_rank());
  for (const std::int64_t step : {1, 2, 3}) {
    const double x = 0.1 * static_cast<double>(step);
    fields.write(flow.view(x, step));
    const SphereLoad load{.tag = 9, .force = {x, 0, 0}};
    sample_on_one_rank(spheres, step, x, load);
    const SphereLoad on_fixed{.tag = 5, .force = {0.5, 0, 2}};
    spheres.sample_fixed(step, x, spheres_of_last_rank(),
                         std::span(&on_fixed, world_rank() == 0 ? 1 : 0), true);
  }
  spheres.flush();
  write_state(folder + "/state.h5", flow.view());
  write_compact_state(folder + "/state.h5", folder + "/start.h5", MPI_COMM_WORLD);
  Timing timing;
  timing.add_phase("sweep");
  const auto rows = timing.reduce(MPI_COMM_WORLD);
  if (world_rank() != 0) return;
  const Settings settings = parse_settings(scene, "scene.toml");
  write_settings_file(folder, settings, derive_numbers(settings));
  History(folder).add({.step = 1});
  write_timing(folder, rows);
  write_statistics(folder, numbered_statistics());
}

}  // namespace
}  // namespace bedload::test
