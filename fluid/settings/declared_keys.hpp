#pragma once

#include <fmt/format.h>

#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fluid/settings/scheme_limits.hpp"
#include "fluid/settings/settings.hpp"

/// The keys of fluid.toml and what each allows. How they are read, written and described is in
/// settings.cpp, the only file that includes this one.
namespace bedload {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Allowed interval of a number.
struct Range {
  double lowest = -infinity;
  double highest = infinity;
  bool open_below = false;

  bool holds(double value) const {
    return (open_below ? value > lowest : value >= lowest) && value <= highest;
  }
  std::string text() const {
    if (lowest == -infinity && highest == infinity) return "any number";
    if (highest == infinity) return fmt::format("{} {}", open_below ? "above" : "at least", lowest);
    return fmt::format("{}{}, {}]", open_below ? "(" : "[", lowest, highest);
  }
};
inline constexpr Range any{};
inline constexpr Range positive{0.0, infinity, true};
inline constexpr Range not_negative{0.0, infinity, false};

enum class Need { optional, required };

template <class Enum>
using Words = std::vector<std::pair<std::string_view, Enum>>;
inline const Words<Wall> wall_words{
    {"periodic", Wall::periodic}, {"no_slip", Wall::no_slip}, {"free_slip", Wall::free_slip}};
inline const Words<Driving> driving_words{{"none", Driving::none},
                                          {"bulk_velocity", Driving::bulk_velocity},
                                          {"pressure_gradient", Driving::pressure_gradient},
                                          {"gravity", Driving::gravity}};
inline const Words<Start> start_words{{"rest", Start::rest},
                                      {"laminar", Start::laminar},
                                      {"logarithmic", Start::logarithmic},
                                      {"state", Start::state}};
inline const Words<Diffusion> diffusion_words{{"auto", Diffusion::automatic},
                                              {"explicit", Diffusion::explicit_},
                                              {"implicit", Diffusion::implicit}};
inline const Words<Exchange> exchange_words{{"stage", Exchange::stage}, {"step", Exchange::step}};
inline const Words<bool> on_off_words{{"on", true}, {"off", false}};
inline const Words<std::string> precision_words{{"double", "double"}, {"single", "single"}};

/// The one place where keys are declared: name, variable (its initialiser is the default), unit,
/// allowed values, meaning. The visitor reads, writes or describes.
template <class Visitor>
void declare_keys(Settings& s, Visitor& key) {
  key.text("title", s.title, "Name of the run in its output.");
  key.integers("grid.cells", s.grid.cells, "-", Range{4, 1 << 20}, Need::required,
               "Cells along x, y and z.");
  key.numbers("grid.length", s.grid.length, "L", positive, Need::required,
              "Edge lengths of the box along x, y and z; cells must come out cubic where y is not "
              "stretched.");
  key.number("grid.y_stretching", s.grid.y_stretching, "-", Range{0.0, 5.0}, Need::optional,
             "Stretches y: s of the hyperbolic tangent that draws cells to the no-slip walls; 0: "
             "does not. No spheres then.");
  key.number("grid.y_uniform", s.grid.y_uniform, "L", not_negative, Need::optional,
             "Stretches y: height from the lower end with cubic cells, a whole number of them, for "
             "spheres; above it cells grow by a constant ratio up to grid.length. 0: does not.");
  key.words("boundary.x", s.boundary.x, wall_words, "Lower and upper end of x.");
  key.words("boundary.y", s.boundary.y, wall_words, "Lower and upper end of y.");
  key.words("boundary.z", s.boundary.z, wall_words, "Lower and upper end of z.");
  key.numbers("boundary.x_lower_velocity", s.boundary.x_lower_velocity, "L/T", any, Need::optional,
              "Velocity of the lower x wall, no_slip, in its own plane (x component 0).");
  key.numbers("boundary.x_upper_velocity", s.boundary.x_upper_velocity, "L/T", any, Need::optional,
              "Velocity of the upper x wall, no_slip, in its own plane (x component 0).");
  key.numbers("boundary.y_lower_velocity", s.boundary.y_lower_velocity, "L/T", any, Need::optional,
              "Velocity of the lower y wall, no_slip, in its own plane (y component 0).");
  key.numbers("boundary.y_upper_velocity", s.boundary.y_upper_velocity, "L/T", any, Need::optional,
              "Velocity of the upper y wall, no_slip, in its own plane (y component 0).");
  key.numbers("boundary.z_lower_velocity", s.boundary.z_lower_velocity, "L/T", any, Need::optional,
              "Velocity of the lower z wall, no_slip, in its own plane (z component 0).");
  key.numbers("boundary.z_upper_velocity", s.boundary.z_upper_velocity, "L/T", any, Need::optional,
              "Velocity of the upper z wall, no_slip, in its own plane (z component 0).");
  key.number("fluid.density", s.fluid.density, "M/L^3", positive, Need::optional,
             "Density of the fluid.");
  key.number("fluid.kinematic_viscosity", s.fluid.kinematic_viscosity, "L^2/T", positive,
             Need::required, "Kinematic viscosity of the fluid.");
  key.numbers(
      "fluid.gravity", s.fluid.gravity, "L/T^2", any, Need::optional,
      "Gravity: gives the spheres' buoyancy, and with flow.driving = \"gravity\" its x part "
      "drives the flow; must equal LIGGGHTS' own.");
  key.word("fluid.convection", s.fluid.convection, on_off_words,
           "Convective term; off solves the unsteady Stokes equations, for spheres that move with "
           "V D/nu far below 1 through the grid.");
  key.word("fluid.diffusion", s.fluid.diffusion, diffusion_words,
           "Viscous term in time; auto: implicit where time.step is longer than explicit diffusion "
           "allows.");
  key.word("flow.driving", s.flow.driving, driving_words,
           "What keeps the flow going along x; gravity: its x part, down a slope.");
  key.number("flow.bulk_velocity", s.flow.bulk_velocity, "L/T", any, Need::optional,
             "Mean of u over the whole box (spheres included), kept constant.");
  key.number("flow.pressure_gradient", s.flow.pressure_gradient, "M/(L^2 T^2)", any, Need::optional,
             "Constant driving force per volume along x.");
  key.number("fringe.rate", s.fringe.rate, "1/T", not_negative, Need::optional,
             "Largest rate at which a region along x draws the flow to a uniform stream, so that "
             "wakes do not come back through periodic ends; 0: no such region.");
  key.number("fringe.begin", s.fringe.begin, "L", not_negative, Need::optional,
             "Where that region begins along x.");
  key.number("fringe.end", s.fringe.end, "L", not_negative, Need::optional,
             "Where it ends along x.");
  key.number("fringe.velocity", s.fringe.velocity, "L/T", any, Need::optional,
             "Velocity of that stream along x.");
  key.word("start.from", s.start.from, start_words, "Field that the run starts from.");
  key.text("start.file", s.start.file,
           "State to start from (start.from = \"state\"), beside fluid.toml; interpolated when its "
           "grid differs.");
  key.number(
      "start.velocity", s.start.velocity, "L/T", any, Need::optional,
      "Mean velocity of the laminar or logarithmic profile over the flow depth; the linear flow "
      "between moving y walls, or z walls where no y end is one, is added to the laminar one.");
  key.number("start.height", s.start.height, "L", not_negative, Need::optional,
             "Height y at which the profile begins (the bed's top); at rest below.");
  key.number("start.disturbance", s.start.disturbance, "-", Range{0.0, 1.0}, Need::optional,
             "Disturbance added to the profile, in start.velocity.");
  key.integer("start.seed", s.start.seed, "-", not_negative, "Seed of the disturbance.");
  key.number("time.step", s.time.step, "T", positive, Need::required,
             "Time step of the fluid; with time.cfl the longest one allowed.");
  key.number("time.cfl", s.time.cfl, "-", Range{0.0, imaginary_limit}, Need::optional,
             "CFL number (|u|+|v|+|w|) dt/h that the time step follows; 0: time.step throughout.");
  key.number("time.end", s.time.end, "T", not_negative, Need::required,
             "Time at which it ends, with the step that reaches it.");
  key.text("spheres.file", s.spheres.file,
           "Fixed spheres of a run without LIGGGHTS: a text file beside fluid.toml, one sphere a "
           "line: x y z radius.");
  key.number("time.wall_limit", s.time.wall_limit, "s", not_negative, Need::optional,
             "Time on the clock after which the run writes a checkpoint and ends; 0: none.");
  key.number("checkpoint.every", s.checkpoint.every, "T", not_negative, Need::optional,
             "Time between checkpoints; 0: none by time.");
  key.number("checkpoint.wall_every", s.checkpoint.wall_every, "s", not_negative, Need::optional,
             "Time on the clock between checkpoints; 0: none by the clock.");
  key.integer("spheres.forcing_loops", s.spheres.forcing_loops, "-", Range{1, 20},
              "Most interpolate-force-spread loops per stage.");
  key.number(
      "spheres.slip_tolerance", s.spheres.slip_tolerance, "L/T", not_negative, Need::optional,
      "Loops stop when no marker slips more than this; not waited for are those that stand for "
      "less than a cell, beside another surface.");
  key.number("spheres.retraction", s.spheres.retraction, "h", Range{-1.0, 1.0}, Need::optional,
             "How far markers are pulled inside the surface, in cells; negative: 0.29 + h/D + 0.13 "
             "(1 - 6 h/D)^2, the last above D/h = 6 with spheres.rigid_core alone.");
  key.number("spheres.marker_density", s.spheres.marker_density, "-", Range{0.5, 2.0},
             Need::optional,
             "Markers of a sphere over pi/3 (12 R^2/h^2 + 1), with which each stands for a cell's "
             "volume; 1 changes drag and torque by 0.1 %, in the densest arrays by 0.6 %, and the "
             "spheres take a fifth more time.");
  key.number(
      "spheres.pressure_share", s.spheres.pressure_share, "-", Range{-1.0, 1.0}, Need::optional,
      "Share of each stage's pressure correction that the old pressure takes over; negative: "
      "0.25, or for a lightest mobile sphere of less than 1.25 times the fluid's density 0.2 of "
      "that ratio, with coupling.exchange = \"stage\" (below 0.5 only beside other mobile "
      "spheres).");
  key.number("spheres.deferred_impulse_share", s.spheres.deferred_impulse_share, "-",
             Range{0.0, 1.0}, Need::optional,
             "Share of a mobile sphere's deferred impulse (what changed inside it between two "
             "forcings) that it gets per stage; 0: density/(density + 4 fluid density).");
  key.number("spheres.deferred_angular_share", s.spheres.deferred_angular_share, "-",
             Range{0.0, 1.0}, Need::optional,
             "Share of the angular impulse due to a mobile sphere that it gets per stage; large "
             "shares are unstable for light spheres; 0: 0.5, with implicit diffusion 0.45 "
             "density/(fluid density), at most 1.");
  key.word(
      "spheres.interior_term", s.spheres.interior_term, on_off_words,
      "Change of the momentum inside a mobile sphere as a part of its load; off: the sphere is "
      "as inert as if the fluid inside were frozen to it (to see what it does).");
  key.word("spheres.rigid_core", s.spheres.rigid_core, on_off_words,
           "The fluid more than three cells under a sphere's surface moves with it; off: it "
           "circulates as markers let it (to see what it does).");
  key.word("spheres.buoyancy", s.spheres.buoyancy, on_off_words,
           "Buoyancy of the mobile spheres in fluid.gravity (off to see what it does).");
  key.word("coupling.exchange", s.coupling.exchange, exchange_words,
           "Whether mobile spheres get their loads and move in each Runge-Kutta stage, or once per "
           "step by the mean load of its stages (for comparison: wet rebounds come out too "
           "low).");
  key.integer(
      "coupling.dem_steps", s.coupling.dem_steps, "-", Range{1, 15000},
      "LIGGGHTS' steps per time step; a multiple of 15 where coupling.exchange is \"stage\".");
  key.integer("ranks.along_z", s.ranks.along_z, "-", Range{0, 1 << 20},
              "Blocks side by side along z, a divisor of the fluid ranks; 0: chosen by cost.");
  key.word("accuracy.precision", s.accuracy.precision, precision_words,
           "Storage precision of the fields.");
  key.text("accuracy.verdicts", s.accuracy.verdicts,
           "What the table of effects says of its rows, \"row: words; row: words\"; "
           "./bedload run --accuracy auto writes why it left something out.");
  key.number("output.fields_every", s.output.fields_every, "T", not_negative, Need::optional,
             "Time between field snapshots; 0: only the end.");
  key.number("output.spheres_every", s.output.spheres_every, "T", not_negative, Need::optional,
             "Time between samples of the mobile spheres; 0: every step. A tenth of a diameter at "
             "the reference velocity is enough for paths and states.");
  key.number("output.fixed_every", s.output.fixed_every, "T", not_negative, Need::optional,
             "Time between samples of the fluid's force on each fixed sphere; 0: only the end.");
  key.integer("output.history_every", s.output.history_every, "-", Range{1, 1 << 30},
              "Steps between rows of history.csv.");
  key.word(
      "output.energy_work", s.output.energy_work, on_off_words,
      "Whether history.csv tells what forcing at the markers, viscosity and convection give to "
      "the flow's energy (columns forcing_work, viscous_work, convective_work); the first two are "
      "not followed, nan, with implicit diffusion; costs sixteen sums over the box in a step and "
      "the memory of three velocity fields.");
  key.integer("statistics.every", s.statistics.every, "-", Range{0, 1 << 30},
              "Steps between samples of the flow statistics; 0: none are taken.");
  key.number("statistics.from", s.statistics.from, "T", not_negative, Need::optional,
             "Time at which the statistics begin; of a run that goes on, they begin anew where it "
             "lies behind all samples so far.");
  key.list("statistics.spectra_heights", s.statistics.spectra_heights, "L", not_negative,
           "Heights y at which spectra along x and z are taken.");
  key.integer("statistics.spectra_every", s.statistics.spectra_every, "-", Range{1, 1 << 30},
              "Samples of the statistics between two of the spectra.");
  key.number("reference.velocity", s.reference.velocity, "L/T", positive, Need::optional,
             "Velocity u_b of the derived numbers.");
  key.number(
      "reference.height", s.reference.height, "L", positive, Need::optional,
      "Flow depth H of the derived numbers: from the bed's top to the free surface or the upper "
      "no-slip wall; between two no-slip walls also half of that, which it is taken for where 2 H "
      "is the box's height above start.height to within 5 %.");
  key.number("reference.diameter", s.reference.diameter, "L", positive, Need::optional,
             "Sphere diameter D of the derived numbers.");
  key.number("reference.sphere_density", s.reference.sphere_density, "M/L^3", not_negative,
             Need::optional, "Density of the mobile spheres in the derived numbers; 0: none.");
}

}  // namespace bedload
