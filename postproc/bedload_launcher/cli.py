"""The command line: subcommands, their options, and what each one does in a few calls."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from . import bench as measure
from . import bed_options, bench_bed, bench_effects, bench_table, job, presets, runs
from . import cost as predict
from . import lint as checks
from .build import FOLDER, ROOT, SANITIZERS, build
from .errors import UserError, no_option, refused, unknown
from .machine import available_memory, processors
from .numbers import finite, named, whole
from .scenes import DEFAULT, all_scenes, choose_model, find_scene, read_variables
from .studies import all_studies, run_study
from .words import plain, say

PYTHON = ["/usr/bin/python3", "-I", "-B"]


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence and points to --help."""

    def error(self, message: str) -> NoReturn:
        raise UserError(f"{message} (see {self.prog} --help)")


def run(options: argparse.Namespace) -> int:
    ask = runs.Ask(
        options.scene, options.model, options.accuracy, options.set, options.var, options.ranks,
        options.steps, options.out, options.restart,
    )  # fmt: skip
    status, out = runs.start(ask)
    if status != 0:
        return status
    return job.run(show_line(out, options.no_pictures, "--after-run"), Path.cwd())


def show_line(out: Path, no_pictures: bool, *more: str) -> list[str]:
    """The program that shows the result of a run."""
    line = [*PYTHON, str(ROOT / "postproc" / "show.py"), str(out), *more]
    return line + (["--no-pictures"] if no_pictures else [])


def show(options: argparse.Namespace) -> int:
    return job.run(show_line(options.out.resolve(), options.no_pictures), Path.cwd())


def film(options: argparse.Namespace) -> int:
    line = [f"--film={options.since!r}", "--frames", str(options.frames)]  # argparse takes a word -1e-05 for an option
    # Debian's VTK draws on a screen only; this one is virtual.
    return job.run(["xvfb-run", "-a", *show_line(options.out.resolve(), False, *line)], Path.cwd())


def lint(options: argparse.Namespace) -> int:
    if not options.quick:
        build(["bedload-fluid"])  # clang-tidy needs to know how files are compiled
    tidy = checks.with_ending(checks.tracked(), [".cpp"]) if options.all else options.tidy
    return min(1, checks.lint(tidy, options.quick))


def test(options: argparse.Namespace) -> int:
    build()
    if options.only is None:  # else the test builds it itself, without a progress line
        build(["tested_with_sanitizers"], folder=SANITIZERS)
    line = ["ctest", "--test-dir", str(FOLDER), "--output-on-failure", "--no-tests=error", "-j", str(processors())]
    return job.run(line + (["-R", options.only] if options.only else []), ROOT)


def build_all(options: argparse.Namespace) -> int:
    build(["bedload-fluid", "bedload-dem"] if options.portable else ["all"], options.portable)
    return 0


def scenes(_: argparse.Namespace) -> int:
    found = all_scenes()
    width = max(map(len, found), default=0)
    for name, scene in found.items():
        mark = "*" if name == DEFAULT else " "
        print(f"{mark} {plain(name):<{width}}  {plain(scene.summary())}")
    return 0


def bench(options: argparse.Namespace) -> int:
    steps, ranks = all_scenes(), job.Ranks.parse(options.ranks)
    known = {*measure.kernel_names(), *steps, "bed", "effects"}
    if options.name is not None and options.name not in known:
        raise unknown("benchmark", options.name, known)
    if options.table and options.name != "fluid":
        raise UserError("--table is there for `./bedload bench fluid` alone.")
    build()
    job.warn_of_crowding(ranks)
    for name, program in measure.programs().items():
        if options.name not in (None, name):
            continue
        records = []
        for record in measure.kernels(program, ranks):
            measure.print_record(record)
            records.append(record)
        if options.table:
            print(bench_table.fluid(records))
    for name, scene in steps.items():
        if options.name == name or (options.name is None and "/" not in name):  # no validation/...
            measure.print_record(measure.whole_step(scene, ranks))
    for name, rows in (("bed", bench_bed.rows), ("effects", bench_effects.rows)):
        if options.name in (None, name):
            for record in rows(ranks):
                measure.print_record(record)
    return 0


def estimate(options: argparse.Namespace) -> int:
    scene = find_scene(options.scene)
    model = choose_model(scene, options.model)
    ranks = job.Ranks.parse(options.ranks, scene)
    settings = presets.settings_of(options.accuracy, scene, options.set, model)
    variables = read_variables(scene, model, options.var)
    build(["bedload-fluid", "bedload-dem"] if scene.moves_grains else ["bedload-fluid"])
    job.warn_of_crowding(ranks)
    whole = job.Job(scene, model, ranks, scene.folder, settings, variables=variables)
    cost = predict.estimate(whole, scene.cells(settings), say)
    print(predict.describe(cost, ranks, scene.moves_grains, available_memory()))
    if errors := presets.errors_to_expect(scene, model, options.accuracy, settings):
        print(f"errors found   {errors} (postproc/reports/accuracy); this scene's own: ./bedload study accuracy SCENE")
    return 0


def settle(options: argparse.Namespace) -> int:
    build(["bedload-fluid", "bedload-dem"] if options.wet else ["bedload-dem"])
    from bedload_studies import bed_settling  # needs numpy, which may just have been installed

    return bed_settling.settle(options)


def study(options: argparse.Namespace) -> int:
    studies = all_studies()
    if options.name is None:
        width = max(map(len, studies), default=0)
        for name, sentence in studies.items():
            print(f"  {name:<{width}}  {sentence}")
        return 0
    if options.name not in studies:
        raise unknown("study", options.name, studies)
    return run_study(
        options.name, options.arguments,
        lambda prog, text: Parser(prog=prog, description=text, allow_abbrev=False), build,
    )  # fmt: skip


def add_run_options(sub: Parser) -> None:
    sub.add_argument(
        "scene", nargs="?", metavar="SCENE",
        help=f"a name from `bedload scenes`, or a folder with a fluid.toml (default: {DEFAULT}, with "
        "--restart the run's own)",
    )  # fmt: skip
    sub.add_argument(
        "--model",
        help="collision model: a file of inputs/models, or of the scene's own folder models, "
        "without its ending",
    )
    sub.add_argument(
        "--accuracy", metavar="PRESET",
        help="; ".join(f"{name}: {sentence}" for name, sentence in presets.SENTENCES.items()),
    )  # fmt: skip
    sub.add_argument(
        "--ranks", metavar="FLUID:DEM",
        help="MPI ranks of the fluid and of LIGGGHTS (default: every core, and 1 that sleeps)",
    )  # fmt: skip
    sub.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE",
        help="a value of fluid.toml for this run, for instance time.end=20; may be repeated",
    )  # fmt: skip
    sub.add_argument(
        "--var", action="append", default=[], metavar="NAME=VALUE",
        help="a variable of in.liggghts, or of a script that it includes; may be repeated",
    )  # fmt: skip
    sub.add_argument("--steps", type=whole(0), metavar="N", help="stop after N fluid steps")
    sub.add_argument(
        "--out", type=named, metavar="DIR", help="output folder (default: runs/SCENE-MODEL)"
    )
    sub.add_argument(
        "--restart", type=named, metavar="DIR",
        help="go on from a checkpoint, or from the last one in the run's folder DIR; without --out "
        "the run goes on there; scene, --set, --var and --accuracy are the run's own where nothing else "
        "is said, and the model stays",
    )  # fmt: skip
    sub.add_argument("--no-pictures", action="store_true", help="numbers only at the end")


def add_estimate_options(sub: Parser) -> None:
    sub.add_argument("scene", nargs="?", default=DEFAULT, metavar="SCENE", help="as for run")
    sub.add_argument("--model", help="as for run")
    sub.add_argument("--accuracy", metavar="PRESET", help="as for run")
    sub.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    sub.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")
    sub.add_argument("--var", action="append", default=[], metavar="NAME=VALUE", help="as for run")


def parser() -> tuple[Parser, dict[str, Parser]]:
    """The parser and its subcommands by name."""
    top = Parser(
        prog="bedload",
        description="Grains on the bed of a turbulent open channel: installs what is missing, "
        "builds, and then does one of these.",
        epilog="Begin with `./bedload run`; README.md shows the way to a scene of one's own, "
        "inputs/KEYS.md all that a scene's fluid.toml may say.",
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name: str, action, sentence: str) -> Parser:
        sub = commands.add_parser(name, help=sentence, description=sentence, allow_abbrev=False)
        sub.set_defaults(action=action)
        return sub

    add_run_options(command("run", run, "run a scene and show the result"))
    add_estimate_options(command("estimate", estimate, "say what a scene needs in memory and time before it is run"))

    sub = command("show", show, "make pictures, numbers and report of a run's output folder again")
    sub.add_argument(
        "out", type=named, metavar="OUT", help="output folder of a run, or a folder of kept results"
    )
    sub.add_argument("--no-pictures", action="store_true", help="numbers and report only")

    sub = command("film", film, "make film.mp4 of a run's moving grains")
    sub.add_argument("out", type=named, metavar="OUT", help="output folder of a run")
    sub.add_argument("--since", type=finite, default=0.0, metavar="T", help="from this time on (default: 0)")
    sub.add_argument("--frames", type=whole(1), default=250, metavar="N", help="at most (default: 250)")

    sub = command("lint", lint, "let clang-format, flake8, mypy and clang-tidy look at the sources")
    sub.add_argument("--quick", action="store_true", help="without clang-tidy")
    sub.add_argument("--tidy", nargs="+", metavar="FILE", help="these for clang-tidy (default: what changed)")
    sub.add_argument("--all", action="store_true", help="every file for clang-tidy: half an hour")

    sub = command("build", build_all, "install what is missing and build, for nothing else yet")
    sub.add_argument("--portable", action="store_true", help="the programs alone, for other processors too")

    sub = command("test", test, "build everything and pass the tests")
    sub.add_argument("--only", metavar="REGEX", help="only the tests whose name matches")

    command("scenes", scenes, "list the scenes, one line each (* is the default)")

    sub = command("bench", bench, "run the benchmarks, one line of JSON per measurement")
    sub.add_argument(
        "name", nargs="?", metavar="NAME", help="only this one: a kernel, or a scene's time step"
    )
    sub.add_argument("--ranks", metavar="FLUID:DEM", help="MPI ranks (default: every core)")
    sub.add_argument("--table", action="store_true", help="of `fluid`, the table of its README behind them")

    sub = command("settle", settle, "let a bed settle from a rain of grains, for a scene's script to read")
    bed_options.add_options(sub)

    sub = command("study", study, "run a series of runs that answers one question, and its report")
    sub.add_argument("name", nargs="?", metavar="NAME", help="which one (none: list them)")
    sub.add_argument(
        "arguments", nargs=argparse.REMAINDER, metavar="...",
        help="the study's own options (`./bedload study NAME --help` lists them)",
    )  # fmt: skip
    return top, commands.choices


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Options of the line; unknown commands and options are refused with the nearest name."""
    top, commands = parser()
    if arguments and arguments[0] == "help":
        arguments = [*arguments[1:2], "--help"]
    if not arguments:
        top.print_help()
        sys.exit(0)
    if not arguments[0].startswith("-") and arguments[0] not in commands:
        raise unknown("command", arguments[0], commands)
    options, left_over = top.parse_known_args(arguments)
    if left_over:
        raise no_option(f"bedload {options.command}", left_over[0], commands[options.command]._option_string_actions)
    return options


def check_names(options: argparse.Namespace) -> None:
    """Refuses a scene or a study that does not exist."""
    if getattr(options, "scene", None) is not None:
        find_scene(options.scene)
    if options.action is study and options.name is not None and options.name not in all_studies():
        raise unknown("study", options.name, all_studies())


def main() -> int:
    os.environ.update(job.environment())
    options = argparse.Namespace()
    try:
        options = parse(sys.argv[1:])
        only_read = os.environ.pop("BEDLOAD_ONLY_READ", None)  # by the script that installs packages
        if only_read and options.action is not scenes:
            check_names(options)
            return int(only_read)
        return options.action(options)
    except UserError as error:
        print(f"bedload: {error}", file=sys.stderr)
        return 2
    except OSError as error:  # a full disk, a folder that may not be written, a file in a folder's place
        print(f"bedload: {plain(refused(error, getattr(options, 'out', None)))}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
