#pragma once

#include <mpi.h>

namespace bedload {

/// What any program around LIGGGHTS needs besides LIGGGHTS itself. Make one after MPI_Init and keep
/// it until LIGGGHTS is gone.
///
/// - When LIGGGHTS stops on an error it calls MPI_Finalize and exit, and every partner in the MPI
/// job
///   would wait for ever. Here the whole job ends with code 1 unless finish() was called.
/// - LIGGGHTS' VTK dumps make a controller over MPI_COMM_WORLD; here VTK is given `dem`, the
///   communicator that LIGGGHTS runs on.
class LiggghtsProgram {
 public:
  /// @param dem communicator of all LIGGGHTS ranks
  explicit LiggghtsProgram(MPI_Comm dem);
  ~LiggghtsProgram();
  LiggghtsProgram(const LiggghtsProgram&) = delete;
  LiggghtsProgram& operator=(const LiggghtsProgram&) = delete;

  /// The run ended as it should: MPI_Finalize may come.
  void finish();

 private:
  int key_ = MPI_KEYVAL_INVALID;
  bool clean_ = false;
  void* controller_ = nullptr;
};

}  // namespace bedload
