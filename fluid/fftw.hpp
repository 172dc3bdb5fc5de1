#pragma once

#include <fftw3.h>
#include <mpi.h>

#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include "fluid/basis.hpp"

namespace bedload {

/// How many transforms of which length, and where their points lie (FFTW's "advanced" interface).
struct FftwShape {
  int n;             ///< points of one transform
  int howmany;       ///< transforms
  int stride = 1;    ///< from point to point, in numbers of each array's kind
  int distance = 0;  ///< from transform to transform
};

/// FFTW's two precisions under one name. Planned by measuring: FFTW's guess is up to 2.5 times
/// slower (192 points). Inputs that are not outputs are kept.
template <class Real>
struct Fftw;

#define BEDLOAD_FFTW(Real, name)                                                                   \
  template <>                                                                                      \
  struct Fftw<Real> {                                                                              \
    using Plan = name##_plan;                                                                      \
    using Complex = name##_complex;                                                                \
    static constexpr unsigned flags = FFTW_MEASURE | FFTW_PRESERVE_INPUT;                          \
    static Plan complex(FftwShape s, Complex* in, Complex* out, int sign) {                        \
      return name##_plan_many_dft(1, &s.n, s.howmany, in, nullptr, s.stride, s.distance, out,      \
                                  nullptr, s.stride, s.distance, sign, flags);                     \
    }                                                                                              \
    static Plan real(FftwShape s, Real* in, Real* out, fftw_r2r_kind kind) {                       \
      return name##_plan_many_r2r(1, &s.n, s.howmany, in, nullptr, s.stride, s.distance, out,      \
                                  nullptr, s.stride, s.distance, &kind, flags);                    \
    }                                                                                              \
    static Plan to_complex(FftwShape s, Real* in, Complex* out) {                                  \
      return name##_plan_many_dft_r2c(1, &s.n, s.howmany, in, nullptr, s.stride, s.distance, out,  \
                                      nullptr, s.stride, s.distance, flags);                       \
    }                                                                                              \
    static Plan to_real(FftwShape s, Complex* in, Real* out) {                                     \
      return name##_plan_many_dft_c2r(1, &s.n, s.howmany, in, nullptr, s.stride, s.distance, out,  \
                                      nullptr, s.stride, s.distance, flags);                       \
    }                                                                                              \
    static void run_complex(Plan p, Complex* in, Complex* out) { name##_execute_dft(p, in, out); } \
    static void run_real(Plan p, Real* in, Real* out) { name##_execute_r2r(p, in, out); }          \
    static void run_to_complex(Plan p, Real* in, Complex* out) {                                   \
      name##_execute_dft_r2c(p, in, out);                                                          \
    }                                                                                              \
    static void run_to_real(Plan p, Complex* in, Real* out) {                                      \
      name##_execute_dft_c2r(p, in, out);                                                          \
    }                                                                                              \
    static void destroy(Plan plan) { name##_destroy_plan(plan); }                                  \
    static char* wisdom() { return name##_export_wisdom_to_string(); }                             \
    static void learn(const char* wisdom) { name##_import_wisdom_from_string(wisdom); }            \
  };
BEDLOAD_FFTW(double, fftw)
BEDLOAD_FFTW(float, fftwf)
#undef BEDLOAD_FFTW

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

/// A planned transform. Complex numbers are pairs of reals. Arrays must be aligned like those of
/// the planning (all of ours begin on a cache line).
template <class Real>
class FourierPlan {
 public:
  enum class Kind { complex, real, to_complex, to_real };

  FourierPlan() = default;
  FourierPlan(const FourierPlan&) = delete;
  FourierPlan& operator=(const FourierPlan&) = delete;
  FourierPlan(FourierPlan&& other) noexcept
      : plan_(std::exchange(other.plan_, nullptr)), kind_(other.kind_) {}
  FourierPlan& operator=(FourierPlan&& other) noexcept {
    std::swap(plan_, other.plan_);
    std::swap(kind_, other.kind_);
    return *this;
  }
  ~FourierPlan() {
    if (plan_) Library::destroy(plan_);
  }

  /// Complex to complex; sign FFTW_FORWARD or FFTW_BACKWARD.
  static FourierPlan complex(FftwShape shape, Real* in, Real* out, int sign) {
    return {Library::complex(shape, pairs(in), pairs(out), sign), Kind::complex};
  }
  /// Sine or cosine transform, forwards or back; together they multiply by twice the cells.
  static FourierPlan real(Basis basis, bool forwards, FftwShape shape, Real* in, Real* out) {
    if (basis == Basis::faces) --shape.n;
    return {Library::real(shape, in, out, fftw_kind(basis, forwards)), Kind::real};
  }
  /// Real numbers to their n/2+1 complex modes, and back.
  static FourierPlan to_complex(FftwShape shape, Real* in, Real* out) {
    return {Library::to_complex(shape, in, pairs(out)), Kind::to_complex};
  }
  static FourierPlan to_real(FftwShape shape, Real* in, Real* out) {
    return {Library::to_real(shape, pairs(in), out), Kind::to_real};
  }

  void operator()(Real* in, Real* out) const {
    switch (kind_) {
      case Kind::complex:
        return Library::run_complex(plan_, pairs(in), pairs(out));
      case Kind::real:
        return Library::run_real(plan_, in, out);
      case Kind::to_complex:
        return Library::run_to_complex(plan_, in, pairs(out));
      case Kind::to_real:
        return Library::run_to_real(plan_, pairs(in), out);
    }
  }

 private:
  using Library = Fftw<Real>;
  using Complex = typename Library::Complex;

  FourierPlan(typename Library::Plan plan, Kind kind) : plan_(plan), kind_(kind) {}
  static Complex* pairs(Real* values) { return reinterpret_cast<Complex*>(values); }
  static fftw_r2r_kind fftw_kind(Basis basis, bool forwards) {
    switch (basis) {
      case Basis::odd_odd:
        return forwards ? FFTW_RODFT10 : FFTW_RODFT01;
      case Basis::even_odd:
        return FFTW_REDFT11;
      case Basis::odd_even:
        return FFTW_RODFT11;
      case Basis::faces:
        return FFTW_RODFT00;
      default:
        return forwards ? FFTW_REDFT10 : FFTW_REDFT01;
    }
  }

  typename Library::Plan plan_ = nullptr;
  Kind kind_ = Kind::complex;
};

}  // namespace bedload
