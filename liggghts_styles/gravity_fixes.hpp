#pragma once

#include <array>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// The fixes gravity of a script, any number of them and each for its group.
class GravityFixes {
 public:
  GravityFixes() = default;

  /// As they are now: such a fix knows its vector when it is initialised, or has acted where
  /// variables make it.
  explicit GravityFixes(LAMMPS_NS::LAMMPS* lmp);

  bool operator==(const GravityFixes&) const = default;

  bool none() const { return pulls_.empty(); }

  /// What they come to for a sphere [L/T²].
  /// @param mask its group mask (atom->mask); ~0: in all groups
  std::array<double, 3> on(int mask) const;
  /// Its magnitude [L/T²]; 0 without one.
  double size_on(int mask) const;

  /// Magnitude of the largest for spheres of one group [L/T²]; 0 without one.
  double largest() const;

 private:
  struct Pull {
    int groupbit;
    std::array<double, 3> vector;
    bool operator==(const Pull&) const = default;
  };
  std::vector<Pull> pulls_;
};

}  // namespace bedload
