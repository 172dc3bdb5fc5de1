#include "fluid/bandwidth.hpp"

#include <algorithm>
#include <vector>

#include "fluid/field.hpp"

namespace bedload {

double triad_bandwidth(MPI_Comm comm, int repeats, int megabytes) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const std::size_t n =
      (static_cast<std::size_t>(megabytes) << 20) / 24 / static_cast<std::size_t>(ranks);
  AlignedArray<double> a(n), b(n), c(n);
  for (std::size_t i = 0; i < n; ++i) b[i] = c[i] = static_cast<double>(i % 7);
  std::vector<double> rates;
  double scale = 3.0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    double *to = a.data(), *from = b.data(), *other = c.data();
    MPI_Barrier(comm);
    const double begin = MPI_Wtime();
    for (std::size_t i = 0; i < n; ++i) to[i] = from[i] + scale * other[i];
    MPI_Barrier(comm);
    rates.push_back(24e-9 * static_cast<double>(n) * ranks / (MPI_Wtime() - begin));
    scale = 1.0 + a[static_cast<std::size_t>(repeat)] * 1e-9;  // nothing may be left out
  }
  std::sort(rates.begin(), rates.end());
  const std::size_t size = rates.size();
  double rate = 0.5 * (rates[(size - 1) / 2] + rates[size / 2]);
  MPI_Bcast(&rate, 1, MPI_DOUBLE, 0, comm);
  return rate;
}

}  // namespace bedload
