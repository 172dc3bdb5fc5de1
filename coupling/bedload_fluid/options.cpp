#include "coupling/bedload_fluid/options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include "coupling/version.hpp"
#include "fluid/checkpoint/checkpoint_store.hpp"
#include "fluid/settings/errors.hpp"
#include "fluid/settings/nearest_name.hpp"
#include "fluid/settings/settings.hpp"

namespace bedload {
namespace {

/// runs/<scene> under the folder that the command is typed in; the scene is the folder of
/// fluid.toml.
std::string default_output(const std::string& file) {
  const std::filesystem::path scene = std::filesystem::absolute(file).parent_path().filename();
  return (std::filesystem::path("runs") / scene).string();
}

/// The output folder of the run that `--restart` names, itself or one of its checkpoints.
std::string run_of_checkpoint(const std::string& where) {
  return std::filesystem::path(locate_checkpoint(where).folder).parent_path().string();
}

/// Empty where `word` is a whole number from 0 on, else what is wrong with it.
std::string count_error(const std::string& word) {
  const char* const end = word.data() + word.size();
  std::int64_t number = 0;
  const auto [stop, error] = std::from_chars(word.data(), end, number);
  if (error == std::errc() && stop == end && number >= 0) return {};
  return fmt::format("is {}, but must be a whole number, at least 0", word);
}

/// Throws for the first word that is no option, with the nearest one.
void check_words(const CLI::App& app) {
  const std::vector<std::string> more = app.remaining();
  if (more.empty()) return;
  std::set<std::string> known;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) known.insert("--" + name);
  const auto option = std::find_if(more.begin(), more.end(),
                                   [](const std::string& word) { return word.starts_with("-"); });
  if (option == more.end())
    throw UserError(fmt::format(
        "'{}' is one word too many: one fluid.toml (bedload-fluid --help lists the options)",
        more.front()));
  throw UserError(
      fmt::format("there is no option '{0}'; the nearest is '{1}' (bedload-fluid --help lists all)",
                  *option, nearest(option->substr(0, option->find('=')), known)));
}

/// Throws where options contradict each other.
void check_together(const FluidOptions& options) {
  if (options.steps > 0 && options.warm_up >= options.steps)
    throw UserError(fmt::format(
        "--warm-up {} leaves none of the --steps {} for the table of times; take fewer.",
        options.warm_up, options.steps));
  std::error_code error;  // a folder that is not there yet is another one
  if (options.overwrite && !options.restart.empty() &&
      std::filesystem::equivalent(options.out, run_of_checkpoint(options.restart), error))
    throw UserError(fmt::format(
        "--overwrite removes the checkpoints of {}, from which --restart goes on; leave out one of "
        "them.",
        options.out));
}

}  // namespace

std::optional<FluidOptions> read_fluid_options(int argc, char** argv, bool first_rank) {
  FluidOptions options;
  bool keys = false;
  bool show_version = false;
  CLI::App app(
      "The fluid of bedload: a channel solver with resolved spheres. Alone it runs a flow "
      "without grains; with bedload-dem in the same MPI job the grains move:\n"
      "  mpirun -np N bedload-fluid fluid.toml : -np M bedload-dem -in in.liggghts",
      "bedload-fluid");
  app.add_option("file", options.file, "The scene: fluid.toml");
  app.add_option("--set", options.settings, "A value for this run, written as in TOML: time.end=20")
      ->allow_extra_args(false);
  app.add_option("--out", options.out,
                 "Folder of the output (default: runs/<folder of fluid.toml>)");
  app.add_option("--restart", options.restart,
                 "Go on from a checkpoint, or from the last one in a run's folder; without --out "
                 "the run goes on in that folder");
  app.add_flag("--overwrite", options.overwrite,
               "Begin in a folder that holds the checkpoints of another run, which are removed");
  app.add_option("--steps", options.steps, "Stop after this many time steps")->check(count_error);
  app.add_option("--warm-up", options.warm_up, "Leave the first N steps out of the table of times")
      ->check(count_error);
  app.add_flag("--without-grains", options.without_grains,
               "Run a scene with a LIGGGHTS script (in.liggghts) as a flow without its grains");
  app.add_flag(
      "--bandwidth", options.bandwidth,
      "At the end measure the memory's bandwidth beside that of the solver's phases (takes "
      "0.6 GB for half a second)");
  CLI::Option* const compact =
      app.add_option("--compact-state", options.compact,
                     "Make of the first file, a state.h5, the second, which must not be there: a "
                     "small start field (every second cell, 16 bits); no run")
          ->expected(2);
  for (CLI::Option* const other : app.get_options())
    if (other != compact && other != app.get_help_ptr()) compact->excludes(other);
  app.allow_extras();
  app.add_flag("--help-keys", keys, "Print what fluid.toml may say");
  app.add_flag("--version", show_version, "Print the version");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    if (first_rank) fmt::print("{}", app.help());
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UserError(fmt::format("{} (bedload-fluid --help lists the options)", error.what()));
  }
  check_words(app);
  if (show_version && first_rank) fmt::print("bedload-fluid {}\n", version);
  if (keys && first_rank) fmt::print("{}", describe_keys());
  if (show_version || keys) return std::nullopt;
  if (!options.compact.empty()) return options;
  if (options.file.empty())
    throw UserError("the scene is missing: bedload-fluid fluid.toml (bedload-fluid --help).");
  if (options.out.empty())
    options.out =
        options.restart.empty() ? default_output(options.file) : run_of_checkpoint(options.restart);
  check_together(options);
  return options;
}

}  // namespace bedload
