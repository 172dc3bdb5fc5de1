#pragma once

#include <fftw3.h>

#include <complex>
#include <utility>

namespace bedload {

/// FFTW's two precisions under one name, and a plan that frees itself. Complex transforms only,
/// planned without measuring, so that every rank and every run computes the same digits.
template <class Real>
struct Fftw;

template <>
struct Fftw<double> {
  using Plan = fftw_plan;
  using Complex = fftw_complex;
  static Plan plan(int n, int howmany, Complex* in, int in_stride, int in_distance, Complex* out,
                   int out_stride, int out_distance, int sign) {
    return fftw_plan_many_dft(1, &n, howmany, in, nullptr, in_stride, in_distance, out, nullptr,
                              out_stride, out_distance, sign, FFTW_ESTIMATE);
  }
  static void execute(Plan plan, Complex* in, Complex* out) { fftw_execute_dft(plan, in, out); }
  static void destroy(Plan plan) { fftw_destroy_plan(plan); }
};

template <>
struct Fftw<float> {
  using Plan = fftwf_plan;
  using Complex = fftwf_complex;
  static Plan plan(int n, int howmany, Complex* in, int in_stride, int in_distance, Complex* out,
                   int out_stride, int out_distance, int sign) {
    return fftwf_plan_many_dft(1, &n, howmany, in, nullptr, in_stride, in_distance, out, nullptr,
                               out_stride, out_distance, sign, FFTW_ESTIMATE);
  }
  static void execute(Plan plan, Complex* in, Complex* out) { fftwf_execute_dft(plan, in, out); }
  static void destroy(Plan plan) { fftwf_destroy_plan(plan); }
};

template <class Real>
class FourierPlan {
 public:
  FourierPlan() = default;
  explicit FourierPlan(typename Fftw<Real>::Plan plan) : plan_(plan) {}
  FourierPlan(FourierPlan&& other) noexcept : plan_(std::exchange(other.plan_, nullptr)) {}
  FourierPlan& operator=(FourierPlan&& other) noexcept {
    std::swap(plan_, other.plan_);
    return *this;
  }
  ~FourierPlan() {
    if (plan_) Fftw<Real>::destroy(plan_);
  }
  /// Arrays must be aligned like those of the planning (all of ours begin on a cache line).
  void operator()(std::complex<Real>* in, std::complex<Real>* out) const {
    using Complex = typename Fftw<Real>::Complex;
    Fftw<Real>::execute(plan_, reinterpret_cast<Complex*>(in), reinterpret_cast<Complex*>(out));
  }

 private:
  typename Fftw<Real>::Plan plan_ = nullptr;
};

}  // namespace bedload
