#include "coupling/checkpoint/script_atoms.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mpi.h>

#include <algorithm>
#include <bit>
#include <sstream>

#include "atom.h"
#include "fluid/kernels/fnv.hpp"
#include "group.h"
#include "lammps.h"
#include "update.h"

namespace bedload {

std::vector<std::string> group_names(LAMMPS_NS::LAMMPS* lmp) {
  std::vector<std::string> names(most_groups);
  for (std::size_t n = 0; n < most_groups; ++n)
    if (lmp->group->names[n]) names[n] = lmp->group->names[n];
  return names;
}

// The exclusive or of each atom's FNV-1a does not care for the order.
ScriptAtoms ScriptAtoms::of(LAMMPS_NS::LAMMPS* lmp) {
  const LAMMPS_NS::Atom& atom = *lmp->atom;
  ScriptAtoms made;
  made.groups = group_names(lmp);
  constexpr std::size_t sizes = most_groups, states = most_groups + 1;
  std::array<std::uint64_t, most_groups + 2> hashes{};
  const bool as_placed = lmp->update->ntimestep == 0;
  std::int64_t count = atom.nlocal;
  for (int i = 0; i < atom.nlocal; ++i) {
    const std::uint64_t number = fnv_mixed(fnv_start, static_cast<std::uint64_t>(atom.tag[i]));
    for (std::size_t n = 0; n < most_groups; ++n)
      if ((static_cast<std::uint32_t>(atom.mask[i]) >> n & 1u) != 0) hashes[n] ^= number;
    hashes[sizes] ^= fnv_mixed(number, std::bit_cast<std::uint64_t>(atom.radius[i]));
    std::uint64_t state = fnv_mixed(number, std::bit_cast<std::uint64_t>(atom.density[i]));
    if (as_placed)
      for (const double* const vector : {atom.x[i], atom.v[i], atom.omega[i]})
        for (int d = 0; d < 3; ++d)
          state = fnv_mixed(state, std::bit_cast<std::uint64_t>(vector[d]));
    hashes[states] ^= state;
  }
  MPI_Allreduce(MPI_IN_PLACE, hashes.data(), static_cast<int>(hashes.size()), MPI_UINT64_T,
                MPI_BXOR, lmp->world);
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, lmp->world);
  for (std::size_t n = 0; n < most_groups; ++n)
    made.members[n] = std::bit_cast<std::int64_t>(hashes[n]);
  made.sizes = std::bit_cast<std::int64_t>(hashes[sizes]);
  made.states = std::bit_cast<std::int64_t>(hashes[states]);
  made.count = count;
  return made;
}

void ScriptAtoms::save(const SaveGroup& group) const {
  group.text("groups", fmt::format("{}", fmt::join(groups, "\n")));
  group.list<std::int64_t>("members", members);
  group.value("count", count);
  group.value("sizes", sizes);
  if (states) group.value("states", *states);
}

void ScriptAtoms::load(const LoadGroup& group) {
  std::istringstream names(group.text("groups"));
  groups.clear();
  for (std::string name; std::getline(names, name);) groups.push_back(name);
  groups.resize(most_groups);
  const auto found = group.list<std::int64_t>("members");
  std::copy_n(found.begin(), std::min(found.size(), most_groups), members.begin());
  count = group.value<std::int64_t>("count");
  sizes = group.value<std::int64_t>("sizes");
  if (group.has("states")) states = group.value<std::int64_t>("states");
}

std::string ScriptAtoms::what_differs(const ScriptAtoms& other) const {
  if (count != other.count) return fmt::format("{} spheres", other.count);
  if (sizes != other.sizes) return "spheres of other sizes or numbers";
  if (states && other.states && *states != *other.states)
    return "spheres of other densities, or elsewhere or with other speeds";
  return "";
}

int ScriptAtoms::bit_of(const std::string& name) const {
  const auto found = std::find(groups.begin(), groups.end(), name);
  return found == groups.end() ? -1 : static_cast<int>(found - groups.begin());
}

}  // namespace bedload
