#include "coupling/job/peer_failure.hpp"

#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "coupling/job/machine.hpp"

namespace bedload {
namespace {

/// What each process tells the others.
struct Introduction {
  std::array<char, 192> machine;  ///< see machine_identity()
  std::int32_t process;
  std::int32_t program;
  std::int32_t rank;  ///< within its program
};

struct Neighbour {
  pid_t process;
  std::string name;
};

// Handlers can reach nothing but objects of static storage, and may run in a thread of MPI's at any
// time. The vector does not change after exchange_process_numbers(); of two texts the one that is
// not shown is written, and shown then.
std::vector<Neighbour> neighbours;  // on this node, in the order of the job's ranks
std::array<std::array<char, 4096>, 2> checkpoints{};
std::atomic<std::size_t> shown{0};
static_assert(std::atomic<std::size_t>::is_always_lock_free);
std::string_view checkpoint() { return checkpoints[shown].data(); }
const char* speaker = "bedload";
volatile std::sig_atomic_t is_said = 0;

int silencing_signal() { return SIGRTMIN + 3; }

/// A sentence put together without allocating, for use in a handler.
class Sentence {
 public:
  Sentence& operator<<(std::string_view text) {
    const std::size_t count = std::min(text.size(), text_.size() - size_);
    std::memcpy(text_.data() + size_, text.data(), count);
    size_ += count;
    return *this;
  }
  void say() const {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text_.data(), size_);
  }

 private:
  std::array<char, 4096> text_;
  std::size_t size_ = 0;
};

bool is_dead(const Neighbour& other) { return ::kill(other.process, 0) != 0 && errno == ESRCH; }

void add_checkpoint(Sentence& sentence) {
  if (const std::string_view folder = checkpoint(); !folder.empty())
    sentence << " The last checkpoint is " << folder << "; go on with --restart " << folder << ".";
  sentence << "\n";
}

void say_who_died() {
  Sentence sentence;
  sentence << "\n" << speaker << ": ";
  bool first = true;
  for (const Neighbour& other : neighbours) {
    if (!is_dead(other)) continue;
    sentence << (first ? "" : " and ") << other.name;
    first = false;
  }
  sentence << " died (killed from outside, out of memory, or crashed), which ends the run.";
  add_checkpoint(sentence);
  sentence.say();
}

/// The step is not over some time after SIGTERM.
void say_that_it_takes_long(int) {
  if (is_said != 0) return;
  is_said = 1;
  Sentence sentence;
  sentence << "\n"
           << speaker
           << ": asked to end by SIGTERM; a checkpoint follows this step if there is time for it.";
  add_checkpoint(sentence);
  sentence.say();
}

}  // namespace

int exchange_process_numbers(MPI_Comm world, Program program, int rank) {
  // Ranks of one node; containers on it may have process tables of their own. What a rank hears and
  // holds does not grow with the nodes.
  int world_rank = 0, size = 1;
  MPI_Comm_rank(world, &world_rank);
  MPI_Comm node = MPI_COMM_NULL;
  MPI_Comm_split_type(world, MPI_COMM_TYPE_SHARED, world_rank, MPI_INFO_NULL, &node);
  MPI_Comm_size(node, &size);
  Introduction mine{};
  machine_identity().copy(mine.machine.data(), mine.machine.size() - 1);
  mine.process = static_cast<std::int32_t>(::getpid());
  mine.program = static_cast<std::int32_t>(program);
  mine.rank = rank;
  std::vector<Introduction> all(static_cast<std::size_t>(size));
  MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all.data(), sizeof mine, MPI_BYTE, node);
  MPI_Comm_free(&node);
  neighbours.clear();
  int of_program = 0;
  for (const Introduction& other : all) {
    if (other.machine != mine.machine) continue;
    neighbours.push_back(
        {other.process,
         fmt::format("{}, rank {} (process {}),", program_name(static_cast<Program>(other.program)),
                     other.rank, other.process)});
    if (other.program == mine.program) ++of_program;
  }
  speaker = program_name(program);
  std::signal(silencing_signal(), [](int) { is_said = 1; });
  // No process reports before all others can be silenced.
  MPI_Barrier(world);
  return of_program;
}

void name_checkpoint(const std::string& folder) {
  const std::size_t next = 1 - shown;
  auto& text = checkpoints[next];
  text[folder.copy(text.data(), text.size() - 1)] = '\0';
  shown = next;
}

std::string last_checkpoint_sentence() {
  if (checkpoint().empty()) return "";
  return fmt::format(" The last checkpoint is {0}; go on with --restart {0}", checkpoint());
}

void silence_peers() {
  is_said = 1;
  for (const Neighbour& other : neighbours)
    if (other.process != ::getpid()) ::kill(other.process, silencing_signal());
}

bool is_silenced() { return is_said != 0; }

bool blame_dead_peers() {
  if (std::none_of(neighbours.begin(), neighbours.end(), is_dead)) return false;
  say_who_died();
  return true;
}

void report_dead_peers(bool writes_checkpoint) {
  const int error = errno;
  const auto is_me = [](const Neighbour& other) { return other.process == ::getpid(); };
  const auto me = std::find_if(neighbours.begin(), neighbours.end(), is_me);
  const bool first = std::all_of(neighbours.begin(), me, is_dead);
  if (std::any_of(neighbours.begin(), neighbours.end(), is_dead)) {
    if (first && is_said == 0) say_who_died();
    is_said = 1;
    // mpirun ends this process within a second; where it is not ended, it ends itself.
    std::signal(SIGALRM, SIG_DFL);
    ::alarm(3);
  } else if (writes_checkpoint && first) {
    std::signal(SIGALRM, say_that_it_takes_long);
    const itimerval most_of_a_second{{0, 0}, {0, 700'000}};
    ::setitimer(ITIMER_REAL, &most_of_a_second, nullptr);
  }
  errno = error;
}

void end_in_good_order() { is_said = 1; }

}  // namespace bedload
