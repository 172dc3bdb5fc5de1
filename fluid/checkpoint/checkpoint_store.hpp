#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fluid/files/file_header.hpp"

namespace bedload {

/// Checkpoints of a run: folders `checkpoint_00001234` in its output folder, named by the fluid
/// step, each with the state of both programs. One is written as `checkpoint.part` and gets its
/// name when all of it is on disk, so both sides appear at once or not at all. Plain functions for
/// one rank; each throws UserError with the path and the system's reason.

inline constexpr const char* checkpoint_fluid_part = "fluid.h5";
inline constexpr const char* checkpoint_grains_part = "grains.h5";
/// In front of the grains' file.
inline constexpr FileHeader grains_file_header{"bedload grains", 4};

/// The group of all that it holds.
inline constexpr const char* grains_group = "grains";
/// Dataset in both halves: a random number that is the same in both.
inline constexpr const char* id_name = "checkpoint_id";

struct CheckpointPlace {
  std::string folder;
  std::int64_t step = -1;

  std::string fluid() const { return folder + "/" + checkpoint_fluid_part; }
  std::string grains() const { return folder + "/" + checkpoint_grains_part; }
};

/// Where the checkpoint after `step` stands once it is whole.
CheckpointPlace checkpoint_place(const std::string& out, std::int64_t step);

/// Those in the output folder of a run, the oldest first.
std::vector<CheckpointPlace> find_checkpoints(const std::string& out);

/// What `--restart WHERE` means: a checkpoint itself, or the newest one in a run's output folder.
CheckpointPlace locate_checkpoint(const std::string& where);

/// Makes the empty folder that a checkpoint is written to and returns its path.
std::string begin_checkpoint(const std::string& out);

/// Forces what stands in begin_checkpoint()'s folder to disk, gives it its final name, and removes
/// all but the last two.
CheckpointPlace commit_checkpoint(const std::string& out, std::int64_t step);

/// Removes what a run that was cut off left half-written; never throws.
void discard_checkpoint(const std::string& out) noexcept;

/// Removes the checkpoints of later steps, when a run goes on from an earlier one in its folder.
void forget_checkpoints_after(const std::string& out, std::int64_t step);

}  // namespace bedload
