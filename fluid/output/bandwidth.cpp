#include "fluid/output/bandwidth.hpp"

#include <algorithm>
#include <vector>

#include "fluid/grid/field.hpp"

namespace bedload {

Triad::Triad(MPI_Comm comm, int megabytes) : comm_(comm) {
  MPI_Comm_size(comm, &ranks_);
  const std::size_t n =
      (static_cast<std::size_t>(megabytes) << 20) / 24 / static_cast<std::size_t>(ranks_);
  for (AlignedArray<double>* array : {&a_, &b_, &c_}) *array = AlignedArray<double>(n);
  // All pages are touched, so that the first pass measures no page faults.
  for (std::size_t i = 0; i < n; ++i) a_[i] = b_[i] = c_[i] = static_cast<double>(i % 7);
}

double Triad::pass() {
  const std::size_t n = a_.size();
  double *to = a_.data(), *from = b_.data(), *other = c_.data();
  MPI_Barrier(comm_);
  const double begin = MPI_Wtime();
  for (std::size_t i = 0; i < n; ++i) to[i] = from[i] + scale_ * other[i];
  MPI_Barrier(comm_);
  double rate = 24e-9 * static_cast<double>(n) * ranks_ / (MPI_Wtime() - begin);
  scale_ = 1.0 + a_[n / 2] * 1e-9;  // nothing may be left out
  MPI_Bcast(&rate, 1, MPI_DOUBLE, 0, comm_);
  return rate;
}

double triad_bandwidth(MPI_Comm comm, int repeats, int megabytes) {
  Triad triad(comm, megabytes);
  std::vector<double> rates;
  rates.reserve(static_cast<std::size_t>(repeats));
  for (int repeat = 0; repeat < repeats; ++repeat) rates.push_back(triad.pass());
  std::sort(rates.begin(), rates.end());
  return 0.5 * (rates[(rates.size() - 1) / 2] + rates[rates.size() / 2]);
}

}  // namespace bedload
