#pragma once

#include <cstdint>
#include <string>

namespace bedload {

/// Files are written under another name beside their final one and renamed when whole, so that a
/// reader, or whoever looks after a crash, never meets half a file under a final name. Plain
/// functions for one rank; each throws UserError with the file's name and the system's reason.

/// Where the file is written until it is whole: path + ".part".
std::string temporary_name(const std::string& path);

/// Forces temporary_name(path) to disk and gives it its final name, over whatever stood there.
void commit_file(const std::string& path);

/// Gives the whole file `existing` a second name, over whatever stood there; a copy where the file
/// system knows no second names.
void commit_link(const std::string& existing, const std::string& path);

/// Removes temporary_name(path) if it is there; never throws.
void discard_temporary(const std::string& path) noexcept;

/// A file that grows in place has its final name only while it is whole: it is renamed before
/// something is added, and put back behind that.
void mark_unfinished(const std::string& path);
void mark_whole(const std::string& path);

/// For a run that goes on: what a killed run left of such a file gets its final name again.
/// Returns whether there is a file; whether it is whole its reader has to find out.
bool find_resumable(const std::string& path);

/// Renames such a file that turns out to be damaged to NAME.torn; returns this name.
std::string rename_damaged_file(const std::string& path);

/// Writes a whole text file under its temporary name and commits it.
void write_text_file(const std::string& path, const std::string& text);

/// Takes `bytes` of the disk for a moment, beside `path`, and gives them back. A full disk, a quota
/// or a folder that cannot be written to is found here, before any rank is inside a collective
/// write: parallel HDF5 1.10 on Open MPI 4.1 was seen to hang in H5Fclose after a failed write.
void require_space(const std::string& path, std::uint64_t bytes);

}  // namespace bedload
