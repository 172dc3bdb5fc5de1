#include "fluid/settings/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <regex>
#include <set>
#include <span>
#include <sstream>
#include <string_view>

#include "fluid/settings/errors.hpp"
#include "fluid/settings/input_file.hpp"
#include "fluid/settings/scheme_limits.hpp"

namespace bedload {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

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
constexpr Range any{};
constexpr Range positive{0.0, infinity, true};
constexpr Range not_negative{0.0, infinity, false};

enum class Need { optional, required };

template <class Enum>
using Words = std::vector<std::pair<std::string_view, Enum>>;
const Words<Wall> wall_words{
    {"periodic", Wall::periodic}, {"no_slip", Wall::no_slip}, {"free_slip", Wall::free_slip}};
const Words<Driving> driving_words{{"none", Driving::none},
                                   {"bulk_velocity", Driving::bulk_velocity},
                                   {"pressure_gradient", Driving::pressure_gradient},
                                   {"gravity", Driving::gravity}};
const Words<Start> start_words{{"rest", Start::rest},
                               {"laminar", Start::laminar},
                               {"logarithmic", Start::logarithmic},
                               {"state", Start::state}};
const Words<Diffusion> diffusion_words{{"auto", Diffusion::automatic},
                                       {"explicit", Diffusion::explicit_},
                                       {"implicit", Diffusion::implicit}};
const Words<Exchange> exchange_words{{"stage", Exchange::stage}, {"step", Exchange::step}};
const Words<bool> on_off_words{{"on", true}, {"off", false}};
const Words<std::string> precision_words{{"double", "double"}, {"single", "single"}};

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
             "Stretches y: height from the lower end with cubic cells, for spheres; above it cells "
             "grow by a constant ratio up to grid.length. 0: does not.");
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
           "Convective term; off solves the unsteady Stokes equations.");
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
  key.number("start.velocity", s.start.velocity, "L/T", any, Need::optional,
             "Mean velocity of the laminar or logarithmic profile over the flow depth.");
  key.number("start.height", s.start.height, "L", not_negative, Need::optional,
             "Height y at which the profile begins (the bed's top); at rest below.");
  key.number("start.disturbance", s.start.disturbance, "-", Range{0.0, 1.0}, Need::optional,
             "Disturbance added to the profile, in start.velocity.");
  key.integer("start.seed", s.start.seed, "-", not_negative, "Seed of the disturbance.");
  key.number("time.step", s.time.step, "T", positive, Need::required,
             "Time step of the fluid; with time.cfl the longest one allowed.");
  key.number("time.cfl", s.time.cfl, "-", Range{0.0, imaginary_limit}, Need::optional,
             "CFL number (|u|+|v|+|w|) dt/h that the time step follows; 0: time.step throughout.");
  key.number("time.end", s.time.end, "T", not_negative, Need::required, "Time at which it ends.");
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
  key.number("spheres.slip_tolerance", s.spheres.slip_tolerance, "L/T", not_negative,
             Need::optional, "Loops stop when no marker slips more than this.");
  key.number("spheres.retraction", s.spheres.retraction, "h", Range{-1.0, 1.0}, Need::optional,
             "How far markers are pulled inside the surface, in cells; negative: 0.29 + 1.0 h/D.");
  key.number("spheres.pressure_share", s.spheres.pressure_share, "-", Range{0.0, 1.0},
             Need::optional,
             "Share of each stage's pressure correction that the old pressure takes over.");
  key.number("spheres.deferred_impulse_share", s.spheres.deferred_impulse_share, "-",
             Range{0.0, 1.0}, Need::optional,
             "Share of a mobile sphere's deferred impulse (what changed inside it between two "
             "forcings) that it gets per stage; 0: density/(density + 4 fluid density).");
  key.number("spheres.deferred_angular_share", s.spheres.deferred_angular_share, "-",
             Range{0.01, 1.0}, Need::optional,
             "Share of the angular impulse due to a mobile sphere that it gets per stage; large "
             "shares are unstable for light spheres.");
  key.word(
      "spheres.interior_term", s.spheres.interior_term, on_off_words,
      "Change of the momentum inside a mobile sphere as a part of its load; off: the sphere is "
      "as inert as if the fluid inside were frozen to it (to see what it does).");
  key.word("spheres.buoyancy", s.spheres.buoyancy, on_off_words,
           "Buoyancy of the mobile spheres in fluid.gravity (off to see what it does).");
  key.word("coupling.exchange", s.coupling.exchange, exchange_words,
           "Whether mobile spheres get their loads and move in each Runge-Kutta stage, or once per "
           "step by the mean load of its stages.");
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
      "the flow's energy (columns forcing_work, viscous_work, convective_work); costs sixteen "
      "sums over the box in a step and the memory of three velocity fields.");
  key.integer("statistics.every", s.statistics.every, "-", Range{0, 1 << 30},
              "Steps between samples of the flow statistics; 0: none are taken.");
  key.number("statistics.from", s.statistics.from, "T", not_negative, Need::optional,
             "Time at which the statistics begin.");
  key.list("statistics.spectra_heights", s.statistics.spectra_heights, "L", not_negative,
           "Heights y at which spectra along x and z are taken.");
  key.integer("statistics.spectra_every", s.statistics.spectra_every, "-", Range{1, 1 << 30},
              "Samples of the statistics between two of the spectra.");
  key.number("reference.velocity", s.reference.velocity, "L/T", positive, Need::optional,
             "Velocity u_b of the derived numbers.");
  key.number("reference.height", s.reference.height, "L", positive, Need::optional,
             "Flow depth H of the derived numbers.");
  key.number("reference.diameter", s.reference.diameter, "L", positive, Need::optional,
             "Sphere diameter D of the derived numbers.");
  key.number("reference.sphere_density", s.reference.sphere_density, "M/L^3", not_negative,
             Need::optional, "Density of the mobile spheres in the derived numbers; 0: none.");
}

/// Number of single-letter edits between two names.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> previous(b.size() + 1), current(b.size() + 1);
  std::iota(previous.begin(), previous.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j)
      current[j] = std::min({previous[j] + 1, current[j - 1] + 1,
                             previous[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
    std::swap(previous, current);
  }
  return previous[b.size()];
}

std::string nearest(std::string_view name, const std::set<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

template <class Enum>
std::string word_list(const Words<Enum>& words) {
  std::string list;
  for (const auto& entry : words)
    list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", entry.first);
  return list;
}

/// Takes every declared key out of the TOML table; what is left over is unknown.
class Reader {
 public:
  Reader(const toml::table& table, std::string file) : table_(table), file_(std::move(file)) {}

  void text(std::string_view name, std::string& value, std::string_view) {
    if (const toml::node* node = take(name)) {
      const auto found = node->value_exact<std::string>();
      if (!found) fail(name, *node, "a text in quotes");
      value = *found;
    }
  }
  template <class Integer>
  void integer(std::string_view name, Integer& value, std::string_view, Range range,
               std::string_view) {
    if (const toml::node* node = take(name)) value = read_integer<Integer>(name, *node, range);
  }
  void number(std::string_view name, double& value, std::string_view, Range range, Need need,
              std::string_view) {
    if (const toml::node* node = take(name, need)) value = read_number(name, *node, range);
  }
  void integers(std::string_view name, std::array<int, 3>& values, std::string_view, Range range,
                Need need, std::string_view) {
    if (const toml::node* node = take(name, need)) {
      const toml::array& list = list_of_three(name, *node);
      for (std::size_t d = 0; d < 3; ++d) values[d] = read_integer<int>(name, list[d], range);
    }
  }
  void numbers(std::string_view name, std::array<double, 3>& values, std::string_view, Range range,
               Need need, std::string_view) {
    if (const toml::node* node = take(name, need)) {
      const toml::array& list = list_of_three(name, *node);
      for (std::size_t d = 0; d < 3; ++d) values[d] = read_number(name, list[d], range);
    }
  }
  void list(std::string_view name, std::vector<double>& values, std::string_view, Range range,
            std::string_view) {
    const toml::node* node = take(name);
    if (!node) return;
    const toml::array* list = node->as_array();
    if (!list) fail(name, *node, "a list of numbers in brackets");
    values.clear();
    for (const toml::node& entry : *list) values.push_back(read_number(name, entry, range));
  }
  template <class Enum>
  void word(std::string_view name, Enum& value, const Words<Enum>& words, std::string_view) {
    if (const toml::node* node = take(name)) value = read_word(name, *node, words);
  }
  template <class Enum>
  void words(std::string_view name, std::array<Enum, 2>& ends, const Words<Enum>& words,
             std::string_view) {
    const toml::node* node = take(name);
    if (!node) return;
    if (const toml::array* list = node->as_array(); list && list->size() == 2) {
      for (std::size_t e = 0; e < 2; ++e) ends[e] = read_word(name, (*list)[e], words);
    } else {
      ends.fill(read_word(name, *node, words));
    }
  }

  /// Throws on the first key of the file that is not declared, and on a required one that is not
  /// there.
  void finish() const {
    if (missing_.empty()) return check_unknown();
    std::set<std::string> unknown;
    each_unknown(table_, "",
                 [&](const std::string& name, const toml::node&) { unknown.insert(name); });
    const std::string meant = nearest(missing_, unknown);
    throw UserError(fmt::format(
        "{}: the key '{}' is missing{}.", file_, missing_,
        meant.empty() ? ""
                      : fmt::format("; there is '{}', which is unknown: is it meant?", meant)));
  }

 private:
  const toml::node* take(std::string_view name, Need need = Need::optional) {
    declared_.insert(std::string(name));
    const toml::node* node = table_.at_path(name).node();
    if (!node && need == Need::required && missing_.empty()) missing_ = name;
    return node;
  }
  [[noreturn]] void fail(std::string_view name, const toml::node& node,
                         std::string_view allowed) const {
    std::ostringstream found;
    node.visit([&found](const auto& n) { found << n; });
    throw UserError(
        fmt::format("{}: '{}' is {}, but must be {}.", place(node), name, found.str(), allowed));
  }
  std::string place(const toml::node& node) const {
    const toml::source_region& source = node.source();
    if (!source.path || *source.path != file_) return file_ + " with --set";
    return fmt::format("{}, line {}", file_, source.begin.line);
  }
  template <class Integer>
  Integer read_integer(std::string_view name, const toml::node& node, Range range) const {
    const auto found = node.value_exact<std::int64_t>();
    if (!found || !range.holds(static_cast<double>(*found)))
      fail(name, node, fmt::format("a whole number, {}", range.text()));
    return static_cast<Integer>(*found);
  }
  double read_number(std::string_view name, const toml::node& node, Range range) const {
    const auto found = node.is_number() ? node.value<double>() : std::nullopt;
    if (!found || !std::isfinite(*found) || !range.holds(*found))
      fail(name, node, fmt::format("a number, {}", range.text()));
    return *found;
  }
  const toml::array& list_of_three(std::string_view name, const toml::node& node) const {
    const toml::array* list = node.as_array();
    if (!list || list->size() != 3) fail(name, node, "a list of three numbers");
    return *list;
  }
  template <class Enum>
  Enum read_word(std::string_view name, const toml::node& node, const Words<Enum>& words) const {
    const auto found = node.value_exact<std::string>();
    for (const auto& [text, value] : words)
      if (found && *found == text) return value;
    fail(name, node, "one of " + word_list(words));
  }
  bool is_group(const std::string& name) const {
    return std::any_of(declared_.begin(), declared_.end(),
                       [&](const auto& known) { return known.starts_with(name + "."); });
  }
  /// Hands (name, node) of each key that is not declared to `visit`.
  template <class Visit>
  void each_unknown(const toml::table& table, const std::string& prefix, Visit visit) const {
    for (const auto& [key, node] : table) {
      const std::string name = prefix + std::string(key.str());
      if (declared_.count(name)) continue;
      if (is_group(name) && node.is_table())
        each_unknown(*node.as_table(), name + ".", visit);
      else
        visit(name, node);
    }
  }
  void check_unknown() const {
    each_unknown(table_, "", [this](const std::string& name, const toml::node& node) {
      throw UserError(fmt::format("{}: unknown key '{}'; the nearest known one is '{}'.",
                                  place(node), name, nearest(name, declared_)));
    });
  }

  const toml::table& table_;
  std::string file_;
  std::set<std::string> declared_;
  std::string missing_;  ///< the first required key that is not there
};

template <class Enum>
std::string_view word_of(const Enum& value, const Words<Enum>& words) {
  for (const auto& [text, candidate] : words)
    if (candidate == value) return text;
  return "";
}

/// Hands every key's present value as TOML text to `line(name, value, unit, allowed, meaning)`.
template <class Line>
class Writer {
 public:
  explicit Writer(Line line) : line_(std::move(line)) {}
  void text(std::string_view name, const std::string& value, std::string_view meaning) {
    std::ostringstream quoted;
    quoted << toml::value<std::string>(value);
    line_(name, quoted.str(), "-", "text", meaning);
  }
  template <class Integer>
  void integer(std::string_view name, Integer value, std::string_view unit, Range range,
               std::string_view meaning) {
    line_(name, fmt::format("{}", value), unit, range.text(), meaning);
  }
  void number(std::string_view name, double value, std::string_view unit, Range range, Need need,
              std::string_view meaning) {
    line_(name, toml_number(value), unit, allowed(range, need), meaning);
  }
  void integers(std::string_view name, const std::array<int, 3>& values, std::string_view unit,
                Range range, Need need, std::string_view meaning) {
    line_(name, fmt::format("[{}]", fmt::join(values, ", ")), unit, allowed(range, need), meaning);
  }
  void numbers(std::string_view name, const std::array<double, 3>& values, std::string_view unit,
               Range range, Need need, std::string_view meaning) {
    line_(name,
          fmt::format("[{}, {}, {}]", toml_number(values[0]), toml_number(values[1]),
                      toml_number(values[2])),
          unit, allowed(range, need), meaning);
  }
  void list(std::string_view name, const std::vector<double>& values, std::string_view unit,
            Range range, std::string_view meaning) {
    std::vector<std::string> numbers;
    numbers.reserve(values.size());
    for (const double value : values) numbers.push_back(toml_number(value));
    line_(name, fmt::format("[{}]", fmt::join(numbers, ", ")), unit,
          fmt::format("any number of numbers, each {}", range.text()), meaning);
  }
  template <class Enum>
  void word(std::string_view name, const Enum& value, const Words<Enum>& words,
            std::string_view meaning) {
    line_(name, fmt::format("\"{}\"", word_of(value, words)), "-", word_list(words), meaning);
  }
  template <class Enum>
  void words(std::string_view name, const std::array<Enum, 2>& ends, const Words<Enum>& words,
             std::string_view meaning) {
    line_(name, fmt::format("[\"{}\", \"{}\"]", word_of(ends[0], words), word_of(ends[1], words)),
          "-", word_list(words), meaning);
  }

 private:
  static std::string allowed(Range range, Need need) {
    return range.text() + (need == Need::required ? ", required" : "");
  }
  /// Shortest text that reads back as the same double and is a TOML float.
  static std::string toml_number(double value) {
    std::string text = fmt::format("{}", value);
    if (text.find_first_of(".en") == std::string::npos) text += ".0";
    return text;
  }
  Line line_;
};

/// Lays `extra` over `base`, table by table.
void merge(toml::table& base, const toml::table& extra) {
  for (const auto& [key, node] : extra) {
    if (node.is_table() && base[key].is_table())
      merge(*base[key].as_table(), *node.as_table());
    else
      base.insert_or_assign(key, node);
  }
}

/// Refuses keys of more parts (a.b.c...) than anybody means: the TOML library reads them by a
/// recursion that overflows the stack. Looks at dots outside of quotes that follow each other
/// without anything but names and spaces between them.
void check_depth(std::string_view text, const std::string& where) {
  constexpr int most_parts = 100;
  int dots = 0, line = 1;
  char quote = 0;
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      dots = 0;
      quote = 0;
    } else if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '.') {
      if (++dots > most_parts)
        throw UserError(
            fmt::format("{}, line {}: a key has more than {} parts.", where, line, most_parts));
    } else if (c == '=' || c == ',' || c == '{' || c == '[' || c == ']' || c == '#') {
      dots = 0;
    }
  }
}

toml::table parse(std::string_view text, const std::string& file) {
  check_depth(text, file);
  return toml::parse(text, file);
}

/// `key=word` as `key="word"`, where the word needs no quotes to be told from TOML's own values;
/// nothing where it is none.
std::optional<std::string> quoted(const std::string& text) {
  static const std::regex bare(
      R"(\s*([A-Za-z0-9_.\-"']+)\s*=\s*([A-Za-z_./][A-Za-z0-9_./+\-]*)\s*)");
  std::smatch match;
  if (!std::regex_match(text, match, bare)) return std::nullopt;
  return fmt::format("{}=\"{}\"", match[1].str(), match[2].str());
}

toml::table parse_override(const std::string& text) {
  check_depth(text, "--set");
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    if (const auto with_quotes = quoted(text)) return toml::parse(*with_quotes);
    throw UserError(fmt::format("--set {}: {}; write it as in TOML, for instance time.end=20.",
                                text, error.description()));
  }
}

}  // namespace

double Settings::constant_driving() const {
  if (flow.driving == Driving::pressure_gradient) return flow.pressure_gradient;
  if (flow.driving == Driving::gravity) return fluid.density * fluid.gravity[0];
  return 0.0;
}

std::string Settings::beside(const std::string& name) const {
  return (std::filesystem::path(file).parent_path() / name).string();
}

Settings parse_settings(const std::string& text, const std::string& file,
                        const std::vector<std::string>& overrides) {
  toml::table table;
  try {
    table = parse(text, file);
  } catch (const toml::parse_error& error) {
    throw UserError(
        fmt::format("{}, line {}: {}.", file, error.source().begin.line, error.description()));
  }
  for (const std::string& override_text : overrides) merge(table, parse_override(override_text));
  Settings settings;
  settings.file = file;
  Reader reader(table, file);
  declare_keys(settings, reader);
  reader.finish();
  return settings;
}

Settings read_settings(const std::string& file, const std::vector<std::string>& overrides) {
  std::ifstream stream = open_input(file);
  std::stringstream text;
  text << stream.rdbuf();
  Settings settings = parse_settings(text.str(), file, overrides);
  settings.overrides = overrides;
  return settings;
}

std::string settings_as_toml(const Settings& settings) {
  std::string out;
  Settings copy = settings;
  Writer writer([&out](std::string_view name, const std::string& value, std::string_view unit,
                       const std::string&, std::string_view meaning) {
    out += fmt::format("{} = {}  # {}[{}]\n", name, value, meaning, unit);
  });
  declare_keys(copy, writer);
  return out;
}

std::vector<std::pair<std::string, std::string>> settings_as_pairs(const Settings& settings) {
  std::vector<std::pair<std::string, std::string>> pairs;
  Settings copy = settings;
  Writer writer([&pairs](std::string_view name, const std::string& value, std::string_view,
                         const std::string&,
                         std::string_view) { pairs.emplace_back(name, value); });
  declare_keys(copy, writer);
  return pairs;
}

std::string describe_keys() {
  std::string out;
  Settings defaults;
  Writer writer([&out](std::string_view name, const std::string& value, std::string_view unit,
                       const std::string& allowed, std::string_view meaning) {
    out += fmt::format("{}\n    {}\n    unit {}; {}; default {}\n", name, meaning, unit, allowed,
                       allowed.ends_with("required") ? "none" : value);
  });
  declare_keys(defaults, writer);
  return out;
}

}  // namespace bedload
