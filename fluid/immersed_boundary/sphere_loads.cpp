#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <type_traits>
#include <utility>

#include "fluid/immersed_boundary/deferred_share.hpp"
#include "fluid/immersed_boundary/excess_spin.hpp"
#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/immersed_boundary/neighbour_messages.hpp"

// What the mobile spheres get: the ranks' shares added up, loads, and impulses that are
// deferred from stage to stage and from rank to rank.

namespace bedload {
namespace {

constexpr int memory_message = 21, share_message = 22, spin_message = 23;  // message tags

constexpr std::size_t memory_numbers = 3 * SphereMemory::vector_names.size() + 1;

void append_memory(SphereMemory memory, std::vector<double>& message) {
  for (const Vec3* v : memory.vectors()) message.insert(message.end(), v->data(), v->data() + 3);
  message.push_back(memory.fresh ? 1.0 : 0.0);
}

SphereMemory read_memory(const double* numbers) {
  SphereMemory memory;
  for (Vec3* v : memory.vectors()) {
    *v = Vec3(numbers);
    numbers += 3;
  }
  memory.fresh = *numbers != 0.0;
  return memory;
}

/// The fluid that a sphere takes in, or leaves, as its radius grows by `growth`, moves with it:
/// what it has for that is no impulse.
SphereMemory resized(SphereMemory memory, double growth) {
  memory.forced.linear *= std::pow(growth, 3);
  memory.forced.angular *= std::pow(growth, 5);
  return memory;
}

}  // namespace

/// Whether `now` is the same sphere as `before`, no further than it can go from one forcing to the
/// next: of one that a script has put elsewhere nothing that was known holds there.
template <class Real>
bool ImmersedBoundary<Real>::goes_on(const SphereState& before, const SphereState& now) const {
  constexpr double furthest = 2.0;  // cells; a stable step is shorter than 1.8
  return before.tag == now.tag && !now.is_new &&
         shortest_way(grid_, before.position, now.position).norm() <= furthest * grid_.h;
}

/// Brings the memory of each sphere that goes on to the rank that holds its centre now, which was
/// near it before.
template <class Real>
void ImmersedBoundary<Real>::hand_over_memories(std::vector<Mobile>& now) const {
  const int me = decomposition_.rank();
  std::map<int, std::vector<double>> leaving, coming;
  std::map<int, std::vector<std::pair<std::size_t, double>>> receivers;  // and the radius of before
  std::size_t n = 0;
  for (const Mobile& old : mobile_) {
    while (n < now.size() && now[n].state.tag < old.state.tag) ++n;
    if (n == now.size()) break;
    Mobile& same = now[n];
    if (!goes_on(old.state, same.state)) continue;
    if (old.home == same.home) {
      same.memory = resized(old.memory, same.state.radius / old.state.radius);
      continue;
    }
    if (!blocks_.is_near(same.home, old.state.position, old.state.radius) ||
        !blocks_.is_near(old.home, same.state.position, same.state.radius))
      continue;
    if (old.home == me) append_memory(old.memory, leaving[same.home]);
    if (same.home == me) {
      receivers[old.home].emplace_back(n, old.state.radius);
      coming[old.home].resize(receivers[old.home].size() * memory_numbers);
    }
  }
  exchange_numbers(decomposition_.comm(), memory_message, leaving, coming);
  for (const auto& [rank, spheres] : receivers)
    for (std::size_t m = 0; m < spheres.size(); ++m) {
      const auto [sphere, radius] = spheres[m];
      now[sphere].memory = resized(read_memory(coming[rank].data() + m * memory_numbers),
                                   now[sphere].state.radius / radius);
    }
}

template <class Real>
void ImmersedBoundary<Real>::find_partners() {
  const int me = decomposition_.rank();
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

/// What the spheres' markers impose, known to the rank that holds a centre, goes to the others.
template <class Real>
void ImmersedBoundary<Real>::share_excess_spins() {
  const auto excess = [this](int n) -> Vec3& {
    return mobile_[static_cast<std::size_t>(n)].memory.excess_spin;
  };
  std::map<int, std::vector<double>> leaving, coming;
  for (const auto& [rank, spheres] : guests_)
    for (const int n : spheres)
      leaving[rank].insert(leaving[rank].end(), excess(n).data(), excess(n).data() + 3);
  for (const auto& [rank, spheres] : homes_) coming[rank].resize(3 * spheres.size());
  exchange_numbers(decomposition_.comm(), spin_message, leaving, coming);
  for (const auto& [rank, spheres] : homes_)
    for (std::size_t m = 0; m < spheres.size(); ++m)
      excess(spheres[m]) = Vec3(coming[rank].data() + 3 * m);
  for (Mobile& sphere : mobile_) {
    sphere.imposed = sphere.state;
    sphere.imposed.angular_velocity += sphere.memory.excess_spin;
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
  exchange_numbers(decomposition_.comm(), share_message, leaving, coming);
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

/// A sphere that moves once per step would get the fluid's whole answer to its last change of speed
/// in its next one and swing from step to step: it gets a share. A steady force arrives whole,
/// C* rho_f/rho_p steps late. Trials: C* = 1/2 and 1 leave swings of 5 and 2 % of the speed at a
/// density ratio of 1.2, 2 less than 1 % from 0.5 on.
template <class Real>
double ImmersedBoundary<Real>::reaction_share(const SphereState& sphere) const {
  if (exchange_ == Exchange::stage || sphere.density == 0.0) return 1.0;
  constexpr double largest_added_mass = 2.0;  // C*
  return answered_share(sphere.density, density_, largest_added_mass);
}

template <class Real>
std::vector<SphereLoad> ImmersedBoundary<Real>::loads(double stage_step, bool spheres_move) {
  const std::vector<Share> sums = complete_shares();
  std::vector<SphereLoad> loads;
  for (std::size_t n = 0; n < mobile_.size(); ++n) {
    if (mobile_[n].home != decomposition_.rank()) continue;
    const SphereState& state = mobile_[n].state;
    SphereMemory& memory = mobile_[n].memory;
    const InteriorMomentum before = interior_momentum(sums[n].before, state.radius);
    const InteriorMomentum after = interior_momentum(sums[n].after, state.radius);
    if (memory.fresh) memory.forced = before;
    memory.fresh = false;
    // What changed inside between the last forcing and this stage's predictor: the projection, and
    // the step of the sphere through the field.
    memory.deferred_impulse.linear += before.linear - memory.forced.linear;
    memory.deferred_impulse.angular += before.angular - memory.forced.angular;
    memory.forced = after;

    // impulse = -rho sum applied h^3 + rho (I_forced - I_before) + rho share * deferred
    const double share = deferred_impulse_share(deferred_impulse_share_, state.density, density_);
    const double cell = grid_.cell_volume();
    const Vec3 applied(sums[n].applied.data()), moment(sums[n].applied_moment.data());
    const Vec3 impulse =
        -cell * applied + after.linear - before.linear + share * memory.deferred_impulse.linear;
    memory.deferred_angular_impulse +=
        -cell * moment + after.angular - before.angular + share * memory.deferred_impulse.angular;
    const Vec3 angular_impulse =
        deferred_angular_share(deferred_angular_share_, state.density, density_, keeps_force_) *
        memory.deferred_angular_impulse;
    memory.deferred_angular_impulse -= angular_impulse;
    memory.deferred_impulse.linear *= 1.0 - share;
    memory.deferred_impulse.angular *= 1.0 - share;

    // given = share * (deferred + impulse), where the sphere will move; the rest is deferred
    memory.deferred_reaction += impulse;
    const Vec3 given =
        spheres_move ? Vec3(reaction_share(state) * memory.deferred_reaction) : Vec3::Zero();
    memory.deferred_reaction -= given;
    memory.excess_spin =
        next_excess_spin(memory.excess_spin, angular_impulse / stage_step, state.radius,
                         core_of(state.radius), grid_.h, viscosity_, stage_step);

    const double volume = 4.0 / 3.0 * std::numbers::pi * std::pow(state.radius, 3);
    loads.push_back({.tag = state.tag,
                     .force = density_ * given / stage_step - density_ * volume * gravity_,
                     .torque = density_ * angular_impulse / stage_step});
  }
  return loads;
}

template <class Real>
std::vector<SphereAccount> ImmersedBoundary<Real>::accounts() const {
  std::vector<SphereAccount> accounts;
  for (const Mobile& sphere : mobile_)
    if (sphere.home == decomposition_.rank())
      accounts.push_back({.tag = sphere.state.tag,
                          .linear = density_ * (sphere.memory.forced.linear -
                                                sphere.memory.deferred_impulse.linear -
                                                sphere.memory.deferred_reaction),
                          .angular = density_ * (sphere.memory.forced.angular -
                                                 sphere.memory.deferred_impulse.angular -
                                                 sphere.memory.deferred_angular_impulse)});
  return accounts;
}

template bool ImmersedBoundary<float>::goes_on(const SphereState&, const SphereState&) const;
template bool ImmersedBoundary<double>::goes_on(const SphereState&, const SphereState&) const;
template void ImmersedBoundary<float>::hand_over_memories(std::vector<Mobile>&) const;
template void ImmersedBoundary<float>::find_partners();
template void ImmersedBoundary<float>::share_excess_spins();
template std::vector<SphereLoad> ImmersedBoundary<float>::loads(double, bool);
template std::vector<SphereAccount> ImmersedBoundary<float>::accounts() const;
template void ImmersedBoundary<double>::hand_over_memories(std::vector<Mobile>&) const;
template void ImmersedBoundary<double>::find_partners();
template void ImmersedBoundary<double>::share_excess_spins();
template std::vector<SphereLoad> ImmersedBoundary<double>::loads(double, bool);
template std::vector<SphereAccount> ImmersedBoundary<double>::accounts() const;

}  // namespace bedload
