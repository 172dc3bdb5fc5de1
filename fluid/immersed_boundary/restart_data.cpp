#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "fluid/files/collectively.hpp"
#include "fluid/grid/send_to_ranks.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"

// What a checkpoint keeps of the mobile spheres: momentum inside them and what is deferred.

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

/// The rank at which a sphere and those who ask for it meet.
std::size_t meeting_rank(std::int64_t tag, std::size_t ranks) {
  return static_cast<std::size_t>(tag) % ranks;
}

/// Of the records on all ranks those whose tags this rank asks for.
std::vector<Kept> fetch(const std::vector<Kept>& share, const std::vector<std::int64_t>& wanted,
                        MPI_Comm comm) {
  int rank = 0, count = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &count);
  const auto ranks = static_cast<std::size_t>(count);
  std::vector<std::vector<Kept>> there(ranks), requests(ranks), answers(ranks);
  for (const Kept& kept : share) there[meeting_rank(kept.tag, ranks)].push_back(kept);
  for (const std::int64_t tag : wanted)
    requests[meeting_rank(tag, ranks)].push_back({tag, {}, 0, rank});
  std::map<std::int64_t, Kept> here;
  for (const Kept& kept : send_to_ranks(comm, there)) here[kept.tag] = kept;
  for (const Kept& request : send_to_ranks(comm, requests))
    if (const auto found = here.find(request.tag); found != here.end())
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
}

template void ImmersedBoundary<float>::save(const SaveGroup&) const;
template void ImmersedBoundary<float>::load(const LoadGroup&);
template void ImmersedBoundary<double>::save(const SaveGroup&) const;
template void ImmersedBoundary<double>::load(const LoadGroup&);

}  // namespace bedload
