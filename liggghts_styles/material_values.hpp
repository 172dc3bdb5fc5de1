#pragma once

#include <string>
#include <vector>

namespace LAMMPS_NS {
class LAMMPS;
}

namespace bedload {

/// Values of a material property per pair of atom types.
class PairTable {
 public:
  PairTable() = default;
  PairTable(int types, std::vector<double> values) : types_(types), values_(std::move(values)) {}

  /// @param i, j atom types from 1
  double operator()(int i, int j) const { return values_[(i - 1) * types_ + (j - 1)]; }
  int types() const { return types_; }

 private:
  int types_ = 0;
  std::vector<double> values_;
};

/// Reads `fix ID all property/global <name> peratomtypepair <types> ...`. Ends the run with one
/// sentence if it is missing, if it is of another number of types, or if a value lies outside
/// [lower, upper].
PairTable read_pair_property(LAMMPS_NS::LAMMPS* lmp, const std::string& style,
                             const std::string& name, double lower, double upper);

}  // namespace bedload
