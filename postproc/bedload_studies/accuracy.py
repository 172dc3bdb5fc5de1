"""What accuracy costs: the error of cases with a known answer against core-seconds and memory.

One knob is turned at a time, then sensible pairs. Points that no other point beats in both error and
core-seconds form the front of best choices. The presets of `--accuracy` are measured among them; their
errors and prices are what `./bedload estimate` quotes. With a SCENE: the same for the scene's own answer
(accuracy_scene.py).
"""

import argparse
import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from bedload_launcher.errors import UserError, unknown
from bedload_launcher.job import Ranks
from bedload_launcher.numbers import positive
from bedload_launcher.words import read_rows

from . import accuracy_scene
from .accuracy_cases import CASES, PricedRunner, choices
from .accuracy_report import draw_cases, write_report
from .earlier_run import add_start_from
from .scene_answers import refuse_needless

OF_A_SCENE = ("hours", "quantity", "model", "ranks", "set", "start_from")
OF_CASES = ("case", "again")


@dataclass(frozen=True)
class Point:
    """One way to compute one case: its error (of 1) and its price."""

    case: str
    label: str
    knob: str
    error: float
    core_seconds: float
    megabytes: float
    interval: float = 0.0  # half width of the error of 1, where chance takes part in it


def measure(
    case: str, label: str, knob: str, n: float, settings: dict, options, made: set[Path]
) -> Point:
    """One point of a case; `made`: the runs that this study has made, which grow. The error of a run that the programs
    stop (a step too long for the flow, say) is no number."""
    folder = options.runs.resolve()
    name = f"{case}-{label}".replace(" ", "_").replace("/", "").replace(",", "")
    runner = PricedRunner(folder, Ranks.parse("1:1"), options.again, made=made)
    try:
        error = CASES[case].error(runner, name, n, settings)
    except UserError as stopped:
        print(f"bedload: {stopped}", flush=True)
        error = math.nan
    return Point(case, label, knob, error, runner.core_seconds, runner.megabytes, runner.interval)


def front(points: list[Point]) -> set[str]:
    """Labels of the points that none beats in both |error| and core-seconds."""
    good = [p for p in points if math.isfinite(p.error)]
    return {
        p.label
        for p in good
        if not any(
            abs(q.error) <= abs(p.error) and q.core_seconds <= p.core_seconds and q != p
            for q in good
        )
    }


def read_table(file: Path) -> list[Point]:
    if not file.is_file():
        return []
    return [
        Point(
            row["case"], row["label"], row["knob"], float(row["error"]),
            float(row["core_seconds"]), float(row["megabytes"]), float(row.get("interval") or 0.0),
        )
        for row in read_rows(file)
    ]  # fmt: skip


def write_table(file: Path, points: list[Point]) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, [*Point.__dataclass_fields__, "best"], lineterminator="\n")
        table.writeheader()
        for case in dict.fromkeys(p.case for p in points):
            mine = [p for p in points if p.case == case]
            best = front(mine)
            table.writerows(asdict(p) | {"best": int(p.label in best)} for p in mine)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", nargs="?", metavar="SCENE", help="a scene's own answer (none: the known cases)")
    parser.add_argument("--hours", type=positive, help="of a SCENE's runs together (default: 0.1); each choice "
                        "runs once whatever that takes")  # fmt: skip
    parser.add_argument("--quantity", metavar="NAME", help="of a SCENE: what is judged (default: grain velocity, "
                        "else driving force, else flow energy; any column of history.csv)")  # fmt: skip
    parser.add_argument("--model", help="of a SCENE: as for run")
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="of a SCENE: as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="of a SCENE: as for run")
    add_start_from(parser)
    parser.add_argument("--case", action="append", metavar="NAME", help=f"of {', '.join(CASES)}")
    parser.add_argument("--runs", type=Path, default=Path("runs/accuracy"), help="where runs go")
    parser.add_argument("--again", action="store_true", help="repeat what the table has already")
    parser.add_argument("--report", type=Path, help="folder of the report (default: RUNS/report)")
    parser.add_argument("--rewrite", type=Path, metavar="DIR", help="figures of a kept report of the known cases anew "
                        "from its numbers; nothing is run")  # fmt: skip


def rewrite(folder: Path) -> None:
    """Figures of a kept report of the known cases from its accuracy.csv."""
    draw_cases(read_table(folder / "accuracy.csv"), front, folder)


def run(options: argparse.Namespace) -> int:
    if options.rewrite is not None:
        if not (options.rewrite / "accuracy.csv").is_file():
            raise UserError(f"{options.rewrite} has no accuracy.csv.")
        rewrite(options.rewrite)
        print(f"bedload: figures anew in {options.rewrite}")
        return 0
    refuse_needless(options, OF_A_SCENE, OF_CASES, "the known cases")
    if options.scene is not None:
        return accuracy_scene.run(options)
    for name in options.case or []:
        if name not in CASES:
            raise unknown("case", name, CASES)
    report = options.report or options.runs / "report"
    report.mkdir(parents=True, exist_ok=True)
    cases = options.case or list(CASES)
    points = read_table(report / "accuracy.csv")
    if options.again:
        points = [p for p in points if p.case not in cases]
    made: set[Path] = set()
    for case in cases:
        for label, knob, n, settings in choices(case):
            if any(p.case == case and p.label == label for p in points):
                continue
            point = measure(case, label, knob, n, settings, options, made)
            points.append(point)
            print(
                f"{case:12} {label:18} error {100 * point.error:+7.2f} ± {100 * point.interval:.2f} %  "
                f"{point.core_seconds:8.1f} core-s {point.megabytes:7.0f} MB",
                flush=True,
            )
            write_table(report / "accuracy.csv", points)
    write_report(report, points, front)
    return 0
