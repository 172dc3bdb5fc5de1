#include "coupling/attach.hpp"
#include "coupling/register_coupling.hpp"
#include "coupling/roles.hpp"
#include "input.h"
#include "lammps.h"
__attribute__((visibility("default"))) void LAMMPS_NS::LAMMPS::post_create() {
  bedload::register_coupling(this);
}
int main(int argc, char** argv) {
  using namespace bedload;
  return run_program(argc, argv, Program::dem, [&](Job& job) {
    DemSide side(job);
    if (!job.alone()) attach(job.own(), &side);
    LAMMPS_NS::LAMMPS lammps(argc, argv, job.own());
    lammps.input->file();
  });
}
