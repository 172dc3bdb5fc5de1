#pragma once

namespace bedload {

/// Where a slab of planes ends.
struct SlabEnds {
  bool wall_below = false;  ///< zero normal derivative below plane 0
  bool wall_above = false;  ///< zero normal derivative above the last plane
};

/// What couples a slab, once eliminated, to the planes X of its neighbours (see eliminate_slab).
struct SlabCoupling {
  double c_last = 0.0;  ///< of the last plane to the plane above the slab
  double f_last = 0.0;  ///< of the last plane to the plane below the slab
  double alpha = 0.0;   ///< of the first plane to the plane below the slab
  double beta = 0.0;    ///< of the first plane to the last plane
};

/// Gaussian elimination, upwards, of the rows of one Fourier mode on a slab of planes 0 .. n-1,
///
///   x_j-1 + b_j x_j + x_j+1 = d_j,      b_j = -2 + eigenvalue (+ 1 beside a wall),
///
/// the plane below the slab, X = x_-1, being carried along as an unknown:
///
///   x_j = d'_j - c_j x_j+1 - f_j X,     c_j = 1/(b_j - c_j-1),   f_j = -c_j f_j-1,
///   d'_j = c_j (d_j - d'_j-1),          c_-1 = 0, d'_-1 = 0, f_-1 = -1 (0 above a wall).
///
/// Going on with the rows j < n-1 gives the first plane in terms of X and the last one alone,
///
///   x_0 = g + alpha X + beta x_n-1,     g = - sum_{j<n-1} f_j-1 d'_j,
///   alpha = sum_{j<n-1} f_j-1 f_j,      beta = - f_n-2,
///
/// because -f_j-1 is the product of -c_0 .. -c_j-1. `store(j, c_j, f_j)` is called for every plane.
/// Where `singular` (the mean mode between two walls), the last pivot is zero; c = 0 there fixes
/// the last plane at zero.
template <class Store>
SlabCoupling eliminate_slab(double eigenvalue, int planes, SlabEnds ends, bool singular,
                            Store&& store) {
  SlabCoupling slab;
  double c = 0.0, f = ends.wall_below ? 0.0 : -1.0;
  for (int j = 0; j < planes; ++j) {
    const bool last = j == planes - 1;
    double b = -2.0 + eigenvalue;
    if (ends.wall_below && j == 0) b += 1.0;
    if (ends.wall_above && last) b += 1.0;
    const double f_before = f;
    c = singular && last ? 0.0 : 1.0 / (b - c);
    f = -c * f_before;
    store(j, c, f);
    if (last)
      slab.beta = -f_before;
    else
      slab.alpha += f_before * f;
  }
  slab.c_last = c;
  slab.f_last = f;
  return slab;
}

}  // namespace bedload
