#pragma once

#include <mpi.h>

#include <functional>

#include "liggghts_styles/vtk_communicator.hpp"

namespace bedload {

/// What any program around LIGGGHTS needs besides LIGGGHTS itself. Make one after MPI_Init and keep
/// it until LIGGGHTS is gone. When LIGGGHTS stops on an error it calls MPI_Finalize and exit, and
/// every partner in the MPI job would wait for ever; here the whole job ends with code 1 unless
/// finish() was called.
class LiggghtsProgram {
 public:
  /// @param dem communicator of all LIGGGHTS ranks
  explicit LiggghtsProgram(MPI_Comm dem);
  ~LiggghtsProgram();
  LiggghtsProgram(const LiggghtsProgram&) = delete;
  LiggghtsProgram& operator=(const LiggghtsProgram&) = delete;

  /// The run ended as it should: MPI_Finalize may come.
  void finish();

  /// Where LIGGGHTS ends the process on its own (`quit`): `take_leave` says whether the run was
  /// over, and has told the partners then; the process ends with status 0.
  void ends_well_if(std::function<bool()> take_leave);

  /// What the end of MPI has to know.
  struct Ending {
    bool clean = false;
    int rank = 0;  ///< among LIGGGHTS' ranks
    std::function<bool()> take_leave = [] { return false; };
  };

 private:
  int key_ = MPI_KEYVAL_INVALID;
  Ending ending_;
  VtkCommunicator vtk_;
};

}  // namespace bedload
