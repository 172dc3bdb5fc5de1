#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bedload {

/// What closes the box at one end of a direction.
enum class Wall { periodic, no_slip, free_slip };

/// What keeps the flow going.
enum class Driving { none, bulk_velocity, pressure_gradient, gravity };

/// How diffusion is stepped in time.
enum class Diffusion { automatic, explicit_, implicit };

/// The field that a run starts from.
enum class Start { rest, laminar, logarithmic, state };

/// When spheres and fluid tell each other of loads and motion.
enum class Exchange { stage, step };

/// Everything that fluid.toml can say. The member initialisers are the defaults; name, unit, range
/// and meaning of each key stand once, in declared_keys.hpp.
struct Settings {
  std::string file;                    ///< where it was read from, for messages
  std::vector<std::string> overrides;  ///< "key=value" of the command line, in order
  /// Path of a file that fluid.toml names, beside which it stands.
  std::string beside(const std::string& name) const;
  /// Driving force per volume along x that the settings fix: of a pressure gradient, or of gravity
  /// down a slope [M/(L^2 T^2)]; 0 where none is fixed.
  double constant_driving() const;
  /// Height over which a driving force G per volume is borne by one wall or the bed on it, whose
  /// stress is G times it [L]: reference.height; between two no-slip y walls half of the distance
  /// that the flow has there. That distance is reference.height, or twice that where it fills the
  /// height above start.height to within 5 %.
  double driven_height() const;

  std::string title = "bedload";
  struct Grid {
    std::array<int, 3> cells{};
    std::array<double, 3> length{};
    double y_stretching = 0.0;
    double y_uniform = 0.0;
  } grid;
  struct Boundary {
    std::array<Wall, 2> x{Wall::periodic, Wall::periodic};
    std::array<Wall, 2> y{Wall::no_slip, Wall::free_slip};
    std::array<Wall, 2> z{Wall::periodic, Wall::periodic};
    std::array<double, 3> x_lower_velocity{};
    std::array<double, 3> x_upper_velocity{};
    std::array<double, 3> y_lower_velocity{};
    std::array<double, 3> y_upper_velocity{};
    std::array<double, 3> z_lower_velocity{};
    std::array<double, 3> z_upper_velocity{};
  } boundary;
  struct Fluid {
    double density = 1.0;
    double kinematic_viscosity = 0.0;
    std::array<double, 3> gravity{};
    bool convection = true;
    Diffusion diffusion = Diffusion::automatic;
  } fluid;
  struct Flow {
    Driving driving = Driving::none;
    double bulk_velocity = 0.0;
    double pressure_gradient = 0.0;
  } flow;
  struct Fringe {
    double rate = 0.0;
    double begin = 0.0;
    double end = 0.0;
    double velocity = 0.0;
  } fringe;
  struct Start_ {
    Start from = Start::rest;
    std::string file;
    double velocity = 0.0;
    double height = 0.0;
    double disturbance = 0.0;
    std::int64_t seed = 1;
  } start;
  struct Time {
    double step = 0.0;
    double cfl = 0.0;
    double end = 0.0;
    double wall_limit = 0.0;
  } time;
  struct Checkpoint {
    double every = 0.0;
    double wall_every = 600.0;
  } checkpoint;
  struct Spheres {
    std::string file;
    int forcing_loops = 1;
    double slip_tolerance = 0.0;
    double retraction = -1.0;
    double marker_density = 0.7;
    double pressure_share = -1.0;         // negative: immersed_boundary/deferred_share.hpp
    double deferred_impulse_share = 0.0;  // 0: likewise
    double deferred_angular_share = 0.0;  // 0: likewise
    bool interior_term = true;
    bool rigid_core = true;
    bool buoyancy = true;
  } spheres;
  struct Coupling {
    Exchange exchange = Exchange::stage;
    int dem_steps = 15;
  } coupling;
  struct Ranks {
    int along_z = 0;
  } ranks;
  struct Accuracy {
    std::string precision = "double";
    std::string verdicts;
  } accuracy;
  struct Output {
    double fields_every = 0.0;
    double spheres_every = 0.0;
    double fixed_every = 0.0;
    int history_every = 10;
    bool energy_work = false;
  } output;
  struct Statistics {
    int every = 0;
    double from = 0.0;
    std::vector<double> spectra_heights;
    int spectra_every = 1;
  } statistics;
  struct Reference {
    double velocity = 1.0;
    double height = 1.0;
    double diameter = 1.0;
    double sphere_density = 0.0;
  } reference;
};

/// Reads fluid.toml, then the overrides ("time.end=20", TOML syntax on the right-hand side; a bare
/// word stands for itself in quotes). Throws UserError with file, key, the value found, what is
/// allowed, and for an unknown key the nearest name. The keys are looked at one by one;
/// fluid/validation judges them together.
Settings read_settings(const std::string& file, const std::vector<std::string>& overrides = {});

/// The same from TOML text; `file` only names it in messages.
Settings parse_settings(const std::string& text, const std::string& file,
                        const std::vector<std::string>& overrides = {});

/// All values in force as TOML, with unit and meaning behind each, ready to be read again.
std::string settings_as_toml(const Settings& settings);

/// The same as pairs of key and value, as TOML writes it.
std::vector<std::pair<std::string, std::string>> settings_as_pairs(const Settings& settings);

/// For each key: name, default, unit, allowed values and meaning (bedload-fluid --help-keys).
std::string describe_keys();

}  // namespace bedload
