// A file that takes its name only when it is whole.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "fluid/files/atomic_file.hpp"

namespace bedload {
namespace {

/// Given once more, as by a restart that makes no step: rename does nothing where both names are
/// links to one file.
TEST(AtomicFile, ALinkGivenTwiceLeavesNoTemporaryName) {
  const auto folder = std::filesystem::temp_directory_path() / "bedload-atomic-file-test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  const std::string state = folder / "checkpoint.h5", path = folder / "state.h5";
  std::ofstream(state) << "whole";
  for (int time = 0; time < 2; ++time) {
    commit_link(state, path);
    EXPECT_TRUE(std::filesystem::equivalent(state, path));
    EXPECT_FALSE(std::filesystem::exists(temporary_name(path)));
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace bedload
