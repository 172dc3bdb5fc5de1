#include "coupling/fluid_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "coupling/handshake.hpp"
#include "coupling/routes.hpp"
#include "coupling/stages.hpp"
#include "fluid/errors.hpp"

namespace bedload {
namespace {

/// Time that a rank spends on getting a long message out before it goes off to compute [s].
constexpr double push_patience = 2e-3;

double relative_difference(const Triple& a, const Triple& b, double size) {
  double difference = 0.0;
  for (std::size_t d = 0; d < 3; ++d) difference = std::max(difference, std::abs(a[d] - b[d]));
  return difference > 0.0 ? difference / size : 0.0;
}

void add(Triple& sum, const Triple& term) {
  for (std::size_t d = 0; d < 3; ++d) sum[d] += term[d];
}

/// What the fluid computes does not depend on which rank of LIGGGHTS holds a sphere.
void sort_by_tag(std::vector<SphereState>& spheres) {
  std::sort(spheres.begin(), spheres.end(),
            [](const SphereState& a, const SphereState& b) { return a.tag < b.tag; });
  const std::vector<SphereState>& ascending = spheres;
  for (std::size_t i = 1; i < ascending.size(); ++i)
    if (ascending[i].tag == ascending[i - 1].tag)
      throw UserError(
          fmt::format("LIGGGHTS has two atoms of tag {}; every atom needs a tag of its own.",
                      ascending[i].tag));
}

}  // namespace

FluidSide::FluidSide(const Job& job) : job_(job), outbox_(job.partner()) {}

void FluidSide::introduce(const FluidFacts& facts, const std::string& grains) {
  facts_ = facts;
  step_ = std::max<std::int64_t>(0, facts.restart_step);
  const auto message = std::make_shared<const Bytes>(pack(facts, std::span<const char>(grains)));
  for (const int dem : listeners(job_.rank(), job_.size(), job_.partner_size()))
    outbox_.post(dem, Subject::fluid_facts, message);
}

Acquaintance FluidSide::meet() {
  const Bytes bytes = receive(job_.partner(), 0, Subject::dem_facts);
  Acquaintance dem;
  dem.facts = unpack_header<DemFacts>(bytes);
  std::vector<char> effects;
  unpack_items<DemFacts>(bytes, effects);
  dem.effects.assign(effects.begin(), effects.end());
  if (const auto sentence = disagreement(facts_, dem.facts)) throw UserError(*sentence);

  for (int rank = 0; rank < job_.partner_size(); ++rank) {
    std::vector<StateRecord> records;
    unpack_items<MotionHeader>(receive(job_.partner(), rank, Subject::spheres), records);
    remember_owners(records, rank);
    for (const StateRecord& record : records) dem.spheres.push_back(sphere_state(record));
  }
  sort_by_tag(dem.spheres);
  const auto mobile =
      std::count_if(dem.spheres.begin(), dem.spheres.end(), [](const auto& s) { return s.mobile; });
  if (mobile != dem.facts.mobile ||
      static_cast<std::int64_t>(dem.spheres.size()) - mobile != dem.facts.fixed)
    throw UserError(fmt::format(
        "LIGGGHTS announced {} mobile and {} fixed spheres but sent {} and {}.", dem.facts.mobile,
        dem.facts.fixed, mobile, static_cast<std::int64_t>(dem.spheres.size()) - mobile));
  return dem;
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
  for (const int dem : listeners(job_.rank(), job_.size(), job_.partner_size()))
    outbox_.post(dem, Subject::division, message);
  for (int dem = 0; dem < job_.partner_size(); ++dem)
    if (receive(job_.partner(), dem, Subject::partners).front() != std::byte{0})
      partners_.push_back(dem);
}

void FluidSide::send_loads(int stage, double time_step, bool last_step,
                           std::span<const SphereLoad> loads) {
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
  outbox_.push(push_patience);
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
    collisions_ += header.collisions;
    motion.dem_began =
        dem == partners_.front() ? header.began : std::min(motion.dem_began, header.began);
    motion.dem_ended = std::max(motion.dem_ended, header.ended);
  }
  sort_by_tag(motion.mobile);
  mobile_ = std::count_if(motion.mobile.begin(), motion.mobile.end(), [this](const auto& s) {
    return blocks_.home(s.position) == job_.rank();
  });
  if (stage_ + 1 == static_cast<int>(sums_.size())) ++step_;
  return motion;
}

StepAccount FluidSide::settle() {
  static_assert(sizeof(sums_) == std::tuple_size_v<decltype(sums_)> * 14 * sizeof(double));
  struct {
    decltype(sums_) stages;
    double collisions, mobile;  // exact in a double
  } all{sums_, static_cast<double>(collisions_), static_cast<double>(mobile_)};
  MPI_Allreduce(MPI_IN_PLACE, &all, sizeof(all) / sizeof(double), MPI_DOUBLE, MPI_SUM, job_.own());
  StepAccount account;
  for (const StageSums& s : all.stages)
    account.momentum_residual =
        std::max({account.momentum_residual, relative_difference(s.given, s.sent, s.size),
                  relative_difference(s.angular_given, s.angular_sent, s.angular_size)});
  account.collisions = all.collisions < 0.0 ? -1 : static_cast<std::int64_t>(all.collisions);
  account.mobile = static_cast<std::int64_t>(all.mobile);
  return account;
}

void FluidSide::order_checkpoint(const std::string& grains) {
  post_loads({step_, 0, Order::checkpoint, 0.0, 0, 0}, {});
  const auto message =
      std::make_shared<const Bytes>(pack(LoadHeader{}, std::span<const char>(grains)));
  for (const int dem : listeners(job_.rank(), job_.size(), job_.partner_size()))
    outbox_.post(dem, Subject::checkpoint, message);
  outbox_.push(push_patience);
}

void FluidSide::await_checkpoint() {
  for (int dem = 0; dem < job_.partner_size(); ++dem)
    receive(job_.partner(), dem, Subject::checkpoint);
}

void FluidSide::stop() {
  post_loads({step_, 0, Order::stop, 0.0, 1, 0}, {});
  outbox_.flush();
}

void FluidSide::post_loads(const LoadHeader& header, std::span<const SphereLoad> loads) {
  std::unordered_map<int, std::vector<LoadRecord>> records;
  for (const SphereLoad& load : loads) records[owners_.at(load.tag)].push_back(load_record(load));
  for (const int dem : partners_)
    outbox_.post(
        dem, Subject::loads,
        std::make_shared<const Bytes>(pack(header, std::span<const LoadRecord>(records[dem]))));
}

}  // namespace bedload
