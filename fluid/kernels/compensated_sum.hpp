#pragma once

#include <cmath>

namespace bedload {

/// A running sum in double that keeps what each addition rounds away (A. Neumaier, Z. Angew. Math.
/// Mech. 54 (1974)): its error does not grow with the number of terms.
class CompensatedSum {
 public:
  CompensatedSum& operator+=(double term) {
    const double next = sum_ + term;
    lost_ += std::abs(sum_) >= std::abs(term) ? (sum_ - next) + term : (term - next) + sum_;
    sum_ = next;
    return *this;
  }
  double value() const { return sum_ + lost_; }

 private:
  double sum_ = 0.0, lost_ = 0.0;
};

}  // namespace bedload
