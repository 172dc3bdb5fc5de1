// Opens what each line of its input names as `--restart` does, and answers each by one line: "step
// N" or the sentence of the refusal.

#include <mpi.h>

#include <iostream>
#include <string>

#include "coupling/checkpoint/checkpoints.hpp"
#include "fluid/settings/errors.hpp"

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  for (std::string where; std::getline(std::cin, where);) {
    try {
      const bedload::Resumption found = bedload::open_checkpoint(where, true, MPI_COMM_WORLD);
      std::cout << "step " << found.header.step << std::endl;
    } catch (const bedload::UserError& error) {
      std::cout << error.what() << std::endl;
    }
  }
  MPI_Finalize();
}
