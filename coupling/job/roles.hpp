#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

namespace bedload {

/// The two programs of a job.
enum class Program : int { fluid, dem };

/// Name on the command line: bedload-fluid or bedload-dem.
const char* program_name(Program program);

/// What both programs of a job must have in common to understand each other's messages.
struct Protocol {
  std::int32_t number;
  std::uint64_t layout;  ///< of the records
};

/// One MPI job from this program's point of view: MPI started, roles known, the ranks of each
/// program on a communicator of their own, and an inter-communicator between the two. Ends MPI when
/// it goes out of scope.
class Job {
 public:
  /// Starts MPI; every rank of MPI_COMM_WORLD says which program, version and protocol it is.
  /// Throws UserError when the two programs do not belong together.
  Job(int* argc, char*** argv, Program program, const Protocol& protocol);
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  Program program() const { return program_; }
  MPI_Comm own() const { return own_; }          ///< the ranks of this program
  MPI_Comm partner() const { return partner_; }  ///< inter-communicator; MPI_COMM_NULL when alone
  bool alone() const { return partner_ == MPI_COMM_NULL; }
  int rank() const { return rank_; }  ///< within own()
  int size() const { return size_; }
  int partner_size() const { return partner_size_; }
  int ranks_here() const { return ranks_here_; }  ///< of this program on this node

  /// Both programs wait here, asleep, until every rank of the other one is done as well.
  void say_farewell() const;

 private:
  Program program_;
  MPI_Comm own_ = MPI_COMM_NULL;
  MPI_Comm partner_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
  int partner_size_ = 0;
  int ranks_here_ = 1;
};

/// Runs `body` as one rank of `program` and returns its status, the exit status of main. A mistake
/// of the user (UserError), or any other exception, ends the whole job, both programs, with exit
/// status 1 after its sentence on stderr.
int run_program(int argc, char** argv, Program program, const Protocol& protocol,
                const std::function<int(Job&)>& body);

/// Ends the whole job with exit status 1 after `sentence` and the last checkpoint on stderr. Rank 0
/// reports at once; another rank reports some seconds later if the job is still there, because then
/// it alone has met the mistake.
[[noreturn]] void end_job(Program program, int rank, const std::string& sentence);

}  // namespace bedload
