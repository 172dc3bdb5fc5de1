#include "coupling/roles.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <vector>

#include "coupling/mailbox.hpp"
#include "coupling/message.hpp"
#include "coupling/version.hpp"
#include "fluid/errors.hpp"

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

Announcement announcement_of(Program program) {
  Announcement a{};
  std::strncpy(a.greeting.data(), "bedload", a.greeting.size() - 1);
  a.program = static_cast<std::int32_t>(program);
  a.protocol = protocol_number;
  a.layout = layout_fingerprint();
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

}  // namespace

const char* program_name(Program program) {
  return program == Program::fluid ? "bedload-fluid" : "bedload-dem";
}

Job::Job(int* argc, char*** argv, Program program) : program_(program) {
  MPI_Init(argc, argv);
  int world_rank = 0;
  int world_size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &world_rank);
  MPI_Comm_size(MPI_COMM_WORLD, &world_size);

  const Announcement mine = announcement_of(program);
  std::vector<Announcement> all(static_cast<std::size_t>(world_size));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, MPI_COMM_WORLD);
  for (const Announcement& other : all) check_fit(mine, other);

  MPI_Comm_split(MPI_COMM_WORLD, mine.program, world_rank, &own_);
  MPI_Comm_rank(own_, &rank_);
  MPI_Comm_size(own_, &size_);
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

void Job::say_farewell() const {
  if (alone()) return;
  Outbox outbox(partner_);
  const auto nothing = std::make_shared<const Bytes>();
  for (int other = 0; other < partner_size_; ++other)
    outbox.post(other, Subject::farewell, nothing);
  for (int other = 0; other < partner_size_; ++other) receive(partner_, other, Subject::farewell);
  outbox.flush();
}

int run_program(int argc, char** argv, Program program, const std::function<int(Job&)>& body) {
  int rank = 0, status = 0;
  try {
    Job job(&argc, &argv, program);
    rank = job.rank();
    // Caught while the job is alive: its destructor would wait for ranks that know of no mistake.
    try {
      status = body(job);
      job.say_farewell();
    } catch (const std::exception& error) {
      end_job(program, rank, error.what());
    }
  } catch (const std::exception& error) {
    end_job(program, rank, error.what());
  }
  return status;
}

void end_job(Program program, int rank, const std::string& sentence) {
  if (rank != 0) {
    std::signal(SIGTERM, SIG_DFL);  // mpirun ends those who wait here
    sleep(5);
  }
  std::fflush(stdout);
  fmt::print(stderr, "\n{}: {}\n", program_name(program), sentence);
  std::fflush(nullptr);
  int started = 0;
  MPI_Initialized(&started);
  if (started) MPI_Abort(MPI_COMM_WORLD, 1);
  std::_Exit(1);
}

}  // namespace bedload
