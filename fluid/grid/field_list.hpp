#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "fluid/grid/field.hpp"

namespace bedload {

/// Where on its cell a quantity lives: on the upper face along x, y or z (directions 0, 1, 2), or
/// at the centre.
enum class Place { x_face, y_face, z_face, centre };

/// Fields in memory. Components that are worked on together share one.
enum class Stored : std::size_t { velocity, pressure };
inline constexpr std::size_t stored_fields = 2;

/// A quantity of the flow as memory, files and ghosts see it.
struct FieldEntry {
  const char* name;  ///< of its dataset in fields.h5 and in a flow state
  const char* unit;  ///< in length L and time T of the scene; the dataset's attribute "unit"
  Place place;
  Stored stored;
  int component;    ///< of that stored field
  bool in_output;   ///< snapshots of fields.h5, at the cell centres
  bool in_restart;  ///< flow states; where a state does not have it, it starts from zero
  constexpr bool on_face(int d) const { return static_cast<int>(place) == d; }
};

/// All quantities of the flow. What is not here exists in no file; a further one is an entry here
/// (with a field of its own in Stored) and its equation in the channel.
inline constexpr std::array field_list{
    FieldEntry{"u", "L/T", Place::x_face, Stored::velocity, 0, true, true},
    FieldEntry{"v", "L/T", Place::y_face, Stored::velocity, 1, true, true},
    FieldEntry{"w", "L/T", Place::z_face, Stored::velocity, 2, true, true},
    FieldEntry{"p", "L^2/T^2", Place::centre, Stored::pressure, 0, true, true},
};

/// The fields of the list on one rank's block.
template <class Real>
class FlowFields {
 public:
  FlowFields(const Grid& grid, Extent extent) {
    for (std::size_t n = 0; n < stored_fields; ++n) {
      const auto components = std::count_if(
          field_list.begin(), field_list.end(),
          [n](const FieldEntry& entry) { return static_cast<std::size_t>(entry.stored) == n; });
      // The velocity's planes are moved by the predictor, which needs one to spare.
      const int spare_planes = n == static_cast<std::size_t>(Stored::velocity) ? 1 : 0;
      fields_.emplace_back(grid, extent, static_cast<int>(components), spare_planes);
    }
  }
  Field<Real>& operator[](Stored stored) { return fields_[static_cast<std::size_t>(stored)]; }
  const Field<Real>& operator[](Stored stored) const {
    return fields_[static_cast<std::size_t>(stored)];
  }
  /// Row (j, k) of a quantity.
  Real* row(const FieldEntry& entry, int j, int k) {
    return (*this)[entry.stored].row(j, k, entry.component);
  }
  const Real* row(const FieldEntry& entry, int j, int k) const {
    return (*this)[entry.stored].row(j, k, entry.component);
  }

 private:
  std::vector<Field<Real>> fields_;  // [Stored]
};

}  // namespace bedload
