#include "coupling/job/signals.hpp"

#include <csignal>
#include <initializer_list>

#include "coupling/job/peer_failure.hpp"

namespace bedload {
namespace {

// Handlers can reach nothing but objects of static storage.
volatile std::sig_atomic_t checkpoint_asked = 0;
volatile std::sig_atomic_t ended_by = 0;

void ask_for_checkpoint(int) { checkpoint_asked = 1; }
void ask_for_end(int signal) {
  ended_by = signal;
  if (signal == SIGTERM) report_dead_peers(true);
}

}  // namespace

void listen_to_signals() {
  std::signal(SIGUSR1, ask_for_checkpoint);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR2}) std::signal(signal, ask_for_end);
}

void leave_signals_to_partner() {
  for (const int signal : {SIGUSR1, SIGINT, SIGUSR2}) std::signal(signal, SIG_IGN);
  std::signal(SIGTERM, [](int) { report_dead_peers(false); });
}

Wish take_wish(int& signal) {
  if (ended_by != 0) {
    signal = ended_by;
    return Wish::end;
  }
  if (checkpoint_asked == 0) return Wish::none;
  checkpoint_asked = 0;
  return Wish::checkpoint;
}

}  // namespace bedload
