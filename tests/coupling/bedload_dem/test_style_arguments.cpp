// Every keyword of every style and command of ours, as declared: wrong type, out of range, missing,
// misspelt, and right. A keyword that is new is covered by itself; a style that is new has to say
// in `lines` how it is written. LIGGGHTS ends the process at an error, so each line is given to a
// forked copy.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <mpi.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "coupling/bedload_dem/register_coupling.hpp"
#include "input.h"
#include "lammps.h"
#include "liggghts_styles/register_styles.hpp"

__attribute__((visibility("default"))) void LAMMPS_NS::LAMMPS::post_create() {
  bedload::register_styles(this);
  bedload::register_coupling(this);
}

namespace bedload {
namespace {

using testing::HasSubstr;

/// What a script says before the lines under test.
constexpr const char* scene[] = {"atom_style granular",
                                 "atom_modify map array",
                                 "boundary f f f",
                                 "newton off",
                                 "communicate single vel yes",
                                 "units si",
                                 "region box block 0 1 0 1 0 1 units box",
                                 "create_box 1 box",
                                 "neighbor 0.1 bin"};

/// How a style is written, with the keywords at the end; more than one where more than one line
/// takes them.
const std::map<std::string, std::vector<std::string>> lines{
    {"normal model actm",
     {"pair_style gran model actm", "pair_style gran model actm tangential history",
      "fix w all wall/gran model actm primitive type 1 yplane 0"}},
    {"normal model rpm",
     {"pair_style gran model rpm", "fix w all wall/gran model rpm primitive type 1 yplane 0"}},
    {"tangential model haff_werner",
     {"pair_style gran model actm tangential haff_werner",
      "fix w all wall/gran model rpm tangential haff_werner primitive type 1 yplane 0"}},
    {"fix lubrication", {"fix f all lubrication"}},
    {"fix collision/table", {"fix t all collision/table file table.csv"}},
    {"plugin", {"plugin"}},
    {"fix couple/fluid", {"fix c all couple/fluid"}},
    {"coupled_run", {"coupled_run"}}};

/// The complaint that follows where the arguments are right: what the styles of a coupled run lack
/// here.
const std::map<std::string, std::string> complaint_behind{
    {"fix couple/fluid", "this job has no fluid"},
    {"coupled_run", "coupled_run needs a fix couple/fluid"},
    {"plugin", "plugin: there is no file"}};

class Liggghts {
 public:
  Liggghts() {
    std::array<std::string, 5> words{"test", "-log", "none", "-screen", "none"};
    std::array<char*, 5> arguments{};
    for (std::size_t n = 0; n < words.size(); ++n) arguments[n] = words[n].data();
    lammps_ =
        new LAMMPS_NS::LAMMPS(static_cast<int>(words.size()), arguments.data(), MPI_COMM_WORLD);
    for (const char* line : scene) lammps_->input->one(line);
  }
  ~Liggghts() { delete lammps_; }
  Liggghts(const Liggghts&) = delete;
  Liggghts& operator=(const Liggghts&) = delete;

  /// What a copy of this LIGGGHTS says to `line`: its error, "" when it takes the line, or how it
  /// died.
  std::string answer(const std::string& line) const {
    std::array<int, 2> pipe_ends{};
    if (pipe(pipe_ends.data()) != 0) return "no pipe";
    const pid_t child = fork();
    if (child == 0) {
      close(pipe_ends[0]);
      lammps_->screen = fdopen(pipe_ends[1], "w");
      setvbuf(lammps_->screen, nullptr, _IOLBF, 1 << 16);
      end_at_finalize();
      lammps_->input->one(line.c_str());
      std::fflush(lammps_->screen);
      _exit(0);
    }
    close(pipe_ends[1]);
    std::string text;
    std::array<char, 4096> block{};
    for (ssize_t n = 0; (n = read(pipe_ends[0], block.data(), block.size())) > 0;)
      text.append(block.data(), static_cast<std::size_t>(n));
    close(pipe_ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) return "died of signal " + std::to_string(WTERMSIG(status));
    std::string errors;
    std::istringstream rows(text);
    for (std::string row; std::getline(rows, row);)
      if (row.find("ERROR") != std::string::npos) errors += (errors.empty() ? "" : "\n") + row;
    if (errors.empty() && WEXITSTATUS(status) != 0) return "ended without a word";
    return errors;
  }

 private:
  /// LIGGGHTS ends on errors by MPI_Finalize, which a forked process must not come to.
  static void end_at_finalize() {
    int key = MPI_KEYVAL_INVALID;
    MPI_Comm_create_keyval(
        MPI_COMM_NULL_COPY_FN,
        [](MPI_Comm, int, void*, void*) -> int {
          std::fflush(nullptr);
          _exit(1);
        },
        &key, nullptr);
    MPI_Comm_set_attr(MPI_COMM_SELF, key, nullptr);
  }

  LAMMPS_NS::LAMMPS* lammps_;
};

std::vector<StyleHelp> all_styles() {
  std::vector<StyleHelp> all = styles();
  for (const StyleHelp& style : coupling_styles()) all.push_back(style);
  return all;
}

/// Three misspellings, each one edit away: a letter less, one doubled, one changed.
std::vector<std::string> misspelt(const std::string& name) {
  std::vector<std::string> all{name, name, name};
  all[0].erase(name.size() / 2, 1);
  all[1].insert(name.size() / 2, 1, name[name.size() / 2]);
  all[2].back() = '_';
  return all;
}

class StyleArguments : public testing::Test {
 protected:
  /// One sentence that names the words.
  void expect_refused(const std::string& line, const std::vector<std::string>& words) {
    SCOPED_TRACE(line);
    const std::string said = liggghts_->answer(line);
    ++cases_;
    EXPECT_THAT(said, HasSubstr("ERROR"));
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    for (const std::string& word : words) EXPECT_THAT(said, HasSubstr(word));
  }

  void expect_taken(const std::string& style, const std::string& line) {
    SCOPED_TRACE(line);
    const std::string said = liggghts_->answer(line);
    ++cases_;
    const auto behind = complaint_behind.find(style);
    if (behind == complaint_behind.end())
      EXPECT_EQ(said, "");
    else
      EXPECT_THAT(said, HasSubstr(behind->second));
  }

  void expect_unknown(const std::string& line, const std::string& name) {
    for (const std::string& wrong : misspelt(name))
      expect_refused(line + " " + wrong + " 1",
                     {"'" + wrong + "'", "the nearest is '" + name + "'"});
  }

  static void SetUpTestSuite() { liggghts_ = std::make_unique<Liggghts>(); }
  static void TearDownTestSuite() { liggghts_.reset(); }

  inline static std::unique_ptr<Liggghts> liggghts_;
  int cases_ = 0;
};

TEST_F(StyleArguments, Numbers) {
  for (const StyleHelp& style : all_styles()) {
    const std::string name(style.name);
    ASSERT_TRUE(lines.contains(name)) << "say in `lines` how " << name << " is written";
    for (const std::string& line : lines.at(name))
      for (const NumberKeyword& number : style.numbers) {
        const std::string keyword(number.name), behind = line + " " + keyword;
        const std::string subject = name + ": " + keyword;
        for (const char* text : {"ten", "3x", "0x", "1,5", "nan", "inf", "-inf", "1e999", "-", "."})
          expect_refused(behind + " " + text,
                         {subject + " needs a number", "'" + std::string(text) + "'"});
        expect_refused(behind, {subject + " needs a number behind it"});

        const std::string allowed = "has to be " + allowed_text(number);
        const auto with = [&](double value) { return fmt::format("{} {}", behind, value); };
        expect_refused(with(number.lower - 1),
                       {subject, allowed, fmt::format("found {}", number.lower - 1)});
        expect_refused(with(-1e300), {subject, allowed});
        if (number.or_equal)
          expect_taken(name, with(number.lower));
        else
          expect_refused(with(number.lower), {subject, allowed});
        if (std::isfinite(number.upper)) {
          expect_taken(name, with(number.upper));
          expect_refused(with(2 * number.upper), {subject, allowed});
        }
        if (number.whole) expect_refused(with(number.lower + 1.5), {subject, allowed});
        expect_taken(name, with(std::min(number.lower + 1, number.upper)));
        expect_unknown(line, keyword);
      }
  }
  EXPECT_GT(cases_, 300);
}

TEST_F(StyleArguments, Words) {
  for (const StyleHelp& style : all_styles())
    for (const WordKeyword& word : style.words) {
      const std::string name(style.name), keyword(word.name);
      const std::string line = lines.at(name).front();
      expect_refused(line + " " + keyword, {name + ": " + keyword + " needs a word behind it"});
      expect_unknown(line, keyword);
    }
  expect_refused("plugin", {"plugin needs the keyword 'load <file>'"});
  expect_refused("plugin load none.so", {"there is no file", "none.so"});
  expect_refused("fix t all collision/table every 10", {"needs the keyword 'file <name>'"});
  expect_refused("fix c all couple/fluid fixed nobody", {"the group 'nobody'"});
  expect_refused("fix c all couple/fluid fixed all fixed all", {"fixed stands there twice"});
  expect_taken("fix couple/fluid", "fix c all couple/fluid fixed all");
}

/// Keywords of several models, LIGGGHTS' own among them, in one line.
TEST_F(StyleArguments, OfSeveralModels) {
  const std::string pair =
      "pair_style gran model actm tangential haff_werner rolling_friction epsd2";
  expect_taken("", pair + " stickAfter 3 collisionSteps 8 torsionTorque on");
  expect_refused(pair + " collisionSteps 8 torsionTorqe on",
                 {"'torsionTorqe'", "the nearest is 'torsionTorque'"});
  expect_refused("pair_style gran model actm collisionSteps 8 tangential haff_werner",
                 {"'tangential' comes too late"});
  expect_refused("pair_style gran model rpm collisionSteps 8 criticalStokes 5",
                 {"'criticalStokes'", "range", "strength"});
}

}  // namespace
}  // namespace bedload

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  const int failed = RUN_ALL_TESTS();
  MPI_Finalize();
  return failed;
}
