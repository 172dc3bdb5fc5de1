#pragma once

#include <fftw3.h>
#include <mpi.h>

#include <complex>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

namespace bedload {

/// FFTW's two precisions under one name, and a plan that frees itself. Complex transforms only,
/// planned by measuring: FFTW's guess is up to 2.5 times slower (192 points).
template <class Real>
struct Fftw;

template <>
struct Fftw<double> {
  using Plan = fftw_plan;
  using Complex = fftw_complex;
  static Plan plan(int n, int howmany, Complex* in, int in_stride, int in_distance, Complex* out,
                   int out_stride, int out_distance, int sign) {
    return fftw_plan_many_dft(1, &n, howmany, in, nullptr, in_stride, in_distance, out, nullptr,
                              out_stride, out_distance, sign, FFTW_MEASURE);
  }
  static void execute(Plan plan, Complex* in, Complex* out) { fftw_execute_dft(plan, in, out); }
  static void destroy(Plan plan) { fftw_destroy_plan(plan); }
  static char* wisdom() { return fftw_export_wisdom_to_string(); }
  static void learn(const char* wisdom) { fftw_import_wisdom_from_string(wisdom); }
};

template <>
struct Fftw<float> {
  using Plan = fftwf_plan;
  using Complex = fftwf_complex;
  static Plan plan(int n, int howmany, Complex* in, int in_stride, int in_distance, Complex* out,
                   int out_stride, int out_distance, int sign) {
    return fftwf_plan_many_dft(1, &n, howmany, in, nullptr, in_stride, in_distance, out, nullptr,
                               out_stride, out_distance, sign, FFTW_MEASURE);
  }
  static void execute(Plan plan, Complex* in, Complex* out) { fftwf_execute_dft(plan, in, out); }
  static void destroy(Plan plan) { fftwf_destroy_plan(plan); }
  static char* wisdom() { return fftwf_export_wisdom_to_string(); }
  static void learn(const char* wisdom) { fftwf_import_wisdom_from_string(wisdom); }
};

/// Runs `plan` on rank 0 first and hands what FFTW learned to the other ranks before they do the
/// same: all ranks then compute with the same algorithms, to the last digit. Collective.
template <class Real, class MakePlans>
void plan_alike(MPI_Comm comm, MakePlans&& plan) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::vector<char> wisdom;
  int length = 0;
  if (rank == 0) {
    plan();
    char* text = Fftw<Real>::wisdom();
    wisdom.assign(text, text + std::strlen(text) + 1);
    std::free(text);
    length = static_cast<int>(wisdom.size());
  }
  MPI_Bcast(&length, 1, MPI_INT, 0, comm);
  wisdom.resize(static_cast<std::size_t>(length));
  MPI_Bcast(wisdom.data(), length, MPI_CHAR, 0, comm);
  if (rank != 0) {
    Fftw<Real>::learn(wisdom.data());
    plan();
  }
}

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
