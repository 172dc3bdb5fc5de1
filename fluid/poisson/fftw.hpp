#pragma once

#include <fftw3.h>
#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "fluid/kernels/heap.hpp"
#include "fluid/poisson/basis.hpp"

namespace bedload {

/// How many transforms of which length, and where their points lie (FFTW's "advanced" interface).
struct FftwShape {
  std::vector<int> n;  ///< points of one transform, along each of its dimensions
  int howmany;         ///< transforms
  int stride = 1;      ///< from point to point, in numbers of each array's kind
  int distance = 0;    ///< from transform to transform
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
    static Plan complex(const FftwShape& s, Complex* in, Complex* out, int sign) {                 \
      return name##_plan_many_dft(static_cast<int>(s.n.size()), s.n.data(), s.howmany, in,         \
                                  nullptr, s.stride, s.distance, out, nullptr, s.stride,           \
                                  s.distance, sign, flags);                                        \
    }                                                                                              \
    static Plan real(const FftwShape& s, Real* in, Real* out, fftw_r2r_kind kind) {                \
      return name##_plan_many_r2r(1, s.n.data(), s.howmany, in, nullptr, s.stride, s.distance,     \
                                  out, nullptr, s.stride, s.distance, &kind, flags);               \
    }                                                                                              \
    static Plan to_complex(const FftwShape& s, Real* in, Complex* out) {                           \
      return name##_plan_many_dft_r2c(1, s.n.data(), s.howmany, in, nullptr, s.stride, s.distance, \
                                      out, nullptr, s.stride, s.distance, flags);                  \
    }                                                                                              \
    static Plan to_real(const FftwShape& s, Complex* in, Real* out) {                              \
      return name##_plan_many_dft_c2r(1, s.n.data(), s.howmany, in, nullptr, s.stride, s.distance, \
                                      out, nullptr, s.stride, s.distance, flags);                  \
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
    static void forget() { name##_forget_wisdom(); }                                               \
  };
BEDLOAD_FFTW(double, fftw)
BEDLOAD_FFTW(float, fftwf)
#undef BEDLOAD_FFTW

/// What FFTW has learned in this process, an entry a line in a fixed order: FFTW itself writes them
/// down as they lie in its table, which depends on the order in which they came.
template <class Real>
std::string wisdom_in_order() {
  char* const text = Fftw<Real>::wisdom();
  std::istringstream lines(text);
  std::free(text);
  std::string head, entry;
  std::getline(lines, head);
  std::vector<std::string> entries;
  while (std::getline(lines, entry) && entry != ")") entries.push_back(entry);
  std::sort(entries.begin(), entries.end());
  for (const std::string& line : entries) head += "\n" + line;
  return head + "\n)\n";
}

/// Knows what `wisdom` says and nothing else: FFTW also remembers what it tried and did not choose.
template <class Real>
void know_only(const std::string& wisdom) {
  Fftw<Real>::forget();
  Fftw<Real>::learn(wisdom.c_str());
}

/// What FFTW has learned in both precisions, one part behind the other: the spectra of the
/// statistics are in double whatever the fields are.
inline std::string all_wisdom() { return wisdom_in_order<double>() + wisdom_in_order<float>(); }

/// Learns what all_wisdom() has written. FFTW does not take parts of the other precision.
inline void learn_all(const std::string& wisdom) {
  for (std::size_t begin = 0; begin < wisdom.size();) {
    const std::size_t end = std::min(wisdom.find("\n(", begin), wisdom.size() - 1) + 1;
    const std::string part = wisdom.substr(begin, end - begin);  // entries within are indented
    Fftw<double>::learn(part.c_str());
    Fftw<float>::learn(part.c_str());
    begin = end;
  }
}

/// Runs `plan` on all ranks so that they compute with the same algorithms, to the last digit, and
/// so does a run that goes on with what this one has learned. The first rank of each `shape` of
/// transforms plans, which measures, on top of what those before it have learned; then all plan
/// from the same knowledge, which measures nothing. Collective.
template <class Real, class MakePlans>
void plan_alike(MPI_Comm comm, int shape, MakePlans&& plan) {
  keep_freed_buffers();
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::vector<int> shapes(static_cast<std::size_t>(ranks));
  MPI_Allgather(&shape, 1, MPI_INT, shapes.data(), 1, MPI_INT, comm);
  for (auto first = shapes.begin(); first != shapes.end(); ++first) {
    if (std::find(shapes.begin(), first, *first) != first) continue;
    const int leader = static_cast<int>(first - shapes.begin());
    std::string wisdom;
    if (rank == leader) {
      plan();
      wisdom = wisdom_in_order<Real>();
    }
    int length = static_cast<int>(wisdom.size());
    MPI_Bcast(&length, 1, MPI_INT, leader, comm);
    wisdom.resize(static_cast<std::size_t>(length));
    MPI_Bcast(wisdom.data(), length, MPI_CHAR, leader, comm);
    know_only<Real>(wisdom);
  }
  const std::string wisdom = wisdom_in_order<Real>();
  plan();
  know_only<Real>(wisdom);
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
  static FourierPlan complex(const FftwShape& shape, Real* in, Real* out, int sign) {
    return {Library::complex(shape, pairs(in), pairs(out), sign), Kind::complex};
  }
  /// Sine or cosine transform, forwards or back; together they multiply by twice the cells.
  static FourierPlan real(Basis basis, bool forwards, FftwShape shape, Real* in, Real* out) {
    if (basis == Basis::faces) --shape.n[0];
    return {Library::real(shape, in, out, fftw_kind(basis, forwards)), Kind::real};
  }
  /// Real numbers to their n/2+1 complex modes, and back.
  static FourierPlan to_complex(const FftwShape& shape, Real* in, Real* out) {
    return {Library::to_complex(shape, in, pairs(out)), Kind::to_complex};
  }
  static FourierPlan to_real(const FftwShape& shape, Real* in, Real* out) {
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
