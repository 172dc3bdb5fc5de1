#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace bedload {

/// Whether FFTW has one piece of straight code for n points, which takes several columns in one
/// register (FFTW 3.3, dft/simd/codlist).
constexpr bool has_straight_code(int n) {
  return n <= 16 || n == 20 || n == 25 || n == 32 || n == 64 || n == 128;
}

/// n as a product of few numbers without common factors for each of which FFTW has straight code,
/// smallest first; n alone where there are none.
inline std::vector<int> coprime_parts(int n) {
  std::vector<int> parts;
  for (int left = n, prime = 2; left > 1 && !has_straight_code(n); ++prime) {
    int power = 1;
    for (; left % prime == 0; left /= prime) power *= prime;
    if (power > 1) parts.push_back(power);
  }
  if (!std::all_of(parts.begin(), parts.end(), has_straight_code)) parts.clear();
  std::sort(parts.begin(), parts.end());
  for (bool merged = true; merged;) {  // the two smallest that have code together
    merged = false;
    for (std::size_t b = 1; b < parts.size() && !merged; ++b)
      for (std::size_t a = 0; a < b && !merged; ++a)
        if (has_straight_code(parts[a] * parts[b])) {
          parts[a] *= parts[b];
          parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(b));
          std::sort(parts.begin(), parts.end());
          merged = true;
        }
  }
  if (parts.empty()) parts.push_back(n);
  return parts;
}

/// Where points and modes of a transform of n = n_1 n_2 .. points stand so that it is one of n_1 by
/// n_2 by .. points, without any factors in between (Good 1958, Thomas 1963):
///
///   point  sum_i (n/n_i) p_i mod n   at (p_1, p_2, ..),
///   mode   m                         at (m mod n_1, m mod n_2, ..),
///
/// since exp(2 pi i p m/n) is then the product of exp(2 pi i p_i m_i/n_i).
struct CoprimePlaces {
  std::vector<int> parts, point, mode;

  explicit CoprimePlaces(std::vector<int> coprime) : parts(std::move(coprime)) {
    int n = 1;
    for (const int part : parts) n *= part;
    point.resize(static_cast<std::size_t>(n));
    mode.resize(static_cast<std::size_t>(n));
    for (int place = 0; place < n; ++place) {
      int sum = 0, left = place;
      for (std::size_t i = parts.size(); i-- > 0; left /= parts[i])
        sum += n / parts[i] * (left % parts[i]);
      point[static_cast<std::size_t>(sum % n)] = place;
    }
    for (int m = 0; m < n; ++m) {
      int place = 0;
      for (const int part : parts) place = place * part + m % part;
      mode[static_cast<std::size_t>(m)] = place;
    }
  }
};

}  // namespace bedload
