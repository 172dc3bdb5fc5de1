// In place of vtk_communicator.cpp where LIGGGHTS was built without VTK.
#include "liggghts_styles/vtk_communicator.hpp"

namespace bedload {

VtkCommunicator::VtkCommunicator(MPI_Comm) {}
VtkCommunicator::~VtkCommunicator() = default;

}  // namespace bedload
