#include "coupling/exchange/dem_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "coupling/exchange/stages.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {

namespace {

/// The text behind a header.
template <Record Header>
std::string text_of(const Bytes& bytes) {
  std::vector<char> text;
  unpack_items<Header>(bytes, text);
  return {text.begin(), text.end()};
}

}  // namespace

DemSide::DemSide(const Job& job) : job_(job), send_queue_(job.partner()) {}

const FluidSceneInfo& DemSide::scene_info() {
  if (!scene_info_) {
    const int sender = source_rank(job_.rank(), job_.partner_size());
    const Bytes bytes = receive(job_.partner(), sender, Subject::fluid_scene_info);
    scene_info_ = unpack_header<FluidSceneInfo>(bytes);
    restart_file_ = text_of<FluidSceneInfo>(bytes);
  }
  return *scene_info_;
}

void DemSide::introduce(const DemSceneInfo& scene_info, const std::string& effects,
                        std::span<const StateRecord> spheres) {
  const auto words =
      std::make_shared<const Bytes>(pack(scene_info, std::span<const char>(effects)));
  for (const int fluid : target_ranks(job_.rank(), job_.size(), job_.partner_size()))
    send_queue_.post(fluid, Subject::dem_scene_info, words);
  send_queue_.post(source_rank(job_.rank(), job_.partner_size()), Subject::spheres,
                   std::make_shared<const Bytes>(pack(MotionHeader{}, spheres)));
  introduced_ = true;
}

void DemSide::find_partners(const Region& region) {
  const int sender = source_rank(job_.rank(), job_.partner_size());
  const Bytes bytes = receive(job_.partner(), sender, Subject::division);
  const auto header = unpack_header<DivisionHeader>(bytes);
  std::vector<std::int32_t> firsts;
  unpack_items<DivisionHeader>(bytes, firsts);
  const FluidSceneInfo& fluid = scene_info();
  const auto z = firsts.begin() + header.y_parts + 1;
  blocks_ = {.length = fluid.length,
             .periodic = {fluid.periodic[0] != 0, fluid.periodic[1] != 0, fluid.periodic[2] != 0},
             .h = fluid.cell_size,
             .y = {firsts.begin(), z},
             .z = {z, firsts.end()}};
  partners_ = partners_of(region, blocks_);
  const std::vector<std::int32_t> ranks(partners_.begin(), partners_.end());
  send_queue_.post(sender, Subject::partners,
                   std::make_shared<const Bytes>(
                       pack(PartnersHeader{job_.rank()}, std::span<const std::int32_t>(ranks))));
}

StageLoads DemSide::receive_loads() {
  StageLoads stage;
  for (const int fluid : partners_) {
    const Bytes bytes = receive(job_.partner(), fluid, Subject::loads);
    stage.header = unpack_header<LoadHeader>(bytes);
    unpack_items<LoadHeader>(bytes, stage.loads);
  }
  stopped_ = stage.header.order == Order::stop;
  if (stage.header.order == Order::advance)
    longest_stage_ = longest_stage_of_step * stage.header.fluid_time_step;
  if (stage.header.order == Order::checkpoint) {
    const Bytes bytes =
        receive(job_.partner(), source_rank(job_.rank(), job_.partner_size()), Subject::checkpoint);
    checkpoint_id_ = unpack_header<CheckpointHeader>(bytes).id;
    checkpoint_file_ = text_of<CheckpointHeader>(bytes);
  }
  // All states have been read when the next order comes; let MPI drop the requests.
  if (stopped_) send_queue_.flush();
  return stage;
}

void DemSide::confirm_checkpoint() {
  const auto message = std::make_shared<const Bytes>();
  for (const int fluid : target_ranks(job_.rank(), job_.size(), job_.partner_size()))
    send_queue_.post(fluid, Subject::checkpoint, message);
}

void DemSide::send_motion(MotionHeader header, std::span<const StateRecord> spheres) {
  std::vector<std::vector<StateRecord>> records(partners_.size());
  for (const StateRecord& sphere : spheres)
    blocks_.near(
        vec3(sphere.position), reach_of(sphere, blocks_.h, longest_stage_), [&](int fluid) {
          const auto partner = std::lower_bound(partners_.begin(), partners_.end(), fluid);
          if (partner == partners_.end() || *partner != fluid)
            throw UserError(fmt::format(
                "atom {} (radius {}) at ({:.6g}, {:.6g}, {:.6g}) reaches further out of its "
                "processor's part of the box than was expected of the largest sphere at "
                "the start; use fewer ranks for LIGGGHTS or a wider neighbor skin.",
                sphere.tag, sphere.radius, sphere.position[0], sphere.position[1],
                sphere.position[2]));
          records[static_cast<std::size_t>(partner - partners_.begin())].push_back(sphere);
        });
  for (std::size_t n = 0; n < partners_.size(); ++n) {
    send_queue_.post(
        partners_[n], Subject::states,
        std::make_shared<const Bytes>(pack(header, std::span<const StateRecord>(records[n]))));
    header.impulse = header.angular_impulse = {};  // the first has them
    header.lost = header.angular_lost = {};
    header.on_lower_walls = header.on_upper_walls = 0.0;
    header.collisions = 0;
  }
}

}  // namespace bedload
