#include "coupling/job/roles.hpp"

#include <execinfo.h>
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "coupling/job/peer_failure.hpp"
#include "coupling/job/start_limit.hpp"
#include "coupling/job/wait.hpp"
#include "coupling/version.hpp"
#include "fluid/output/printable.hpp"
#include "fluid/settings/errors.hpp"

namespace bedload {
namespace {

/// What each rank of the job says about itself. Its own layout never changes, so that programs of
/// different versions understand each other this far.
struct Announcement {
  std::array<char, 16> greeting;
  std::int32_t program;
  std::int32_t protocol;
  std::uint64_t layout;
  std::array<char, 32> version;
};
static_assert(sizeof(Announcement) == 64);

Announcement announcement_of(Program program, const Protocol& protocol) {
  Announcement a{};
  std::strncpy(a.greeting.data(), "bedload", a.greeting.size() - 1);
  a.program = static_cast<std::int32_t>(program);
  a.protocol = protocol.number;
  a.layout = protocol.layout;
  std::strncpy(a.version.data(), version, a.version.size() - 1);
  return a;
}

void check_fit(const Announcement& mine, const Announcement& other) {
  if (mine.greeting != other.greeting)
    throw UserError(
        "the MPI job holds a program that is neither bedload-fluid nor bedload-dem; start only "
        "these two.");
  if (mine.protocol != other.protocol || mine.layout != other.layout)
    throw UserError(fmt::format(
        "{} is version {} (exchange protocol {}), {} is version {} (exchange protocol {}); start "
        "both from one build.",
        program_name(static_cast<Program>(mine.program)), mine.version.data(), mine.protocol,
        program_name(static_cast<Program>(other.program)), other.version.data(), other.protocol));
}

constexpr const char* out_of_memory =
    "there is not enough memory (of the machine, or allowed by a limit: ulimit -v, or that of the "
    "batch job); take fewer cells or more machines (./bedload estimate tells what a scene needs).";

/// Open MPI prints the stack of a process that crashes, in the handler of the signal. The first
/// backtrace() of a process loads a library, which allocates memory: after a crash inside an
/// allocation it would wait for that one's lock for ever, and the job with it. Here is the first.
void prepare_stack_trace() {
  std::array<void*, 1> frames{};
  ::backtrace(frames.data(), static_cast<int>(frames.size()));
}

/// Rank in the whole job; 0 before MPI has started.
int rank_in_job() {
  int started = 0, rank = 0;
  MPI_Initialized(&started);
  if (started) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

}  // namespace

const char* program_name(Program program) {
  return program == Program::fluid ? "bedload-fluid" : "bedload-dem";
}

Job::Job(int* argc, char*** argv, Program program, const Protocol& protocol) : program_(program) {
  int world_rank = 0;
  int world_size = 1;
  const Announcement mine = announcement_of(program, protocol);
  std::vector<Announcement> all;
  {
    const StartLimit limit(program_name(program));
    MPI_Init(argc, argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);
    MPI_Comm_size(MPI_COMM_WORLD, &world_size);
    all.resize(static_cast<std::size_t>(world_size));
    MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, MPI_COMM_WORLD);
  }
  for (const Announcement& other : all) check_fit(mine, other);

  MPI_Comm_split(MPI_COMM_WORLD, mine.program, world_rank, &own_);
  MPI_Comm_rank(own_, &rank_);
  MPI_Comm_size(own_, &size_);
  ranks_here_ = exchange_process_numbers(MPI_COMM_WORLD, program, rank_);
  partner_size_ = world_size - size_;
  if (partner_size_ == 0) return;
  int partner_leader = 0;
  while (all[static_cast<std::size_t>(partner_leader)].program == mine.program) ++partner_leader;
  MPI_Intercomm_create(own_, 0, MPI_COMM_WORLD, partner_leader, 0, &partner_);
}

Job::~Job() {
  if (partner_ != MPI_COMM_NULL) MPI_Comm_free(&partner_);
  MPI_Comm_free(&own_);
  MPI_Finalize();
}

// Each rank hears from one rank of the other program that all ranks of it are here.
void Job::say_farewell() const {
  if (alone()) return;
  constexpr int farewell_tag = 1000;  // none of the exchange's
  std::vector<MPI_Request> requests(1);
  const auto wait = [&requests] {
    wait_until([&requests] {
      int done = 0;
      MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
      return done != 0;
    });
  };
  MPI_Ibarrier(own_, &requests[0]);
  wait();
  MPI_Irecv(nullptr, 0, MPI_BYTE, rank_ % partner_size_, farewell_tag, partner_, &requests[0]);
  for (int other = rank_; other < partner_size_; other += size_)
    MPI_Isend(nullptr, 0, MPI_BYTE, other, farewell_tag, partner_, &requests.emplace_back());
  wait();
}

int run_program(int argc, char** argv, Program program, const Protocol& protocol,
                const std::function<int(Job&)>& body) {
  // A file that grows beyond a limit of the user's (ulimit -f) is an error of its write, with a
  // sentence, and not the silent end that the signal is unless told.
  std::signal(SIGXFSZ, SIG_IGN);
  prepare_stack_trace();
  int status = 0;
  try {
    Job job(&argc, &argv, program, protocol);
    // Caught while the job is alive: its destructor would wait for ranks that know of no mistake.
    try {
      status = body(job);
      end_in_good_order();
      job.say_farewell();
    } catch (const std::bad_alloc&) {
      end_job(program, job.rank(), out_of_memory);
    } catch (const std::exception& error) {
      end_job(program, job.rank(), error.what());
    }
  } catch (const std::exception& error) {
    end_job(program, rank_in_job(), error.what());
  }
  return status;
}

void end_job(Program program, int rank, const std::string& sentence) {
  if (rank != 0) {
    // mpirun ends those who wait here, a second after the first has ended.
    std::signal(SIGTERM, SIG_DFL);
    const int half_seconds = 2 + 3 * std::min(rank, 4);
    timespec left{half_seconds / 2, half_seconds % 2 * 500'000'000L};
    while (nanosleep(&left, &left) != 0) {  // a signal may interrupt it
    }
  }
  std::fflush(stdout);
  if (!is_silenced()) {
    silence_peers();
    if (!blame_dead_peers())
      fmt::print(stderr, "\n{}: {}{}\n", program_name(program), printable(sentence),
                 last_checkpoint_sentence());
  }
  std::fflush(nullptr);
  int started = 0;
  MPI_Initialized(&started);
  if (started) MPI_Abort(MPI_COMM_WORLD, 1);
  std::_Exit(1);
}

}  // namespace bedload
