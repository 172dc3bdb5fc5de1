#include <array>
#include <map>
#include <vector>

#include "fluid/immersed_boundary/immersed_boundary.hpp"
#include "fluid/immersed_boundary/neighbour_messages.hpp"

// What is kept by marker goes with its mobile sphere, from rank to rank and from stage to stage:
// the volumes of a step, the forces of implicit diffusion (marker_force.hpp).

namespace bedload {
namespace {

constexpr std::array<std::size_t, 3> components{0, 1, 2};

constexpr int found_numbers_message = 24, all_numbers_message = 25;  // message tags

}  // namespace

/// What is kept of the markers of the spheres that stay, by tag, goes over to `now`: volumes of
/// those of the same size, forces where they are still in their place, too. Returns whether one is
/// new or of another size, for the markers of which nobody knows a volume.
template <class Real>
bool ImmersedBoundary<Real>::keep_by_marker(std::vector<Mobile>& now) {
  bool remade = false;
  auto old = mobile_.begin();
  for (Mobile& sphere : now) {
    remade |= sphere.state.is_new;
    while (old != mobile_.end() && old->state.tag < sphere.state.tag) ++old;
    if (old == mobile_.end() || old->state.tag != sphere.state.tag) continue;  // of another rank
    const bool other_size = old->state.radius != sphere.state.radius;
    remade |= other_size;
    if (sphere.state.is_new || other_size) continue;
    sphere.volumes = std::move(old->volumes);
    if (goes_on(old->state, sphere.state)) sphere.kept_forces = std::move(old->kept_forces);
  }
  return remade;
}

/// Tells all ranks near a sphere the `numbers` of all its markers, of which each rank has `found`
/// those of its own: on its way some may go over to another rank. The rank that holds the centre
/// adds up what the others found.
template <class Real>
void ImmersedBoundary<Real>::share_by_marker(ByMarker Mobile::*numbers,
                                             std::vector<Real> MarkerList<Real>::*found) {
  for (Mobile& sphere : mobile_) {
    const MarkerLayout& layout = layouts_[static_cast<std::size_t>(layout_of(sphere.state.radius))];
    for (std::vector<Real>& all : sphere.*numbers) all.assign(layout.offsets.size(), Real{});
  }
  for (const std::size_t c : components) {
    const MarkerList<Real>& list = mobile_lists_[c];
    for (const auto& range : list.ranges) {
      std::vector<Real>& all = (mobile_[static_cast<std::size_t>(range.sphere)].*numbers)[c];
      for (auto m = static_cast<std::size_t>(range.begin); m < static_cast<std::size_t>(range.end);
           ++m)
        all[static_cast<std::size_t>(list.offset[m])] = (list.*found)[m];
    }
  }
  const auto use_all = [this, numbers](const std::vector<int>& spheres, auto use) {
    for (const int n : spheres)
      for (std::vector<Real>& all : mobile_[static_cast<std::size_t>(n)].*numbers)
        for (Real& number : all) use(number);
  };
  const auto pass = [&](int tag, const Partners& senders, const Partners& receivers, auto take) {
    std::map<int, std::vector<double>> leaving, coming;
    for (const auto& [rank, spheres] : receivers)
      use_all(spheres, [&message = leaving[rank]](Real v) { message.push_back(double{v}); });
    for (const auto& [rank, spheres] : senders) {
      std::size_t count = 0;
      use_all(spheres, [&count](Real) { ++count; });
      coming[rank].resize(count);
    }
    exchange_numbers(decomposition_.comm(), tag, leaving, coming);
    for (const auto& [rank, spheres] : senders) {
      const double* next = coming[rank].data();
      use_all(spheres, [&](Real& v) { take(v, static_cast<Real>(*next++)); });
    }
  };
  pass(found_numbers_message, guests_, homes_, [](Real& here, Real more) { here += more; });
  pass(all_numbers_message, homes_, guests_, [](Real& here, Real all) { here = all; });
}

/// The `numbers` of a list's markers as they are now. A rank that a sphere has come near to within
/// the step does not know them (`unknown`), but none goes so far in one that its markers are there.
template <class Real>
void ImmersedBoundary<Real>::take_by_marker(const MarkerList<Real>& list, std::size_t component,
                                            ByMarker Mobile::*numbers, std::vector<Real>& here,
                                            Real unknown) const {
  for (const auto& range : list.ranges) {
    const auto& all = (mobile_[static_cast<std::size_t>(range.sphere)].*numbers)[component];
    for (auto m = static_cast<std::size_t>(range.begin); m < static_cast<std::size_t>(range.end);
         ++m)
      here[m] = all.empty() ? unknown : all[static_cast<std::size_t>(list.offset[m])];
  }
}

template <class Real>
void ImmersedBoundary<Real>::share_volumes() {
  share_by_marker(&Mobile::volumes, &MarkerList<Real>::volume);
}

/// Volumes of the step's begin for the markers as they are now.
template <class Real>
void ImmersedBoundary<Real>::use_volumes() {
  for (const std::size_t c : components)
    take_by_marker(mobile_lists_[c], c, &Mobile::volumes, mobile_lists_[c].volume, Real{1});
}

/// All ranks near a sphere come to know the force of all its markers, any of which may be theirs in
/// the next stage.
template <class Real>
void ImmersedBoundary<Real>::share_kept_forces() {
  share_by_marker(&Mobile::kept_forces, &MarkerList<Real>::kept_force);
}

/// For the markers of the mobile spheres as they are now; those of a sphere that is new have none.
template <class Real>
void ImmersedBoundary<Real>::use_kept_forces() {
  if (!keeps_force_) return;
  for (const std::size_t c : components) {
    MarkerList<Real>& list = mobile_lists_[c];
    list.kept_force.resize(static_cast<std::size_t>(list.size()));
    take_by_marker(list, c, &Mobile::kept_forces, list.kept_force, Real{});
  }
}

template bool ImmersedBoundary<float>::keep_by_marker(std::vector<Mobile>&);
template void ImmersedBoundary<float>::share_volumes();
template void ImmersedBoundary<float>::use_volumes();
template void ImmersedBoundary<float>::share_kept_forces();
template void ImmersedBoundary<float>::use_kept_forces();
template bool ImmersedBoundary<double>::keep_by_marker(std::vector<Mobile>&);
template void ImmersedBoundary<double>::share_volumes();
template void ImmersedBoundary<double>::use_volumes();
template void ImmersedBoundary<double>::share_kept_forces();
template void ImmersedBoundary<double>::use_kept_forces();

}  // namespace bedload
