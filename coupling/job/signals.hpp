#pragma once

namespace bedload {

/// What somebody outside asks of a run by a signal: a batch system that warns of its time limit, or
/// a person. SIGUSR1: a checkpoint, and go on. SIGTERM, SIGINT, SIGUSR2: a checkpoint, and end
/// (mpirun passes SIGUSR1 and SIGUSR2 on to the programs, but kills them a second after a SIGTERM
/// of its own).
enum class Wish : int { none, checkpoint, end };

/// From here on signals only leave a wish behind.
void listen_to_signals();

/// From here on signals are left to the partner program, which will end the job in good order.
void leave_signals_to_partner();

/// The strongest wish so far of this process; one for a checkpoint is forgotten with this, one for
/// the end stays. `signal` is set to the number of the one that asked for the end.
Wish take_wish(int& signal);

}  // namespace bedload
