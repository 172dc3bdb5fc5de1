#pragma once

#include <mpi.h>

#include <cstdint>
#include <string>

namespace bedload {

/// In front of the content of each file that a run may be continued from stands one block of text
/// with the kind and version of the format and the size and check sum of all bytes behind it, so
/// that damage is found before anybody trusts the bytes.
inline constexpr std::uint64_t file_header_bytes = 512;

/// What a file says that it is.
struct FileHeader {
  const char* kind;  ///< for people and programs: "bedload state"
  int version;
};

/// Writes the block of temporary_name(path), whose content stands behind it already and is closed.
/// Collective; throws UserError on all ranks.
void write_file_header(const std::string& path, const FileHeader& block, MPI_Comm comm);

/// Refuses what is not exactly the file that was sealed: missing, foreign, of another version,
/// truncated, too long or damaged. Collective; throws UserError with one sentence on all ranks.
void check_file_header(const std::string& path, const FileHeader& block, MPI_Comm comm);

}  // namespace bedload
