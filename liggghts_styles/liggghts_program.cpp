#include "liggghts_styles/liggghts_program.hpp"

#include <cstdio>

namespace bedload {

namespace {

// Called by MPI_Finalize, which frees the attributes of MPI_COMM_SELF first.
int end_job_unless_clean(MPI_Comm, int, void* clean, void*) {
  std::fflush(nullptr);
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  // Alone, LIGGGHTS' own exit(1) follows and nobody waits.
  if (size > 1 && !*static_cast<bool*>(clean)) MPI_Abort(MPI_COMM_WORLD, 1);
  return MPI_SUCCESS;
}

}  // namespace

LiggghtsProgram::LiggghtsProgram(MPI_Comm dem) : vtk_(dem) {
  // LIGGGHTS does not flush its last words before MPI_Abort; by lines they are never lost.
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, end_job_unless_clean, &key_, nullptr);
  MPI_Comm_set_attr(MPI_COMM_SELF, key_, &clean_);
}

void LiggghtsProgram::finish() { clean_ = true; }

LiggghtsProgram::~LiggghtsProgram() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized == 0) {
    MPI_Comm_delete_attr(MPI_COMM_SELF, key_);
    MPI_Comm_free_keyval(&key_);
  }
}

}  // namespace bedload
