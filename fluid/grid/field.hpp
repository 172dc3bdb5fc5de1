#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "fluid/grid/grid.hpp"
#include "fluid/kernels/huge_pages.hpp"

namespace bedload {

inline constexpr std::size_t cache_line = 64;

/// Memory on cache-line boundaries, set to zero.
template <class Real>
class AlignedArray {
 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size) : size_(size) {
    const std::size_t bytes = (size * sizeof(Real) + cache_line - 1) / cache_line * cache_line;
    void* memory = std::aligned_alloc(cache_line, std::max(bytes, cache_line));
    if (!memory) throw std::bad_alloc();
    ask_for_huge_pages(memory, bytes);
    data_.reset(static_cast<Real*>(memory));
    std::fill_n(data_.get(), size, Real{});
  }
  Real* data() { return data_.get(); }
  const Real* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  Real& operator[](std::size_t n) { return data_.get()[n]; }
  const Real& operator[](std::size_t n) const { return data_.get()[n]; }

 private:
  struct Free {
    void operator()(Real* memory) const { std::free(memory); }
  };
  std::unique_ptr<Real, Free> data_;
  std::size_t size_ = 0;
};

/// Planes along y and rows along z of one rank's block; x is never divided.
struct Extent {
  int planes, rows;
};

/// Of a block's planes and rows: one layer all around, or none along y and z.
enum class Ghosts { around, none };

/// Values on a block of y planes and z rows, with one ghost layer all around unless told.
///
/// Storage from slowest to fastest: plane j, row k, component c, x. A row starts on a cache line
/// and ends with a pad that holds its own upper x ghost and the next row's lower one: row(j, k,
/// c)[i] is valid for i = -1 .. nx. Planes and rows are local, j = -1 .. planes. Rows k = -1 .. nz
/// go through a table: where periodic z is not divided the ghost rows are the opposite rows
/// themselves, otherwise they have storage of their own. One whole plane is one contiguous block,
/// so that its message needs no packing. Without ghosts planes -1 and `planes` do not exist, and
/// rows -1 and nz are the opposite rows.
template <class Real>
class Field {
 public:
  /// `spare_planes` of storage below plane -1 let relabel() move the planes.
  Field(const Grid& grid, Extent extent, int components, int spare_planes = 0,
        Ghosts ghosts = Ghosts::around)
      : nx_(grid.cells[0]), nz_(extent.rows), planes_(extent.planes), components_(components) {
    constexpr std::size_t lane = cache_line / sizeof(Real);
    stride_ = (static_cast<std::size_t>(nx_) + 2 + lane - 1) / lane * lane;
    row_stride_ = stride_ * static_cast<std::size_t>(components);
    const bool around = ghosts == Ghosts::around;
    const bool wrapped = !around || (grid.periodic(2) && nz_ == grid.cells[2]);
    const int stored_rows = wrapped ? nz_ : nz_ + 2;
    plane_stride_ = row_stride_ * static_cast<std::size_t>(stored_rows);
    for (int k = -1; k <= nz_; ++k) {
      const int stored = wrapped ? (k + nz_) % nz_ : k + 1;
      rows_.push_back(static_cast<std::size_t>(stored) * row_stride_);
    }
    // Loops over whole registers read beyond the ends of a row.
    data_ = AlignedArray<Real>(
        2 * lane +
        plane_stride_ * static_cast<std::size_t>(planes_ + spare_planes + (around ? 2 : 0)));
    first_ = lane + plane_stride_ * static_cast<std::size_t>(spare_planes + (around ? 1 : 0));
  }

  int nx() const { return nx_; }
  int nz() const { return nz_; }  ///< rows of this block
  int planes() const { return planes_; }
  int components() const { return components_; }

  /// Pointer to i = 0 of a row; j = -1 .. planes, k = -1 .. nz.
  Real* row(int j, int k, int c = 0) { return data_.data() + offset(j, k, c); }
  const Real* row(int j, int k, int c = 0) const { return data_.data() + offset(j, k, c); }

  /// Distance between two components of one row, in values.
  std::size_t component_stride() const { return stride_; }

  /// One row with all its components and their x ghosts, contiguous: begins one value before i = 0.
  Real* row_block(int j, int k) { return row(j, k) - 1; }
  const Real* row_block(int j, int k) const { return row(j, k) - 1; }
  std::size_t row_size() const { return row_stride_; }

  /// The contiguous block of one plane: all its stored rows with both x ghosts.
  Real* plane(int j) { return data_.data() + plane_offset(j) - 1; }
  const Real* plane(int j) const { return data_.data() + plane_offset(j) - 1; }
  std::size_t plane_size() const { return plane_stride_; }

  /// Renames storage: what was plane j is plane j + shift from now on (a sweep that wrote each
  /// plane over its lower neighbour ends with relabel(1), the way back with relabel(-1)).
  void relabel(int shift) {
    if (shift > 0)
      first_ -= plane_stride_ * static_cast<std::size_t>(shift);
    else
      first_ += plane_stride_ * static_cast<std::size_t>(-shift);
  }

  void fill(Real value) { std::fill_n(data_.data(), data_.size(), value); }

  std::size_t bytes() const { return data_.size() * sizeof(Real); }

 private:
  std::size_t plane_offset(int j) const {
    assert(j >= -1 && j <= planes_);
    return j < 0 ? first_ - plane_stride_ : first_ + static_cast<std::size_t>(j) * plane_stride_;
  }
  std::size_t offset(int j, int k, int c) const {
    assert(k >= -1 && k <= nz_ && c >= 0 && c < components_);
    return plane_offset(j) + rows_[static_cast<std::size_t>(k + 1)] +
           static_cast<std::size_t>(c) * stride_;
  }

  int nx_, nz_, planes_, components_;
  std::size_t stride_ = 0, row_stride_ = 0, plane_stride_ = 0;
  std::size_t first_ = 0;  // place of plane 0
  std::vector<std::size_t> rows_;
  AlignedArray<Real> data_;
};

/// Copies the periodic x neighbours into the pads of one plane: row[-1] = row[nx-1], row[nx] =
/// row[0].
template <class Real>
void wrap_x_ghosts(Field<Real>& field, int j) {
  const int nx = field.nx();
  for (int k = 0; k < field.nz(); ++k)
    for (int c = 0; c < field.components(); ++c) {
      Real* row = field.row(j, k, c);
      row[-1] = row[nx - 1];
      row[nx] = row[0];
    }
}

}  // namespace bedload
