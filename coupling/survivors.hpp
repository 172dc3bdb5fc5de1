#pragma once

#include <mpi.h>

#include <string>

#include "coupling/roles.hpp"

namespace bedload {

/// A process of a job may die without a word: killed, out of memory, crashed. mpirun then sends
/// SIGTERM to the others and kills them a second later. In that second the first survivor of the
/// node says who died and which checkpoint is whole.

/// Every process of `world` learns the process numbers of the others on its node, and stays silent
/// when one of them ends the job with a sentence of its own. Returns how many processes of
/// `program` the node has. Collective.
int know_each_other(MPI_Comm world, Program program, int rank);

/// The checkpoint that a last sentence names from here on.
void name_checkpoint(const std::string& folder);

/// " The last checkpoint is …" for the end of a sentence; nothing when there is none.
std::string last_checkpoint_sentence();

/// Before a sentence that ends the job: the other processes of the node need not say anything.
void speak_for_all();

/// Whether another process has said so.
bool is_spoken_for();

/// To be called by the handler of SIGTERM; safe there. `writes_checkpoint`: this process will write
/// one after its step, if it lives so long.
void look_for_the_dead(bool writes_checkpoint);

/// The run has come to an end in good order: nothing is left to be said.
void nothing_to_say();

}  // namespace bedload
