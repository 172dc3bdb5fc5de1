#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluid/grid/sphere.hpp"
#include "fluid/output/sphere_rows.hpp"

namespace bedload {

class Hdf5File;

/// Where the spheres are and what acts on them: spheres.h5 with spheres.xdmf beside it.
///
/// /fixed is written once, but for the forces on its spheres, /fixed/force, a row per sample with
/// three numbers for each sphere, beside /fixed/force_step and /fixed/force_time. /mobile is one
/// long table, a row per mobile sphere and sample, by ascending samples and tags, each column a
/// dataset that grows. Each rank has the rows of its own spheres, fixed or mobile. A small batch of
/// them is written by the first rank, a large one by all ranks together, each an even share; in
/// between the file is closed: a killed run leaves a readable file that lacks at most the last
/// batch, and a reader may open it while the run goes on.
class SphereWriter {
 public:
  /// Seconds of wall clock between batches.
  static constexpr double default_interval = 5.0;
  /// What a mobile sphere takes in each sample: step, tag, time, radius and five vectors.
  static constexpr double row_bytes = 19.0 * 8.0;
  /// Rows of a batch up to which the first rank writes alone, 8 MB of them: opening a file together
  /// takes longer than so much data. (README.md, "Who writes the samples")
  static constexpr std::uint64_t few_rows = 50000;

  /// `spheres`: those whose centre this rank holds; of these the fixed ones are written.
  /// `resume_after` >= 0 keeps the rows up to that step of a run that is continued. Collective.
  SphereWriter(const std::string& folder, MPI_Comm comm, std::span<const SphereState> spheres,
               std::int64_t resume_after = -1, double seconds_between_batches = default_interval,
               std::uint64_t few = few_rows);
  ~SphereWriter();
  SphereWriter(const SphereWriter&) = delete;
  SphereWriter& operator=(const SphereWriter&) = delete;

  /// One sample of the mobile spheres: `spheres` are those whose centre this rank holds, `loads`
  /// this rank's part of what acts on any of them, added up by tags (zero where there is none).
  /// Collective.
  void sample(std::int64_t step, double time, std::span<const SphereState> spheres,
              std::span<const SphereLoad> loads);

  /// The same of the fixed spheres; only forces count. Written at once, in place of all samples
  /// before if told to `replace` them. Collective.
  void sample_fixed(std::int64_t step, double time, std::span<const SphereState> spheres,
                    std::span<const SphereLoad> loads, bool replace);

  /// Hands over what was gathered and renews the XDMF. Collective.
  void flush();

 private:
  struct Columns {  ///< rows of /mobile, one vector per dataset
    std::vector<std::int64_t> step, tag;
    std::vector<double> time, position, velocity, angular_velocity, force, torque, radius;
  };
  struct Instant {
    std::int64_t step;
    double time;
  };
  /// Hands (name, width, column) of each dataset of /mobile to `visit`: the only list of them.
  template <class Visitor>
  static void columns(Columns& rows, Visitor&& visit);
  struct Sample {
    double time;
    std::uint64_t first_row, rows;
  };
  void create_file();
  void write_fixed(std::span<const SphereState> spheres);
  void resume_file(std::int64_t step);
  void read_samples(const Hdf5File& file, std::int64_t step);
  void resume_forces(Hdf5File& file, std::int64_t step) const;
  static Columns columns_of(std::span<const SphereRow> rows, std::span<const Instant> instants);
  template <class Write>
  void in_file(std::uint64_t rows, std::uint64_t bytes, Write&& write);
  void note_samples(std::span<const Instant> instants, std::span<const std::uint64_t> rows);
  void write_xdmf() const;

  std::string folder_, path_;
  MPI_Comm comm_ = MPI_COMM_NULL;  ///< of its own
  bool is_first_ = false;          ///< this is the first rank
  double interval_, last_flush_;
  std::uint64_t few_;              ///< rows that the first rank writes alone
  std::vector<SphereRow> rows_;    ///< of the batch, this rank's
  std::vector<Instant> instants_;  ///< of the batch
  std::uint64_t fixed_ = 0;        ///< on all ranks together
  std::uint64_t total_rows_ = 0;   ///< in the file; first rank's, as samples_
  std::vector<Sample> samples_;
};

}  // namespace bedload
