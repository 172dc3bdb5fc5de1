#include "liggghts_styles/liggghts_program.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace bedload {

namespace {

// Called by MPI_Finalize, which frees the attributes of MPI_COMM_SELF first.
int end_job_unless_clean(MPI_Comm, int, void* state, void*) {
  std::fflush(nullptr);
  const auto& ending = *static_cast<LiggghtsProgram::Ending*>(state);
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  // Alone, LIGGGHTS' own exit(1) follows and no other program waits.
  if (size == 1 || ending.clean) return MPI_SUCCESS;
  if (ending.take_leave()) {
    std::atexit([] {
      std::fflush(nullptr);
      _exit(0);
    });
    return MPI_SUCCESS;
  }
  if (ending.rank != 0) {
    // Rank 0 still has the message to print, and ends this one behind it.
    std::signal(SIGTERM, SIG_DFL);
    sleep(2);
  }
  MPI_Abort(MPI_COMM_WORLD, 1);
  return MPI_SUCCESS;
}

}  // namespace

LiggghtsProgram::LiggghtsProgram(MPI_Comm dem) : vtk_(dem) {
  // LIGGGHTS does not flush its last words before MPI_Abort; by lines they are never lost.
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, end_job_unless_clean, &key_, nullptr);
  MPI_Comm_rank(dem, &ending_.rank);
  MPI_Comm_set_attr(MPI_COMM_SELF, key_, &ending_);
}

void LiggghtsProgram::ends_well_if(std::function<bool()> take_leave) {
  ending_.take_leave = std::move(take_leave);
}

void LiggghtsProgram::finish() { ending_.clean = true; }

LiggghtsProgram::~LiggghtsProgram() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (finalized == 0) {
    ending_.clean = true;  // an exception is on its way to whoever has a sentence for it
    MPI_Comm_delete_attr(MPI_COMM_SELF, key_);
    MPI_Comm_free_keyval(&key_);
  }
}

}  // namespace bedload
