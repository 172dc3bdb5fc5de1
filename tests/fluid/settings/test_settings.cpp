#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fluid/grid/grid.hpp"
#include "fluid/poisson/fft_length.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/validation/validate.hpp"

namespace bedload {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string smallest = R"(
grid.cells = [8, 4, 4]
grid.length = [2.0, 1.0, 1.0]
fluid.kinematic_viscosity = 0.01
[time]
step = 0.1
end = 1
)";

std::string complaint(const std::string& extra, const std::vector<std::string>& overrides = {}) {
  try {
    validate(parse_settings(extra, "fluid.toml", overrides));
  } catch (const UserError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(Settings, DefaultsAndGivenValues) {
  const Settings s = parse_settings(smallest, "fluid.toml", {"time.end=20", "title=\"x\""});
  EXPECT_EQ(s.grid.cells[0], 8);
  EXPECT_EQ(s.time.end, 20.0);
  EXPECT_EQ(s.title, "x");
  EXPECT_EQ(s.boundary.y[1], Wall::free_slip);
}

TEST(Settings, MistakesNameFileKeyFoundAndAllowed) {
  EXPECT_THAT(
      complaint(smallest + "stepp = 1\n"),
      AllOf(HasSubstr("fluid.toml, line 8"), HasSubstr("'time.stepp'"), HasSubstr("'time.step'")));
  EXPECT_THAT(complaint(smallest, {"time.step=-1.0"}),
              AllOf(HasSubstr("'time.step' is -1.0"), HasSubstr("above 0")));
  EXPECT_THAT(complaint(smallest, {"flow.driving=\"bulk\""}),
              AllOf(HasSubstr("bulk"), HasSubstr("\"bulk_velocity\"")));
  EXPECT_THAT(complaint(smallest, {"time.step=\"fast\""}), HasSubstr("a number"));
  EXPECT_THAT(complaint(smallest, {"time.step=nan"}), HasSubstr("a number"));
  EXPECT_THAT(complaint(smallest, {"grid.cells=[8, 4]"}), HasSubstr("list of three"));
  EXPECT_THAT(complaint(smallest, {"grid.cells=[8, 4, 5]"}), HasSubstr("cubes"));
  EXPECT_THAT(complaint(smallest, {"boundary.y=[\"periodic\", \"no_slip\"]"}), HasSubstr("both"));
  EXPECT_THAT(complaint(smallest, {"boundary.y_lower_velocity=[0.1, 0.2, 0.0]"}),
              AllOf(HasSubstr("'boundary.y_lower_velocity'"), HasSubstr("y component")));
  EXPECT_THAT(complaint(smallest, {"boundary.z_upper_velocity=[0.1, 0.0, 0.0]"}),
              AllOf(HasSubstr("'boundary.z_upper_velocity'"), HasSubstr("\"no_slip\"")));
  EXPECT_THAT(complaint(smallest, {"grid.y_uniform=0.6"}),
              AllOf(HasSubstr("'grid.y_uniform' is 0.6"), HasSubstr("whole number of cells")));
  EXPECT_THAT(complaint(smallest, {"grid.y_uniform=0.5", "grid.length=[2.0, 3.0, 1.0]"}),
              AllOf(HasSubstr("'grid.y_uniform' = 0.5"), HasSubstr("1.2 is allowed")));
  EXPECT_THAT(complaint(smallest, {"grid.y_stretching=1.0", "boundary.y=\"free_slip\""}),
              HasSubstr("no-slip walls"));
  EXPECT_THAT(complaint("title = \"x\"\n"), HasSubstr("'grid.cells' is missing"));
  EXPECT_THAT(complaint("title = \n"), HasSubstr("line 1"));
}

/// Cubes up to the height that is asked for, one ratio above, both ends met.
TEST(Settings, StretchedFacesMeetTheBox) {
  Settings s = parse_settings(
      smallest, "fluid.toml",
      {"grid.cells=[8, 10, 4]", "grid.length=[2.0, 3.0, 1.0]", "grid.y_uniform=1.0"});
  Grid grid = make_grid(s);
  EXPECT_EQ(grid.y_face(-1), 0.0);
  EXPECT_EQ(grid.y_face(9), 3.0);
  for (int j = 0; j < 4; ++j) EXPECT_NEAR(grid.thickness(j), 1.0, 1e-12);
  for (int j = 3; j < 9; ++j)
    EXPECT_NEAR(grid.thickness(j + 1) / grid.thickness(j), grid.thickness(4), 1e-9);
  EXPECT_NEAR(grid.cubes_up_to(), 1.0, 1e-12);
  s.grid.y_uniform = 0.0;
  s.grid.y_stretching = 1.5;
  s.boundary.y = {Wall::no_slip, Wall::no_slip};
  grid = make_grid(s);
  EXPECT_NEAR(grid.thickness(0), grid.thickness(9), 1e-12);
  EXPECT_LT(grid.thickness(0), 0.5 * grid.thickness(4));
  EXPECT_EQ(grid.cubes_up_to(), 0.0);
}

TEST(Settings, WrittenValuesReadBackTheSame) {
  const Settings s =
      parse_settings(smallest, "fluid.toml", {"boundary.y=\"no_slip\"", R"(title='a "b" \c')"});
  EXPECT_EQ(s.title, R"(a "b" \c)");
  const std::string written = settings_as_toml(s);
  EXPECT_EQ(written, settings_as_toml(parse_settings(written, "settings.toml")));
}

TEST(Lengths, SlowTransformsGetAHint) {
  for (const int n : {4, 128, 135, 160, 192, 1040, 7 * 11, 64 * 13})
    EXPECT_EQ(faster_length(n), std::nullopt) << n;
  EXPECT_EQ(faster_length(134), 135);  // 2 * 67
  EXPECT_EQ(faster_length(127), 128);
  EXPECT_EQ(faster_length(121), 120);            // 11 * 11; 122 = 2 * 61
  EXPECT_EQ(length_hints({128, 131, 160}), "");  // y is not transformed
  EXPECT_THAT(length_hints({134, 8, 127}),
              AllOf(HasSubstr("134 cells along x"), HasSubstr("127 cells along z"),
                    HasSubstr("; 135 would")));
}

}  // namespace
}  // namespace bedload
