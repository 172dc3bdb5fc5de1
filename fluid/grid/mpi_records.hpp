#pragma once

#include <fmt/format.h>
#include <mpi.h>

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "fluid/settings/errors.hpp"

namespace bedload {

/// A number of things as MPI and the lists of markers count them, in 32 bits.
/// @param what the things, for the sentence, in the plural
/// @throws UserError when there are 2^31 or more on this rank
inline int mpi_count(std::uint64_t number, std::string_view what) {
  if (number > static_cast<std::uint64_t>(std::numeric_limits<int>::max()))
    throw UserError(fmt::format(
        "One rank has {} {}, more than 2^31 - 1: start the run on more ranks.", number, what));
  return static_cast<int>(number);
}

/// A record as MPI sees it: counts are those of records, so that 32 bits reach for 2^31 of them.
template <class Record>
struct RecordType {
  RecordType() {
    MPI_Type_contiguous(sizeof(Record), MPI_BYTE, &type);
    MPI_Type_commit(&type);
  }
  ~RecordType() { MPI_Type_free(&type); }
  RecordType(const RecordType&) = delete;
  RecordType& operator=(const RecordType&) = delete;

  MPI_Datatype type = MPI_DATATYPE_NULL;
};

/// Where the parts of `counts` records begin when they stand one after the other; returns how many
/// they are together.
inline std::size_t places_of(std::span<const int> counts, std::vector<int>& places) {
  std::uint64_t all = 0;
  places.clear();
  for (const int count : counts) {
    places.push_back(mpi_count(all, "records"));
    all += static_cast<std::uint64_t>(count);
  }
  return all;
}

}  // namespace bedload
