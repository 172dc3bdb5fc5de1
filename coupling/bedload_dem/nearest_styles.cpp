#include "coupling/bedload_dem/nearest_styles.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "fluid/settings/nearest_name.hpp"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/private_access.hpp"
#include "modify.h"

namespace bedload {
namespace detail {

struct CommandWord {
  friend constexpr auto member(CommandWord);
};
template struct PrivateMember<CommandWord, &LAMMPS_NS::Input::command>;

struct ComputeStyles {
  friend constexpr auto member(ComputeStyles);
};
template struct PrivateMember<ComputeStyles, &LAMMPS_NS::Modify::compute_map>;

struct PairStyles {
  friend constexpr auto member(PairStyles);
};
template struct PrivateMember<PairStyles, &LAMMPS_NS::Force::pair_map>;

using Models = LIGGGHTS::ContactModels::Factory;

struct NormalModels {
  friend constexpr auto member(NormalModels);
};
template struct PrivateMember<NormalModels, &Models::normal_models>;

struct TangentialModels {
  friend constexpr auto member(TangentialModels);
};
template struct PrivateMember<TangentialModels, &Models::tangential_models>;

struct CohesionModels {
  friend constexpr auto member(CohesionModels);
};
template struct PrivateMember<CohesionModels, &Models::cohesion_models>;

struct RollingModels {
  friend constexpr auto member(RollingModels);
};
template struct PrivateMember<RollingModels, &Models::rolling_models>;

struct SurfaceModels {
  friend constexpr auto member(SurfaceModels);
};
template struct PrivateMember<SurfaceModels, &Models::surface_models>;

}  // namespace detail
namespace {

using Names = std::set<std::string>;

/// What LIGGGHTS compares word by word, with no table that a program could read.
const Names built_in_commands{"atom_modify",   "atom_style",   "boundary",       "box",
                              "clear",         "communicate",  "compute",        "dimension",
                              "dump",          "dump_modify",  "echo",           "fix",
                              "fix_modify",    "group",        "hard_particles", "if",
                              "include",       "jump",         "label",          "lattice",
                              "log",           "mass",         "neigh_modify",   "neighbor",
                              "newton",        "next",         "pair_coeff",     "pair_modify",
                              "pair_style",    "partition",    "print",          "processors",
                              "quit",          "region",       "reset_timestep", "restart",
                              "run_style",     "shell",        "soft_particles", "thermo",
                              "thermo_modify", "thermo_style", "timestep",       "uncompute",
                              "undump",        "unfix",        "units",          "variable"};
const Names dump_styles{"atom/vtk",  "custom",   "custom/vtk", "decomposition/vtk",
                        "euler/vtk", "image",    "local",      "local/gran/vtk",
                        "mesh/stl",  "mesh/vtk", "movie",      "stl",
                        "xyz"};
const Names region_styles{"block", "cone",  "cylinder", "intersect", "mesh/tet",
                          "plane", "prism", "sphere",   "union",     "wedge"};
const Names atom_styles{"granular", "hybrid", "sphere"};

template <class Table>
Names names_of(const Table& table) {
  Names names;
  for (const auto& entry : table) names.insert(entry.first);
  return names;
}

std::string sentence(std::string_view kind, const std::string& word, const Names& known) {
  return fmt::format(" The nearest {} to '{}' is '{}'.", kind, word, nearest(word, known));
}

/// LIGGGHTS' contact models by the word in front of their name.
std::map<std::string, std::map<std::string, int>> contact_models() {
  detail::Models& all = detail::Models::instance();
  return {{"model", all.*member(detail::NormalModels{})},
          {"tangential", all.*member(detail::TangentialModels{})},
          {"cohesion", all.*member(detail::CohesionModels{})},
          {"rolling_friction", all.*member(detail::RollingModels{})},
          {"surface", all.*member(detail::SurfaceModels{})}};
}

/// The words behind a command that name contact models, of `pair_style` and `fix wall/gran`.
std::string nearest_model(const std::vector<std::string>& words) {
  const auto models = contact_models();
  bool any = false;
  for (std::size_t n = 0; n + 1 < words.size(); ++n) {
    const auto kind = models.find(words[n]);
    if (kind == models.end()) continue;
    any = true;
    if (!kind->second.contains(words[n + 1]))
      return sentence(fmt::format("name behind '{}'", words[n]), words[n + 1],
                      names_of(kind->second));
    ++n;
  }
  return any ? " Each of its contact models is known, but these do not go together "
               "(liggghts_styles/doc)."
             : "";
}

}  // namespace

std::string nearest_style(const LAMMPS_NS::LAMMPS& lmp, std::string_view error) {
  LAMMPS_NS::Input& input = *lmp.input;
  const char* const command = input.*member(detail::CommandWord{});
  if (command == nullptr) return "";
  std::vector<std::string> words{command};
  for (const char* word : std::span(input.arg, static_cast<std::size_t>(input.narg)))
    words.emplace_back(word);
  const auto about = [&](std::string_view start, std::size_t place) {
    return error.find(start) != std::string_view::npos && place < words.size();
  };
  if (about("Unknown command", 0)) {
    Names known = names_of(*(input.*member(detail::Commands{})));
    known.insert(built_in_commands.begin(), built_in_commands.end());
    return sentence("command", words[0], known);
  }
  if (about("Invalid fix style", 3))
    return sentence("fix style", words[3], names_of(*(lmp.modify->*member(detail::FixStyles{}))));
  if (about("Invalid compute style", 3))
    return sentence("compute style", words[3],
                    names_of(*(lmp.modify->*member(detail::ComputeStyles{}))));
  if (about("Invalid pair style", 1))
    return sentence("pair style", words[1], names_of(*(lmp.force->*member(detail::PairStyles{}))));
  if (about("Invalid dump style", 3)) return sentence("dump style", words[3], dump_styles);
  if (about("Invalid region style", 2)) return sentence("region style", words[2], region_styles);
  if (about("Invalid atom style", 1)) return sentence("atom style", words[1], atom_styles);
  const bool models = about("Invalid model specified", 1) || about("Unknown normal model", 1) ||
                      about("Unknown tangential model", 1) || about("Unknown cohesion model", 1) ||
                      about("Unknown rolling model", 1) || about("Unknown surface model", 1);
  return models ? nearest_model(words) : "";
}

}  // namespace bedload
