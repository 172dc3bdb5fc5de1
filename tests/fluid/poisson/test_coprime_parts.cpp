#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "fluid/poisson/coprime_parts.hpp"

namespace bedload {
namespace {

using testing::ElementsAre;
using Complex = std::complex<double>;

TEST(CoprimeParts, AreFewAndHaveStraightCode) {
  EXPECT_THAT(coprime_parts(130), ElementsAre(10, 13));
  EXPECT_THAT(coprime_parts(120), ElementsAre(8, 15));
  EXPECT_THAT(coprime_parts(96), ElementsAre(3, 32));
  EXPECT_THAT(coprime_parts(312), ElementsAre(3, 8, 13));
  for (const int whole : {1, 2, 13, 16, 17, 64, 128, 256, 54, 98, 34}) {
    EXPECT_THAT(coprime_parts(whole), ElementsAre(whole));
  }
}

/// exp(-2 pi i times)
Complex turned(double times) { return std::polar(1.0, -2.0 * std::numbers::pi * times); }

/// The transform by its definition, and as one along each part, places by CoprimePlaces.
TEST(CoprimeParts, MakeTheSameTransform) {
  for (const int n : {7, 12, 30, 60, 78, 312}) {
    const CoprimePlaces places(coprime_parts(n));
    std::vector<Complex> x, at_place(static_cast<std::size_t>(n));
    for (int k = 0; k < n; ++k) x.emplace_back(std::sin(1.0 + k * k), std::cos(2.0 + 3.0 * k));
    for (std::size_t k = 0; k < x.size(); ++k)
      at_place[static_cast<std::size_t>(places.point[k])] = x[k];
    int stride = n;
    for (const int part : places.parts) {
      stride /= part;
      const std::vector<Complex> before = at_place;
      for (int place = 0; place < n; ++place) {
        const int mode = place / stride % part, first = place - mode * stride;
        Complex sum = 0.0;
        for (int p = 0; p < part; ++p)
          sum += before[static_cast<std::size_t>(first + p * stride)] *
                 turned(double(p) * mode / part);
        at_place[static_cast<std::size_t>(place)] = sum;
      }
    }
    for (int mode = 0; mode < n; ++mode) {
      Complex sum = 0.0;
      for (int k = 0; k < n; ++k)
        sum += x[static_cast<std::size_t>(k)] * turned(double(k) * mode / n);
      const int place = places.mode[static_cast<std::size_t>(mode)];
      EXPECT_LT(std::abs(at_place[static_cast<std::size_t>(place)] - sum), 1e-11 * n) << n;
    }
  }
}

}  // namespace
}  // namespace bedload
