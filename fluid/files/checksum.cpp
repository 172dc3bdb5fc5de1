#include "fluid/files/checksum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "fluid/files/collectively.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {

std::uint64_t file_checksum(const std::string& path, std::uint64_t first, MPI_Comm comm) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::uint64_t sum = 0;
  collectively(comm, [&] {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    std::ifstream file(path, std::ios::binary);
    if (error || !file || size < first) throw UserError(fmt::format("{}: cannot be read.", path));
    const std::uint64_t words = (size - first + 7) / 8;
    const std::uint64_t share = static_cast<std::uint64_t>(rank);
    const std::uint64_t begin = words * share / static_cast<std::uint64_t>(ranks);
    const std::uint64_t end = words * (share + 1) / static_cast<std::uint64_t>(ranks);
    std::vector<std::uint64_t> block(1 << 16);
    file.seekg(static_cast<std::streamoff>(first + 8 * begin));
    for (std::uint64_t n = begin; n < end;) {
      const std::uint64_t count = std::min<std::uint64_t>(block.size(), end - n);
      const std::uint64_t bytes = std::min(8 * count, size - first - 8 * n);
      block[count - 1] = 0;
      if (!file.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(bytes)))
        throw UserError(fmt::format("{}: cannot be read to its end.", path));
      for (std::uint64_t b = 0; b < count; ++b) sum += checksum_term(block[b], n + b);
      n += count;
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm);
  return sum;
}

}  // namespace bedload
