#pragma once

#include <mpi.h>

#include <memory>
#include <vector>

#include "coupling/message.hpp"

namespace bedload {

/// What a message is about: the MPI tag.
enum class Subject : int {
  fluid_facts,
  dem_facts,
  spheres,
  division,
  partners,
  loads,
  states,
  checkpoint,
  farewell
};

/// Messages on their way to ranks of the partner. Posting never waits; buffers live until they have
/// left.
class Outbox {
 public:
  explicit Outbox(MPI_Comm partner) : partner_(partner) {}
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  /// Hands one message over to MPI for rank `to` of the partner.
  void post(int to, Subject subject, std::shared_ptr<const Bytes> message);

  /// Gives MPI up to `seconds` to get everything out; sleeps in between. A long message leaves only
  /// when both sides are inside MPI, so that one who goes off to compute does this first.
  void push(double seconds);

  /// Waits, asleep, until everything has left.
  void flush();

 private:
  struct Letter {
    MPI_Request request;
    std::shared_ptr<const Bytes> message;
  };
  bool all_gone();

  MPI_Comm partner_;
  std::vector<Letter> letters_;
};

/// Waits, asleep, for the message of rank `from` of the partner; of any length.
Bytes receive(MPI_Comm partner, int from, Subject subject);

}  // namespace bedload
