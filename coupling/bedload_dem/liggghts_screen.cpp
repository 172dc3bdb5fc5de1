#include "coupling/bedload_dem/liggghts_screen.hpp"

#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "coupling/bedload_dem/nearest_styles.hpp"
#include "coupling/job/peer_failure.hpp"
#include "coupling/job/roles.hpp"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/private_member.hpp"

namespace bedload {
namespace detail {

/// The line of the script that LIGGGHTS is at, as it stands there.
struct ScriptLine {
  friend constexpr auto member(ScriptLine);
};
template struct PrivateMember<ScriptLine, &LAMMPS_NS::Input::line>;

/// The files that it is read from, the innermost include last, and how many.
struct ScriptFiles {
  friend constexpr auto member(ScriptFiles);
};
template struct PrivateMember<ScriptFiles, &LAMMPS_NS::Input::infiles>;

struct ScriptDepth {
  friend constexpr auto member(ScriptDepth);
};
template struct PrivateMember<ScriptDepth, &LAMMPS_NS::Input::nfile>;

}  // namespace detail
namespace {

/// LIGGGHTS numbers the bins in which it looks for neighbouring triangles from the box and the
/// largest triangle; copies through periodic ends may lie beyond them.
constexpr std::string_view lost_triangle = "region_neighbor_list_I.h";
constexpr const char* about_triangles =
    "a mesh wall has triangles that LIGGGHTS cannot keep in a periodic box of this size: their "
    "largest radius (centre to corner) has to lie between a sixth of the neighbour cut-off "
    "(largest "
    "diameter and range, and skin) and the shortest periodic length less half that cut-off; divide "
    "or "
    "join triangles, or write the wall as a primitive one";

FILE* innermost_script(const LAMMPS_NS::Input& input) {
  const int depth = input.*member(detail::ScriptDepth{});
  return depth > 0 ? (input.*member(detail::ScriptFiles{}))[depth - 1] : nullptr;
}

/// " (in.liggghts, line 12)": how far a script has been read; "" where it is no file.
std::string file_and_line(FILE* script) {
  if (script == nullptr || script == stdin) return "";
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path link = fmt::format("/proc/self/fd/{}", fileno(script));
  fs::path path = fs::read_symlink(link, error);
  if (const fs::path near = fs::proximate(path, error); !error && *near.begin() != "..")
    path = near;
  const long end = std::ftell(script);
  std::ifstream text(link);
  long lines = 0, at = 0;
  char c = '\n';
  for (; at < end && text.get(c); ++at) lines += c == '\n' ? 1 : 0;
  if (c != '\n') ++lines;  // the last one of a file may have no end
  return at < end ? "" : fmt::format(" ({}, line {})", path.string(), lines);
}

/// Several ranks may meet the same mistake at once; the first one speaks.
bool another_speaks(std::string_view line) {
  constexpr useconds_t a_moment = 200'000;
  if (line.starts_with("ERROR on proc") && !line.starts_with("ERROR on proc 0")) usleep(a_moment);
  return is_silenced();
}

}  // namespace

// LIGGGHTS' own sentences name neither the line nor the file, "Substitution for illegal variable"
// for one.
std::string LiggghtsScreen::place(const std::string& error) const {
  if (lmp_ == nullptr) return "";
  std::string_view line = lmp_->input->*member(detail::ScriptLine{});
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  line = line.substr(0, line.find_last_not_of(" \t\r\n") + 1);
  if (line.empty() || line.starts_with("coupled_run")) return "";
  return fmt::format(" The script's line is '{}'{}.{}", line,
                     file_and_line(innermost_script(*lmp_->input)), nearest_style(*lmp_, error));
}

LiggghtsScreen::LiggghtsScreen(FILE* all) : all_(all) {
  cookie_io_functions_t functions{};
  functions.write = [](void* self, const char* text, std::size_t size) {
    static_cast<LiggghtsScreen*>(self)->take(text, size);
    return static_cast<ssize_t>(size);
  };
  stream_ = fopencookie(this, "w", functions);
  // LIGGGHTS may end the process right after its message.
  setvbuf(stream_, nullptr, _IONBF, 0);
}

LiggghtsScreen::~LiggghtsScreen() { std::fclose(stream_); }

void LiggghtsScreen::take(const char* text, std::size_t size) {
  if (all_ != nullptr) std::fwrite(text, 1, size, all_);
  for (const char c : std::string_view(text, size)) {
    if (c != '\n') {
      line_ += c;
      continue;
    }
    take_line();
    line_.clear();
  }
  if (all_ != nullptr) std::fflush(all_);
}

void LiggghtsScreen::take_line() {
  // Some of LIGGGHTS' warnings say what they warn of in the next line.
  if (line_ == "WARNING:" || line_ == "WARNING: ") {
    begun_ = "WARNING: ";
    return;
  }
  if (!begun_.empty()) {
    const std::size_t text = line_.find_first_not_of(" \t");
    if (text == std::string::npos) return;
    line_ = std::exchange(begun_, "") + line_.substr(text);
  }
  const char* name = program_name(Program::dem);
  if (line_.starts_with("ERROR")) {
    saw_error_ = true;
    const bool of_triangles = line_.find(lost_triangle) != std::string::npos;
    if (all_ != nullptr) {
      if (const std::string there = place(line_); !there.empty())
        std::fprintf(all_, "%s:%s\n", name, there.c_str());
      if (of_triangles) std::fprintf(all_, "%s: %s\n", name, about_triangles);
    } else if (!another_speaks(line_)) {
      silence_peers();
      if (of_triangles) line_ = fmt::format("ERROR: {} ({})", about_triangles, line_);
      std::fprintf(stderr, "\n%s: %s%s%s\n", name, line_.c_str(), place(line_).c_str(),
                   last_checkpoint_sentence().c_str());
    }
  } else if (all_ != nullptr) {
    return;
  } else if (line_.starts_with("WARNING")) {
    if (said_.insert(line_).second) std::fprintf(stderr, "\n%s: %s\n", name, line_.c_str());
  } else if (line_.starts_with("NOTE")) {
    if (said_.insert(line_).second) std::fprintf(stderr, "%s: %s\n", name, line_.c_str());
  } else if (line_ == "Created 0 atoms") {
    std::fprintf(stderr, "\n%s: WARNING: a create_atoms has made no atom: %s\n", name,
                 "its place lies outside the box or its region");
  }
}

}  // namespace bedload
