#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <type_traits>

#include "fluid/spheres/gather.hpp"
#include "fluid/spheres/immersed_boundary.hpp"

// What the mobile spheres get: the ranks' shares added up, loads, and what a sphere is still owed
// from stage to stage and from rank to rank.

namespace bedload {
namespace {

/// Share of the interior momentum still owed to a sphere that it gets per stage: 1 is exact at once
/// but unstable below a density ratio of about 0.8, 0.1 is stable down to 0.5 (README.md).
constexpr double owed_share = 0.1;

/// Share of the angular momentum due to a sphere that it gets per stage. The kernel makes it drag a
/// layer outside its surface, alpha times as inert as the fluid inside, by what it turned in the
/// stage before: with the whole at once its spin changes sign and grows where alpha rho_f/rho_p > 1
/// (README.md, "The layer that turns along"); with one half only beyond 3.
constexpr double turn_share = 0.5;

constexpr int memory_message = 21, share_message = 22;  // message tags

/// Sends and receives one message per rank; lengths are known on both sides.
void exchange(MPI_Comm comm, int tag, const std::map<int, std::vector<double>>& leaving,
              std::map<int, std::vector<double>>& coming) {
  std::vector<MPI_Request> requests;
  for (auto& [rank, message] : coming)
    MPI_Irecv(message.data(), static_cast<int>(message.size()), MPI_DOUBLE, rank, tag, comm,
              &requests.emplace_back());
  for (const auto& [rank, message] : leaving)
    MPI_Isend(message.data(), static_cast<int>(message.size()), MPI_DOUBLE, rank, tag, comm,
              &requests.emplace_back());
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

constexpr std::size_t memory_numbers = 16;

template <class Memory>
void append_memory(const Memory& memory, std::vector<double>& message) {
  for (const InteriorMomentum* m : {&memory.forced, &memory.owed})
    for (const Vec3* v : {&m->linear, &m->angular})
      message.insert(message.end(), v->data(), v->data() + 3);
  message.insert(message.end(), memory.turn_due.data(), memory.turn_due.data() + 3);
  message.push_back(memory.fresh ? 1.0 : 0.0);
}

template <class Memory>
void read_memory(const double* numbers, Memory& memory) {
  for (InteriorMomentum* m : {&memory.forced, &memory.owed})
    for (Vec3* v : {&m->linear, &m->angular})
      for (int d = 0; d < 3; ++d) (*v)[d] = *numbers++;
  for (int d = 0; d < 3; ++d) memory.turn_due[d] = *numbers++;
  memory.fresh = *numbers != 0.0;
}

}  // namespace

/// Brings the memory of each sphere that stays to the rank that holds its centre now. Both ranks
/// know of it when each of them was, and is, near the sphere; one that has jumped further starts
/// afresh.
template <class Real>
void ImmersedBoundary<Real>::hand_over_memories(std::vector<Mobile>& now) const {
  const int me = slabs_.rank();
  std::map<int, std::vector<double>> leaving, coming;
  std::map<int, std::vector<std::size_t>> receivers;
  std::size_t n = 0;
  for (const Mobile& old : mobile_) {
    while (n < now.size() && now[n].state.tag < old.state.tag) ++n;
    if (n == now.size()) break;
    Mobile& same = now[n];
    if (same.state.tag != old.state.tag) continue;
    if (old.home == same.home) {
      same.memory = old.memory;
      continue;
    }
    if (!blocks_.is_near(same.home, old.state.position, old.state.radius) ||
        !blocks_.is_near(old.home, same.state.position, same.state.radius))
      continue;
    if (old.home == me) append_memory(old.memory, leaving[same.home]);
    if (same.home == me) {
      receivers[old.home].push_back(n);
      coming[old.home].resize(receivers[old.home].size() * memory_numbers);
    }
  }
  exchange(slabs_.comm(), memory_message, leaving, coming);
  for (const auto& [rank, spheres] : receivers)
    for (std::size_t m = 0; m < spheres.size(); ++m)
      read_memory(coming[rank].data() + m * memory_numbers, now[spheres[m]].memory);
}

template <class Real>
void ImmersedBoundary<Real>::find_partners() {
  const int me = slabs_.rank();
  homes_.clear();
  guests_.clear();
  for (std::size_t n = 0; n < mobile_.size(); ++n) {
    const Mobile& sphere = mobile_[n];
    if (sphere.home != me)
      homes_[sphere.home].push_back(static_cast<int>(n));
    else
      blocks_.near(sphere.state.position, sphere.state.radius, [&](int rank) {
        if (rank != me) guests_[rank].push_back(static_cast<int>(n));
      });
  }
}

/// The shares of all ranks added up, right for the spheres whose centre this rank holds.
template <class Real>
std::vector<typename ImmersedBoundary<Real>::Share> ImmersedBoundary<Real>::complete_shares()
    const {
  static_assert(std::is_trivially_copyable_v<Share> && sizeof(Share) % sizeof(double) == 0);
  constexpr std::size_t numbers = sizeof(Share) / sizeof(double);
  std::map<int, std::vector<double>> leaving, coming;
  for (const auto& [rank, spheres] : homes_) {
    std::vector<double>& message = leaving[rank];
    message.resize(spheres.size() * numbers);
    for (std::size_t m = 0; m < spheres.size(); ++m)
      std::memcpy(message.data() + m * numbers,
                  &mobile_[static_cast<std::size_t>(spheres[m])].share, sizeof(Share));
  }
  for (const auto& [rank, spheres] : guests_) coming[rank].resize(spheres.size() * numbers);
  exchange(slabs_.comm(), share_message, leaving, coming);
  std::vector<Share> shares(mobile_.size());
  for (std::size_t n = 0; n < mobile_.size(); ++n) shares[n] = mobile_[n].share;
  for (const auto& [rank, spheres] : guests_)
    for (std::size_t m = 0; m < spheres.size(); ++m) {
      std::array<double, numbers> sum, term;
      Share& share = shares[static_cast<std::size_t>(spheres[m])];
      std::memcpy(sum.data(), &share, sizeof(Share));
      std::memcpy(term.data(), coming[rank].data() + m * numbers, sizeof(Share));
      for (std::size_t i = 0; i < numbers; ++i) sum[i] += term[i];
      std::memcpy(&share, sum.data(), sizeof(Share));
    }
  return shares;
}

template <class Real>
std::vector<SphereLoad> ImmersedBoundary<Real>::loads(double stage_step) {
  const std::vector<Share> sums = complete_shares();
  std::vector<SphereLoad> loads;
  for (std::size_t n = 0; n < mobile_.size(); ++n) {
    if (mobile_[n].home != slabs_.rank()) continue;
    const SphereState& state = mobile_[n].state;
    Memory& memory = mobile_[n].memory;
    const InteriorMomentum before = interior_momentum(sums[n].before, state.radius);
    const InteriorMomentum after = interior_momentum(sums[n].after, state.radius);
    if (memory.fresh) memory.forced = before;
    memory.fresh = false;
    // What changed inside between the last forcing and this stage's predictor: the projection, and
    // the step of the sphere through the field.
    memory.owed.linear += before.linear - memory.forced.linear;
    memory.owed.angular += before.angular - memory.forced.angular;
    memory.forced = after;

    // impulse = -rho sum given h^3 + rho (I_forced - I_before) + rho share * owed
    const double cell = grid_.cell_volume();
    const Vec3 given(sums[n].given.data()), moment(sums[n].given_moment.data());
    const Vec3 impulse =
        -cell * given + after.linear - before.linear + owed_share * memory.owed.linear;
    memory.turn_due +=
        -cell * moment + after.angular - before.angular + owed_share * memory.owed.angular;
    const Vec3 turn = turn_share * memory.turn_due;
    memory.turn_due -= turn;
    memory.owed.linear *= 1.0 - owed_share;
    memory.owed.angular *= 1.0 - owed_share;

    const double volume = 4.0 / 3.0 * std::numbers::pi * std::pow(state.radius, 3);
    loads.push_back({.tag = state.tag,
                     .force = density_ * impulse / stage_step - density_ * volume * gravity_,
                     .torque = density_ * turn / stage_step});
  }
  return loads;
}

template <class Real>
std::vector<SphereAccount> ImmersedBoundary<Real>::accounts() const {
  std::vector<SphereAccount> accounts;
  for (const Mobile& sphere : mobile_)
    if (sphere.home == slabs_.rank())
      accounts.push_back(
          {.tag = sphere.state.tag,
           .linear = density_ * (sphere.memory.forced.linear - sphere.memory.owed.linear),
           .angular = density_ * (sphere.memory.forced.angular - sphere.memory.owed.angular -
                                  sphere.memory.turn_due)});
  return accounts;
}

template <class Real>
std::vector<double> ImmersedBoundary<Real>::remembered() const {
  struct Row {
    double tag;
    std::array<double, memory_numbers> memory;
  };
  static_assert(sizeof(Row) == numbers_remembered * sizeof(double));
  std::vector<Row> mine;
  for (const Mobile& sphere : mobile_) {
    if (sphere.home != slabs_.rank()) continue;
    std::vector<double> numbers;
    append_memory(sphere.memory, numbers);
    mine.push_back({.tag = static_cast<double>(sphere.state.tag), .memory = {}});
    std::copy(numbers.begin(), numbers.end(), mine.back().memory.begin());
  }
  const std::vector<Row> all = gather_by_tag<Row>(slabs_.comm(), mine);
  std::vector<double> rows(all.size() * numbers_remembered);
  std::memcpy(rows.data(), all.data(), rows.size() * sizeof(double));
  return rows;
}

template <class Real>
void ImmersedBoundary<Real>::set_remembered(std::span<const double> rows) {
  for (; rows.size() >= numbers_remembered; rows = rows.subspan(numbers_remembered)) {
    const auto tag = static_cast<std::int64_t>(rows[0]);
    const auto known =
        std::lower_bound(mobile_.begin(), mobile_.end(), tag,
                         [](const Mobile& m, std::int64_t t) { return m.state.tag < t; });
    if (known != mobile_.end() && known->state.tag == tag) read_memory(&rows[1], known->memory);
  }
}

template void ImmersedBoundary<float>::hand_over_memories(std::vector<Mobile>&) const;
template void ImmersedBoundary<float>::find_partners();
template std::vector<SphereLoad> ImmersedBoundary<float>::loads(double);
template std::vector<SphereAccount> ImmersedBoundary<float>::accounts() const;
template std::vector<double> ImmersedBoundary<float>::remembered() const;
template void ImmersedBoundary<float>::set_remembered(std::span<const double>);
template void ImmersedBoundary<double>::hand_over_memories(std::vector<Mobile>&) const;
template void ImmersedBoundary<double>::find_partners();
template std::vector<SphereLoad> ImmersedBoundary<double>::loads(double);
template std::vector<SphereAccount> ImmersedBoundary<double>::accounts() const;
template std::vector<double> ImmersedBoundary<double>::remembered() const;
template void ImmersedBoundary<double>::set_remembered(std::span<const double>);

}  // namespace bedload
