// Every key of fluid.toml, as `bedload-fluid --help-keys` lists them, with wrong values; and texts
// that random changes have spoiled. Nothing but a sentence may come of it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <regex>
#include <sstream>

#include "fluid/immersed_boundary/sphere_file.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/settings.hpp"
#include "fluid/validation/validate.hpp"
#include "fluid/validation/warnings.hpp"

namespace bedload {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Key {
  std::string name, allowed, usual;
};

/// All keys with what is allowed and the default, as the program prints them.
std::vector<Key> all_keys() {
  std::vector<Key> keys;
  std::istringstream lines(describe_keys());
  std::string name, meaning, rest;
  while (std::getline(lines, name) && std::getline(lines, meaning) && std::getline(lines, rest)) {
    const auto allowed = rest.find("; "), usual = rest.rfind("; default ");
    keys.push_back({name, rest.substr(allowed + 2, usual - allowed - 2), rest.substr(usual + 10)});
  }
  return keys;
}

const std::vector<std::string> good{"grid.cells=[8, 8, 8]", "grid.length=[1.0, 1.0, 1.0]",
                                    "fluid.kinematic_viscosity=0.01", "time.step=0.1",
                                    "time.end=1.0"};

/// The sentence about `good` with `key` set to `value`; "" when it is accepted.
std::string complaint(const std::string& key, const std::string& value) {
  std::vector<std::string> lines = good;
  lines.push_back(key + "=" + value);
  try {
    validate(parse_settings("", "fluid.toml", lines));
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

bool is_list(const Key& key) { return key.usual.starts_with("["); }

TEST(BadSettings, ThereAreKeys) { EXPECT_GT(all_keys().size(), 50u); }

TEST(BadSettings, WrongTypesNameKeyFoundAndAllowed) {
  for (const Key& key : all_keys())
    for (const char* value :
         {"true", "1979-05-27", "{a = 1}", "[[1.0]]", "nan", "inf", "\"fats\""}) {
      const bool text = key.allowed == "text" && value[0] == '"';
      if (text) continue;
      EXPECT_THAT(complaint(key.name, value),
                  AllOf(HasSubstr("fluid.toml"), HasSubstr(key.name), HasSubstr("must be")))
          << key.name << " = " << value;
    }
}

TEST(BadSettings, NumbersOutOfRange) {
  const std::regex interval(R"(([\[(])([-+0-9.e]+), ([-+0-9.e]+)\])"),
      from(R"((above|at least) (\S+))");
  int bounds = 0;
  for (const Key& key : all_keys()) {
    std::vector<double> outside;
    std::smatch match;
    if (std::regex_search(key.allowed, match, interval)) {
      const double low = std::stod(match[2]), high = std::stod(match[3]);
      outside = {match[1] == "(" ? low : low - 1.0, high + 1.0};
    } else if (std::regex_search(key.allowed, match, from)) {
      const double low = std::stod(match[2]);
      outside = {match[1] == "above" ? low : low - 1.0, -1e300};
    }
    const bool whole = key.usual.find_first_of(".e\"") == std::string::npos;
    for (const double value : outside) {
      if (whole && std::abs(value) > 1e15) continue;
      std::string text = fmt::format("{}", value);
      if (!whole && text.find_first_of(".e") == std::string::npos) text += ".0";
      if (is_list(key)) text = fmt::format("[{0}, {0}, {0}]", text);
      EXPECT_THAT(complaint(key.name, text),
                  AllOf(HasSubstr("'" + key.name + "'"), HasSubstr("must be")))
          << text << ", allowed: " << key.allowed;
      ++bounds;
    }
  }
  EXPECT_GT(bounds, 40);
}

TEST(BadSettings, UnknownKeysAreOfferedTheNearest) {
  for (const Key& key : all_keys()) {
    std::string mistyped = key.name;
    std::swap(mistyped[mistyped.size() - 1], mistyped[mistyped.size() - 2]);
    if (mistyped == key.name || mistyped.back() == '.') mistyped = key.name + key.name.back();
    EXPECT_THAT(complaint(mistyped, "1"), AllOf(HasSubstr("unknown key '" + mistyped + "'"),
                                                HasSubstr("'" + key.name + "'")));
  }
}

TEST(BadSettings, UnknownGroupsAreOfferedTheNearestGroup) {
  EXPECT_THAT(complaint("outputs", "{fields_every = 1.0}"),
              AllOf(HasSubstr("'[outputs]'"), HasSubstr("nearest known one is '[output]'")));
  EXPECT_THAT(complaint("sphere.forcing_loops", "2"),
              HasSubstr("nearest known one is '[spheres]'"));
}

TEST(BadSettings, KeysWithoutTheirGroupAreOfferedWithIt) {
  EXPECT_THAT(complaint("precision", "\"single\""), HasSubstr("'accuracy.precision'"));
  EXPECT_THAT(complaint("fluid.dem_steps", "15"), HasSubstr("'coupling.dem_steps'"));
}

TEST(BadSettings, MissingKeysAreNamed) {
  int required = 0;
  for (const Key& key : all_keys()) {
    if (key.allowed.find("required") == std::string::npos) continue;
    ++required;
    std::vector<std::string> lines;
    for (const std::string& line : good)
      if (!line.starts_with(key.name + "=")) lines.push_back(line);
    try {
      parse_settings("", "fluid.toml", lines);
      ADD_FAILURE() << key.name;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), HasSubstr("'" + key.name + "' is missing"));
    }
  }
  EXPECT_EQ(required, 5);
}

TEST(BadSettings, NumbersThatNoMachineCanCompute) {
  EXPECT_THAT(complaint("time.step", "1e-300"), AllOf(HasSubstr("'time.end'"), HasSubstr("steps")));
  EXPECT_THAT(complaint("grid.cells", "[1048576, 1048576, 1048576]"), HasSubstr("cells in all"));
  EXPECT_THAT(complaint("time.cfl", "5.0"), HasSubstr("'time.cfl' is 5.0"));
  EXPECT_THAT(complaint("time.cfl", "1e-9"), HasSubstr("'time.cfl' is 1e-09, but must be 0"));
  EXPECT_THAT(complaint("start.height", "7.0"), HasSubstr("'start.height' is 7, but the box"));
}

/// The TOML library reads such keys by a recursion that would overflow the stack.
TEST(BadSettings, KeysOfAnyDepthAreRefused) {
  std::string deep = "a";
  for (int n = 0; n < 50000; ++n) deep += ".a";
  const auto sentence = [](const std::string& text, const std::vector<std::string>& overrides) {
    try {
      parse_settings(text, "fluid.toml", overrides);
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const std::string& text : {deep + " = 1", "[" + deep + "]", "x = {" + deep + " = 1}"})
    EXPECT_THAT(sentence(text, {}), AllOf(HasSubstr("fluid.toml, line 1"), HasSubstr("100 parts")));
  EXPECT_THAT(sentence("", {deep + "=1"}), HasSubstr("100 parts"));
  std::string list = "statistics.spectra_heights = [0.1";
  for (int n = 0; n < 300; ++n) list += ", 0.1";
  EXPECT_THAT(sentence(list + "]", good), "");
}

/// A pipe, and a device without end, where a file is meant.
TEST(BadSettings, OnlyOrdinaryFilesAreRead) {
  const std::string pipe = testing::TempDir() + "bedload_pipe";
  ::unlink(pipe.c_str());
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& file : {pipe, std::string("/dev/zero"), std::string("/")}) {
    try {
      read_settings(file);
      ADD_FAILURE() << file;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr(file), HasSubstr("an ordinary file")));
    }
    try {
      read_spheres(file, make_grid(parse_settings("", "fluid.toml", good)));
      ADD_FAILURE() << file;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr(file), HasSubstr("an ordinary file")));
    }
  }
  ::unlink(pipe.c_str());
}

/// Both ends of a periodic direction are one place.
TEST(BadSettings, TwoSpheresOfAFileDoNotStandAtOnePlace) {
  std::vector<std::string> lines = good;
  lines.insert(lines.end(), {"grid.cells=[40, 20, 20]", "grid.length=[4.0, 2.0, 2.0]"});
  const Grid grid = make_grid(parse_settings("", "fluid.toml", lines));
  const std::string file = testing::TempDir() + "bedload_twins.txt";
  const auto sentence = [&](const std::string& spheres) {
    std::ofstream(file) << spheres;
    try {
      read_spheres(file, grid);
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(sentence("0 0.5 0.5 0.4\n1.0 0.5 0.5 0.4\n"), "");
  EXPECT_THAT(sentence("# x y z r\n0 0.5 0.5 0.4\n1.0 0.5 0.5 0.4\n4.0 0.5 0.5 0.4\n"),
              AllOf(HasSubstr("line 4"), HasSubstr("that of line 2")));
}

/// What is typed behind --set needs no quotes where the shell would eat them.
TEST(BadSettings, BareWordsStandForTexts) {
  std::vector<std::string> lines = good;
  for (const char* line :
       {"fluid.convection=off", "boundary.y = no_slip", "title=./a-b.c", "start.from=rest"})
    lines.push_back(line);
  const Settings s = parse_settings("", "fluid.toml", lines);
  EXPECT_FALSE(s.fluid.convection);
  EXPECT_EQ(s.boundary.y[1], Wall::no_slip);
  EXPECT_EQ(s.title, "./a-b.c");
  EXPECT_THAT(complaint("fluid.convection", "of"), HasSubstr("must be one of \"on\", \"off\""));
  EXPECT_THAT(complaint("time.end", "soon"), HasSubstr("must be a number"));
}

TEST(BadSettings, AMisnamedRequiredKeyIsShown) {
  std::vector<std::string> lines = good;
  std::replace(lines.begin(), lines.end(), std::string("time.step=0.1"),
               std::string("time.stepp=0.1"));
  try {
    parse_settings("", "fluid.toml", lines);
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("'time.step' is missing"), HasSubstr("'time.stepp' may be meant")));
  }
}

/// Gravity down a slope drives as a pressure gradient of the same force does.
TEST(BadSettings, GravityDrivesWhereItIsToldTo) {
  EXPECT_THAT(complaint("flow.driving", "\"gravity\""), HasSubstr("has no x part"));
  std::vector<std::string> lines = good;
  for (const char* line :
       {"flow.driving=gravity", "fluid.gravity=[0.25, -9.0, 0.0]", "fluid.density=3.0"})
    lines.push_back(line);
  const Settings s = parse_settings("", "fluid.toml", lines);
  validate(s);
  EXPECT_EQ(s.constant_driving(), 0.75);
  EXPECT_EQ(derive_numbers(s).friction.value().source, FrictionSource::driving);
}

/// Allowed, but probably a mistake: a warning each, and none for a scene that makes sense.
TEST(BadSettings, WarningsAreGiven) {
  const auto spoken = [](std::vector<std::string> more) {
    std::vector<std::string> lines = good;
    lines.insert(lines.end(), more.begin(), more.end());
    const Settings s = parse_settings("", "fluid.toml", lines);
    std::string all;
    for (const std::string& warning : warnings(s, derive_numbers(s))) all += warning + "\n";
    return all;
  };
  const std::string driven = "flow.driving=\"bulk_velocity\"";
  EXPECT_EQ(spoken({driven, "flow.bulk_velocity=1.0"}), "");
  EXPECT_THAT(spoken({driven, "fluid.kinematic_viscosity=1e-4"}), HasSubstr("wall units"));
  // Laminar, with lowest cells of more than five nu/u_tau.
  EXPECT_EQ(spoken({driven, "fluid.kinematic_viscosity=0.0025", "grid.cells=[4, 4, 4]"}), "");
  EXPECT_THAT(spoken({driven, "flow.bulk_velocity=1.0", "time.step=0.2"}),
              HasSubstr("1.6 cells a step"));
  EXPECT_EQ(spoken({driven, "flow.bulk_velocity=1.0", "time.step=0.2", "fluid.convection=off"}),
            "");
  // The cells beside the wall, wherever it is: the thin ones here.
  const std::vector<std::string> thin{driven, "fluid.kinematic_viscosity=1e-4",
                                      "grid.y_stretching=2.5"};
  const auto with_wall = [&](const char* y) {
    std::vector<std::string> lines = thin;
    lines.push_back(y);
    return spoken(lines);
  };
  const std::string below = with_wall("boundary.y=[\"no_slip\", \"free_slip\"]");
  EXPECT_THAT(below, HasSubstr("wall units high"));
  EXPECT_EQ(below, with_wall("boundary.y=[\"free_slip\", \"no_slip\"]"));
  // Nothing flows: settling in a box that is held. No wall: no wall units.
  EXPECT_EQ(spoken({driven, "flow.bulk_velocity=0.0", "time.step=0.2"}), "");
  EXPECT_EQ(spoken({"flow.driving=\"pressure_gradient\"", "flow.pressure_gradient=1.0",
                    "fluid.kinematic_viscosity=1e-4", "boundary.y=\"free_slip\""}),
            "");
  EXPECT_THAT(spoken({"flow.bulk_velocity=1.0"}), HasSubstr("'flow.bulk_velocity'"));
  EXPECT_THAT(spoken({"flow.pressure_gradient=1.0"}), HasSubstr("'flow.pressure_gradient'"));
  EXPECT_THAT(spoken({"start.disturbance=0.1"}), HasSubstr("'start.disturbance'"));
  EXPECT_THAT(spoken({"spheres.slip_tolerance=0.1"}), HasSubstr("'spheres.forcing_loops'"));
  EXPECT_THAT(spoken({"start.file=flow.h5"}), HasSubstr("'start.file'"));
  EXPECT_THAT(spoken({"start.velocity=1.0"}), HasSubstr("'start.velocity'"));
  EXPECT_THAT(spoken({"start.height=0.2"}), HasSubstr("'start.height'"));
  EXPECT_EQ(spoken({"start.height=0.2", "boundary.y=no_slip"}), "");  // the bed's, in u_tau
  EXPECT_THAT(spoken({"start.from=logarithmic", "start.velocity=1.0", "boundary.x=free_slip"}),
              HasSubstr("'start.velocity' = 1 is along x"));
  EXPECT_THAT(spoken({"fringe.begin=0.5"}), HasSubstr("'fringe.begin'"));
  EXPECT_THAT(spoken({"fringe.rate=1.0", "fringe.end=0.5", "output.energy_work=on"}),
              HasSubstr("none of its columns"));
  EXPECT_EQ(spoken({"fringe.rate=1.0", "fringe.end=0.5"}), "");
  EXPECT_THAT(spoken({"statistics.from=0.5"}), HasSubstr("'statistics.from'"));
  EXPECT_THAT(spoken({"fluid.gravity=[0.1, -1.0, 0.0]"}),
              HasSubstr("'flow.driving' = \"gravity\""));
  EXPECT_THAT(spoken({"fluid.gravity=[0.0, -1.0, 0.1]"}), HasSubstr("0.1 along z"));
  EXPECT_EQ(spoken({"fluid.gravity=[0.1, -1.0, 0.0]", "flow.driving=gravity"}), "");
  EXPECT_THAT(spoken({"statistics.every=1", "statistics.from=2.0"}),
              HasSubstr("'statistics.from'"));
  EXPECT_THAT(spoken({"time.end=1.0", "time.step=2.1"}), HasSubstr("no step will be made"));
  EXPECT_EQ(spoken({"time.end=1.0", "time.step=2.1", "time.cfl=1.0"}), "");  // it shortens the step
  EXPECT_THAT(spoken({"statistics.every=1", "statistics.spectra_every=2"}),
              HasSubstr("'statistics.spectra_heights'"));
  EXPECT_THAT(spoken({"spheres.interior_term=off", "spheres.deferred_impulse_share=0.3"}),
              HasSubstr("'spheres.interior_term'"));
  // A disturbance is a share of start.velocity.
  const std::string profile = "start.from=\"laminar\"";
  const std::string walls = "boundary.z=\"no_slip\"",
                    slides = "boundary.z_upper_velocity=[1, 0, 0]";
  EXPECT_THAT(spoken({profile, walls, slides}), HasSubstr("what the z walls move"));
  EXPECT_EQ(spoken({profile, walls, slides, "boundary.y=\"free_slip\""}), "");
  EXPECT_THAT(spoken({profile, walls, "start.velocity=1.0", "boundary.y=\"free_slip\""}),
              HasSubstr("'start.velocity' = 1 is even over the box"));
  EXPECT_THAT(spoken({profile, "start.disturbance=0.1"}), HasSubstr("'start.velocity'"));
  EXPECT_EQ(spoken({profile, "start.disturbance=0.1", "start.velocity=1.0"}), "");
  EXPECT_THAT(spoken({profile, "start.velocity=1.0", "start.seed=2"}),
              HasSubstr("'start.disturbance' above 0"));
  const std::string spectra = "statistics.spectra_heights=[0.5]";
  EXPECT_EQ(spoken({"statistics.every=1", spectra}), "");
  for (const std::string across : {"x", "z"})
    EXPECT_THAT(spoken({"statistics.every=1", spectra, "boundary." + across + "=no_slip"}),
                HasSubstr("along " + across + ", between walls"));
}

/// Spheres that the study of stability has found inaccurate are warned of, those beside them that
/// pass are not.
TEST(BadSettings, SpheresBeyondTheStudysLimitsAreWarnedOf) {
  const auto spoken = [](double density, double cells_a_step, double diameter,
                         std::vector<std::string> more = {}) {
    std::vector<std::string> lines = good;
    lines.insert(lines.end(), more.begin(), more.end());
    const Settings s = parse_settings("", "fluid.toml", lines);
    const double h = s.grid.length[0] / s.grid.cells[0];
    SphereState sphere{.tag = 1, .radius = 0.5 * diameter, .mobile = true};
    sphere.density = density * s.fluid.density;
    sphere.velocity = {0.6 * cells_a_step * h / s.time.step, 0.8 * cells_a_step * h / s.time.step,
                       0.0};
    std::string all;
    for (const std::string& warning :
         warnings(s, extremes_of(s, std::vector{sphere, sphere}, s.time.step)))
      all += warning + "\n";
    return all;
  };
  const Settings s = parse_settings("", "fluid.toml", good);
  const double small = 0.1 * std::min(s.grid.length[0], s.grid.length[2]);
  const double wide = std::min(s.grid.length[0], s.grid.length[2]) / 1.5;
  EXPECT_THAT(spoken(0.3, 1.0, small), HasSubstr("0.3 times the fluid's density goes 1 cells"));
  EXPECT_EQ(spoken(0.3, 0.6, small), "");
  EXPECT_EQ(spoken(0.5, 1.0, small), "");
  const std::vector<std::string> one{"coupling.exchange=\"step\"", "coupling.dem_steps=1"};
  EXPECT_THAT(spoken(8.0, 0.6, small, one), HasSubstr("'coupling.dem_steps' = 1"));
  EXPECT_EQ(spoken(8.0, 0.3, small, one), "");
  EXPECT_EQ(spoken(8.0, 0.6, small), "");
  const std::vector<std::string> periodic{"fluid.gravity=[0.1, 0.0, 0.1]",
                                          "boundary.y=\"periodic\""};
  const auto with = [&periodic](std::vector<std::string> more) {
    more.insert(more.begin(), periodic.begin(), periodic.end());
    return more;
  };
  EXPECT_THAT(spoken(2.5, 0.1, small, periodic), HasSubstr("acts along x, where nothing holds"));
  {
    Settings held = s;
    held.fluid.gravity = {0.1, 0.0, 0.0};
    held.boundary.y = {Wall::periodic, Wall::periodic};
    SphereState grain{.tag = 1, .radius = 0.5 * small, .mobile = true},
        bed{.tag = 2, .mobile = false};
    grain.density = 2.5 * held.fluid.density;
    bed.radius = 0.5 * small;
    const double dt = held.time.step;
    EXPECT_EQ(warnings(held, extremes_of(held, std::vector{grain}, dt)).size(), 1);
    EXPECT_THAT(warnings(held, extremes_of(held, std::vector{grain, bed}, dt)), testing::IsEmpty());
  }
  EXPECT_THAT(spoken(0.9, 0.1, small, with({"boundary.z=\"free_slip\""})),
              HasSubstr("acts along x, where nothing holds"));
  EXPECT_THAT(spoken(2.5, 0.1, small, with({"flow.driving=\"bulk_velocity\""})),
              AllOf(HasSubstr("acts along z"), Not(HasSubstr("acts along x"))));
  EXPECT_EQ(spoken(1.0, 0.1, small, periodic), "");
  EXPECT_EQ(spoken(2.5, 0.1, small, with({"boundary.z=\"no_slip\""})), "");
  EXPECT_THAT(spoken(2.5, 0.1, wide), HasSubstr("the box is 1.5 diameters"));
  EXPECT_EQ(spoken(2.5, 0.3, wide), "");
  EXPECT_EQ(spoken(2.5, 0.1, 0.75 * wide), "");
}

/// Free spheres, one alone as well, may swing where a step of implicit diffusion is long for their
/// density.
TEST(BadSettings, LongImplicitStepsOfFreeSpheresAreWarnedOf) {
  const auto spoken = [](double diffusion_number, double density, bool mobile) {
    Settings s = parse_settings("", "fluid.toml", good);
    const double h = s.grid.length[0] / s.grid.cells[0];
    s.fluid.diffusion = diffusion_number > 0.2 ? Diffusion::implicit : Diffusion::explicit_;
    s.fluid.kinematic_viscosity = diffusion_number * h * h / s.time.step;
    SphereState sphere{.tag = 1, .radius = 3.0 * h, .mobile = mobile};
    sphere.density = density * s.fluid.density;
    std::string all;
    for (const std::string& warning : warnings(s, extremes_of(s, std::vector{sphere}, s.time.step)))
      all += warning + "\n";
    return all;
  };
  EXPECT_THAT(spoken(2.1, 1.0, true), AllOf(HasSubstr("a diffusion number nu dt/h^2 of 2.1"),
                                            HasSubstr("beyond 2, one alone")));
  EXPECT_THAT(spoken(8.1, 3.0, true), HasSubstr("beyond 8, one alone"));
  EXPECT_EQ(spoken(1.9, 1.0, true), "");
  EXPECT_EQ(spoken(7.9, 3.0, true), "");
  EXPECT_EQ(spoken(8.1, 3.0, false), "");
  EXPECT_EQ(spoken(0.19, 0.3, true), "");
}

/// reference.* names spheres that are not there; a mean of several sizes is none's own and fits.
TEST(BadSettings, WarnsOfAReferenceThatNoSphereHas) {
  Settings s = parse_settings("", "fluid.toml", good);
  s.reference.diameter = 0.1;
  s.reference.sphere_density = 2.5;
  const auto sphere = [](double diameter, double density) {
    return SphereState{.radius = 0.5 * diameter, .mobile = true, .density = density};
  };
  const auto spoken = [&s](const std::vector<SphereState>& spheres) {
    return warnings_of_reference(s, extremes_of(s, spheres, s.time.step));
  };
  EXPECT_THAT(spoken({sphere(0.1, 2.5), sphere(0.1, 2.5)}), testing::IsEmpty());
  EXPECT_THAT(spoken({sphere(0.05, 2.0), sphere(0.2, 3.0)}), testing::IsEmpty());
  EXPECT_THAT(spoken({}), testing::IsEmpty());
  EXPECT_THAT(spoken({sphere(0.2, 5.0)}),
              testing::ElementsAre(
                  HasSubstr("'reference.diameter' = 0.1, but the mobile spheres have 0.2:"),
                  HasSubstr("'reference.sphere_density' = 2.5, but the mobile spheres have 5:")));
  s.reference.sphere_density = 0.0;  // no grains are meant
  EXPECT_THAT(spoken({sphere(0.02, 5.0), sphere(0.05, 5.0)}),
              testing::ElementsAre(HasSubstr("have 0.02 to 0.05:")));
}

/// Keys of spheres, told once, in a run that can have none.
TEST(BadSettings, WarnsOfKeysOfSpheresWithoutSpheres) {
  const auto spoken = [](std::vector<std::string> more, bool fixed = false) {
    std::vector<std::string> lines = good;
    lines.insert(lines.end(), more.begin(), more.end());
    return warnings_without_spheres(parse_settings("", "fluid.toml", lines), fixed);
  };
  EXPECT_THAT(spoken({}), testing::IsEmpty());
  EXPECT_THAT(spoken({"spheres.retraction=0.1"}),
              testing::ElementsAre(HasSubstr("'spheres.retraction' is set, but has no effect")));
  EXPECT_THAT(spoken({"spheres.rigid_core=off", "coupling.dem_steps=30", "output.fixed_every=1"}),
              testing::ElementsAre(HasSubstr(
                  "'spheres.rigid_core', 'coupling.dem_steps', 'output.fixed_every' are set")));
  EXPECT_THAT(
      spoken({"spheres.rigid_core=off", "coupling.dem_steps=30", "output.fixed_every=1"}, true),
      testing::ElementsAre(
          HasSubstr("'coupling.dem_steps' is set, but has no effect without mobile spheres")));
}

/// The scenes that come with the program give none, but for the sphere that rolls down a plane:
/// there gravity along x is meant for the sphere alone, as in a tank on a slope.
TEST(BadSettings, ScenesThatAreShippedAreNotWarnedOf) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(BEDLOAD_INPUTS))
    if (entry.path().extension() == ".toml") {
      const Settings s = read_settings(entry.path().string());
      validate(s);
      const std::vector<std::string> said = warnings(s, derive_numbers(s));
      if (entry.path().parent_path().filename() == "rolling")
        EXPECT_THAT(said, testing::ElementsAre(HasSubstr("along x")));
      else
        EXPECT_THAT(said, testing::IsEmpty()) << entry.path();
    }
}

/// Texts of all scenes with a few random changes each: bytes, lines, numbers, brackets.
TEST(BadSettings, SpoiltTextsAreReadOrRefused) {
  std::vector<std::string> texts;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(BEDLOAD_INPUTS))
    if (entry.path().extension() == ".toml") {
      std::ifstream file(entry.path());
      texts.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
  ASSERT_GT(texts.size(), 5u);
  const std::vector<std::string> pieces{"[",
                                        "]",
                                        "[[",
                                        "{",
                                        "}",
                                        "\"",
                                        "\"\"\"",
                                        "=",
                                        "=\n",
                                        ".",
                                        "#",
                                        "1e999",
                                        "-",
                                        "nan",
                                        "\\u0000",
                                        "\xff\xfe",
                                        "\n[grid]\n",
                                        "0x7fffffffffffffff",
                                        "99999999999999999999",
                                        ","};
  std::mt19937 random(20240607);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  int refused = 0, read = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text = texts[below(texts.size())];
    for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes) {
      const std::size_t at = below(text.size());
      switch (below(6)) {
        case 0:
          text[at] = static_cast<char>(below(256));
          break;
        case 1:
          text.erase(at, 1 + below(40));
          break;
        case 2:
          text.insert(at, pieces[below(pieces.size())]);
          break;
        case 3:
          text.insert(at, text.substr(below(text.size()), below(80)));
          break;
        case 4:
          text.insert(at, std::string(1 + below(2000), "[{"[below(2)]));
          break;
        default:
          text.resize(at);
      }
    }
    try {
      validate(parse_settings(text, "fluid.toml"));
      ++read;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), HasSubstr("fluid.toml"));
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
  EXPECT_GT(read, 200);
}

}  // namespace
}  // namespace bedload
