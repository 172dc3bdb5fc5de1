#include "coupling/exchange/mailbox.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "coupling/job/wait.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// Messages up to this size [bytes] are with the receiver's MPI as soon as they are posted,
/// whatever it does (Open MPI's limit is 4 kB or more, its own header included).
constexpr std::size_t sent_at_once = 3500;

/// MPI counts bytes in 32 bits with a sign: about 10^7 spheres from one rank to another.
constexpr std::size_t longest_message = std::numeric_limits<int>::max();

}  // namespace

void SendQueue::post(int to, Subject subject, std::shared_ptr<const Bytes> message) {
  if (message->size() > longest_message)
    throw UserError(fmt::format(
        "a message of {} bytes to rank {} of the other program is longer than MPI's {}; "
        "use more ranks, so that each has fewer spheres.",
        message->size(), to, longest_message));
  all_gone();
  MPI_Request request;
  MPI_Isend(message->data(), static_cast<int>(message->size()), MPI_BYTE, to,
            static_cast<int>(subject), partner_, &request);
  pending_.push_back({request, std::move(message)});
}

bool SendQueue::all_gone() {
  std::erase_if(pending_, [](PendingSend& send) {
    int gone = 0;
    MPI_Test(&send.request, &gone, MPI_STATUS_IGNORE);
    return gone != 0;
  });
  return pending_.empty();
}

void SendQueue::push(double seconds) {
  const bool leave_alone =
      std::all_of(pending_.begin(), pending_.end(),
                  [](const PendingSend& send) { return send.message->size() <= sent_at_once; });
  if (leave_alone) return;
  wait_until_or([this] { return all_gone(); }, seconds);
}

void SendQueue::flush() {
  wait_until([this] { return all_gone(); });
}

Bytes receive(MPI_Comm partner, int from, Subject subject) {
  MPI_Message message;
  MPI_Status status;
  wait_until([&] {
    int there = 0;
    MPI_Improbe(from, static_cast<int>(subject), partner, &there, &message, &status);
    return there != 0;
  });
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Bytes bytes(static_cast<std::size_t>(size));
  MPI_Request request;
  MPI_Imrecv(bytes.data(), size, MPI_BYTE, &message, &request);
  wait_until([&] {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  });
  return bytes;
}

}  // namespace bedload
