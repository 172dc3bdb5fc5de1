// LIGGGHTS with our styles and no fluid, for the tests of the styles.
#include <mpi.h>

#include "input.h"
#include "lammps.h"
#include "liggghts_styles/liggghts_program.hpp"
#include "liggghts_styles/register_styles.hpp"

__attribute__((visibility("default"))) void LAMMPS_NS::LAMMPS::post_create() {
  bedload::register_styles(this);
}

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  {
    bedload::LiggghtsProgram program(MPI_COMM_WORLD);
    auto* liggghts = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
    bedload::check_styles(liggghts);
    liggghts->input->file();
    delete liggghts;
    program.finish();
  }
  MPI_Finalize();
}
