#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <limits>

#include "fluid/checkpoint/state_file.hpp"
#include "fluid/files/atomic_file.hpp"
#include "fluid/files/collectively.hpp"

namespace bedload {
namespace {

/// The coarse planes that one rank makes: an even share.
struct Share {
  int first, planes;
};

Share share_of(int planes, MPI_Comm comm) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const int first = static_cast<int>(std::int64_t{planes} * rank / ranks);
  return {first, static_cast<int>(std::int64_t{planes} * (rank + 1) / ranks) - first};
}

/// A velocity component on the coarse planes of `share`: with m fine cells per coarse one, the
/// coarse upper face lies on a fine one and is made of m x m fine faces,
///   U(I) = 1/m^2 sum of u over these faces,
/// so that the flux through each coarse cell's surface, and its sum zero, is kept.
std::vector<double> coarsened(const StateReader& state, const FieldEntry& entry, int m,
                              const Share& share) {
  const auto& cells = state.header().cells;
  const int nx = cells[0], nz = cells[2], coarse_nx = nx / m, coarse_nz = nz / m;
  std::vector<double> coarse(static_cast<std::size_t>(share.planes) *
                             static_cast<std::size_t>(coarse_nx) *
                             static_cast<std::size_t>(coarse_nz));
  std::vector<double> fine(static_cast<std::size_t>(nx) * static_cast<std::size_t>(nz));
  // A fine cell counts when it lies on the coarse face: all along the two tangential directions,
  // the last of m along its own.
  const auto counts = [&](int d, int n) { return !entry.on_face(d) || n % m == m - 1; };
  // Means over areas: on stretched y the planes that are joined differ in height.
  const std::vector<double>& faces = state.header().y_faces;
  const auto weight_of = [&](int j) {
    if (entry.on_face(1) || faces.empty()) return 1.0 / (m * m);
    const auto below = static_cast<std::size_t>(j), first = static_cast<std::size_t>(j / m * m);
    return (faces[below + 1] - faces[below]) /
           (m * (faces[first + static_cast<std::size_t>(m)] - faces[first]));
  };
  for (int j = share.first * m; j < (share.first + share.planes) * m; ++j) {
    if (!counts(1, j)) continue;
    const double weight = weight_of(j);
    state.read_rows(entry, j, 0, nz, fine.data());
    for (int k = 0; k < nz; ++k) {
      if (!counts(2, k)) continue;
      const double* row = fine.data() + static_cast<std::ptrdiff_t>(nx) * k;
      double* to =
          coarse.data() +
          (static_cast<std::ptrdiff_t>(j / m - share.first) * coarse_nz + k / m) * coarse_nx;
      for (int i = 0; i < nx; ++i)
        if (counts(0, i)) to[i / m] += weight * row[i];
    }
  }
  return coarse;
}

}  // namespace

void write_compact_state(const std::string& state_path, const std::string& compact, MPI_Comm comm,
                         const Compaction& how) {
  const StateReader state(state_path, comm);
  StateHeader header = state.header();
  on_first_rank(comm, [&] {
    for (std::size_t d = 0; d < 3; ++d)
      if (header.cells[d] % how.every != 0)
        throw UserError(fmt::format("{}: {} cells along {} cannot be joined by {}.", state_path,
                                    header.cells[d], "xyz"[d], how.every));
  });
  for (int& n : header.cells) n /= how.every;
  if (!header.y_faces.empty()) {
    std::vector<double> kept;
    for (std::size_t j = 0; j < header.y_faces.size(); j += static_cast<std::size_t>(how.every))
      kept.push_back(header.y_faces[j]);
    header.y_faces = kept;
  }
  const Share share = share_of(header.cells[1], comm);
  const auto size = [](int n) { return static_cast<std::uint64_t>(n); };
  const Hyperslab slab{{size(header.cells[1]), size(header.cells[2]), size(header.cells[0])},
                       {size(share.first), 0, 0},
                       {size(share.planes), size(header.cells[2]), size(header.cells[0])}};
  const Storage storage{{1, slab.shape[1], slab.shape[2]}, how.gzip};
  try {
    on_first_rank(comm, [&] {
      const std::uint64_t numbers = slab.shape[0] * slab.shape[1] * slab.shape[2] * 3;
      require_space(compact, numbers * sizeof(std::int16_t) + (1 << 20));
    });
    const auto file = create_state(compact, header, comm);
    for (const FieldEntry& entry : field_list) {
      if (entry.stored != Stored::velocity) continue;
      std::vector<double> values;
      collectively(comm, [&] { values = coarsened(state, entry, how.every, share); });
      double largest = 0.0;
      for (const double value : values) largest = std::max(largest, std::abs(value));
      MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
      const double scale = largest > 0.0 ? largest / std::numeric_limits<std::int16_t>::max() : 1.0;
      std::vector<std::int16_t> scaled;
      scaled.reserve(values.size());
      for (const double value : values)
        scaled.push_back(static_cast<std::int16_t>(std::lround(value / scale)));
      file->write(entry.name, slab, scaled.data(), storage);
      file->set_text(entry.name, "unit", entry.unit);
      file->set_attribute(entry.name, "scale", scale);
    }
    file->close();
    seal_state(compact, comm);
  } catch (const UserError&) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    if (rank == 0) discard_temporary(compact);
    throw;
  }
}

}  // namespace bedload
