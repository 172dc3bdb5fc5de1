#include "coupling/dem_side.hpp"

#include <memory>

#include "coupling/routes.hpp"

namespace bedload {

DemSide::DemSide(const Job& job) : job_(job), outbox_(job.partner()) {}

const FluidFacts& DemSide::facts() {
  if (!facts_) {
    const int sender = load_sender(job_.rank(), job_.partner_size());
    facts_ = unpack_header<FluidFacts>(receive(job_.partner(), sender, Subject::fluid_facts));
  }
  return *facts_;
}

void DemSide::introduce(const DemFacts& facts, const std::string& effects,
                        std::span<const StateRecord> spheres) {
  if (job_.rank() == 0) {
    const auto message = std::make_shared<const Bytes>(pack(facts, std::span<const char>(effects)));
    for (const int fluid : state_receivers(job_.partner_size()))
      outbox_.post(fluid, Subject::dem_facts, message);
  }
  post_states(Subject::spheres, MotionHeader{}, spheres);
  introduced_ = true;
}

StageLoads DemSide::receive_loads() {
  const int sender = load_sender(job_.rank(), job_.partner_size());
  const Bytes bytes = receive(job_.partner(), sender, Subject::loads);
  StageLoads stage;
  stage.header = unpack_header<LoadHeader>(bytes);
  unpack_items<LoadHeader>(bytes, stage.loads);
  stopped_ = stage.header.order == Order::stop;
  // All states have been read when the next order comes; let MPI drop the requests.
  if (stopped_) outbox_.flush();
  return stage;
}

void DemSide::send_motion(MotionHeader header, std::span<const StateRecord> spheres) {
  post_states(Subject::states, header, spheres);
}

void DemSide::post_states(Subject subject, const MotionHeader& header,
                          std::span<const StateRecord> spheres) {
  const auto message = std::make_shared<const Bytes>(pack(header, spheres));
  for (const int fluid : state_receivers(job_.partner_size()))
    outbox_.post(fluid, subject, message);
}

}  // namespace bedload
