#include "coupling/bedload_dem/inputs_folder.hpp"

#include <filesystem>
#include <system_error>

namespace bedload {

namespace fs = std::filesystem;

std::string inputs_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / "share" / "bedload";
  std::string found =
      fs::is_directory(installed / "models", error) ? installed.string() : BEDLOAD_INPUTS;
  if (found.find_first_of(" \t\n") == std::string::npos) return found;
  const fs::path from_here = fs::relative(found, error);
  return error ? found : from_here.string();
}

std::vector<char*> with_inputs(int argc, char** argv, std::string& folder) {
  static char option[] = "-var", name[] = "inputs";
  std::vector<char*> all(argv, argv + argc);
  all.insert(all.end(), {option, name, folder.data(), nullptr});
  return all;
}

}  // namespace bedload
