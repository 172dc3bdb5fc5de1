#include "coupling/grains_state.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <utility>

#include "atom.h"
#include "atom_vec.h"
#include "comm.h"
#include "coupling/byte_stream.hpp"
#include "domain.h"
#include "fix.h"
#include "fix_contact_history.h"
#include "fluid/output/agreement.hpp"
#include "fluid/output/aside_file.hpp"
#include "fluid/output/checkpoint_store.hpp"
#include "fluid/output/front_block.hpp"
#include "force.h"
#include "lammps.h"
#include "memory.h"
#include "modify.h"
#include "pair.h"
#include "update.h"

namespace bedload {
namespace {

/// Room for one packed sphere beyond what fixes announce: motion, and fixes that announce nothing.
constexpr int packing_room = 4096;
constexpr std::size_t position_at = 1;  ///< in a packed sphere, behind its length

/// A LIGGGHTS fix writes its own state into a FILE, rank 0 alone, behind its length.
std::vector<char> own_state(LAMMPS_NS::Fix& fix, bool first_rank) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const file = first_rank ? open_memstream(&text, &size) : nullptr;
  fix.write_restart(file);
  if (!file) return {};
  std::fclose(file);
  std::vector<char> bytes;
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

void broadcast(std::vector<char>& bytes, MPI_Comm comm) {
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, comm);
  bytes.resize(size);
  MPI_Bcast(bytes.data(), static_cast<int>(size), MPI_CHAR, 0, comm);
}

std::vector<char> content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto size = std::filesystem::file_size(path) - front_block_bytes;
  std::vector<char> bytes(size);
  file.seekg(static_cast<std::streamoff>(front_block_bytes));
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw UserError(fmt::format("{}: cannot be read to its end.", path));
  return bytes;
}

}  // namespace

GrainsState::GrainsState(LAMMPS_NS::LAMMPS* lmp, std::int64_t fluid_step)
    : lmp_(lmp), fluid_step_(fluid_step) {
  LAMMPS_NS::Atom& atom = *lmp->atom;
  step_ = lmp->update->ntimestep;
  time_ = lmp->update->atime;
  time_step_of_time_ = lmp->update->atimestep;
  std::copy_n(lmp->comm->procgrid, 3, ranks_.begin());
  sphere_fixes_ = fixes_of_spheres();
  for (int n = 0; n < lmp->modify->nfix; ++n) {
    LAMMPS_NS::Fix& fix = *lmp->modify->fix[n];
    if (has_state_of_its_own(fix))
      fix_parts_.push_back({fix.id, fix.style, own_state(fix, lmp->comm->me == 0)});
  }
  for (FixPart& part : fix_parts_) broadcast(part.bytes, lmp->world);

  const auto restart_fixes = fixes_with_restart_alone();
  std::vector<double> packed;
  for (int i = 0; i < atom.nlocal; ++i) {
    int room = packing_room + lmp->comm->maxexchange_atom + lmp->comm->maxexchange_fix;
    for (LAMMPS_NS::Fix* fix : restart_fixes) room += fix->size_restart(i);
    const std::size_t begin = packed.size();
    packed.resize(begin + static_cast<std::size_t>(room));
    double* next = packed.data() + begin;
    next += atom.avec->pack_exchange(i, next);
    for (LAMMPS_NS::Fix* fix : restart_fixes) next += fix->pack_restart(i, next);
    packed.resize(static_cast<std::size_t>(next - packed.data()));
  }
  spheres_ = {std::move(packed)};
}

GrainsState::GrainsState(LAMMPS_NS::LAMMPS* lmp, const std::string& path, std::int64_t fluid_step)
    : lmp_(lmp), path_(path) {
  check_front_block(path, grains_front, lmp->world);
  together(lmp->world, [&] {
    const std::vector<char> bytes = content(path);
    try {
      ByteReader in(bytes);
      fluid_step_ = in.get<std::int64_t>();
      step_ = in.get<std::int64_t>();
      time_ = in.get<double>();
      time_step_of_time_ = in.get<std::int64_t>();
      ranks_ = in.get<std::array<std::int32_t, 3>>();
      const auto fixes = in.get<std::uint64_t>();
      for (std::uint64_t n = 0; n < fixes; ++n) sphere_fixes_.push_back(in.get_text());
      const auto parts = in.get<std::uint64_t>();
      for (std::uint64_t n = 0; n < parts; ++n) {
        FixPart part;
        part.id = in.get_text();
        part.style = in.get_text();
        part.bytes = in.get_list<char>();
        fix_parts_.push_back(std::move(part));
      }
      const auto blocks = in.get<std::uint64_t>();
      for (std::uint64_t n = 0; n < blocks; ++n) spheres_.push_back(in.get_list<double>());
    } catch (const UserError& error) {
      throw UserError(fmt::format("{}: {}.", path, error.what()));
    }
    if (fluid_step_ != fluid_step)
      throw UserError(fmt::format(
          "{}: holds the grains of fluid step {}, but the fluid's file beside it is of step {}.",
          path, fluid_step_, fluid_step));
  });
}

void GrainsState::write(const std::string& path) const {
  const MPI_Comm world = lmp_->world;
  const auto& mine = spheres_.front();
  const int count = static_cast<int>(mine.size()), ranks = lmp_->comm->nprocs;
  std::vector<int> counts(static_cast<std::size_t>(ranks)), starts(counts.size(), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, world);
  for (std::size_t n = 1; n < counts.size(); ++n) starts[n] = starts[n - 1] + counts[n - 1];
  std::vector<double> all;
  if (lmp_->comm->me == 0) all.resize(static_cast<std::size_t>(starts.back() + counts.back()));
  MPI_Gatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE,
              0, world);

  on_first_rank(world, [&] {
    ByteWriter out;
    out.put(fluid_step_);
    out.put(step_);
    out.put(time_);
    out.put(time_step_of_time_);
    out.put(ranks_);
    out.put(static_cast<std::uint64_t>(sphere_fixes_.size()));
    for (const std::string& fix : sphere_fixes_) out.put_text(fix);
    out.put(static_cast<std::uint64_t>(fix_parts_.size()));
    for (const FixPart& part : fix_parts_) {
      out.put_text(part.id);
      out.put_text(part.style);
      out.put_list(std::span<const char>(part.bytes));
    }
    out.put(static_cast<std::uint64_t>(counts.size()));
    for (std::size_t n = 0; n < counts.size(); ++n)
      out.put_list(std::span<const double>(all).subspan(static_cast<std::size_t>(starts[n]),
                                                        static_cast<std::size_t>(counts[n])));
    require_space(path, out.bytes().size() + front_block_bytes);
    std::ofstream file(aside_name(path), std::ios::binary);
    file << std::string(front_block_bytes, '\0');
    file.write(out.bytes().data(), static_cast<std::streamsize>(out.bytes().size()));
    file.close();
    if (!file) throw UserError(fmt::format("{}: cannot be written.", path));
  });
  write_front_block(path, grains_front, world);
  on_first_rank(world, [&] { put_in_place(path); });
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

void GrainsState::put_back() {
  together(lmp_->world, [&] { check_fixes(); });
  LAMMPS_NS::Atom& atom = *lmp_->atom;
  for (const FixPart& part : fix_parts_) restore(part);
  if (atom.map_style != 0) atom.map_clear();
  atom.nlocal = atom.nghost = 0;
  const bool same_ranks = std::equal(ranks_.begin(), ranks_.end(), lmp_->comm->procgrid);
  together(lmp_->world, [&] {
    for (std::size_t rank = 0; rank < spheres_.size(); ++rank)
      if (!same_ranks || rank == static_cast<std::size_t>(lmp_->comm->me))
        unpack(spheres_[rank], same_ranks);
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
  std::vector<char> bytes = part.bytes;
  fix->restart(bytes.data());
}

void GrainsState::align_random_numbers() const {
  for (const FixPart& part : fix_parts_)
    if (draws_random_numbers(part.style)) restore(part);
}

/// Name of every fix that keeps something per sphere, in the order of a packed sphere.
std::vector<std::string> GrainsState::fixes_of_spheres() const {
  const LAMMPS_NS::Atom& atom = *lmp_->atom;
  std::vector<std::string> names;
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

bool GrainsState::is_mine(const double* packed) const {
  const LAMMPS_NS::Domain& domain = *lmp_->domain;
  std::array<double, 3> x{};
  std::copy_n(packed + position_at, 3, x.begin());
  lmp_->domain->remap(x.data());
  for (std::size_t d = 0; d < 3; ++d) {
    const bool first = lmp_->comm->myloc[d] == 0;
    const bool last = lmp_->comm->myloc[d] + 1 == lmp_->comm->procgrid[d];
    if (!first && x[d] < domain.sublo[d]) return false;
    if (!last && x[d] >= domain.subhi[d]) return false;
  }
  return true;
}

/// Each sphere: what LIGGGHTS packed for a change of rank, behind its length, then what the fixes
/// with a restart alone packed, each behind its length.
void GrainsState::unpack(const std::vector<double>& packed, bool all) {
  const std::size_t restart_fixes = fixes_with_restart_alone().size();
  const auto length_at = [&](std::size_t at) {
    if (at >= packed.size() || !(packed[at] >= 1.0) ||
        packed[at] > static_cast<double>(packed.size() - at))
      throw UserError(
          fmt::format("{}: its spheres are not packed as this LIGGGHTS does it.", path_));
    return static_cast<std::size_t>(packed[at]);
  };
  std::size_t at = 0;
  while (at < packed.size()) {
    const std::size_t begin = at;
    at += length_at(at);
    const std::size_t restart_begin = at;
    for (std::size_t n = 0; n < restart_fixes; ++n) at += length_at(at);
    if (!all && !is_mine(&packed[begin])) continue;
    std::vector<double> sphere(packed.begin() + static_cast<std::ptrdiff_t>(begin),
                               packed.begin() + static_cast<std::ptrdiff_t>(restart_begin));
    lmp_->atom->avec->unpack_exchange(sphere.data());
    restart_parts_.emplace_back(packed.begin() + static_cast<std::ptrdiff_t>(restart_begin),
                                packed.begin() + static_cast<std::ptrdiff_t>(at));
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
