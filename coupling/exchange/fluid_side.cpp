#include "coupling/exchange/fluid_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "coupling/exchange/handshake.hpp"
#include "coupling/exchange/routes.hpp"
#include "coupling/exchange/stages.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/grid/send_to_ranks.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Time that a rank spends on getting a long message out before it goes off to compute [s].
constexpr double longest_push = 2e-3;

double relative_difference(const Triple& a, const Triple& b, double size) {
  double difference = 0.0;
  for (std::size_t d = 0; d < 3; ++d) difference = std::max(difference, std::abs(a[d] - b[d]));
  return difference > 0.0 ? difference / size : 0.0;
}

void add(Triple& sum, const Triple& term) {
  for (std::size_t d = 0; d < 3; ++d) sum[d] += term[d];
}

[[noreturn]] void report_twins(std::int64_t tag) {
  throw UserError(
      fmt::format("LIGGGHTS has two atoms of tag {}; every atom needs a tag of its own.", tag));
}

/// What the fluid computes does not depend on which rank of LIGGGHTS holds a sphere.
void sort_by_tag(std::vector<SphereState>& spheres) {
  std::sort(spheres.begin(), spheres.end(),
            [](const SphereState& a, const SphereState& b) { return a.tag < b.tag; });
  const std::vector<SphereState>& ascending = spheres;
  for (std::size_t i = 1; i < ascending.size(); ++i)
    if (ascending[i].tag == ascending[i - 1].tag) report_twins(ascending[i].tag);
}

/// The lowest tag that comes twice among first .. first + count - 1; tags of a rank ascend and lie
/// in that piece. Collective.
std::int64_t lowest_twin(MPI_Comm comm, std::span<const SphereState> mine, std::int64_t first,
                         int count) {
  std::vector<std::int32_t> holders(static_cast<std::size_t>(count), 0);
  for (const SphereState& sphere : mine) ++holders[static_cast<std::size_t>(sphere.tag - first)];
  MPI_Allreduce(MPI_IN_PLACE, holders.data(), count, MPI_INT32_T, MPI_SUM, comm);
  const auto twin = std::find_if(holders.begin(), holders.end(), [](int n) { return n > 1; });
  return first + (twin - holders.begin());
}

/// Throws UserError where two ranks know a sphere of the same tag; tags of a rank ascend and
/// differ. A bit for each tag goes round, a piece of them at a time, so that no rank holds the tags
/// of all: where tags differ there are as many bits as spheres. Collective.
void check_tags_of_ranks(MPI_Comm comm, std::span<const SphereState> mine) {
  constexpr std::uint64_t word = 64;
  constexpr int piece = 1 << 20;
  std::int64_t last = mine.empty() ? -1 : mine.back().tag;
  MPI_Allreduce(MPI_IN_PLACE, &last, 1, MPI_INT64_T, MPI_MAX, comm);
  std::vector<std::uint64_t> known(piece / word);
  for (std::int64_t first = 0; first <= last; first += piece) {
    std::fill(known.begin(), known.end(), 0);
    const auto end = std::find_if(mine.begin(), mine.end(),
                                  [&](const SphereState& s) { return s.tag >= first + piece; });
    const std::span<const SphereState> here(mine.begin(), end);
    mine = mine.subspan(here.size());
    for (const SphereState& sphere : here) {
      const auto place = static_cast<std::uint64_t>(sphere.tag - first);
      known[place / word] |= std::uint64_t{1} << (place % word);
    }
    auto spheres = static_cast<std::int64_t>(here.size()), tags = std::int64_t{0};
    MPI_Allreduce(MPI_IN_PLACE, &spheres, 1, MPI_INT64_T, MPI_SUM, comm);
    MPI_Allreduce(MPI_IN_PLACE, known.data(), static_cast<int>(known.size()), MPI_UINT64_T, MPI_BOR,
                  comm);
    for (const std::uint64_t bits : known) tags += std::popcount(bits);
    if (tags != spheres) report_twins(lowest_twin(comm, here, first, piece));
  }
}

}  // namespace

double kinds_of(std::span<const SphereState> spheres) {
  double sum = 0.0;
  for (const SphereState& sphere : spheres) {
    if (!sphere.mobile) continue;
    std::uint64_t hash = fnv_start;
    for (const std::uint64_t word :
         {static_cast<std::uint64_t>(sphere.tag), std::bit_cast<std::uint64_t>(sphere.radius),
          std::bit_cast<std::uint64_t>(sphere.density)})
      hash = fnv_mixed(hash, word);
    sum += static_cast<double>((hash ^ (hash >> 32)) & 0xffffffffULL);
  }
  return sum;
}

FluidSide::FluidSide(const Job& job) : job_(job), send_queue_(job.partner()) {}

void FluidSide::introduce(const FluidSceneInfo& scene_info, const std::string& grains) {
  scene_info_ = scene_info;
  step_ = std::max<std::int64_t>(0, scene_info.restart_step);
  const auto message =
      std::make_shared<const Bytes>(pack(scene_info, std::span<const char>(grains)));
  for (const int dem : target_ranks(job_.rank(), job_.size(), job_.partner_size()))
    send_queue_.post(dem, Subject::fluid_scene_info, message);
}

PartnerScene FluidSide::meet() {
  const Bytes bytes = receive(job_.partner(), source_rank(job_.rank(), job_.partner_size()),
                              Subject::dem_scene_info);
  PartnerScene dem;
  dem.scene_info = unpack_header<DemSceneInfo>(bytes);
  std::vector<char> effects;
  unpack_items<DemSceneInfo>(bytes, effects);
  dem.effects.assign(effects.begin(), effects.end());
  if (const auto sentence = disagreement(scene_info_, dem.scene_info)) throw UserError(*sentence);

  for (const int rank : target_ranks(job_.rank(), job_.size(), job_.partner_size())) {
    std::vector<StateRecord> records;
    unpack_items<MotionHeader>(receive(job_.partner(), rank, Subject::spheres), records);
    for (const StateRecord& record : records) {
      told_.push_back({rank, record});
      dem.told.push_back(sphere_state(record));
    }
  }
  collectively(job_.own(), [&] { sort_by_tag(dem.told); });
  check_tags_of_ranks(job_.own(), dem.told);
  std::array<std::int64_t, 2> sent{0, 0};  // fixed and mobile
  for (const SphereState& sphere : dem.told) ++sent[sphere.mobile ? 1 : 0];
  MPI_Allreduce(MPI_IN_PLACE, sent.data(), 2, MPI_INT64_T, MPI_SUM, job_.own());
  if (sent[1] != dem.scene_info.mobile || sent[0] != dem.scene_info.fixed)
    throw UserError(
        fmt::format("LIGGGHTS announced {} mobile and {} fixed spheres but sent {} and {}.",
                    dem.scene_info.mobile, dem.scene_info.fixed, sent[1], sent[0]));
  return dem;
}

std::vector<SphereState> FluidSide::share_out(const BlockMap& blocks) {
  std::vector<std::vector<OwnedSphere>> near(static_cast<std::size_t>(job_.size()));
  for (const OwnedSphere& sphere : std::exchange(told_, {}))
    blocks.near(vec3(sphere.record.position), reach_of(sphere.record, blocks.h),
                [&](int block) { near[static_cast<std::size_t>(block)].push_back(sphere); });
  std::vector<SphereState> spheres;
  for (const OwnedSphere& sphere : send_to_ranks(job_.own(), near)) {
    remember_owners({sphere.record}, static_cast<int>(sphere.owner));
    spheres.push_back(sphere_state(sphere.record));
  }
  sort_by_tag(spheres);
  return spheres;
}

void FluidSide::remember_owners(const std::vector<StateRecord>& records, int dem) {
  for (const StateRecord& record : records)
    if (record.mobile != 0) owners_[record.tag] = dem;
}

void FluidSide::divide(const BlockMap& blocks) {
  blocks_ = blocks;
  std::vector<std::int32_t> firsts(blocks.y.begin(), blocks.y.end());
  firsts.insert(firsts.end(), blocks.z.begin(), blocks.z.end());
  const auto message = std::make_shared<const Bytes>(pack(
      DivisionHeader{blocks.y_parts(), blocks.z_parts()}, std::span<const std::int32_t>(firsts)));
  for (const int dem : target_ranks(job_.rank(), job_.size(), job_.partner_size()))
    send_queue_.post(dem, Subject::division, message);
  std::vector<std::vector<int>> partners_of(static_cast<std::size_t>(job_.size()));
  for (const int dem : target_ranks(job_.rank(), job_.size(), job_.partner_size())) {
    std::vector<std::int32_t> ranks;
    const Bytes bytes = receive(job_.partner(), dem, Subject::partners);
    assert(unpack_header<PartnersHeader>(bytes).rank == dem);
    unpack_items<PartnersHeader>(bytes, ranks);
    for (const std::int32_t rank : ranks)
      partners_of[static_cast<std::size_t>(rank)].push_back(dem);
  }
  partners_ = send_to_ranks(job_.own(), partners_of);
  std::sort(partners_.begin(), partners_.end());
}

void FluidSide::send_loads(int stage, double time_step, bool last_step,
                           std::span<const SphereLoad> loads) {
  receive_renewed();  // where the caller has not asked for it
  stage_ = stage;
  StageSums& sums = sums_[static_cast<std::size_t>(stage)] = {};
  const double length = dem_steps().duration(stage, time_step);
  for (const SphereLoad& load : loads) {
    add(sums.sent, triple(length * load.force));
    add(sums.angular_sent, triple(length * load.torque));
    sums.size += length * load.force.norm();
    sums.angular_size += length * load.torque.norm();
  }
  post_loads({step_, stage, Order::advance, time_step, last_step ? 1 : 0, 0}, loads);
  send_queue_.push(longest_push);
}

Motion FluidSide::receive_motion() {
  Motion motion;
  StageSums& sums = sums_[static_cast<std::size_t>(stage_)];
  owners_.clear();
  collisions_ = 0;
  for (const int dem : partners_) {
    const Bytes bytes = receive(job_.partner(), dem, Subject::states);
    const auto header = unpack_header<MotionHeader>(bytes);
    assert(header.step == step_ && header.stage == stage_);
    std::vector<StateRecord> records;
    unpack_items<MotionHeader>(bytes, records);
    remember_owners(records, dem);
    for (const StateRecord& record : records) motion.mobile.push_back(sphere_state(record));
    add(sums.given, header.impulse);
    add(sums.angular_given, header.angular_impulse);
    add(sums.given, header.lost);
    add(sums.angular_given, header.angular_lost);
    sums.on_walls[0] += header.on_lower_walls;
    sums.on_walls[1] += header.on_upper_walls;
    collisions_ += header.collisions;
    renewal_due_ = header.renewed != 0;
    motion.dem_began =
        dem == partners_.front() ? header.began : std::min(motion.dem_began, header.began);
    motion.dem_ended = std::max(motion.dem_ended, header.ended);
  }
  sort_by_tag(motion.mobile);
  std::vector<SphereState> here;
  std::copy_if(motion.mobile.begin(), motion.mobile.end(), std::back_inserter(here),
               [this](const auto& s) { return blocks_.home(s.position) == job_.rank(); });
  mobile_ = static_cast<std::int64_t>(here.size());
  kinds_ = kinds_of(here);
  if (stage_ + 1 == static_cast<int>(sums_.size())) ++step_;
  return motion;
}

std::vector<SphereState> FluidSide::receive_renewed() {
  std::vector<SphereState> spheres;
  if (!std::exchange(renewal_due_, false)) return spheres;
  for (const int dem : partners_) {
    std::vector<StateRecord> records;
    unpack_items<MotionHeader>(receive(job_.partner(), dem, Subject::states), records);
    remember_owners(records, dem);
    for (const StateRecord& record : records) spheres.push_back(sphere_state(record));
  }
  sort_by_tag(spheres);
  return spheres;
}

StepAccount FluidSide::settle() {
  static_assert(sizeof(sums_) == std::tuple_size_v<decltype(sums_)> * 16 * sizeof(double));
  struct {
    decltype(sums_) stages;
    double collisions, mobile, renewed, kinds;  // exact in a double
  } all{sums_, static_cast<double>(collisions_), static_cast<double>(mobile_),
        renewal_due_ ? 1.0 : 0.0, kinds_};
  MPI_Allreduce(MPI_IN_PLACE, &all, sizeof(all) / sizeof(double), MPI_DOUBLE, MPI_SUM, job_.own());
  StepAccount account;
  for (const StageSums& s : all.stages) {
    account.momentum_residual =
        std::max({account.momentum_residual, relative_difference(s.given, s.sent, s.size),
                  relative_difference(s.angular_given, s.angular_sent, s.angular_size)});
    for (std::size_t end = 0; end < s.on_walls.size(); ++end)
      account.on_walls[end] += s.on_walls[end];
  }
  account.collisions = all.collisions < 0.0 ? -1 : static_cast<std::int64_t>(all.collisions);
  account.mobile = static_cast<std::int64_t>(all.mobile);
  renewal_due_ = all.renewed > 0.0;  // also of ranks without a partner
  account.kinds = all.kinds;
  return account;
}

void FluidSide::order_checkpoint(const std::string& grains, std::int64_t id) {
  post_loads({step_, 0, Order::checkpoint, 0.0, 0, 0}, {});
  const auto message =
      std::make_shared<const Bytes>(pack(CheckpointHeader{id}, std::span<const char>(grains)));
  for (const int dem : target_ranks(job_.rank(), job_.size(), job_.partner_size()))
    send_queue_.post(dem, Subject::checkpoint, message);
  send_queue_.push(longest_push);
}

void FluidSide::await_checkpoint() {
  receive(job_.partner(), source_rank(job_.rank(), job_.partner_size()), Subject::checkpoint);
}

void FluidSide::stop() {
  receive_renewed();
  post_loads({step_, 0, Order::stop, 0.0, 1, 0}, {});
  send_queue_.flush();
}

void FluidSide::post_loads(const LoadHeader& header, std::span<const SphereLoad> loads) {
  std::unordered_map<int, std::vector<LoadRecord>> records;
  for (const SphereLoad& load : loads) records[owners_.at(load.tag)].push_back(load_record(load));
  for (const int dem : partners_)
    send_queue_.post(
        dem, Subject::loads,
        std::make_shared<const Bytes>(pack(header, std::span<const LoadRecord>(records[dem]))));
}

}  // namespace bedload
