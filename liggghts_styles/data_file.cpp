#include "liggghts_styles/data_file.hpp"

#include <fmt/format.h>
#include <mpi.h>
#include <stdio.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "atom.h"
#include "comm.h"
#include "lammps.h"
#include "liggghts_styles/keywords.hpp"
#include "read_data.h"
#include "update.h"

namespace bedload {
namespace {

constexpr std::size_t whole_columns = 2;  // number and type of an atom

/// Lines of a file, counted from 1.
class Lines {
 public:
  explicit Lines(std::FILE* file) : file_(file) {}
  ~Lines() { std::free(text_); }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  bool next() {
    ++number_;
    return getline(&text_, &room_, file_) >= 0;
  }
  std::int64_t number() const { return number_; }
  /// The words before a comment.
  std::vector<std::string> words() const {
    std::istringstream stream(std::string(text_).substr(0, std::string_view(text_).find('#')));
    std::vector<std::string> found;
    for (std::string word; stream >> word;) found.push_back(word);
    return found;
  }

 private:
  std::FILE* file_;
  char* text_ = nullptr;
  std::size_t room_ = 0;
  std::int64_t number_ = 0;
};

/// Whether the whole word is a number that a column takes.
bool is_taken(const std::string& word, bool whole) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  return *end == '\0' && std::isfinite(value) && (!whole || value == std::floor(value));
}

std::optional<std::string> flaw_of_row(const std::vector<std::string>& words, std::size_t width,
                                       std::span<const std::string_view> names, std::size_t whole) {
  if (words.size() != width)
    return fmt::format("{} words, but the first row of this section has {}", words.size(), width);
  for (std::size_t n = 0; n < words.size(); ++n) {
    if (is_taken(words[n], n < whole)) continue;
    const std::string column = n < names.size() ? fmt::format("the {}", names[n])
                                                : fmt::format("word {} of the row", n + 1);
    return fmt::format("{} is '{}', but has to be a {} number", column, words[n],
                       n < whole ? "whole" : "finite");
  }
  return std::nullopt;
}

/// File that LIGGGHTS reads for this line: `*` is the step where atoms are added.
std::string file_of(const LAMMPS_NS::LAMMPS& lmp, std::span<char*> words) {
  std::string file(words[0]);
  const auto star = file.find('*');
  if (star != std::string::npos && words.size() > 1 && std::string_view(words[1]) == "add")
    file.replace(star, 1, fmt::format("{}", lmp.update->ntimestep));
  return file;
}

/// The flaw of a file that can be read as text; about others LIGGGHTS has its sentence.
std::optional<std::string> flaw_of_file(const std::string& name, bool names_known) {
  std::FILE* const file = name.ends_with(".gz") ? nullptr : std::fopen(name.c_str(), "r");
  if (file == nullptr) return std::nullopt;
  auto flaw = flaw_of_data(file, names_known);
  std::fclose(file);
  return flaw;
}

}  // namespace

std::optional<std::string> flaw_of_data(std::FILE* file, bool names_known) {
  Lines lines(file);
  std::int64_t atoms = 0;
  lines.next();  // a title
  while (lines.next()) {
    const std::vector<std::string> head = lines.words();
    if (head.size() == 2 && head[1] == "atoms") atoms = std::strtoll(head[0].c_str(), nullptr, 10);
    const bool places = head.size() == 1 && head[0] == "Atoms";
    if (!places && !(head.size() == 1 && head[0] == "Velocities")) continue;
    using Names = std::span<const std::string_view>;
    Names names = places ? Names(granular_atoms) : Names(granular_velocities);
    if (!names_known) names = {};
    lines.next();  // an empty one
    std::size_t width = 0;
    for (std::int64_t row = 0; row < atoms && lines.next(); ++row) {
      const std::vector<std::string> words = lines.words();
      if (row == 0) width = words.size();
      if (const auto flaw = flaw_of_row(words, width, names, places ? whole_columns : 1))
        return fmt::format("line {}: {}", lines.number(), *flaw);
    }
  }
  return std::nullopt;
}

void read_checked_data(LAMMPS_NS::LAMMPS* lmp, int narg, char** arg) {
  if (narg > 0) {
    const std::string file = file_of(*lmp, std::span(arg, static_cast<std::size_t>(narg)));
    const std::string_view style(lmp->atom->atom_style != nullptr ? lmp->atom->atom_style : "");
    std::string said;
    if (lmp->comm->me == 0)
      said = flaw_of_file(file, style == "granular" || style == "sphere").value_or("");
    int size = static_cast<int>(said.size());
    MPI_Bcast(&size, 1, MPI_INT, 0, lmp->world);
    said.resize(static_cast<std::size_t>(size));
    MPI_Bcast(said.data(), size, MPI_CHAR, 0, lmp->world);
    if (!said.empty()) stop_run(lmp, fmt::format("read_data: {}, {}", file, said));
  }
  LAMMPS_NS::ReadData(lmp).command(narg, arg);
}

}  // namespace bedload
