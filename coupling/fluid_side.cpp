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

std::vector<std::int64_t> tags_of(const std::vector<SphereState>& spheres) {
  std::vector<std::int64_t> tags;
  tags.reserve(spheres.size());
  for (const SphereState& s : spheres) tags.push_back(s.tag);
  return tags;
}

void check_tags(const std::vector<SphereState>& ascending) {
  for (std::size_t i = 1; i < ascending.size(); ++i)
    if (ascending[i].tag == ascending[i - 1].tag)
      throw UserError(
          fmt::format("LIGGGHTS has two atoms of tag {}; every atom needs a tag of its own.",
                      ascending[i].tag));
}

}  // namespace

FluidSide::FluidSide(const Job& job) : job_(job), outbox_(job.partner()) {}

void FluidSide::introduce(const FluidFacts& facts) {
  facts_ = facts;
  const auto message = std::make_shared<const Bytes>(pack(facts, std::span<const char>{}));
  for (const int dem : load_receivers(job_.rank(), job_.size(), job_.partner_size()))
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

  std::vector<MotionHeader> headers;
  dem.spheres = gather_states(Subject::spheres, headers);
  const auto mobile =
      std::count_if(dem.spheres.begin(), dem.spheres.end(), [](const auto& s) { return s.mobile; });
  if (mobile != dem.facts.mobile ||
      static_cast<std::int64_t>(dem.spheres.size()) - mobile != dem.facts.fixed)
    throw UserError(fmt::format(
        "LIGGGHTS announced {} mobile and {} fixed spheres but sent {} and {}.", dem.facts.mobile,
        dem.facts.fixed, mobile, static_cast<std::int64_t>(dem.spheres.size()) - mobile));
  for (const SphereState& s : dem.spheres)
    if (s.mobile) mobile_tags_.push_back(s.tag);
  return dem;
}

void FluidSide::send_loads(int stage, double time_step, bool last_step,
                           std::span<const SphereLoad> loads) {
  stage_ = stage;
  std::vector<LoadRecord> records;
  records.reserve(loads.size());
  impulse_sent_ = angular_impulse_sent_ = {};
  impulse_size_ = angular_impulse_size_ = 0.0;
  const double length = stage_length(stage, time_step);
  for (const SphereLoad& load : loads) {
    records.push_back(load_record(load));
    add(impulse_sent_, triple(length * load.force));
    add(angular_impulse_sent_, triple(length * load.torque));
    impulse_size_ += length * load.force.norm();
    angular_impulse_size_ += length * load.torque.norm();
  }
  post_loads({step_, stage, Order::advance, time_step, last_step ? 1 : 0, 0}, records);
  outbox_.push(push_patience);
}

Motion FluidSide::receive_motion() {
  std::vector<MotionHeader> headers;
  Motion motion;
  motion.mobile = gather_states(Subject::states, headers);

  Triple impulse{}, angular_impulse{};
  motion.dem_began = headers.front().began;
  std::int64_t collisions = 0;
  for (const MotionHeader& header : headers) {
    add(impulse, header.impulse);
    add(angular_impulse, header.angular_impulse);
    collisions += header.collisions;
    motion.dem_began = std::min(motion.dem_began, header.began);
    motion.dem_ended = std::max(motion.dem_ended, header.ended);
  }
  motion.collisions = collisions < 0 ? -1 : collisions;
  motion.momentum_residual =
      std::max(relative_difference(impulse, impulse_sent_, impulse_size_),
               relative_difference(angular_impulse, angular_impulse_sent_, angular_impulse_size_));

  const std::vector<std::int64_t> tags = tags_of(motion.mobile);
  motion.same_spheres = tags == mobile_tags_;
  mobile_tags_ = tags;
  if (stage_ + 1 == static_cast<int>(dem_substeps.size())) ++step_;
  return motion;
}

void FluidSide::stop() {
  post_loads({step_, 0, Order::stop, 0.0, 1, 0}, {});
  outbox_.flush();
}

void FluidSide::post_loads(const LoadHeader& header, std::span<const LoadRecord> records) {
  const auto message = std::make_shared<const Bytes>(pack(header, records));
  for (const int dem : load_receivers(job_.rank(), job_.size(), job_.partner_size()))
    outbox_.post(dem, Subject::loads, message);
}

std::vector<SphereState> FluidSide::gather_states(Subject subject,
                                                  std::vector<MotionHeader>& headers) const {
  std::vector<StateRecord> records;
  for (int dem = 0; dem < job_.partner_size(); ++dem) {
    const Bytes bytes = receive(job_.partner(), dem, subject);
    headers.push_back(unpack_header<MotionHeader>(bytes));
    assert(headers.back().step == step_ && headers.back().stage == stage_);
    unpack_items<MotionHeader>(bytes, records);
  }
  // Ascending tags: what the fluid computes does not depend on which LIGGGHTS rank holds a sphere.
  std::sort(records.begin(), records.end(),
            [](const StateRecord& a, const StateRecord& b) { return a.tag < b.tag; });
  std::vector<SphereState> spheres;
  spheres.reserve(records.size());
  for (const StateRecord& record : records) spheres.push_back(sphere_state(record));
  check_tags(spheres);
  return spheres;
}

}  // namespace bedload
