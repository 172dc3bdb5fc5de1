#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "fluid/grid/field.hpp"
#include "fluid/kernels/prefetch.hpp"

namespace bedload {

/// A number per mode, spectral row and plane, of which only modes at both ends of a row are kept:
/// there the waves are long (in a row of Fourier modes they come from both sides), and what a plane
/// does to its neighbours reaches far only for long waves.
template <class Real>
class EndModes {
 public:
  /// The kept modes of one row and plane: 0 .. low-1 and high .. , one after the other in values.
  struct Part {
    const Real* values;
    std::size_t low, high;
  };

  EndModes() = default;
  EndModes(int rows, int planes)
      : planes_(static_cast<std::size_t>(planes)),
        rows_(static_cast<std::size_t>(rows)),
        places_(rows_.size() * planes_) {}

  /// Keeps what of value(j, m) is needed for keep(j, m) to be there, for all planes of one row.
  template <class Keep, class Value>
  void set_row(int row, std::size_t modes, Keep keep, Value value) {
    const auto r = static_cast<std::size_t>(row);
    std::size_t size = 0;
    for (std::size_t j = 0; j < planes_; ++j) {
      Place& place = places_[j * rows_.size() + r];
      const std::size_t middle = (modes + 1) / 2;
      place = {size, middle, middle};
      while (place.low > 0 && !keep(j, place.low - 1)) --place.low;
      while (place.high < modes && !keep(j, place.high)) ++place.high;
      size += place.low + (modes - place.high);
    }
    rows_[r] = AlignedArray<Real>(size);
    for (std::size_t j = 0; j < planes_; ++j) {
      const Place& place = places_[j * rows_.size() + r];
      Real* to = rows_[r].data() + place.begin;
      for (std::size_t m = 0; m < place.low; ++m) *to++ = value(j, m);
      for (std::size_t m = place.high; m < modes; ++m) *to++ = value(j, m);
    }
  }

  Part part(int j, int row) const {
    const auto r = static_cast<std::size_t>(row);
    const Place& place = places_[static_cast<std::size_t>(j) * rows_.size() + r];
    return {rows_[r].data() + place.begin, place.low, place.high};
  }
  std::size_t planes() const { return planes_; }

 private:
  struct Place {
    std::size_t begin, low, high;
  };
  std::size_t planes_ = 0;
  std::vector<AlignedArray<Real>> rows_;  // [row], plane after plane
  std::vector<Place> places_;             // [plane][row]
};

/// A number per mode, row and plane for sweeps through the planes, up and then down. What a plane
/// has in common with the one before is kept once: on cubes the coefficients of an elimination
/// soon stop changing, within a few planes for short waves.
template <class Real>
class ModeCoefficients {
 public:
  ModeCoefficients() = default;
  ModeCoefficients(int rows, int planes, std::size_t pitch)
      : pitch_(pitch), changes_(rows, planes), now_(static_cast<std::size_t>(rows) * pitch) {}

  /// The values of all planes of one row, [plane][mode].
  void set_row(int row, std::span<const Real> values) {
    const std::size_t planes = changes_.planes();
    const auto at = [&](std::size_t j, std::size_t m) { return values[j * pitch_ + m]; };
    // A plane's own values are needed on the way up where they differ from those of the plane
    // below, on the way down where they differ from those of the plane above.
    changes_.set_row(
        row, pitch_,
        [&](std::size_t j, std::size_t m) {
          return j == 0 || at(j, m) != at(j - 1, m) || (j + 1 < planes && at(j, m) != at(j + 1, m));
        },
        at);
  }

  /// Asks for what row() is going to read.
  void ask_for_row(int j, int row) const {
    const auto change = changes_.part(j, row);
    ask_for(change.values, change.low + pitch_ - change.high);
  }

  /// The values of plane j, valid until the next call for this row; planes in turn, up from 0 or
  /// down again.
  const Real* row(int j, int row) {
    Real* now = &now_[static_cast<std::size_t>(row) * pitch_];
    const auto change = changes_.part(j, row);
    std::copy_n(change.values, change.low, now);
    std::copy_n(change.values + change.low, pitch_ - change.high, now + change.high);
    return now;
  }

 private:
  std::size_t pitch_ = 0;
  EndModes<Real> changes_;
  AlignedArray<Real> now_;  // of the plane where the sweep stands
};

}  // namespace bedload
