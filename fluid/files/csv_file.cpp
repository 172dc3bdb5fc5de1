#include "fluid/files/csv_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "fluid/files/atomic_file.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {

CsvFile::CsvFile(const std::string& path, const std::string& header, long long resume_after)
    : path_(path) {
  std::string text = header + "\n";
  if (resume_after >= 0) {
    std::ifstream old(path);
    std::string line;
    if (old && std::getline(old, line) && line != header)
      throw UserError(fmt::format("{}: has other columns than this program writes.", path));
    // A last line without its end was cut off by a crash and is left out.
    while (std::getline(old, line) && !old.eof()) {
      const long long first = std::strtoll(line.c_str(), nullptr, 10);
      if (first > resume_after) continue;
      text += line + "\n";
      kept_until_ = first;
    }
  }
  write_text_file(path, text);
  file_ = std::fopen(path.c_str(), "a");
  if (!file_)
    throw UserError(fmt::format("{}: cannot be written ({}).", path, std::strerror(errno)));
}

CsvFile::~CsvFile() {
  if (file_) std::fclose(file_);
}

void CsvFile::add(const std::string& row) {
  const std::string line = row + "\n";
  if (std::fwrite(line.data(), 1, line.size(), file_) != line.size() || std::fflush(file_) != 0)
    throw UserError(fmt::format("{}: cannot be written ({}).", path_, std::strerror(errno)));
}

}  // namespace bedload
