#pragma once

#include <cstdio>
#include <string>

namespace bedload {

/// A table of text that grows row by row: every row is on its way to the disk when add() returns,
/// so that a killed run leaves whole rows. For one rank; throws UserError naming the file.
class CsvFile {
 public:
  /// Replaces what stands under `path`. With `resume_after` >= 0 the rows of an old file with the
  /// same header are kept while their first column is at most that number.
  CsvFile(const std::string& path, const std::string& header, long long resume_after = -1);
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  void add(const std::string& row);
  /// First column of the last row that was kept; -1: none was.
  long long kept_until() const { return kept_until_; }

 private:
  std::string path_;
  std::FILE* file_ = nullptr;
  long long kept_until_ = -1;
};

}  // namespace bedload
