#include "fluid/output/timing.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fluid/files/atomic_file.hpp"

namespace bedload {

void Timing::restart() {
  for (Phase& phase : phases_) {
    phase.seconds = 0.0;
    phase.calls = 0;
  }
  born_ = MPI_Wtime();
}

std::vector<TimingRow> Timing::reduce(MPI_Comm comm) const {
  const double total = MPI_Wtime() - born_;
  std::vector<double> mine;
  for (const Phase& phase : phases_) mine.push_back(phase.seconds);
  double rest = total;
  for (const double seconds : mine) rest -= seconds;
  mine.push_back(std::max(rest, 0.0));
  mine.push_back(total);
  std::vector<double> sum(mine.size()), largest(mine.size());
  const int count = static_cast<int>(mine.size());
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  MPI_Allreduce(mine.data(), sum.data(), count, MPI_DOUBLE, MPI_SUM, comm);
  MPI_Allreduce(mine.data(), largest.data(), count, MPI_DOUBLE, MPI_MAX, comm);
  std::vector<TimingRow> rows;
  for (std::size_t n = 0; n + 1 < mine.size(); ++n) {
    const bool is_phase = n < phases_.size();
    rows.push_back({is_phase ? phases_[n].name : "rest", sum[n] / ranks, largest[n],
                    sum.back() > 0.0 ? sum[n] / sum.back() : 0.0, is_phase ? phases_[n].calls : 0});
  }
  return rows;
}

std::string timing_table(const std::vector<TimingRow>& rows) {
  std::size_t width = 4;
  for (const TimingRow& row : rows) width = std::max(width, row.part.size());
  std::string text = fmt::format("{:<{}}  {:>10}  {:>10}  {:>6}  {:>9}\n", "part", width, "seconds",
                                 "slowest", "share", "calls");
  for (const TimingRow& row : rows)
    text += fmt::format("{:<{}}  {:>10.3f}  {:>10.3f}  {:>5.1f}%  {:>9}\n", row.part, width,
                        row.seconds_mean, row.seconds_max, 100.0 * row.share, row.calls);
  return text;
}

void write_timing(const std::string& folder, const std::vector<TimingRow>& rows) {
  std::string text = "part,seconds_mean_over_ranks,seconds_max,share,calls\n";
  for (const TimingRow& row : rows)
    text += fmt::format("{},{:.6f},{:.6f},{:.6f},{}\n", row.part, row.seconds_mean, row.seconds_max,
                        row.share, row.calls);
  write_text_file(folder + "/timing.csv", text);
}

}  // namespace bedload
