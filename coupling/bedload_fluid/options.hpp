#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bedload {

/// The command line of bedload-fluid.
struct FluidOptions {
  std::string file;                   ///< fluid.toml
  std::vector<std::string> settings;  ///< --set key=value
  std::string out;                    ///< --out DIR
  std::string restart;                ///< --restart DIR; empty: from the beginning
  std::int64_t steps = -1;            ///< --steps N; negative: until time.end
  std::int64_t warm_up = 0;           ///< --warm-up N: steps that the table of times leaves out
  bool overwrite = false;             ///< --overwrite: a fresh start may remove checkpoints
  bool without_grains = false;        ///< --without-grains: the flow of a scene that has some
  bool bandwidth = false;             ///< --bandwidth: measure the memory's at the end
  /// --compact-state STATE START: a state file and the small start field to make of it; no run.
  std::vector<std::string> compact;
};

/// Reads the command line. Returns nothing when all that was wanted is printed (--help,
/// --help-keys, --version; by rank 0 alone). Throws UserError.
std::optional<FluidOptions> read_fluid_options(int argc, char** argv, bool first_rank);

}  // namespace bedload
