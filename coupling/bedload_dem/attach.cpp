#include "coupling/bedload_dem/attach.hpp"

namespace bedload {
namespace {

int side_key() {
  static const int key = [] {
    int fresh = MPI_KEYVAL_INVALID;
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, MPI_COMM_NULL_DELETE_FN, &fresh, nullptr);
    return fresh;
  }();
  return key;
}

}  // namespace

void attach(MPI_Comm world, DemSide* side) { MPI_Comm_set_attr(world, side_key(), side); }

DemSide* attached(MPI_Comm world) {
  void* side = nullptr;
  int found = 0;
  MPI_Comm_get_attr(world, side_key(), &side, &found);
  return found ? static_cast<DemSide*>(side) : nullptr;
}

}  // namespace bedload
