"""The command line: subcommands, their options, and what each one does in a few calls."""

import argparse
import difflib
import os
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from . import accuracy
from . import bench as measure
from . import bench_bed, bench_effects
from . import estimate as predict
from . import job
from .build import FOLDER, ROOT, build
from .errors import UserError, unknown
from .machine import available_memory, processors
from .scenes import DEFAULT, all_scenes, choose_model, find_scene, read_variables
from .studies import all_studies, run_study
from .words import say

MODEL_FILE = "model.txt"  # in a run's folder
PYTHON = ["/usr/bin/python3", "-I", "-B"]


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence and points to --help."""

    def error(self, message: str) -> NoReturn:
        raise UserError(f"{message} (see {self.prog} --help)")


def previous_of(out: Path) -> Path:
    """Where an earlier run in `out` moves to."""
    return out.with_name(out.name + ".previous")


def claim_output(out: Path) -> None:
    """Makes room for a new run: an earlier run there moves to `<out>.previous` (one is kept).

    Raises UserError when the folder holds something that is no run.
    """
    if not out.exists() or all(file.name == MODEL_FILE for file in out.iterdir()):
        return  # nothing there, or a run that never began
    if not (out / "settings.toml").is_file():
        raise UserError(f"{out} is not empty and holds no earlier run; name another with --out.")
    previous = previous_of(out)
    if previous.exists():
        if not (previous / "settings.toml").is_file():
            raise UserError(f"{previous} is in the way and holds no earlier run; move it aside.")
        # Only what was once a run's output folder is ever removed.
        subprocess.run(["rm", "-rf", "--", str(previous)], check=True)
    out.rename(previous)


def run_folder(restart: Path) -> Path:
    """The folder of the run that `--restart` names, itself or by one of its checkpoints."""
    return restart.parent if restart.name.startswith("checkpoint_") else restart


def last_checkpoint(out: Path) -> Path | None:
    """The newest checkpoint of the run in `out`."""
    return max(out.glob("checkpoint_" + "[0-9]" * 8), default=None)


def check_restart(restart: Path, out: Path) -> None:
    """Refuses what holds no checkpoint, and a run that making room in `out` would remove."""
    folder = run_folder(restart)
    if not restart.is_dir() or (restart == folder and last_checkpoint(folder) is None):
        raise UserError(f"--restart {restart}: is neither a checkpoint nor a run that holds one.")
    if folder != out and folder == previous_of(out):
        raise UserError(
            f"--restart names {folder}, the place for an earlier run of {out}; "
            "go on without --out, or name another."
        )


def record_model(out: Path, model: str | None) -> None:
    """Notes the collision model beside the run's files, for the one that goes on from there."""
    if model:
        (out / MODEL_FILE).write_text(model + "\n", encoding="utf-8")


def recorded_model(restart: Path | None) -> str | None:
    """The model of the run that `--restart` names, where it is noted."""
    file = run_folder(restart) / MODEL_FILE if restart else None
    return file.read_text(encoding="utf-8").strip() if file and file.is_file() else None


def go_on(options: argparse.Namespace, out: Path) -> str:
    """How to go on with the run in `out`: what was said about it has to be said again."""
    last = last_checkpoint(out)
    if last is None:
        return ""
    words = ["--accuracy", options.accuracy] if options.accuracy else []
    for name, values in (("--set", options.set), ("--var", options.var)):
        words += [word for value in values for word in (name, value)]
    return f"; go on with {shlex.join([*words, '--restart', str(last)])}"


def run(options: argparse.Namespace) -> int:
    scene = find_scene(options.scene)
    restart = options.restart and options.restart.resolve()
    model = choose_model(scene, options.model or recorded_model(restart))
    settings = accuracy.settings_of(options.accuracy, scene, options.set)
    variables = read_variables(scene, model, options.var)
    name = "-".join(filter(None, (scene.name, model, options.accuracy)))
    out = (options.out or (run_folder(restart) if restart else Path("runs") / name)).resolve()
    ranks = job.Ranks.parse(options.ranks)
    if restart:
        check_restart(restart, out)
    build(["bedload-fluid", "bedload-dem"] if scene.moves_grains else ["bedload-fluid"])
    if restart and run_folder(restart) == out:
        job.keep_part(out)
    else:
        claim_output(out)
    out.mkdir(parents=True, exist_ok=True)
    record_model(out, model)
    work = job.Job(scene, model, ranks, out, settings, options.steps, variables, restart)
    print(f"bedload: {work.summary()}; output in {out}", flush=True)
    status = job.run(work.command(), scene.folder)
    if status != 0:
        print(
            f"bedload: the run ended with status {status}; its output is {out}{go_on(options, out)}",
            file=sys.stderr,
        )
        return status
    show = [*PYTHON, str(ROOT / "postproc" / "show.py"), str(out), "--after-run"]
    return job.run(show + (["--no-pictures"] if options.no_pictures else []), Path.cwd())


def test(options: argparse.Namespace) -> int:
    build()
    line = ["ctest", "--test-dir", str(FOLDER), "--output-on-failure", "-j", str(processors())]
    return job.run(line + (["-R", options.only] if options.only else []), ROOT)


def scenes(_: argparse.Namespace) -> int:
    found = all_scenes()
    width = max(map(len, found), default=0)
    for name, scene in found.items():
        mark = "*" if name == DEFAULT else " "
        print(f"{mark} {name:<{width}}  {scene.summary()}")
    return 0


def bench(options: argparse.Namespace) -> int:
    build()
    kernels, steps = measure.programs(), all_scenes()
    ranks = job.Ranks.parse(options.ranks)
    known = {*kernels, *steps, "bed", "effects"}
    if options.name is not None and options.name not in known:
        raise unknown("benchmark", options.name, known)
    for name, program in kernels.items():
        if options.name in (None, name):
            for record in measure.kernels(program, ranks):
                measure.print_record(record)
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
    ranks = job.Ranks.parse(options.ranks)
    settings = accuracy.settings_of(options.accuracy, scene, options.set)
    build(["bedload-fluid", "bedload-dem"] if scene.moves_grains else ["bedload-fluid"])
    cost = predict.estimate(scene, model, ranks, settings, scene.cells(settings), say)
    print(predict.describe(cost, ranks, scene.moves_grains, available_memory()))
    errors = accuracy.measured_errors(options.accuracy or "standard")
    if errors and scene.moves_grains:
        print(
            f"errors found   {', '.join(errors)}, with ten cells to a diameter before the preset "
            "(postproc/reports/accuracy)"
        )
    return 0


def study(options: argparse.Namespace) -> int:
    studies = all_studies()
    if options.name is None:
        width = max(map(len, studies), default=0)
        for name, sentence in studies.items():
            print(f"  {name:<{width}}  {sentence}")
        return 0
    if options.name not in studies:
        raise unknown("study", options.name, studies)
    build()
    return run_study(
        options.name, options.arguments, lambda prog, text: Parser(prog=prog, description=text)
    )


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

    sub = command("run", run, "run a scene and show the result")
    sub.add_argument(
        "scene", nargs="?", default=DEFAULT, metavar="SCENE",
        help=f"a name from `bedload scenes`, or a folder with a fluid.toml (default: {DEFAULT})",
    )  # fmt: skip
    sub.add_argument(
        "--model",
        help="collision model: a file of inputs/models, or of the scene's own folder models, "
        "without its ending",
    )
    sub.add_argument(
        "--accuracy", metavar="PRESET",
        help="; ".join(f"{name}: {p.sentence}" for name, p in accuracy.PRESETS.items()),
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
    sub.add_argument("--steps", type=int, metavar="N", help="stop after N fluid steps")
    sub.add_argument(
        "--out", type=Path, metavar="DIR", help="output folder (default: runs/SCENE-MODEL)"
    )
    sub.add_argument(
        "--restart", type=Path, metavar="DIR",
        help="go on from a checkpoint, or from the last one in the run's folder DIR; without --out "
        "the run goes on there; takes the model from there, but not --set, --var and --accuracy",
    )  # fmt: skip
    sub.add_argument("--no-pictures", action="store_true", help="numbers only at the end")

    sub = command("estimate", estimate, "say what a scene needs in memory and time before it is run")
    sub.add_argument("scene", nargs="?", default=DEFAULT, metavar="SCENE", help="as for run")
    sub.add_argument("--model", help="as for run")
    sub.add_argument("--accuracy", metavar="PRESET", help="as for run")
    sub.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    sub.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")

    sub = command("test", test, "build everything and pass the tests")
    sub.add_argument("--only", metavar="REGEX", help="only the tests whose name matches")

    command("scenes", scenes, "list the scenes, one line each (* is the default)")

    sub = command("bench", bench, "run the benchmarks, one line of JSON per measurement")
    sub.add_argument(
        "name", nargs="?", metavar="NAME", help="only this one: a kernel, or a scene's time step"
    )
    sub.add_argument("--ranks", metavar="FLUID:DEM", help="MPI ranks (default: every core)")

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
    if not arguments:
        top.print_help()
        sys.exit(0)
    if not arguments[0].startswith("-") and arguments[0] not in commands:
        raise unknown("command", arguments[0], commands)
    options, left_over = top.parse_known_args(arguments)
    if left_over:
        known = [flag for flag in commands[options.command]._option_string_actions]
        near = difflib.get_close_matches(left_over[0].split("=")[0], known, n=1, cutoff=0.5)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise UserError(f"bedload {options.command} has no '{left_over[0]}'{hint}")
    return options


def main() -> int:
    os.environ.update(job.environment())
    try:
        options = parse(sys.argv[1:])
        return options.action(options)
    except UserError as error:
        print(f"bedload: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
