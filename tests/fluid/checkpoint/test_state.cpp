#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <limits>

#include "fluid/checkpoint/interpolation.hpp"
#include "fluid/checkpoint/state_file.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/file_header.hpp"
#include "tests/fluid/output_helpers.hpp"

namespace bedload::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double pi = std::numbers::pi;

template <class Real>
class OutputState : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(OutputState, Precisions);

/// Groups of 1, 2, ... ranks read what all ranks wrote, each with slabs of other heights.
TYPED_TEST(OutputState, ComesBackBitForBitOnAnyNumberOfRanks) {
  using Real = TypeParam;
  const Folder folder;
  const Grid grid = channel_grid(12);
  const std::vector<double> cost{9, 1, 1, 1, 1, 1};
  Flow<Real> written(grid, MPI_COMM_WORLD,
                     {.y = divide_evenly(cost, world_size()), .z = {0, grid.cells[2]}});
  const auto value = [](int c, int i, int j, int k) {
    return i == 0 ? -0.0 : scattered(c, i, j, k) / 3.0;
  };
  written.fill(CellValue(value));
  const std::vector<std::int64_t> own(static_cast<std::size_t>(world_rank()), world_rank());
  write_state(folder / "state.h5", written.view(1.0 / 3.0, 123456789012, -2.0 / 3.0),
              [&](const SaveGroup& run) {
                run.text("words", "several\nlines");
                run.list<double>("numbers", std::vector{1.0 / 3.0, -2.5e300});
                run.group("below").value("whole", std::int64_t{1} << 62);
                run.parts("parts", own.size());
                run.rows<std::int64_t>("ranks", own);
              });

  for (int group = 1; group <= world_size(); ++group) {
    MPI_Comm comm;
    MPI_Comm_split(MPI_COMM_WORLD, world_rank() < group ? 0 : MPI_UNDEFINED, 0, &comm);
    if (comm != MPI_COMM_NULL) {
      Flow<Real> read(grid, comm);
      const StateRead found =
          read_state(folder / "state.h5", grid, read.decomposition, read.fields);
      EXPECT_FALSE(found.interpolated);
      EXPECT_EQ(found.header.time, 1.0 / 3.0);
      EXPECT_EQ(found.header.step, 123456789012);
      EXPECT_EQ(found.header.driving, -2.0 / 3.0);
      const StateReader state(folder / "state.h5", comm);
      EXPECT_EQ(state.run().text("words"), "several\nlines");
      EXPECT_EQ(state.run().template list<double>("numbers"), (std::vector{1.0 / 3.0, -2.5e300}));
      EXPECT_EQ(state.run().group("below").template value<std::int64_t>("whole"),
                std::int64_t{1} << 62);
      const Part last = state.run().part_of_rank("parts", world_size() - 1);
      EXPECT_EQ(state.run().template rows<std::int64_t>("ranks", last, 1),
                (std::vector<std::int64_t>(last.count, world_size() - 1)));
      EXPECT_EQ(last.count, static_cast<std::uint64_t>(world_size() - 1));
      int differing = 0;
      read.each([&](int c, int i, int j, int k) {
        const Real expected = static_cast<Real>(
            value(c, i, read.decomposition.first() + j, read.decomposition.first_row() + k));
        differing += std::memcmp(&read.at(c, i, j, k), &expected, sizeof expected) != 0;
      });
      EXPECT_EQ(differing, 0) << "with " << group << " ranks";
      MPI_Comm_free(&comm);
    }
    MPI_Barrier(MPI_COMM_WORLD);
  }
}

/// Smooth, and true to the walls of channel_grid(): u and w at the lower wall's speed there, no
/// gradient at the free-slip end, v zero on both, pressure without gradient at both.
double smooth(int c, double x, double y, double z) {
  const double height = 0.5, wave = std::sin(2 * pi * x + 0.3) * std::cos(2 * pi * z - 0.4);
  const double rise = std::sin(0.5 * pi * y / height);
  if (c == 0) return 0.7 + rise * (1.0 + wave);
  if (c == 1) return std::sin(pi * y / height) * wave;
  if (c == 2) return 0.4 + rise * (wave - 0.2);
  return std::cos(pi * y / height) * wave;
}

/// Largest error of each component, interpolated from one grid onto another.
std::array<double, 4> interpolation_error(const Grid& stored, const Grid& wanted) {
  const Folder folder;
  Flow<double> from(stored, MPI_COMM_WORLD);
  from.fill(PlaceValue(smooth));
  write_state(folder / "state.h5", from.view());
  Flow<double> to(wanted, MPI_COMM_WORLD);
  const StateRead found = read_state(folder / "state.h5", to.grid, to.decomposition, to.fields);
  EXPECT_TRUE(found.interpolated);
  EXPECT_EQ(found.header.y_faces, stored.y_faces);
  std::array<double, 4> error{};
  to.each([&](int c, int i, int j, int k) {
    const double exact = smooth(c, to.place(c, 0, i), to.place(c, 1, to.decomposition.first() + j),
                                to.place(c, 2, to.decomposition.first_row() + k));
    double& largest = error[static_cast<std::size_t>(c)];
    largest = std::max(largest, std::abs(to.at(c, i, j, k) - exact));
  });
  MPI_Allreduce(MPI_IN_PLACE, error.data(), 4, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return error;
}

/// The largest error, walls included, falls with h^2. From 16 to 64 cells the worst place within a
/// cell wanders, hence a quarter of an order either way; a wall taken for a mirror, or a component
/// read at the wrong face, gives first order. Stretched planes on either side or on both: those of
/// a factor 1.5 reach 1.66 times the mean height; planes taken for even ones miss by 0.1 of the
/// box, whatever the grid.
TEST(OutputInterpolation, IsOfSecondOrderUpToTheWalls) {
  struct Case {
    double stored, wanted;  // stretching; 0: cubes
  };
  for (const auto& [stored, wanted] : {Case{0, 0}, Case{1.5, 0}, Case{0, 1.5}, Case{1.5, 1.2}}) {
    SCOPED_TRACE(testing::Message() << "stretching " << stored << " to " << wanted);
    const auto grid = [](int cells, double stretching) {
      return stretching > 0.0 ? stretched_grid(cells, stretching) : channel_grid(cells);
    };
    const Grid to = grid(36, wanted);
    const auto coarse = interpolation_error(grid(16, stored), to);
    const auto fine = interpolation_error(grid(64, stored), to);
    const double tallest = stored > 0.0 ? 1.66 * 1.66 : 1.0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double order = std::log(coarse[c] / fine[c]) / std::log(4.0);
      EXPECT_NEAR(order, 2.0, 0.25) << "component " << c << ": " << coarse[c] << ", " << fine[c];
      // Bound of trilinear interpolation: h^2/8 times the second derivatives, here at most
      // 2 (2 pi)^2 along x and z and (2 pi)^2 along y, amplitude 1.
      EXPECT_LT(fine[c], (4.0 + tallest) * 4.0 * pi * pi / 8.0 / (64.0 * 64.0));
    }
  }
}

/// The same number of planes at other heights is another grid, the same heights are not.
TEST(OutputInterpolation, HeightsOfPlanesBelongToTheGrid) {
  const Folder folder;
  Flow<double> from(stretched_grid(16, 1.5), MPI_COMM_WORLD);
  from.fill(CellValue(scattered));
  write_state(folder / "state.h5", from.view());
  for (const double stretching : {0.0, 1.4, 1.5}) {
    Flow<double> to(stretching > 0.0 ? stretched_grid(16, stretching) : channel_grid(16),
                    MPI_COMM_WORLD);
    const StateRead found = read_state(folder / "state.h5", to.grid, to.decomposition, to.fields);
    EXPECT_EQ(found.interpolated, stretching != 1.5) << stretching;
    int differing = 0;
    to.each(
        [&](int c, int i, int j, int k) { differing += to.at(c, i, j, k) != from.at(c, i, j, k); });
    EXPECT_EQ(differing == 0, stretching == 1.5) << stretching;
  }
}

TEST(OutputInterpolation, IsExactForLinearFunctionsAndOnStoredPoints) {
  const PointRow row{8, 0.5, 0.5, {Continuation::opposed, Continuation::mirrored}};
  const auto value = [&](double y, double wall) {
    const LinearStencil s = linear_stencil(row, y);
    const auto q = [&](int n) { return 3.0 + 2.0 * (n + 0.5) * 0.5; };
    return s.lower_weight * q(s.lower) + s.upper_weight * q(s.upper) + s.wall_weight[0] * wall;
  };
  EXPECT_DOUBLE_EQ(value(1.9, 3.0), 3.0 + 2.0 * 1.9);
  EXPECT_DOUBLE_EQ(value(0.1, 3.0), 3.0 + 2.0 * 0.1);    // between wall and first point
  EXPECT_DOUBLE_EQ(value(3.95, 3.0), 3.0 + 2.0 * 3.75);  // free slip: flat beyond the last
  EXPECT_EQ(linear_stencil(row, 0.75).lower_weight, 1.0);
  EXPECT_EQ(linear_stencil(row, 0.75).lower, 1);
}

/// A discrete velocity without divergence: the curl of a scattered vector potential on the edges.
double solenoidal(const Grid& grid, int c, int i, int j, int k) {
  const auto wrap = [](int n, int cells) { return (n + cells) % cells; };
  const auto potential = [&](int d, int a, int b, int e) {
    // No flux through the y walls: the potential along them is constant there (0).
    if (d != 1 && (b < 0 || b == grid.cells[1] - 1)) return 0.0;
    return scattered(d, wrap(a, grid.cells[0]), b, wrap(e, grid.cells[2]));
  };
  if (c == 0)
    return potential(2, i, j, k) - potential(2, i, j - 1, k) -
           (potential(1, i, j, k) - potential(1, i, j, k - 1));
  if (c == 1)
    return potential(0, i, j, k) - potential(0, i, j, k - 1) -
           (potential(2, i, j, k) - potential(2, i - 1, j, k));
  if (c == 2)
    return potential(1, i, j, k) - potential(1, i - 1, j, k) -
           (potential(0, i, j, k) - potential(0, i, j - 1, k));
  return 5.0;
}

void expect_face_means(const Grid& fine_grid, const Grid& coarse_grid) {
  const Folder folder;
  // Area of a face across c of a cell of plane j, in h^2.
  const auto area = [](const Grid& grid, int c, int j) { return c == 1 ? 1.0 : grid.thickness(j); };
  Flow<double> fine(fine_grid, MPI_COMM_WORLD);
  fine.fill(CellValue([&](int c, int i, int j, int k) {
    return solenoidal(fine_grid, c, i, j, k) / area(fine_grid, c, j);
  }));
  write_state(folder / "state.h5", fine.view());
  write_compact_state(folder / "state.h5", folder / "compact.h5", MPI_COMM_WORLD);

  Flow<double> coarse(coarse_grid, MPI_COMM_WORLD);
  coarse.pressure.fill(3.0);
  const StateRead found =
      read_state(folder / "compact.h5", coarse_grid, coarse.decomposition, coarse.fields);
  EXPECT_FALSE(found.interpolated);
  EXPECT_EQ(found.header.step, 42);

  const auto mean = [&](int c, int i, int j, int k) {
    double flux = 0.0, faces = 0.0;
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) {
        const int plane = c == 1 ? 2 * j + 1 : 2 * j + a;
        faces += area(fine_grid, c, plane);
        flux += c == 0   ? solenoidal(fine_grid, c, 2 * i + 1, plane, 2 * k + b)
                : c == 1 ? solenoidal(fine_grid, c, 2 * i + a, plane, 2 * k + b)
                         : solenoidal(fine_grid, c, 2 * i + b, plane, 2 * k + 1);
      }
    return flux / faces;
  };
  std::array<double, 3> largest{}, error{};
  coarse.each([&](int c, int i, int j, int k) {
    if (c == 3) {
      EXPECT_EQ(coarse.at(c, i, j, k), 0.0);
      return;
    }
    const double exact =
        mean(c, i, coarse.decomposition.first() + j, coarse.decomposition.first_row() + k);
    const auto n = static_cast<std::size_t>(c);
    largest[n] = std::max(largest[n], std::abs(exact));
    error[n] = std::max(error[n], std::abs(coarse.at(c, i, j, k) - exact));
  });
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), 3, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, error.data(), 3, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  double rounding = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double half_step = 0.5 * largest[c] / std::numeric_limits<std::int16_t>::max();
    EXPECT_LE(error[c], half_step * (1 + 1e-9));
    EXPECT_GT(error[c], 0.5 * half_step);  // some of thousands of values come near the bound
    rounding = std::max(rounding, half_step);
  }
  // Flux out of each coarse cell: a rounding of each of its six faces at most.
  for (int j = 0; j < coarse.decomposition.planes(); ++j) wrap_x_ghosts(coarse.velocity, j);
  coarse.decomposition.exchange(coarse.velocity);
  double worst = 0.0;
  for (int j = 0; j < coarse.decomposition.planes(); ++j) {
    const double side = area(coarse_grid, 0, coarse.decomposition.first() + j);
    for (int k = 0; k < coarse.decomposition.rows(); ++k)
      for (int i = 0; i < 12; ++i) {
        const Field<double>& u = coarse.velocity;
        const double below = coarse.decomposition.first() + j == 0 ? 0.0 : u.row(j - 1, k, 1)[i];
        const double flux = side * (u.row(j, k, 0)[i] - u.row(j, k, 0)[i - 1]) + u.row(j, k, 1)[i] -
                            below + side * (u.row(j, k, 2)[i] - u.row(j, k - 1, 2)[i]);
        worst = std::max(worst, std::abs(flux) / (4.0 * side + 2.0));
      }
  }
  EXPECT_LE(worst, rounding * (1 + 1e-9));
}
TEST(OutputCompactState, HoldsFaceMeansWithinItsRoundingAndNoDivergence) {
  expect_face_means(channel_grid(24), channel_grid(12));
  expect_face_means(stretched_grid(24, 1.5), stretched_grid(12, 1.5));
}

/// The scattered values do not compress: no field of this size takes more.
TEST(OutputCompactState, OfTheDefaultSceneIsSmallEnoughToShip) {
  const Folder folder;
  const Grid grid{.cells = {160, 90, 80},
                  .length = {16.0, 9.0, 8.0},
                  .h = 0.1,
                  .walls = channel_grid(4).walls,
                  .wall_velocity = {}};
  Flow<float> flow(grid, MPI_COMM_WORLD);
  flow.fill(CellValue(scattered));
  write_state(folder / "state.h5", flow.view());
  write_compact_state(folder / "state.h5", folder / "compact.h5", MPI_COMM_WORLD);
  EXPECT_LT(std::filesystem::file_size(folder / "compact.h5"), 3u << 20);
  EXPECT_THAT(complaint([&] {
                write_compact_state(folder / "state.h5", folder / "c.h5", MPI_COMM_WORLD,
                                    {.every = 4, .gzip = 1});
              }),
              HasSubstr("90 cells along y cannot be joined by 4"));
}

/// Every kind of damage is one sentence that begins with the file's name, on all ranks.
TEST(OutputStateRefuses, DamagedForeignAndMisfittingFiles) {
  const Folder folder;
  const std::string path = folder / "state.h5";
  const Grid grid = channel_grid(8);
  Flow<double> flow(grid, MPI_COMM_WORLD);
  flow.fill(CellValue(scattered));
  write_state(path, flow.view());
  const std::string whole = content(path);
  const auto refusal_on = [&](const Grid& g, const std::string& bytes) {
    MPI_Barrier(MPI_COMM_WORLD);
    if (world_rank() == 0) std::ofstream(path, std::ios::binary) << bytes;
    MPI_Barrier(MPI_COMM_WORLD);
    Flow<double> other(g, MPI_COMM_WORLD);
    const std::string sentence =
        complaint([&] { read_state(path, g, other.decomposition, other.fields); });
    EXPECT_EQ(sentence.find('\n'), std::string::npos);
    EXPECT_THAT(sentence, testing::AnyOf(testing::IsEmpty(), StartsWith(path + ": ")));
    return sentence;
  };
  const auto refusal = [&](const std::string& bytes) { return refusal_on(grid, bytes); };

  EXPECT_EQ(refusal(whole), "");
  for (std::size_t at = file_header_bytes; at < whole.size(); at += whole.size() / 40) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    EXPECT_THAT(refusal(damaged), HasSubstr("damaged")) << "byte " << at;
  }
  EXPECT_THAT(refusal(whole.substr(0, whole.size() - 1)), HasSubstr("truncated"));
  EXPECT_THAT(refusal(whole.substr(0, whole.size() / 2)), HasSubstr("truncated"));
  EXPECT_THAT(refusal(whole.substr(0, 300)), HasSubstr("truncated"));
  EXPECT_THAT(refusal(whole + "x"), HasSubstr("too long"));
  EXPECT_THAT(refusal(""), HasSubstr("not a state"));
  EXPECT_THAT(refusal(whole.substr(file_header_bytes)), HasSubstr("not a state"));
  std::string newer = whole;
  newer[std::strlen("bedload state ")] = '9';
  EXPECT_THAT(refusal(newer), HasSubstr("format 9"));
  if (world_rank() == 0) std::filesystem::remove(path);
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THAT(complaint([&] { read_state(path, grid, flow.decomposition, flow.fields); }),
              HasSubstr("cannot be opened"));

  Grid longer = grid;
  longer.length[0] = 1.125;
  longer.cells[0] = 9;
  EXPECT_THAT(refusal_on(longer, whole), HasSubstr("box is 1 long along x"));
  Grid closed = grid;
  closed.walls[2] = {Wall::no_slip, Wall::no_slip};
  EXPECT_THAT(refusal_on(closed, whole), HasSubstr("periodic along z"));
}

/// A limit on the size of files stands for a full disk: the old state stays whole, nothing half is
/// left, and every rank hears the reason.
TEST(OutputState, LeavesTheOldOneWhenTheDiskIsFull) {
  const Folder folder;
  const Grid grid = channel_grid(48);
  Flow<double> flow(grid, MPI_COMM_WORLD);
  write_state(folder / "state.h5", flow.view(0.0, 1));
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  rlimit tight = usual;
  tight.rlim_cur = 1 << 20;
  setrlimit(RLIMIT_FSIZE, &tight);
  const std::string sentence =
      complaint([&] { write_state(folder / "state.h5", flow.view(0.0, 2)); });
  setrlimit(RLIMIT_FSIZE, &usual);
  EXPECT_EQ(sentence, folder / "state.h5: cannot be written (File too large).");
  EXPECT_EQ(StateReader(folder / "state.h5", MPI_COMM_WORLD).header().step, 1);
  EXPECT_FALSE(std::filesystem::exists(temporary_name(folder / "state.h5")));
  EXPECT_THAT(complaint([&] { write_state(folder / "none/state.h5", flow.view()); }),
              HasSubstr("none/state.h5: cannot be written (No such file or directory)"));
}

/// Sealed, but by no program that knows what a state is.
TEST(OutputState, RefusesAHeaderThatMakesNoSense) {
  const Folder folder;
  const std::string path = folder / "state.h5";
  const auto refusal = [&](const StateHeader& header) -> std::string {
    create_state(path, header, MPI_COMM_WORLD)->close();
    seal_state(path, MPI_COMM_WORLD);
    try {
      const StateReader reader(path, MPI_COMM_WORLD);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  const StateHeader good{.cells = {4, 2, 4}, .length = {2.0, 1.0, 2.0}};
  EXPECT_EQ(refusal(good), "");
  StateHeader bad = good;
  bad.cells[2] = 0;
  EXPECT_THAT(refusal(bad), HasSubstr("'cells'"));
  bad = good;
  bad.length[0] = 0.0;
  EXPECT_THAT(refusal(bad), HasSubstr("'length'"));
  bad = good;
  bad.y_faces = {0.0, 0.5};
  EXPECT_THAT(refusal(bad), HasSubstr("'y_faces'"));
  bad.y_faces = {0.0, 0.5, 0.5};
  EXPECT_THAT(refusal(bad), HasSubstr("'y_faces'"));

  auto file = create_state(path, good, MPI_COMM_WORLD);
  const std::uint64_t mine = world_rank() == 0 ? 3 : 0;
  file->write("y_faces", {{1, 3}, {0, 0}, {1, mine}}, std::vector<double>{0.0, 0.5, 1.0}.data());
  file->close();
  seal_state(path, MPI_COMM_WORLD);
  EXPECT_THROW(StateReader(path, MPI_COMM_WORLD), UserError);
}

}  // namespace
}  // namespace bedload::test
