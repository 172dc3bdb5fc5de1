// bedload-dem: LIGGGHTS with our styles. Beside bedload-fluid in one MPI job it moves the grains in
// the fluid; alone it is plain LIGGGHTS for any script.

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coupling/bedload_dem/attach.hpp"
#include "coupling/bedload_dem/command_line.hpp"
#include "coupling/bedload_dem/inputs_folder.hpp"
#include "coupling/bedload_dem/liggghts_screen.hpp"
#include "coupling/bedload_dem/register_coupling.hpp"
#include "coupling/bedload_dem/written_files.hpp"
#include "coupling/exchange/dem_side.hpp"
#include "coupling/job/peer_failure.hpp"
#include "coupling/job/roles.hpp"
#include "coupling/job/signals.hpp"
#include "coupling/version.hpp"
#include "fluid/checkpoint/checkpoint_store.hpp"
#include "fluid/files/collectively.hpp"
#include "fluid/settings/errors.hpp"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/liggghts_program.hpp"
#include "liggghts_styles/register_styles.hpp"
#include "signal_handling.h"

// LIGGGHTS calls this when it starts and after `clear`, which forgets fix styles.
__attribute__((visibility("default"))) void LAMMPS_NS::LAMMPS::post_create() {
  bedload::register_styles(this);
  bedload::register_coupling(this);
}

namespace bedload {
namespace {

constexpr const char* early_end =
    "the LIGGGHTS script came to its end before the fluid did; it needs a fix couple/fluid and "
    "behind it coupled_run (without 'steps' for the last one).";

constexpr const char* own_screen_end =
    "LIGGGHTS has ended before the fluid did; its log and the file behind '-screen' say why.";

/// Ctrl-C, or a batch system's warning, lets plain LIGGGHTS end after its present step.
void handle_signals_as_liggghts_does() {
  std::signal(SIGINT, LAMMPS_NS::SignalHandler::int_handler);
  std::signal(SIGTERM, LAMMPS_NS::SignalHandler::int_handler);
  std::signal(SIGUSR1, LAMMPS_NS::SignalHandler::usr1_handler);
}

/// Speaks when LIGGGHTS ends the process on its own without having reported an error on a screen of
/// ours (`quit` in the script, or a screen of the user's choice): it calls MPI_Finalize, which
/// first asks for the attributes of MPI_COMM_SELF, the latest first; the one of LiggghtsProgram
/// then ends the job. Nothing is said of a `quit` behind the fluid's end.
class LastWord {
 public:
  LastWord(const LiggghtsScreen& screen, bool own_screen, std::function<bool()> is_over)
      : screen_(screen), own_screen_(own_screen), is_over_(std::move(is_over)) {
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, speak, &key_, nullptr);
    MPI_Comm_set_attr(MPI_COMM_SELF, key_, this);
  }
  ~LastWord() {
    silent_ = true;
    MPI_Comm_delete_attr(MPI_COMM_SELF, key_);
    MPI_Comm_free_keyval(&key_);
  }
  LastWord(const LastWord&) = delete;
  LastWord& operator=(const LastWord&) = delete;

 private:
  static int speak(MPI_Comm, int, void* self, void*) {
    const auto& word = *static_cast<LastWord*>(self);
    if (!word.silent_ && !word.screen_.saw_error() && !word.is_over_()) {
      silence_peers();
      std::fprintf(stderr, "\n%s: %s%s\n", program_name(Program::dem),
                   word.own_screen_ ? own_screen_end : early_end,
                   last_checkpoint_sentence().c_str());
    }
    return MPI_SUCCESS;
  }

  const LiggghtsScreen& screen_;
  bool own_screen_;
  std::function<bool()> is_over_;
  int key_ = MPI_KEYVAL_INVALID;
  bool silent_ = false;
};

constexpr const char* help =
    "bedload-dem: LIGGGHTS with bedload's contact models, lubrication and coupling to a fluid.\n"
    "  bedload-dem -in SCRIPT [-var NAME VALUE]...   any LIGGGHTS script, without a fluid\n"
    "  mpirun -np N bedload-fluid fluid.toml : -np M bedload-dem -in in.liggghts -var model actm\n"
    "\n"
    "  --help-styles   every keyword of our styles\n"
    "  --version       the version\n"
    "  -help           LIGGGHTS' own options and styles\n";

/// Whether only help was wanted, which is printed then.
bool print_help(const Job& job, int argc, char** argv) {
  if (!job.alone()) return false;
  for (const std::string_view word : std::span(argv + 1, argv + argc)) {
    if (word != "--help" && word != "--help-styles" && word != "--version") continue;
    std::string text = word == "--help" ? help : "";
    if (word == "--version") text = fmt::format("bedload-dem {}\n", version);
    if (word == "--help-styles")
      for (const auto& group : {styles(), coupling_styles()})
        for (const StyleHelp& style : group) text += describe_style(style);
    if (job.rank() == 0) std::fputs(text.c_str(), stdout);
    return true;
  }
  return false;
}

/// Adds the variables of the run that this one goes on from to the command line, and keeps both for
/// the next checkpoint. Waits for the fluid, which says whether there is such a run.
void take_variables(const Job& job, DemSide& side, std::vector<std::string>& words) {
  RunScript script = read_run_script(words);
  side.scene_info();
  if (!side.restart_file().empty())
    collectively(job.own(), [&] {
      const Hdf5File file(side.restart_file(), Hdf5File::Access::read, MPI_COMM_SELF);
      RunScript before;
      before.load(LoadGroup(file, grains_group).group("run_script"));
      const std::vector<std::string> more = missing_variables(before, script);
      words.insert(words.end(), more.begin(), more.end());
      script = read_run_script(words);
    });
  if (job.rank() == 0)
    for (const std::string& sentence : unused_variables(script))
      fmt::print(stderr, "bedload-dem: WARNING: {}.\n", sentence);
  if (job.rank() == 0 && !side.restart_file().empty())
    for (const std::string& sentence : keep_tables(script.tables))
      fmt::print("bedload-dem: NOTE: {}.\n", sentence);
  side.set_script(std::move(script));
}

int run_script(Job& job, int argc, char** argv) {
  if (print_help(job, argc, argv)) return 0;
  DemSide side(job);
  if (job.alone()) {
    handle_signals_as_liggghts_does();
  } else {
    leave_signals_to_partner();
    attach(job.own(), &side);
  }

  LiggghtsProgram program(job.own());
  {
    const bool own_screen = std::any_of(argv + 1, argv + argc, [](std::string_view word) {
      return word == "-screen" || word == "-sc";
    });
    LiggghtsScreen liggghts_screen(job.alone() ? stdout : nullptr);
    std::optional<LastWord> last_word;
    // Errors are seen on the first rank, on a screen of ours.
    const auto is_over = [&] {
      return side.stopped() && (job.rank() != 0 ||
                                (!own_screen && !liggghts_screen.saw_error() && !unwritten_file()));
    };
    if (!job.alone())
      program.ends_well_if([&] {
        if (!is_over()) return false;
        end_in_good_order();
        job.say_farewell();
        return true;
      });
    if (!job.alone() && job.rank() == 0) last_word.emplace(liggghts_screen, own_screen, is_over);
    std::string inputs = inputs_folder();
    const std::vector<char*> given = with_inputs(argc, argv, inputs);
    std::vector<std::string> texts(given.begin(), given.end() - 1);
    check_command_line(texts, !job.alone());
    if (!job.alone()) take_variables(job, side, texts);
    std::vector<char*> words;
    words.reserve(texts.size() + 1);
    for (std::string& text : texts) words.push_back(text.data());
    words.push_back(nullptr);
    LAMMPS_NS::LAMMPS lammps(static_cast<int>(texts.size()), words.data(), job.own());
    check_styles(&lammps);
    // LIGGGHTS writes what it says of a mesh to its screen without asking whether it has one.
    if (lammps.screen == nullptr && job.rank() == 0) lammps.screen = std::fopen("/dev/null", "w");
    if (!own_screen && lammps.screen != nullptr) {
      liggghts_screen.follow(&lammps);
      lammps.screen = liggghts_screen.stream();
    }
    lammps.input->file();
    liggghts_screen.follow(nullptr);
  }
  program.finish();
  if (const auto sentence = unwritten_file()) throw UserError(*sentence + ".");
  if (!job.alone() && !side.stopped()) throw UserError(early_end);
  return 0;
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  using namespace bedload;
  return run_program(argc, argv, Program::dem, exchange_protocol(),
                     [&](Job& job) { return run_script(job, argc, argv); });
}
