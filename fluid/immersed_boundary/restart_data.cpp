#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>
#include <utility>

#include "fluid/files/collectively.hpp"
#include "fluid/grid/send_to_ranks.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"

// What a checkpoint keeps of the mobile spheres, momentum inside them and what is deferred, and of
// all markers where diffusion is implicit.

namespace bedload {
namespace {

constexpr const auto& vectors = SphereMemory::vector_names;

/// One sphere on its way from a file to the ranks that know it.
struct Kept {
  std::int64_t tag;
  std::array<std::array<double, 3>, vectors.size()> values;
  std::int32_t fresh, rank;  ///< rank: who asks, in a request
};

std::vector<Kept> read_share(const LoadGroup& group, MPI_Comm comm) {
  std::vector<Kept> share;
  collectively(comm, [&] {
    const Part part = even_share(group.size("tag"), comm);
    const auto tags = group.rows<std::int64_t>("tag", part, 1);
    const auto fresh = group.rows<std::int32_t>("fresh", part, 1);
    share.resize(tags.size());
    for (std::size_t n = 0; n < share.size(); ++n) share[n] = {tags[n], {}, fresh[n], 0};
    for (std::size_t v = 0; v < vectors.size(); ++v) {
      const auto numbers = group.rows<double>(vectors[v], part, 3);
      for (std::size_t n = 0; n < share.size(); ++n)
        std::copy_n(&numbers[3 * n], 3, share[n].values[v].begin());
    }
  });
  return share;
}

/// The kept force of one marker on its way.
struct KeptForce {
  std::int64_t tag;
  std::int32_t place, rank;  ///< 3 times the place in the layout, and the component; who asks
  double force;
};

std::vector<KeptForce> read_force_share(const LoadGroup& group, MPI_Comm comm) {
  std::vector<KeptForce> share;
  collectively(comm, [&] {
    if (!group.has("marker_force")) return;  // of a run with explicit diffusion
    const Part part = even_share(group.size("marker_force"), comm);
    const auto tags = group.rows<std::int64_t>("marker_tag", part, 1);
    const auto places = group.rows<std::int32_t>("marker_place", part, 1);
    const auto forces = group.rows<double>("marker_force", part, 1);
    for (std::size_t n = 0; n < tags.size(); ++n)
      share.push_back({tags[n], places[n], 0, forces[n]});
  });
  return share;
}

/// The rank at which a sphere and those who ask for it meet.
std::size_t meeting_rank(std::int64_t tag, std::size_t ranks) {
  return static_cast<std::size_t>(tag) % ranks;
}

/// Of the records on all ranks those whose tags this rank asks for.
template <class Record>
std::vector<Record> fetch(const std::vector<Record>& share, const std::vector<std::int64_t>& wanted,
                          MPI_Comm comm) {
  int rank = 0, count = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &count);
  const auto ranks = static_cast<std::size_t>(count);
  std::vector<std::vector<Record>> there(ranks), requests(ranks), answers(ranks);
  for (const Record& kept : share) there[meeting_rank(kept.tag, ranks)].push_back(kept);
  for (const std::int64_t tag : wanted) {
    Record request{};
    request.tag = tag;
    request.rank = rank;
    requests[meeting_rank(tag, ranks)].push_back(request);
  }
  std::multimap<std::int64_t, Record> here;
  for (const Record& kept : send_to_ranks(comm, there)) here.emplace(kept.tag, kept);
  for (const Record& request : send_to_ranks(comm, requests))
    for (auto [found, end] = here.equal_range(request.tag); found != end; ++found)
      answers[static_cast<std::size_t>(request.rank)].push_back(found->second);
  return send_to_ranks(comm, answers);
}

}  // namespace

template <class Real>
void ImmersedBoundary<Real>::save(const SaveGroup& group) const {
  std::vector<std::int64_t> tags;
  std::vector<std::int32_t> fresh;
  std::array<std::vector<double>, vectors.size()> numbers;
  for (const Mobile& sphere : mobile_) {
    if (sphere.home != decomposition_.rank()) continue;
    tags.push_back(sphere.state.tag);
    fresh.push_back(sphere.memory.fresh ? 1 : 0);
    SphereMemory memory = sphere.memory;
    const auto values = memory.vectors();
    for (std::size_t v = 0; v < values.size(); ++v)
      numbers[v].insert(numbers[v].end(), values[v]->data(), values[v]->data() + 3);
  }
  group.rows<std::int64_t>("tag", tags);
  group.rows<std::int32_t>("fresh", fresh);
  for (std::size_t v = 0; v < vectors.size(); ++v) group.rows<double>(vectors[v], numbers[v], 3);
  if (keeps_force_) save_kept_forces(group);
}

template <class Real>
void ImmersedBoundary<Real>::load(const LoadGroup& group) {
  const MPI_Comm comm = decomposition_.comm();
  std::vector<std::int64_t> wanted;
  for (const Mobile& sphere : mobile_) wanted.push_back(sphere.state.tag);
  for (const Kept& kept : fetch(read_share(group, comm), wanted, comm)) {
    const auto known =
        std::lower_bound(mobile_.begin(), mobile_.end(), kept.tag,
                         [](const Mobile& m, std::int64_t t) { return m.state.tag < t; });
    const auto values = known->memory.vectors();
    for (std::size_t v = 0; v < values.size(); ++v) *values[v] = Vec3(kept.values[v].data());
    known->memory.fresh = kept.fresh != 0;
  }
  if (keeps_force_) load_kept_forces(group);
}

template <class Real>
void ImmersedBoundary<Real>::save_kept_forces(const SaveGroup& group) const {
  std::vector<std::int64_t> tags;
  std::vector<std::int32_t> places;
  std::vector<double> forces;
  const auto add = [&](const MarkerList<Real>& list, std::size_t c, auto tag_of) {
    for (const auto& range : list.ranges)
      for (auto m = static_cast<std::size_t>(range.begin); m < static_cast<std::size_t>(range.end);
           ++m) {
        tags.push_back(tag_of(static_cast<std::size_t>(range.sphere)));
        places.push_back(3 * list.offset[m] + static_cast<std::int32_t>(c));
        forces.push_back(static_cast<double>(list.kept_force[m]));
      }
  };
  for (std::size_t c = 0; c < 3; ++c) {
    add(fixed_lists_[c], c, [this](std::size_t n) { return fixed_[n].tag; });
    add(mobile_lists_[c], c, [this](std::size_t n) { return mobile_[n].state.tag; });
  }
  group.rows<std::int64_t>("marker_tag", tags);
  group.rows<std::int32_t>("marker_place", places);
  group.rows<double>("marker_force", forces);
}

template <class Real>
void ImmersedBoundary<Real>::load_kept_forces(const LoadGroup& group) {
  std::vector<std::int64_t> wanted;
  std::unordered_map<std::int64_t, ByMarker> forces;
  const auto ask = [&](const SphereState& sphere) {
    wanted.push_back(sphere.tag);
    const MarkerLayout& layout = layouts_[static_cast<std::size_t>(layout_of(sphere.radius))];
    for (std::vector<Real>& all : forces[sphere.tag]) all.assign(layout.offsets.size(), Real{});
  };
  for (const SphereState& sphere : fixed_) ask(sphere);
  for (const Mobile& sphere : mobile_) ask(sphere.state);
  const MPI_Comm comm = decomposition_.comm();
  for (const KeptForce& kept : fetch(read_force_share(group, comm), wanted, comm)) {
    std::vector<Real>& all = forces.at(kept.tag)[static_cast<std::size_t>(kept.place % 3)];
    const auto place = static_cast<std::size_t>(kept.place / 3);
    if (place < all.size()) all[place] = static_cast<Real>(kept.force);
  }
  for (Mobile& sphere : mobile_) sphere.kept_forces = forces.at(sphere.state.tag);
  use_kept_forces();
  for (std::size_t c = 0; c < 3; ++c) {
    MarkerList<Real>& list = fixed_lists_[c];
    for (const auto& range : list.ranges)
      for (auto m = static_cast<std::size_t>(range.begin); m < static_cast<std::size_t>(range.end);
           ++m)
        list.kept_force[m] = forces.at(fixed_[static_cast<std::size_t>(range.sphere)]
                                           .tag)[c][static_cast<std::size_t>(list.offset[m])];
  }
}

template void ImmersedBoundary<float>::save(const SaveGroup&) const;
template void ImmersedBoundary<float>::load(const LoadGroup&);
template void ImmersedBoundary<double>::save(const SaveGroup&) const;
template void ImmersedBoundary<double>::load(const LoadGroup&);

}  // namespace bedload
