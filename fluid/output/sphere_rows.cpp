#include "fluid/output/sphere_rows.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <tuple>

#include "fluid/grid/mpi_ranks.hpp"
#include "fluid/grid/send_to_ranks.hpp"

namespace bedload {
namespace {

/// The rows of even ranges of tags, each range on one rank: by ascending instants and tags.
std::vector<SphereRow> by_range_of_tags(MPI_Comm comm, const std::vector<SphereRow>& rows) {
  constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::array<std::int64_t, 2> ends{none, none};  // lowest tag, and the highest with other sign
  for (const SphereRow& row : rows)
    ends = {std::min(ends[0], row.tag), std::min(ends[1], -row.tag)};
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 2, MPI_INT64_T, MPI_MIN, comm);
  const auto ranks = static_cast<std::size_t>(size_of(comm));
  // In double: where no rank has a row both are the largest number.
  const double width = -static_cast<double>(ends[1]) - static_cast<double>(ends[0]) + 1.0;
  std::vector<std::vector<SphereRow>> to(ranks);
  for (const SphereRow& row : rows) {
    const double part = static_cast<double>(row.tag - ends[0]) / width;
    to[std::min(ranks - 1, static_cast<std::size_t>(part * static_cast<double>(ranks)))].push_back(
        row);
  }
  std::vector<SphereRow> here = send_to_ranks(comm, to);
  std::stable_sort(here.begin(), here.end(), [](const SphereRow& a, const SphereRow& b) {
    return std::tuple(a.sample, a.tag, a.radius == 0.0) <
           std::tuple(b.sample, b.tag, b.radius == 0.0);
  });
  return here;
}

/// Rows of one sphere and instant stand one after the other, the sphere itself first.
std::vector<SphereRow> loads_added_up(const std::vector<SphereRow>& rows) {
  std::vector<SphereRow> whole;
  for (const SphereRow& row : rows) {
    const bool known =
        !whole.empty() && whole.back().sample == row.sample && whole.back().tag == row.tag;
    if (row.radius != 0.0) {
      whole.push_back(row);
    } else if (known) {
      whole.back().force += row.force;
      whole.back().torque += row.torque;
    }
  }
  return whole;
}

}  // namespace

SphereRows ordered_by_tag(MPI_Comm comm, const std::vector<SphereRow>& rows, std::size_t samples,
                          std::uint64_t few) {
  std::vector<SphereRow> whole = loads_added_up(by_range_of_tags(comm, rows));

  SphereRows ordered;
  std::vector<std::uint64_t> mine(samples, 0), place(samples, 0);
  for (const SphereRow& row : whole) ++mine[static_cast<std::size_t>(row.sample)];
  ordered.of_sample = mine;
  const int count = mpi_count(samples, "samples of the spheres");
  MPI_Allreduce(MPI_IN_PLACE, ordered.of_sample.data(), count, MPI_UINT64_T, MPI_SUM, comm);
  MPI_Exscan(mine.data(), place.data(), count, MPI_UINT64_T, MPI_SUM, comm);
  if (rank_in(comm) == 0) std::fill(place.begin(), place.end(), 0);  // MPI leaves it open there
  std::uint64_t all = 0;
  for (std::size_t n = 0; n < samples; ++n) {
    place[n] += all;
    all += ordered.of_sample[n];
  }

  // Rank r of those that get any has the places all r/ranks and up.
  const auto ranks = static_cast<std::uint64_t>(all > few ? size_of(comm) : 1);
  std::vector<std::vector<SphereRow>> to(static_cast<std::size_t>(size_of(comm)));
  for (SphereRow& row : whole) {
    const std::uint64_t at = place[static_cast<std::size_t>(row.sample)]++;
    row.place = static_cast<std::int64_t>(at);
    to[((at + 1) * ranks - 1) / all].push_back(row);
  }
  whole = {};
  ordered.mine = send_to_ranks(comm, to);
  std::sort(ordered.mine.begin(), ordered.mine.end(),
            [](const SphereRow& a, const SphereRow& b) { return a.place < b.place; });
  return ordered;
}

}  // namespace bedload
