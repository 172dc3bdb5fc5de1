#pragma once

#include <mpi.h>

#include <memory>
#include <vector>

#include "coupling/exchange/message.hpp"

namespace bedload {

/// What a message is about: the MPI tag.
enum class Subject : int {
  fluid_scene_info,
  dem_scene_info,
  spheres,
  division,
  partners,
  loads,
  states,
  checkpoint
};

/// Messages on their way to ranks of the partner. Posting never waits; buffers live until they have
/// left.
class SendQueue {
 public:
  explicit SendQueue(MPI_Comm partner) : partner_(partner) {}
  SendQueue(const SendQueue&) = delete;
  SendQueue& operator=(const SendQueue&) = delete;

  /// Hands one message over to MPI for rank `to` of the partner.
  void post(int to, Subject subject, std::shared_ptr<const Bytes> message);

  /// Gives MPI up to `seconds` to get everything out; sleeps in between. A long message leaves only
  /// when both sides are inside MPI, so that one who goes off to compute does this first.
  void push(double seconds);

  /// Waits, asleep, until everything has left.
  void flush();

 private:
  struct PendingSend {
    MPI_Request request;
    std::shared_ptr<const Bytes> message;
  };
  bool all_gone();

  MPI_Comm partner_;
  std::vector<PendingSend> pending_;
};

/// Waits, asleep, for the message of rank `from` of the partner; of any length.
Bytes receive(MPI_Comm partner, int from, Subject subject);

}  // namespace bedload
