#include "liggghts_styles/vtk_communicator.hpp"

#include <vtkMPI.h>
#include <vtkMPICommunicator.h>
#include <vtkMPIController.h>

namespace bedload {

VtkCommunicator::VtkCommunicator(MPI_Comm dem) {
  vtkMPICommunicatorOpaqueComm opaque(&dem);
  vtkMPICommunicator* communicator = vtkMPICommunicator::New();
  communicator->InitializeExternal(&opaque);
  vtkMPIController* controller = vtkMPIController::New();
  controller->SetCommunicator(communicator);
  communicator->Delete();
  vtkMultiProcessController::SetGlobalController(controller);
  controller_ = controller;
}

VtkCommunicator::~VtkCommunicator() {
  vtkMultiProcessController::SetGlobalController(nullptr);
  static_cast<vtkMPIController*>(controller_)->Delete();
}

}  // namespace bedload
