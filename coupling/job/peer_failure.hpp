#pragma once

#include <mpi.h>

#include <string>

#include "coupling/job/roles.hpp"

namespace bedload {

/// A process of a job may die without a word: killed, out of memory, crashed. mpirun then sends
/// SIGTERM to the others and kills them a second later. In that second the first process
/// left on the node says who died and which checkpoint is complete.

/// Every process of `world` learns the process numbers of the others on its node, and stays silent
/// when one of them ends the job with a sentence of its own. Returns how many processes of
/// `program` the node has. Collective.
int exchange_process_numbers(MPI_Comm world, Program program, int rank);

/// The checkpoint that a last sentence names from here on.
void name_checkpoint(const std::string& folder);

/// " The last checkpoint is …" for the end of a sentence; nothing when there is none.
std::string last_checkpoint_sentence();

/// Before a sentence that ends the job: the other processes of the node need not say anything.
void silence_peers();

/// Whether another process has called silence_peers().
bool is_silenced();

/// To be called by the handler of SIGTERM; safe there. `writes_checkpoint`: this process will write
/// one after its step, if it lives so long.
void report_dead_peers(bool writes_checkpoint);

/// Before a sentence about an error of this process: where another one of the node has died, that
/// is its cause (mpirun takes MPI's files away before SIGTERM comes), and it is said instead.
/// Returns whether it was.
bool blame_dead_peers();

/// The run has come to an end in good order: no report is due.
void end_in_good_order();

}  // namespace bedload
