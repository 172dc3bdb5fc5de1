#pragma once

#include <mpi.h>

namespace bedload {

/// LIGGGHTS' VTK dumps make a controller over MPI_COMM_WORLD and would wait there for the fluid;
/// while this lives, VTK keeps to the communicator that LIGGGHTS runs on. A LIGGGHTS without VTK
/// needs nothing of it: without_vtk.cpp.
class VtkCommunicator {
 public:
  /// @param dem communicator of all LIGGGHTS ranks
  explicit VtkCommunicator(MPI_Comm dem);
  ~VtkCommunicator();  // NOLINT(performance-trivially-destructible): with VTK it has work to do
  VtkCommunicator(const VtkCommunicator&) = delete;
  VtkCommunicator& operator=(const VtkCommunicator&) = delete;

 private:
  void* controller_ = nullptr;
};

}  // namespace bedload
