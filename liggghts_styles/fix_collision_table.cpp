#include "liggghts_styles/fix_collision_table.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "liggghts_styles/find_fix.hpp"
#include "liggghts_styles/fluid_values.hpp"
#include "liggghts_styles/hand_on.hpp"
#include "liggghts_styles/liggghts.hpp"
#include "liggghts_styles/owned_atom.hpp"

namespace bedload {

namespace {
constexpr const char* style_name = "fix collision/table";
constexpr const char* columns =
    "tag_i,tag_j,time_start,time_end,x,y,z,impact_speed_normal,impact_speed_tangential,"
    "rebound_speed_normal,impulse_normal,impulse_tangential,largest_overlap\n";

/// By `order`, then tags: the same order on any number of ranks.
template <class Row>
std::string text_of(std::vector<Row> rows, std::size_t order) {
  std::sort(rows.begin(), rows.end(), [order](const Row& a, const Row& b) {
    return std::tie(a[order], a[0], a[1]) < std::tie(b[order], b[0], b[1]);
  });
  std::string text;
  for (const Row& row : rows) {
    text += fmt::format("{:.0f},{:.0f}", row[0], row[1]);
    for (std::size_t n = 2; n < row.size(); ++n) text += fmt::format(",{:.12g}", row[n]);
    text += '\n';
  }
  return text;
}

/// collisions.csv -> collisions_open.csv
std::string open_file(const std::filesystem::path& table) {
  std::filesystem::path file = table;
  return file.replace_filename(table.stem().string() + "_open" + table.extension().string());
}
}  // namespace

FixCollisionTable::FixCollisionTable(LAMMPS_NS::LAMMPS* lammps, int narg, char** arg)
    : Fix(lammps, narg, arg) {
  nevery = 1;
  scalar_flag = 1;
  global_freq = 1;
  restart_global = 1;
  restart_peratom = 1;
  if (find_fix(*modify, "collision/table") != nullptr) {
    stop_run(lmp, "fix collision/table: there is one already, and one serves all pairs and walls");
  }
  const Arguments given(lmp, help, std::span(arg, narg).subspan(3));
  file_ = given.word("file");
  every_ = static_cast<std::int64_t>(given.number("every"));
  if (file_.empty()) stop_run(lmp, "fix collision/table needs the keyword 'file <name>'");
  atom->add_callback(1);
}

FixCollisionTable::~FixCollisionTable() { atom->delete_callback(id, 1); }

int FixCollisionTable::setmask() {
  return LAMMPS_NS::FixConst::PRE_NEIGHBOR | LAMMPS_NS::FixConst::END_OF_STEP;
}

void FixCollisionTable::init() {
  contact_observers_.check_pairs(lmp, style_name);
  refuse_newton(lmp, style_name);
  if (started_ || comm->me != 0) {
    started_ = true;
    return;
  }
  // A run from its beginning starts a new table, a restarted one goes on with what is there: beside
  // a fluid its clock is not set yet where a command between two coupled runs initialises LIGGGHTS.
  started_ = true;
  const bool fluid = FluidValue::find(lmp, "dt_fluid", "").live();
  const bool fresh = fluid ? !FluidValue::find(lmp, "goes_on", "").known() : update->ntimestep == 0;
  std::remove(open_file(file_).c_str());  // of an end that is none any more
  add_to_file(file_, fresh ? "w" : "a", [](std::FILE* out) {
    std::fseek(out, 0, SEEK_END);
    if (std::ftell(out) == 0) std::fputs(columns, out);
  });
  rows_ = keep_rows(INT64_MAX);
}

template <class Add>
void FixCollisionTable::add_to_file(const std::string& name, const char* mode, Add&& add) {
  std::FILE* const out = std::fopen(name.c_str(), mode);
  bool done = out != nullptr;
  if (done) {
    add(out);
    done = std::ferror(out) == 0;
    done = std::fclose(out) == 0 && done;  // what a buffer holds fails here
  }
  if (done) return;
  error->one(FLERR, fmt::format("{}: cannot write the file '{}' ({})", style_name, name,
                                std::strerror(errno))
                        .c_str());
}

/// The contact between these, nullptr if none is under way.
FixCollisionTable::Record* FixCollisionTable::find(double tag, double other) {
  const auto contacts = open_.find(static_cast<std::int64_t>(tag));
  if (contacts == open_.end()) return nullptr;
  for (Record& record : contacts->second)
    if (record.other == other) return &record;
  return nullptr;
}

/// Takes over a contact; returns whether it was not known.
bool FixCollisionTable::keep(const Record& record) {
  if (find(record.tag, record.other) != nullptr) return false;
  open_[static_cast<std::int64_t>(record.tag)].push_back(record);
  return true;
}

void FixCollisionTable::touch(const ContactStep& c) {
  const int* tag = atom->tag;
  const bool pair = c.j >= 0;
  if (((atom->mask[c.i] | (pair ? atom->mask[c.j] : 0)) & groupbit) == 0) return;
  // A pair across a rank boundary is seen from both sides; the lower tag's side keeps it.
  if (pair && c.j >= atom->nlocal && tag[c.i] > tag[c.j]) return;
  Record fresh{};
  fresh.tag = pair ? std::min(tag[c.i], tag[c.j]) : tag[c.i];
  fresh.other = pair ? std::max(tag[c.i], tag[c.j]) : -c.wall;
  const auto now = static_cast<double>(update->ntimestep);
  const double dt = update->dt;

  Record* known = find(fresh.tag, fresh.other);
  const bool is_new = known == nullptr;
  Record& r = is_new ? open_[static_cast<std::int64_t>(fresh.tag)].emplace_back(fresh) : *known;
  if (is_new) {
    // Touched since -gap / speed, if that lies within this step.
    const double since = c.gap < 0 && c.normal_speed < 0 ? c.gap / c.normal_speed : 0.0;
    r.start_time = time() - std::min(since, dt);
    for (int d = 0; d < 3; ++d) {
      r.position[d] = atom->x[c.i][d] - (c.radius + 0.5 * c.gap) * c.normal[d];
    }
    r.impact_speed = -c.normal_speed;
    r.impact_slip = c.tangential_speed;
  }
  double normal_force = 0;
  for (int d = 0; d < 3; ++d) normal_force += c.force[d] * c.normal[d];
  r.normal_impulse += normal_force * dt;
  // As seen by the sphere of the lower tag.
  const double sense = pair && tag[c.i] > tag[c.j] ? -1 : 1;
  for (int d = 0; d < 3; ++d) {
    r.tangential_impulse[d] += sense * (c.force[d] - normal_force * c.normal[d]) * dt;
  }
  r.last_step = now;
  r.last_time = time();
  r.last_gap = c.gap;
  r.largest_overlap = std::max(r.largest_overlap, -c.gap);
  r.last_speed = c.normal_speed + normal_force * dt * c.inverse_mass;
}

void FixCollisionTable::end_of_step() {
  const auto now = static_cast<double>(update->ntimestep);
  for (auto& [tag, contacts] : open_)
    std::erase_if(contacts, [&](const Record& record) {
      if (record.last_step >= now) return false;
      finish(record);
      return true;
    });
  last_time_ = time();
  if (update->ntimestep % every_ == 0) write();
}

double FixCollisionTable::time() const { return clock_offset_ + update->get_cur_time(); }

void FixCollisionTable::setup(int) {
  contact_observers_.check_walls(lmp, style_name, groupbit);
  set_clock();
}

void FixCollisionTable::set_clock() {
  const bool fluid = FluidValue::find(lmp, "dt_fluid", "").live();
  const bool begins = fluid && !beside_fluid_ && !FluidValue::find(lmp, "goes_on", "").known();
  const double now = update->get_cur_time();
  if (begins && has_run_ && compute_scalar() > 0)
    stop_run(lmp,
             fmt::format("fix collision/table: '{}' holds contacts of a run before the fluid, "
                         "the times of which would mix with the fluid's; write this fix behind "
                         "that run",
                         file_));
  if (begins) {
    const double before = time();
    clock_offset_ = -now;
    for (auto& [tag, contacts] : open_)
      for (Record& record : contacts) {
        record.start_time -= before;
        record.last_time -= before;
      }
  } else if (restarted_) {
    clock_offset_ = restart_time_ - now;
  } else if (has_run_) {
    clock_offset_ = last_time_ - now;
  }
  const auto step = static_cast<double>(update->ntimestep);  // as is, or was set back
  for (auto& [tag, contacts] : open_)
    for (Record& record : contacts) record.last_step = step;
  restarted_ = false;
  has_run_ = true;
  beside_fluid_ = fluid;
  last_time_ = time();
}

// Rows of the file, clock, collisions so far, which are more where the run has gone on in another
// file. What is finished is written down first, so that a run that goes on from here finds it in
// the file. An earlier version kept clock and collisions alone; a first number below 0 tells.
void FixCollisionTable::write_restart(std::FILE* file) {
  pre_neighbor();  // the command write_restart hands spheres on and builds no lists
  write();
  const std::array<double, 3> state{static_cast<double>(-1 - rows_), time(),
                                    static_cast<double>(count_)};
  const int bytes = sizeof(state);
  if (comm->me != 0) return;
  std::fwrite(&bytes, sizeof(bytes), 1, file);
  std::fwrite(state.data(), bytes, 1, file);
}

void FixCollisionTable::restart(char* buffer) {
  const auto number = [&buffer] {
    double value = 0;
    std::memcpy(&value, buffer, sizeof(value));
    buffer += sizeof(value);
    return value;
  };
  const double first = number();
  restart_time_ = first < 0 ? number() : first;
  count_ = static_cast<std::int64_t>(number());
  restarted_ = true;
  open_.clear();
  finished_.clear();
  // Off with those that the earlier run wrote after the state that this one starts from.
  if (comm->me == 0) rows_ = keep_rows(first < 0 ? static_cast<std::int64_t>(-1 - first) : count_);
}

// Leaves the head of the file and at most so many of its whole rows; returns how many there are.
std::int64_t FixCollisionTable::keep_rows(std::int64_t most) const {
  std::ifstream file(file_, std::ios::binary);
  std::string line;
  std::uint64_t bytes = 0;
  std::int64_t rows = -1;  // the head is none
  for (; rows < most && std::getline(file, line) && !file.eof(); ++rows) bytes += line.size() + 1;
  std::error_code failure;
  if (std::filesystem::file_size(file_, failure) > bytes && !failure)
    std::filesystem::resize_file(file_, bytes, failure);
  return std::max<std::int64_t>(0, rows);
}

FixCollisionTable::Row FixCollisionTable::row_of(const Record& r, double end) {
  const double* t = r.tangential_impulse;
  return {r.tag,
          r.other < 0 ? -1.0 : r.other,
          r.start_time,
          end,
          r.position[0],
          r.position[1],
          r.position[2],
          r.impact_speed,
          r.impact_slip,
          r.last_speed,
          r.normal_impulse,
          std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]),
          r.largest_overlap};
}

void FixCollisionTable::finish(const Record& r) {
  const double until = r.last_gap < 0 && r.last_speed > 0
                           ? std::min(-r.last_gap / r.last_speed, 1.5 * update->dt)
                           : 0.0;
  finished_.push_back(row_of(r, r.last_time + until));
}

/// The contacts of all ranks on the first one, none on the others. Collective.
std::vector<FixCollisionTable::Row> FixCollisionTable::gathered(
    const std::vector<Row>& mine) const {
  const int count = static_cast<int>(mine.size() * std::tuple_size_v<Row>);
  std::vector<int> counts(comm->me == 0 ? comm->nprocs : 0), starts(counts.size(), 0);
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, world);
  for (std::size_t n = 1; n < counts.size(); ++n) starts[n] = starts[n - 1] + counts[n - 1];
  const int all = counts.empty() ? 0 : starts.back() + counts.back();
  std::vector<Row> rows(all / std::tuple_size_v<Row>);
  MPI_Gatherv(mine.data(), count, MPI_DOUBLE, rows.data(), counts.data(), starts.data(), MPI_DOUBLE,
              0, world);
  return rows;
}

void FixCollisionTable::write() {
  const std::vector<Row> rows = gathered(finished_);
  auto count = static_cast<std::int64_t>(finished_.size());
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT64_T, MPI_SUM, world);
  count_ += count;
  finished_.clear();
  if (rows.empty()) return;
  rows_ += static_cast<std::int64_t>(rows.size());
  constexpr std::size_t by_end = 3;
  const std::string text = text_of(rows, by_end);
  add_to_file(file_, "a", [&](std::FILE* out) { std::fputs(text.c_str(), out); });
}

// As if they ended with the run.
void FixCollisionTable::write_open() {
  std::vector<Row> mine;
  for (const auto& [tag, contacts] : open_)
    for (const Record& record : contacts) mine.push_back(row_of(record, time()));
  const std::vector<Row> rows = gathered(mine);
  if (comm->me != 0) return;
  constexpr std::size_t by_start = 2;
  const std::string text = columns + text_of(rows, by_start);
  add_to_file(open_file(file_), "w", [&](std::FILE* out) { std::fputs(text.c_str(), out); });
}

// Spheres may have changed rank: their contacts follow.
void FixCollisionTable::pre_neighbor() {
  if (comm->nprocs == 1) return;
  const auto is_mine = [&](double tag) { return owned_atom(*atom, static_cast<int>(tag)) >= 0; };
  std::vector<Record> leaving;
  std::erase_if(open_, [&](const auto& of_sphere) {
    const auto& [tag, contacts] = of_sphere;
    if (is_mine(static_cast<double>(tag))) return false;
    leaving.insert(leaving.end(), contacts.begin(), contacts.end());
    return true;
  });
  const auto take = [&](const Record& record) { return is_mine(record.tag) && keep(record); };
  for (const Record& record : hand_on(world, neighbour_ranks(*comm), leaving, take))
    finish(record);  // its sphere is gone
}

void FixCollisionTable::post_run() {
  write();
  write_open();
}

double FixCollisionTable::compute_scalar() {
  double mine = static_cast<double>(finished_.size()), all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, world);
  return all + static_cast<double>(count_);
}

void* FixCollisionTable::extract(const char* name, int& dimension) {
  dimension = 0;
  return std::string_view(name) == "started" && started_ ? &started_ : nullptr;
}

// Restart: with each sphere the contacts that it keeps, behind their number of values.
int FixCollisionTable::size_restart(int i) {
  const auto contacts = open_.find(atom->tag[i]);
  return 1 +
         record_size * (contacts == open_.end() ? 0 : static_cast<int>(contacts->second.size()));
}

// LIGGGHTS asks all ranks, and gives each sphere as much room where it reads the file.
int FixCollisionTable::maxsize_restart() {
  int most = 1;
  for (int i = 0; i < atom->nlocal; ++i) most = std::max(most, size_restart(i));
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, world);
  return most;
}

int FixCollisionTable::pack_restart(int i, double* buffer) {
  const int size = size_restart(i);
  buffer[0] = size;
  if (size > 1) std::memcpy(buffer + 1, open_.at(atom->tag[i]).data(), (size - 1) * sizeof(double));
  return size;
}

void FixCollisionTable::unpack_restart(int local, int nth) {
  // LIGGGHTS keeps what all fixes stored for a sphere in one row, each part behind its length.
  const double* part = atom->extra[local];
  for (int n = 0; n < nth; ++n) part += static_cast<int>(*part);
  const int size = static_cast<int>(*part);
  for (int n = 1; n < size; n += record_size) {
    Record r;
    std::memcpy(&r, part + n, sizeof(Record));
    keep(r);
  }
}

}  // namespace bedload
