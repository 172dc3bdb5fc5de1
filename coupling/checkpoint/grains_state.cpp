#include "coupling/checkpoint/grains_state.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>
#include <utility>

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "domain.h"
#include "fix.h"
#include "fix_contact_history.h"
#include "fluid/checkpoint/checkpoint_store.hpp"
#include "fluid/checkpoint/group.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/files/file_header.hpp"
#include "fluid/files/hdf5_file.hpp"
#include "fluid/grid/send_to_ranks.hpp"
#include "fluid/immersed_boundary/gather.hpp"
#include "fluid/settings/errors.hpp"
#include "force.h"
#include "group.h"
#include "lammps.h"
#include "liggghts_styles/private_access.hpp"
#include "memory.h"
#include "modify.h"
#include "pair.h"
#include "update.h"

namespace bedload {
namespace {

/// Room for one packed sphere beyond what fixes announce: motion, and fixes that announce nothing.
constexpr int packing_room = 4096;
/// Groups and headers of the file.
constexpr std::uint64_t metadata_room = 1 << 16;

/// A LIGGGHTS fix writes its own state into a FILE, rank 0 alone, behind its length.
std::vector<std::uint8_t> own_state(LAMMPS_NS::Fix& fix, bool first_rank) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const file = first_rank ? open_memstream(&text, &size) : nullptr;
  fix.write_restart(file);
  if (!file) return {};
  std::fclose(file);
  std::vector<std::uint8_t> bytes;
  if (size > sizeof(int)) bytes.assign(text + sizeof(int), text + size);
  std::free(text);
  return bytes;
}

/// Meshes come from the script as they were; the histories check their length only.
bool has_state_of_its_own(const LAMMPS_NS::Fix& fix) {
  const std::string_view style(fix.style);
  return fix.restart_global != 0 && !style.starts_with("mesh") && !style.starts_with("move/mesh");
}

/// "id (style, size)": contact models differ in what they remember of a contact.
std::string name_of(LAMMPS_NS::Fix& fix) {
  int size = fix.peratom_flag != 0 ? fix.size_peratom_cols : 0;  // LIGGGHTS sets it only then
  if (auto* const history = dynamic_cast<LAMMPS_NS::FixContactHistory*>(&fix))
    size = history->get_dnum();
  return fmt::format("{} ({}, {})", fix.id, fix.style, size);
}

std::vector<LAMMPS_NS::Fix*> insertions(LAMMPS_NS::Modify& modify) {
  std::vector<LAMMPS_NS::Fix*> fixes;
  for (int n = 0; n < modify.nfix; ++n)
    if (std::string_view(modify.fix[n]->style).starts_with("insert/"))
      fixes.push_back(modify.fix[n]);
  return fixes;
}

bool draws_random_numbers(std::string_view style) {
  return style.starts_with("insert/") || style.starts_with("particletemplate/") ||
         style.starts_with("particledistribution/");
}

/// In pieces that MPI's 32-bit counts hold.
void broadcast(std::vector<std::uint8_t>& bytes, MPI_Comm comm) {
  constexpr std::uint64_t piece = 1 << 30;
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm);
  bytes.resize(size);
  for (std::uint64_t first = 0; first < size; first += piece)
    MPI_Bcast(bytes.data() + first, static_cast<int>(std::min(piece, size - first)), MPI_CHAR, 0,
              comm);
}

/// Texts that hold no line feed, as one text; and back.
std::string joined(const std::vector<std::string>& texts) {
  return fmt::format("{}", fmt::join(texts, "\n"));
}
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string part_name(std::size_t n) { return fmt::format("fix_{:03d}", n); }

}  // namespace

GrainsState::GrainsState(LAMMPS_NS::LAMMPS* lmp, std::int64_t fluid_step, std::int64_t id,
                         const RunScript& script, const ScriptAtoms& made)
    : lmp_(lmp), fluid_step_(fluid_step), id_(id), script_(script), made_(made) {
  LAMMPS_NS::Atom& atom = *lmp->atom;
  step_ = lmp->update->ntimestep;
  time_ = lmp->update->atime;
  time_step_of_time_ = lmp->update->atimestep;
  step_length_ = lmp->update->dt;
  ranks_.assign(lmp->comm->procgrid, lmp->comm->procgrid + 3);
  sphere_fixes_ = fixes_of_spheres();
  for (int n = 0; n < lmp->modify->nfix; ++n) {
    LAMMPS_NS::Fix& fix = *lmp->modify->fix[n];
    if (has_state_of_its_own(fix))
      fix_parts_.push_back({fix.id, fix.style, own_state(fix, lmp->comm->me == 0)});
  }
  for (FixPart& part : fix_parts_) broadcast(part.bytes, lmp->world);

  group_names_ = group_names(lmp);

  const auto restart_fixes = fixes_with_restart_alone();
  std::vector<double>& packed = spheres_.values;
  for (int i = 0; i < atom.nlocal; ++i) {
    // maxexchange_fix is the largest of what contact histories have, each of which may have as
    // much.
    int room = packing_room + lmp->comm->maxexchange_atom +
               std::max(1, atom.nextra_grow) * lmp->comm->maxexchange_fix;
    for (LAMMPS_NS::Fix* fix : restart_fixes) room += fix->size_restart(i);
    const std::size_t begin = packed.size();
    packed.resize(begin + static_cast<std::size_t>(room));
    double* next = packed.data() + begin;
    next += atom.avec->pack_exchange(i, next);
    for (LAMMPS_NS::Fix* fix : restart_fixes) next += fix->pack_restart(i, next);
    packed.resize(static_cast<std::size_t>(next - packed.data()));
    spheres_.tag.push_back(atom.tag[i]);
    spheres_.radius.push_back(atom.radius[i]);
    spheres_.position.insert(spheres_.position.end(), atom.x[i], atom.x[i] + 3);
    spheres_.size.push_back(static_cast<std::int64_t>(packed.size() - begin));
  }
}

GrainsState::GrainsState(LAMMPS_NS::LAMMPS* lmp, const std::string& path, std::int64_t fluid_step)
    : lmp_(lmp), path_(path) {
  check_file_header(path, grains_file_header, lmp->world);
  std::optional<Hdf5File> file;
  collectively(lmp->world, [&] {
    file.emplace(path, Hdf5File::Access::read, MPI_COMM_SELF);
    load(LoadGroup(*file, grains_group));
    if (fluid_step_ != fluid_step)
      throw UserError(fmt::format(
          "{}: holds the grains of fluid step {}, but the fluid's file beside it is of step {}.",
          path, fluid_step_, fluid_step));
  });
  const Part values = packed_part();
  collectively(lmp->world, [&] {
    const LoadGroup spheres = LoadGroup(*file, grains_group).group("spheres");
    spheres_.values = spheres.rows<double>("packed", values, 1);
  });
}

/// Where this rank's spheres stand among the packed ones: behind those of the ranks before it.
Part GrainsState::packed_part() const {
  Part part;
  for (const std::int64_t size : spheres_.size) part.count += static_cast<std::uint64_t>(size);
  MPI_Exscan(&part.count, &part.first, 1, MPI_UINT64_T, MPI_SUM, lmp_->world);
  if (lmp_->comm->me == 0) part.first = 0;  // MPI leaves it open there
  return part;
}

void GrainsState::save(const SaveGroup& grains) const {
  grains.value(id_name, id_);
  grains.value("fluid_step", fluid_step_);
  grains.value("step", step_);
  grains.value("time", time_);
  grains.value("step_of_time", time_step_of_time_);
  grains.value("step_length", step_length_);
  grains.list<std::int32_t>("rank_grid", ranks_);
  grains.text("groups", joined(group_names_));
  grains.text("fixes_of_spheres", joined(sphere_fixes_));
  grains.value("fixes", static_cast<std::int64_t>(fix_parts_.size()));
  for (std::size_t n = 0; n < fix_parts_.size(); ++n) {
    const SaveGroup part = grains.group(part_name(n));
    part.text("id", fix_parts_[n].id);
    part.text("style", fix_parts_[n].style);
    part.list<std::uint8_t>("restart_data", fix_parts_[n].bytes);
  }
  script_.save(grains.group("run_script"));
  made_.save(grains.group("made_by_script"));
  const SaveGroup spheres = grains.group("spheres");
  spheres.parts("spheres_of_rank", spheres_.tag.size());
  spheres.parts("values_of_rank", spheres_.values.size());
  spheres.rows<std::int64_t>("tag", spheres_.tag);
  spheres.rows<double>("radius", spheres_.radius);
  spheres.rows<double>("position", spheres_.position, 3);
  spheres.rows<std::int64_t>("packed_size", spheres_.size);
  spheres.rows<double>("packed", spheres_.values);
}

void GrainsState::load(const LoadGroup& grains) {
  fluid_step_ = grains.value<std::int64_t>("fluid_step");
  step_ = grains.value<std::int64_t>("step");
  time_ = grains.value<double>("time");
  time_step_of_time_ = grains.value<std::int64_t>("step_of_time");
  if (grains.has("step_length")) step_length_ = grains.value<double>("step_length");
  ranks_ = grains.list<std::int32_t>("rank_grid");
  group_names_ = lines_of(grains.text("groups"));
  group_names_.resize(most_groups);
  sphere_fixes_ = lines_of(grains.text("fixes_of_spheres"));
  const auto fixes = static_cast<std::size_t>(grains.value<std::int64_t>("fixes"));
  for (std::size_t n = 0; n < fixes; ++n) {
    const LoadGroup part = grains.group(part_name(n));
    fix_parts_.push_back(
        {part.text("id"), part.text("style"), part.list<std::uint8_t>("restart_data")});
  }
  script_.load(grains.group("run_script"));
  made_.load(grains.group("made_by_script"));
  load_spheres(grains.group("spheres"));
}

/// On the same grid of ranks those that this rank wrote, otherwise an even share.
void GrainsState::load_spheres(const LoadGroup& group) {
  const bool same = same_ranks();
  const Part part = same ? group.part_of_rank("spheres_of_rank", lmp_->comm->me)
                         : even_share(group.size("tag"), lmp_->world);
  spheres_.tag = group.rows<std::int64_t>("tag", part, 1);
  spheres_.radius = group.rows<double>("radius", part, 1);
  spheres_.position = group.rows<double>("position", part, 3);
  spheres_.size = group.rows<std::int64_t>("packed_size", part, 1);
}

bool GrainsState::same_ranks() const {
  return std::equal(ranks_.begin(), ranks_.end(), lmp_->comm->procgrid, lmp_->comm->procgrid + 3);
}

void GrainsState::write(const std::string& path) const {
  const MPI_Comm world = lmp_->world;
  std::uint64_t bytes = 0;
  save({nullptr, grains_group, world, bytes});
  on_first_rank(world, [&] { require_space(path, bytes + metadata_room); });
  Hdf5File file(temporary_name(path), Hdf5File::Access::create, world, file_header_bytes);
  save({&file, grains_group, world, bytes});
  file.close();
  write_file_header(path, grains_file_header, world);
  on_first_rank(world, [&] { commit_file(path); });
}

void GrainsState::refuse_moves_of_other_steps() const {
  constexpr double rounding = 1e-9;
  const double now = lmp_->update->dt;
  if (step_length_ == 0.0 || std::abs(now - step_length_) <= rounding * step_length_) return;
  for (int n = 0; n < lmp_->modify->nfix; ++n)
    if (std::string_view(lmp_->modify->fix[n]->style) == "move")
      throw UserError(fmt::format(
          "restart: fix move ({}) counts LIGGGHTS' steps, which were {:.6g} long in the run before "
          "and are {:.6g} now, so that its spheres would jump; go on with the 'time.step' and "
          "'coupling.dem_steps' of that run",
          lmp_->modify->fix[n]->id, step_length_, now));
}

void GrainsState::set_clock() const {
  lmp_->update->ntimestep = step_;
  lmp_->update->atime = time_;
  lmp_->update->atimestep = time_step_of_time_;
}

void GrainsState::let_insertions_pass() const {
  for (LAMMPS_NS::Fix* fix : insertions(*lmp_->modify))
    fix->reset_timestep(step_, lmp_->update->ntimestep);
}

void GrainsState::set_up_insertions() const {
  for (LAMMPS_NS::Fix* fix : insertions(*lmp_->modify)) fix->setup(0);
}

/// A sphere's groups are bits, which a script deals out in the order in which it makes groups. The
/// file's groups are found again by name; in those that this script makes otherwise, or that the
/// file does not know, are the spheres that this script has put there.
class GrainsState::GroupBits {
 public:
  /// Before LIGGGHTS' spheres are replaced. Collective.
  GroupBits(LAMMPS_NS::LAMMPS* lmp, const std::vector<std::string>& of_file,
            const std::vector<std::string>& of_script) {
    for (const std::string& name : of_file) {
      const bool from_script =
          std::find(of_script.begin(), of_script.end(), name) != of_script.end();
      const int here = name.empty() ? -1 : lmp->group->find(name.c_str());
      bits_.push_back(here < 0 ? 0 : lmp->group->bitmask[here]);
      if (from_script && here >= 0) decided_by_script_ |= lmp->group->bitmask[here];
    }
    for (const std::string& name : of_script)
      if (const int here = lmp->group->find(name.c_str()); here >= 0)
        gather(lmp, lmp->group->bitmask[here]);
  }

  int of(int mask, int tag) const {
    int bits = 0;
    for (std::size_t n = 0; n < bits_.size(); ++n)
      if ((static_cast<std::uint32_t>(mask) >> n & 1u) != 0) bits |= bits_[n];
    const auto made = made_by_script_.find(tag);
    if (made == made_by_script_.end()) return bits;  // it came later
    return (bits & ~decided_by_script_) | made->second;
  }

 private:
  /// All atoms of the script, and which of them are in the group.
  void gather(LAMMPS_NS::LAMMPS* lmp, int bit) {
    struct Member {
      std::int64_t tag, is_in;
    };
    std::vector<Member> mine;
    mine.reserve(static_cast<std::size_t>(lmp->atom->nlocal));
    for (int i = 0; i < lmp->atom->nlocal; ++i)
      mine.push_back({lmp->atom->tag[i], (lmp->atom->mask[i] & bit) != 0 ? 1 : 0});
    for (const Member& member : gather_by_tag<Member>(lmp->world, mine))
      made_by_script_[static_cast<int>(member.tag)] |= member.is_in != 0 ? bit : 0;
  }

  std::vector<int> bits_;  ///< of this script, by bit of the file
  int decided_by_script_ = 0;
  std::map<int, int> made_by_script_;
};

void GrainsState::compare(const RunScript& script, const ScriptAtoms& made) {
  std::vector<std::string> told = differences(script_, script);
  int changed = told.empty() ? 0 : 1;  // the first rank alone knows the scripts
  MPI_Bcast(&changed, 1, MPI_INT, 0, lmp_->world);
  const std::string others = changed != 0 ? made_.what_differs(made) : "";
  if (!others.empty())
    throw UserError(fmt::format(
        "{}: the run before began with {} spheres, and this script makes {}; a run goes "
        "on with its own spheres: take back what changes them ({}), or begin a new run.",
        path_, made_.count, others, lmp_->comm->me == 0 ? told.front() : ""));
  for (std::size_t n = 0; n < most_groups; ++n) {
    const std::string& name = made.groups[n];
    if (name.empty() || name == "all") continue;
    const int before = made_.bit_of(name);
    const bool in_file =
        std::find(group_names_.begin(), group_names_.end(), name) != group_names_.end();
    const bool differs =
        before >= 0
            ? changed != 0 && made_.members[static_cast<std::size_t>(before)] != made.members[n]
            : !in_file;
    if (!differs) continue;
    new_groups_.push_back(name);
    told.push_back(
        fmt::format("the group '{}' is {} one of this script", name, in_file ? "the" : "a new"));
  }
  if (lmp_->comm->me == 0)
    for (const std::string& sentence : told)
      fmt::print(stderr, "bedload-dem: restart: {}.\n", sentence);
}

void GrainsState::put_back() {
  collectively(lmp_->world, [&] { check_fixes(); });
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  const GroupBits groups(lmp_, group_names_, new_groups_);
  for (const FixPart& part : fix_parts_) restore(part);
  if (atom.map_style != 0) atom.map_clear();
  atom.nlocal = atom.nghost = 0;
  if (!same_ranks()) send_to_owners();
  collectively(lmp_->world, [&] {
    unpack(groups);
    unpack_restart_parts();
  });
  LAMMPS_NS::bigint local = atom.nlocal;
  MPI_Allreduce(&local, &atom.natoms, 1, MPI_LMP_BIGINT, MPI_SUM, lmp_->world);
  if (atom.map_style != 0) {
    atom.map_init();
    atom.map_set();
  }
  // Or LIGGGHTS would give the spheres of a fix that has not run yet its initial values.
  for (int n = 0; n < lmp_->modify->nfix; ++n) lmp_->modify->fix[n]->just_created = 0;
  // The histories are with the spheres; those in the old neighbour lists are of no use any more.
  int dimension = 0;
  if (lmp_->force->pair)
    if (void* const in_lists = lmp_->force->pair->extract("computeflag", dimension))
      *static_cast<int*>(in_lists) = 0;
}

/// Hands a fix what it wrote; one that this script does not have is passed over.
void GrainsState::restore(const FixPart& part) const {
  LAMMPS_NS::Fix* const fix = lmp_->modify->find_fix_id_style(part.id.c_str(), part.style.c_str());
  if (fix == nullptr || part.bytes.empty()) return;
  std::vector<std::uint8_t> bytes = part.bytes;
  fix->restart(reinterpret_cast<char*>(bytes.data()));
  if (auto* const insertion = dynamic_cast<LAMMPS_NS::FixInsert*>(fix))
    if (detail::Insertion::is_over(*insertion, bytes)) insertion->next_reneighbor = 0;
}

void GrainsState::align_random_numbers() const {
  for (const FixPart& part : fix_parts_)
    if (draws_random_numbers(part.style)) restore(part);
}

/// Name of every fix that keeps something per sphere, in the order of a packed sphere.
std::vector<std::string> GrainsState::fixes_of_spheres() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  std::vector<std::string> names;
  names.reserve(static_cast<std::size_t>(atom.nextra_grow));
  for (int n = 0; n < atom.nextra_grow; ++n)
    names.push_back(name_of(*lmp_->modify->fix[atom.extra_grow[n]]));
  for (LAMMPS_NS::Fix* fix : fixes_with_restart_alone()) names.push_back(name_of(*fix));
  return names;
}

/// Fixes that keep something per sphere for restarts and do not hand it on with the sphere.
std::vector<LAMMPS_NS::Fix*> GrainsState::fixes_with_restart_alone() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  std::vector<LAMMPS_NS::Fix*> fixes;
  for (int n = 0; n < atom.nextra_restart; ++n) {
    const int* const end = atom.extra_grow + atom.nextra_grow;
    if (std::find(static_cast<const int*>(atom.extra_grow), end, atom.extra_restart[n]) == end)
      fixes.push_back(lmp_->modify->fix[atom.extra_restart[n]]);
  }
  return fixes;
}

void GrainsState::check_fixes() const {
  const std::vector<std::string> here = fixes_of_spheres();
  if (here == sphere_fixes_) return;
  throw UserError(
      fmt::format("{}: was written by another LIGGGHTS script or model: its spheres have the fixes "
                  "{}, those of this script {}.",
                  path_, fmt::join(sphere_fixes_, ", "), fmt::join(here, ", ")));
}

/// Every rank's part of the box; parts at the box's ends reach on without end.
std::vector<GrainsState::Region> GrainsState::regions() const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Region mine;
  for (std::size_t d = 0; d < 3; ++d) {
    const bool first = lmp_->comm->myloc[d] == 0;
    const bool last = lmp_->comm->myloc[d] + 1 == lmp_->comm->procgrid[d];
    mine[d] = {first ? -infinity : lmp_->domain->sublo[d],
               last ? infinity : lmp_->domain->subhi[d]};
  }
  std::vector<Region> all(static_cast<std::size_t>(lmp_->comm->nprocs));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, lmp_->world);
  return all;
}

std::size_t GrainsState::owner_of(const double* position, const std::vector<Region>& parts) const {
  std::array<double, 3> x{};
  std::copy_n(position, 3, x.begin());
  lmp_->domain->remap(x.data());
  const auto holds = [&x](const Region& part) {
    return x[0] >= part[0][0] && x[0] < part[0][1] && x[1] >= part[1][0] && x[1] < part[1][1] &&
           x[2] >= part[2][0] && x[2] < part[2][1];
  };
  const auto found = std::find_if(parts.begin(), parts.end(), holds);
  return found == parts.end() ? 0 : static_cast<std::size_t>(found - parts.begin());
}

/// Each sphere goes to the rank in whose part of the box it lies.
void GrainsState::send_to_owners() {
  const auto ranks = static_cast<std::size_t>(lmp_->comm->nprocs);
  std::vector<std::vector<std::int64_t>> sizes(ranks);
  std::vector<std::vector<double>> values(ranks);
  const std::vector<Region> parts = regions();
  auto next = spheres_.values.begin();
  for (std::size_t n = 0; n < spheres_.size.size(); ++n) {
    const std::size_t owner = owner_of(&spheres_.position[3 * n], parts);
    sizes[owner].push_back(spheres_.size[n]);
    values[owner].insert(values[owner].end(), next, next + spheres_.size[n]);
    next += spheres_.size[n];
  }
  spheres_.size = send_to_ranks(lmp_->world, sizes);
  spheres_.values = send_to_ranks(lmp_->world, values);
}

/// Each sphere: what LIGGGHTS packed for a change of rank, behind its length, then what the fixes
/// with a restart alone packed, each behind its length.
void GrainsState::unpack(const GroupBits& groups) {
  const std::size_t restart_fixes = fixes_with_restart_alone().size();
  auto next = spheres_.values.begin();
  for (const std::int64_t size : spheres_.size) {
    const auto end = next + size;
    const auto length_at = [&](auto at) {
      if (at >= end || !(*at >= 1.0) || *at > static_cast<double>(end - at))
        throw UserError(
            fmt::format("{}: its spheres are not packed as this LIGGGHTS does it.", path_));
      return static_cast<std::ptrdiff_t>(*at);
    };
    const auto restart_begin = next + length_at(next);
    auto at = restart_begin;
    for (std::size_t n = 0; n < restart_fixes; ++n) at += length_at(at);
    std::vector<double> sphere(next, restart_begin);
    lmp_->atom->avec->unpack_exchange(sphere.data());
    const int i = lmp_->atom->nlocal - 1;
    lmp_->atom->mask[i] = groups.of(lmp_->atom->mask[i], lmp_->atom->tag[i]);
    restart_parts_.emplace_back(restart_begin, at);
    next = end;
  }
}

/// Fixes take such parts out of a table that LIGGGHTS has while it reads a restart file.
void GrainsState::unpack_restart_parts() {
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  const auto fixes = fixes_with_restart_alone();
  std::vector<double*> rows;
  for (std::vector<double>& part : restart_parts_) rows.push_back(part.data());
  double** const kept = std::exchange(atom.extra, rows.data());
  for (std::size_t n = 0; n < fixes.size(); ++n)
    for (int i = 0; i < atom.nlocal; ++i) fixes[n]->unpack_restart(i, static_cast<int>(n));
  atom.extra = kept;
  restart_parts_.clear();
}

}  // namespace bedload
