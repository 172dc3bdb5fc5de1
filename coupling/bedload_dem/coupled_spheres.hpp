#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "coupling/exchange/message.hpp"

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// The spheres that are in the fluid: those of one group of LIGGGHTS. Those that are in a second
/// group as well are fixed, the others mobile.
class CoupledSpheres {
 public:
  /// @param groupbit that of the group in the fluid
  /// @param fixed_bit that of the group of fixed spheres; 0: all are mobile
  CoupledSpheres(LAMMPS_NS::LAMMPS* lmp, int groupbit, int fixed_bit)
      : lmp_(lmp), groupbit_(groupbit), fixed_bit_(fixed_bit) {}

  /// @param mask the sphere's group mask (atom->mask)
  bool contains(int mask) const { return (mask & groupbit_) != 0; }
  bool is_mobile(int mask) const { return contains(mask) && (mask & fixed_bit_) == 0; }
  bool is_fixed(int mask) const { return contains(mask) && (mask & fixed_bit_) != 0; }
  /// Whether there is a group of fixed spheres.
  bool names_fixed() const { return fixed_bit_ != 0; }

  /// This rank's mobile spheres as the fluid is told of them, and its fixed ones where these are
  /// asked for.
  /// @param overlaps of this rank's atoms (StateRecord); none: nothing overlaps
  /// @param is_new of an atom's index here; none: no sphere is
  std::vector<StateRecord> states(bool with_fixed, const double* const* overlaps = nullptr,
                                  const std::function<bool(int)>& is_new = {}) const;
  /// A number that differs when the fixed spheres do (number, place, speed, size); the same on any
  /// ranks and in any order. Collective.
  std::uint64_t fingerprint_of_fixed() const;
  /// Of all spheres in the fluid, and of those that fixes may insert [L]. Collective.
  double largest_radius() const;

 private:
  LAMMPS_NS::LAMMPS* lmp_;
  int groupbit_, fixed_bit_;
};

}  // namespace bedload
