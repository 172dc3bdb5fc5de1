#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluid/grid/sphere.hpp"

namespace bedload {

class Hdf5File;

/// Where the spheres are and what acts on them: spheres.h5 with spheres.xdmf beside it.
///
/// /fixed is written once, but for the forces on its spheres, /fixed/force, a row per sample with
/// three numbers for each sphere, beside /fixed/force_step and /fixed/force_time. /mobile is one
/// long table, a row per mobile sphere and sample, each column a dataset that grows. Rows are
/// gathered and handed over in batches, the file being closed between them: a killed run leaves a
/// readable file that lacks at most the last batch, and a reader may open it while the run goes on.
/// The list of spheres is the same on all ranks, so the first one writes alone.
class SphereWriter {
 public:
  /// Seconds of wall clock between batches.
  static constexpr double default_interval = 5.0;
  /// What a mobile sphere takes in each sample: step, tag, time, radius and five vectors.
  static constexpr double row_bytes = 19.0 * 8.0;

  /// `spheres`: all of them, at the start. `resume_after` >= 0 keeps the rows up to that step of a
  /// run that is continued. Collective.
  SphereWriter(const std::string& folder, MPI_Comm comm, std::span<const SphereState> spheres,
               std::int64_t resume_after = -1, double seconds_between_batches = default_interval);
  ~SphereWriter();
  SphereWriter(const SphereWriter&) = delete;
  SphereWriter& operator=(const SphereWriter&) = delete;

  /// One sample of the mobile spheres among `spheres`, with the load of the same tag (zero where
  /// there is none). Call on every rank; only the first one stores, and it alone throws UserError.
  void sample(std::int64_t step, double time, std::span<const SphereState> spheres,
              std::span<const SphereLoad> loads);

  /// One sample of the forces on the fixed spheres, in the order of /fixed; written at once, in
  /// place of all others if told to `replace` them. Call on every rank, as above.
  void sample_fixed(std::int64_t step, double time, std::span<const SphereLoad> forces,
                    bool replace);

  /// Hands over what was gathered and renews the XDMF. First rank's own.
  void flush();

 private:
  struct Rows {  ///< gathered rows, one vector per dataset
    std::vector<std::int64_t> step, tag;
    std::vector<double> time, position, velocity, angular_velocity, force, torque, radius;
  };
  /// Hands (name, width, column) of each dataset of /mobile to `visit`: the only list of them.
  template <class Visitor>
  static void columns(Rows& rows, Visitor&& visit);
  struct Sample {
    double time;
    std::uint64_t first_row, rows;
  };
  void create_file(std::span<const SphereState> spheres);
  void resume_file(std::int64_t step);
  void resume_forces(Hdf5File& file, std::int64_t step) const;
  void write_xdmf() const;

  std::string folder_, path_;
  bool writes_ = false;  ///< this is the first rank
  double interval_, last_flush_;
  Rows rows_;
  std::uint64_t total_rows_ = 0, fixed_ = 0;
  std::vector<Sample> samples_;
};

}  // namespace bedload
