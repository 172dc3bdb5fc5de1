#include "fluid/checkpoint/checkpoint_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <optional>

#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "checkpoint_";
constexpr std::size_t kept = 2;

std::string part_folder(const std::string& out) { return out + "/checkpoint.part"; }

/// The step in the name of a checkpoint's folder.
std::optional<std::int64_t> step_of(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(prefix)) return std::nullopt;
  std::int64_t step = 0;
  const char* const end = name.data() + name.size();
  const auto [read, error] = std::from_chars(name.data() + prefix.size(), end, step);
  if (error != std::errc{} || read != end || step < 0) return std::nullopt;
  return step;
}

/// Whether a program of ours, or MPI-IO on its behalf ("fluid.h5.part-1.lock"), wrote the file.
bool is_part(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.starts_with("fluid.") || name.starts_with("grains.");
}

/// Removes the parts, and the folder where nothing else is left in it.
void remove_parts(const std::string& folder) noexcept {
  std::error_code error;
  std::vector<fs::path> parts;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (is_part(entry.path())) parts.push_back(entry.path());
  for (const fs::path& part : parts) fs::remove(part, error);
  fs::remove(folder, error);
}

/// `base`, or base1, base2, … when that is taken; empty when all are.
std::string free_name(const std::string& base) {
  std::error_code error;
  for (int n = 0; n < 1000; ++n) {
    std::string name = n == 0 ? base : base + std::to_string(n);
    if (!fs::exists(fs::symlink_status(name, error))) return name;
  }
  return {};
}

/// Removes a checkpoint. What somebody else put there, or what the file system holds on to, stays
/// in `folder`.left, which no reader takes for a checkpoint. Tidying up never ends a run.
void remove_checkpoint(const std::string& folder) noexcept {
  try {
    std::error_code error;
    if (!fs::exists(fs::symlink_status(folder, error))) return;
    // It loses its name first, so that no reader finds one that is half removed.
    const std::string old = (fs::path(folder).parent_path() / "checkpoint.old").string();
    if (folder != old) remove_checkpoint(old);
    fs::rename(folder, old, error);
    const std::string& now = error ? folder : old;
    remove_parts(now);
    if (!fs::exists(now, error)) return;
    const std::string left = free_name(folder + ".left");
    fs::rename(now, left, error);
    fmt::print(stderr, "bedload-fluid: WARNING: {} {}\n", folder,
               error ? fmt::format("cannot be removed ({}).", error.message())
                     : fmt::format("holds more than a checkpoint; the rest is {} now.", left));
  } catch (const std::exception&) {  // out of memory, say: it stays
  }
}

void sync(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY);
  const bool done = file >= 0 && (::fsync(file) == 0 || errno == EINVAL);
  const int error = errno;
  if (file >= 0) ::close(file);
  if (!done)
    throw UserError(fmt::format("{}: cannot be written ({}).", path, std::strerror(error)));
}

}  // namespace

CheckpointPlace checkpoint_place(const std::string& out, std::int64_t step) {
  return {fmt::format("{}/{}{:08d}", out, prefix, step), step};
}

std::vector<CheckpointPlace> find_checkpoints(const std::string& out) {
  std::vector<CheckpointPlace> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(out, error))
    if (const auto step = step_of(entry.path()); step && entry.is_directory(error))
      found.push_back({entry.path().string(), *step});
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.step < b.step; });
  return found;
}

CheckpointPlace locate_checkpoint(const std::string& where) {
  fs::path path = fs::absolute(where).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (!fs::exists(path)) throw UserError(fmt::format("--restart {}: there is nothing.", where));
  if (const auto step = step_of(path)) return {path.string(), *step};
  const auto found = find_checkpoints(path.string());
  if (found.empty())
    throw UserError(fmt::format(
        "--restart {}: is neither a checkpoint nor a folder of a run that holds one.", where));
  return found.back();
}

std::string begin_checkpoint(const std::string& out) {
  std::string folder = part_folder(out);
  remove_checkpoint(folder);
  std::error_code error;
  if (!fs::create_directory(folder, error) && !fs::is_directory(folder))
    throw UserError(fmt::format("{}: cannot be made ({}).", folder,
                                error ? error.message() : "something else stands there"));
  return folder;
}

CheckpointPlace commit_checkpoint(const std::string& out, std::int64_t step) {
  CheckpointPlace place = checkpoint_place(out, step);
  const std::string& folder = place.folder;
  sync(part_folder(out));
  remove_checkpoint(folder);
  if (::rename(part_folder(out).c_str(), folder.c_str()) != 0)
    throw UserError(fmt::format("{}: cannot be written ({}).", folder, std::strerror(errno)));
  sync(out);
  const auto all = find_checkpoints(out);
  for (std::size_t n = 0; n + kept < all.size(); ++n) remove_checkpoint(all[n].folder);
  return place;
}

void discard_checkpoint(const std::string& out) noexcept { remove_checkpoint(part_folder(out)); }

void forget_checkpoints_after(const std::string& out, std::int64_t step) {
  for (const CheckpointPlace& place : find_checkpoints(out))
    if (place.step > step) remove_checkpoint(place.folder);
}

}  // namespace bedload
