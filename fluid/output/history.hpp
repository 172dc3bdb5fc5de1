#pragma once

#include <cstdint>
#include <string>
#include <tuple>

#include "fluid/files/csv_file.hpp"

namespace bedload {

/// The state of a run at one step: one row of history.csv.
struct HistoryRow {
  std::int64_t step = 0;
  double time = 0.0;               ///< [T]
  double dt = 0.0;                 ///< step just made [T]
  double cfl = 0.0;                ///< its max over cells of (|u| + |v| + |w|) dt / h
  double bulk_velocity = 0.0;      ///< mean of u over the box [L/T]
  double driving = 0.0;            ///< mean driving force per volume along x [M/(L^2 T^2)]
  double kinetic_energy = 0.0;     ///< per volume of the box [M/(L T^2)]
  double dissipation = 0.0;        ///< what viscosity turns into heat [M/(L T^3)]
  double forcing_work = 0.0;       ///< of the markers on the flow, last step [M/(L T^3)]
  double viscous_work = 0.0;       ///< of viscosity and sliding walls (energy_account.hpp)
  double convective_work = 0.0;    ///< of convection, likewise: an error of the time scheme
  double u_tau_driving = 0.0;      ///< of the driving force (derived_numbers.hpp) [L/T]
  double wall_stress_lower = 0.0;  ///< of the fluid on the lower y wall along x [M/(L T^2)]
  double wall_stress_upper = 0.0;
  /// Of the mobile spheres on walls below them along x, by contacts and by films, over the area of
  /// a y wall, mean over the last step [M/(L T^2)]; the fluid's stress is without it.
  double grain_stress_lower = 0.0;
  double grain_stress_upper = 0.0;  ///< on walls above them
  double max_divergence = 0.0;      ///< largest |div u| [1/T]
  double slip_max = 0.0;            ///< largest slip of a marker [L/T]
  double slip_rms = 0.0;            ///< [L/T]
  std::int64_t forcing_loops = 0;   ///< of the last stage
  std::int64_t mobile_spheres = 0;
  double momentum_residual = 0.0;  ///< largest since the row before, relative; NaN: not followed
  /// Of the fluid on all fixed spheres, mean over the last step, buoyancy included [M L/T^2].
  double fixed_force_x = 0.0, fixed_force_y = 0.0, fixed_force_z = 0.0;
};

template <class T>
struct HistoryColumn {
  const char* name;
  T HistoryRow::*value;
};

/// The columns in their order; header and rows come from here.
inline constexpr std::tuple history_columns{
    HistoryColumn<std::int64_t>{"step", &HistoryRow::step},
    HistoryColumn<double>{"time", &HistoryRow::time},
    HistoryColumn<double>{"dt", &HistoryRow::dt},
    HistoryColumn<double>{"cfl", &HistoryRow::cfl},
    HistoryColumn<double>{"bulk_velocity", &HistoryRow::bulk_velocity},
    HistoryColumn<double>{"driving", &HistoryRow::driving},
    HistoryColumn<double>{"kinetic_energy", &HistoryRow::kinetic_energy},
    HistoryColumn<double>{"dissipation", &HistoryRow::dissipation},
    HistoryColumn<double>{"forcing_work", &HistoryRow::forcing_work},
    HistoryColumn<double>{"viscous_work", &HistoryRow::viscous_work},
    HistoryColumn<double>{"convective_work", &HistoryRow::convective_work},
    HistoryColumn<double>{"u_tau_driving", &HistoryRow::u_tau_driving},
    HistoryColumn<double>{"wall_stress_lower", &HistoryRow::wall_stress_lower},
    HistoryColumn<double>{"wall_stress_upper", &HistoryRow::wall_stress_upper},
    HistoryColumn<double>{"grain_stress_lower", &HistoryRow::grain_stress_lower},
    HistoryColumn<double>{"grain_stress_upper", &HistoryRow::grain_stress_upper},
    HistoryColumn<double>{"max_divergence", &HistoryRow::max_divergence},
    HistoryColumn<double>{"slip_max", &HistoryRow::slip_max},
    HistoryColumn<double>{"slip_rms", &HistoryRow::slip_rms},
    HistoryColumn<std::int64_t>{"forcing_loops", &HistoryRow::forcing_loops},
    HistoryColumn<std::int64_t>{"mobile_spheres", &HistoryRow::mobile_spheres},
    HistoryColumn<double>{"momentum_residual", &HistoryRow::momentum_residual},
    HistoryColumn<double>{"fixed_force_x", &HistoryRow::fixed_force_x},
    HistoryColumn<double>{"fixed_force_y", &HistoryRow::fixed_force_y},
    HistoryColumn<double>{"fixed_force_z", &HistoryRow::fixed_force_z}};

/// The names of all columns, with commas between.
std::string history_header();
/// The values in the same order; numbers read back as the same double.
std::string history_line(const HistoryRow& row);

/// folder/history.csv. For the first rank.
class History {
 public:
  /// `resume_after` >= 0 keeps the rows up to that step of a run that is continued.
  explicit History(const std::string& folder, std::int64_t resume_after = -1)
      : file_(folder + "/history.csv", history_header(), resume_after) {}
  /// Step of the last row that was kept; -1: none was.
  std::int64_t kept_until() const { return file_.kept_until(); }
  void add(const HistoryRow& row) { file_.add(history_line(row)); }

 private:
  CsvFile file_;
};

}  // namespace bedload
