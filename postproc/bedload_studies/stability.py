"""Hard cases over the time step and the knob that matters: pass, inaccurate, unstable, refused, stopped.

Every case has a criterion that can fail (hard_cases.py). The map goes to stability.csv, .png and .html
in the report's folder; runs that are in the table already are not repeated. With a SCENE: how far it is from
its own limits (stability_scene.py). A million steps of a small bed in single precision, with the drift of every
budget: `./bedload study budgets --steps 1000000`.
"""

import argparse
import csv
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from bedload_launcher import job
from bedload_launcher.errors import UserError, unknown
from bedload_launcher.machine import cores
from bedload_launcher.numbers import positive, whole
from bedload_launcher.scenes import Scene
from bedload_launcher.words import end_of, read_rows
from bedload_post.outputs import MissingOutput

from . import stability_scene
from .criteria import REFUSED, SEVERITY, STOPPED, UNSTABLE, Verdict
from .hard_cases import CASES, HardCase
from .runaway import without_cause
from .scene_answers import refuse_needless
from .stability_report import draw_map, write_report
from .trajectories import Trajectories

OF_A_SCENE = ("time", "model", "ranks", "set")
OF_CASES = ("case", "quick", "long", "again", "jobs")
TIMEOUT = 1800  # s: a run that hangs is a verdict too


@dataclass(frozen=True)
class Cell:
    """One run of the map."""

    case: str
    value: str
    courant: float
    precision: str
    verdict: str = ""
    number: float = float("nan")
    words: str = ""

    def key(self) -> tuple:
        return (self.case, self.value, self.courant, self.precision)


def kind_of_end(words: str) -> str:
    """A run that ended in a sentence: refused before its first step, stopped later, or blown up."""
    step = re.search(r"step (\d+)( \(t|:)", words)
    if step is None:
        refusals = ("'time.step'", "must be", "is stable only")
        return REFUSED if any(part in words for part in refusals) else UNSTABLE
    if "CFL" not in words:
        return UNSTABLE
    return REFUSED if int(step[1]) <= 1 else STOPPED


def run_cell(case: HardCase, value, courant: float, precision: str, folder: Path) -> Cell:
    """Writes the scene, runs it, judges it; the folder goes away."""
    small = case.scene(value, 1.0)  # the cell's size, to know the time step
    dt = courant * small.cell
    scene = case.scene(value, dt)
    scene.write(folder)
    ranks = job.Ranks(int(value) if case.knob == "fluid ranks" else 1, 1)
    keys = [f'accuracy.precision="{precision}"']
    work = job.Job(Scene(folder), scene.model, ranks, folder / "out", keys)
    (folder / "out").mkdir(exist_ok=True)
    cell = (case.name, str(value), courant, precision)
    limit = TIMEOUT * (20 if case.long else 1)
    try:
        done = subprocess.run(
            work.command(), cwd=folder, env=job.environment(), stdin=subprocess.DEVNULL,
            capture_output=True, text=True, timeout=limit, check=False,
            preexec_fn=job.dies_with_us(),
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return Cell(*cell, UNSTABLE, float("nan"), f"no end after {limit} s")
    if done.returncode != 0:
        words = end_of(done.stderr) or f"status {done.returncode}"
        kind = kind_of_end(words)
        if kind == STOPPED and (why := without_cause(folder / "out", scene)):
            kind, words = UNSTABLE, f"{why}; {words}"
        shutil.rmtree(folder)
        return Cell(*cell, kind, float("nan"), words)
    try:
        verdict: Verdict = case.judge(value, dt, Trajectories.of(folder / "out"))
    except MissingOutput as error:
        verdict = Verdict(UNSTABLE, float("nan"), str(error))
    shutil.rmtree(folder)
    return Cell(*cell, verdict.kind, verdict.number, verdict.words)


def plan(cases: list[HardCase], quick: bool) -> list[tuple]:
    """(case, value, courant, precision): the map in double, its middle column also in single."""
    cells: list[tuple] = []
    for case in cases:
        middle = case.courant[len(case.courant) // 2]
        for value in case.values:
            steps = [middle] if quick else case.courant
            cells += [(case, value, c, "double") for c in steps]
            if not quick:
                cells.append((case, value, middle, "single"))
    return cells


def read_table(file: Path) -> list[Cell]:
    if not file.is_file():
        return []
    return [
        Cell(
            row["case"], row["value"], float(row["courant"]), row["precision"], row["verdict"],
            float(row["number"]), row["words"],
        )
        for row in read_rows(file)
    ]  # fmt: skip


def write_table(file: Path, cells: list[Cell]) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(Cell.__dataclass_fields__), lineterminator="\n")
        table.writeheader()
        table.writerows(asdict(cell) for cell in cells)


def counted(cells: list[Cell]) -> str:
    """How many runs got which verdict, in one line."""
    kinds = [cell.verdict for cell in cells]
    parts = [f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys([*SEVERITY, STOPPED, REFUSED])]
    return f"{len(kinds)} runs: {', '.join(parts)}"


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?", metavar="SCENE", help="a scene's own limits (none: the hard cases)")
    parser.add_argument("--time", type=positive, metavar="T", help="of a SCENE's runs (default: sixty of its steps)")
    parser.add_argument("--model", help="of a SCENE: as for run")
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="of a SCENE: as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of a SCENE: as for run")
    parser.add_argument("--case", action="append", metavar="NAME", help="only this case; repeat")
    parser.add_argument("--quick", action="store_true", help="one time step a value, double only")
    parser.add_argument("--long", action="store_true", help="with the cases that take hours")
    parser.add_argument("--again", action="store_true", help="repeat what the table has already")
    parser.add_argument("--jobs", type=whole(1), metavar="N", help="runs at a time (default: cores)")
    parser.add_argument(
        "--out", type=Path, default=Path("runs/stability"), help="folder of the report"
    )
    parser.add_argument("--rewrite", type=Path, metavar="DIR", help="map of a kept report of the hard cases anew from "
                        "its numbers; nothing is run")  # fmt: skip


def run(options: argparse.Namespace) -> int:
    if options.rewrite is not None:
        if not (options.rewrite / "stability.csv").is_file():
            raise UserError(f"{options.rewrite} has no stability.csv.")
        draw_map(read_table(options.rewrite / "stability.csv"), options.rewrite / "stability.png")
        print(f"bedload: map anew in {options.rewrite}")
        return 0
    refuse_needless(options, OF_A_SCENE, OF_CASES, "the hard cases")
    if options.scene is not None:
        return stability_scene.run(options)
    for name in options.case or []:
        if name not in CASES:
            raise unknown("case", name, CASES)
    names = options.case or [name for name, case in CASES.items() if options.long or not case.long]
    cases = [CASES[name] for name in names]
    options.out.mkdir(parents=True, exist_ok=True)
    table = options.out / "stability.csv"
    done = {cell.key(): cell for cell in read_table(table)}

    def one(entry) -> Cell:
        case, value, courant, precision = entry
        key = (case.name, str(value), courant, precision)
        if key in done and not options.again:
            return done[key]
        folder = options.out / "runs" / "-".join(map(str, key))
        shutil.rmtree(folder, ignore_errors=True)
        return run_cell(case, value, courant, precision, folder.resolve())

    with ThreadPoolExecutor(options.jobs or cores()) as pool:
        for cell in pool.map(one, plan(cases, options.quick)):
            done[cell.key()] = cell
            print(
                f"{cell.case:14} {cell.value:>9} c = {cell.courant:<4g} {cell.precision} "
                f"{cell.verdict:10} {cell.number:.3g} {cell.words}",
                flush=True,
            )
            write_table(table, list(done.values()))
    write_report(options.out, list(done.values()))
    print(counted(list(done.values())))
    print(f"Report: {options.out / 'stability.html'}", file=sys.stderr)
    return 0
