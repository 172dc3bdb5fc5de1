#pragma once

#include <string>

#include "fluid/checkpoint/group.hpp"
#include "fluid/files/hdf5_file.hpp"

namespace bedload::test {

/// What a checkpoint keeps of an object goes through `file`, which all ranks of `comm` write, to
/// another. Collective.
template <class From, class To>
void carry_over(From& from, To& to, const std::string& file, MPI_Comm comm) {
  std::uint64_t bytes = 0;
  Hdf5File written(file, Hdf5File::Access::create, comm);
  from.save(SaveGroup(&written, "object", comm, bytes));
  written.close();
  const Hdf5File read(file, Hdf5File::Access::read, MPI_COMM_SELF);
  to.load(LoadGroup(read, "object"));
  MPI_Barrier(comm);
}

}  // namespace bedload::test
