"""What accuracy costs: the error of cases with a known answer against core-seconds and memory.

One knob is turned at a time, then sensible pairs. Points that no other point beats in both error and
core-seconds form the front of best choices. The presets of `--accuracy` are measured among them; their
errors and prices are what `./bedload estimate` quotes.
"""

import argparse
import csv
import math
import os
import resource
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from bedload_launcher.accuracy import PRESETS
from bedload_launcher.errors import unknown
from bedload_launcher.job import Ranks
from bedload_launcher.memory import MemoryWatch

from . import validation_moving, validation_steady
from .accuracy_report import write_report
from .validation_runs import Runner


@dataclass(frozen=True)
class Point:
    """One way to compute one case: its error (of 1) and its price."""

    case: str
    label: str
    knob: str
    error: float
    core_seconds: float
    megabytes: float


@dataclass
class PricedRunner(Runner):
    """A Runner that also notes processor time and memory; both stand in a file beside the run."""

    core_seconds: float = 0.0
    megabytes: float = 0.0

    def __call__(self, scene, label, settings: Mapping = {}, variables: Mapping = {}):
        run = super().__call__(scene, label, settings, variables)
        row = (self.folder / label / "price.csv").read_text(encoding="utf-8").split(",")
        self.core_seconds += float(row[0])
        self.megabytes = max(self.megabytes, float(row[1]))
        return run

    def _run(self, line, scene, out: Path) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with MemoryWatch(os.getpid()) as memory:
            seconds = super()._run(line, scene, out)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        megabytes = memory.bytes_of() / 1e6
        (out / "price.csv").write_text(f"{spent:.3f},{megabytes:.1f}", encoding="utf-8")
        return seconds


# --- The cases: (runner, label, D/h, settings) -> error ---------------------------------------------


def array_drag(runner: Runner, label: str, n: float, settings: dict) -> float:
    """Drag of a dense array in Stokes flow, volume fraction 0.216."""
    fraction = 0.216
    cells = round(n * validation_steady._array_edge(fraction))
    drag, _ = validation_steady._array(runner, label, fraction, cells, **settings)
    return drag / validation_steady.ZICK_HOMSY[fraction] - 1.0


def settling(runner: Runner, label: str, n: float, settings: dict) -> float:
    """Terminal velocity of a settling sphere, Ga = 144, density ratio 1.5."""
    _, _, u = validation_moving._settle(
        runner, label, 144.0, 1.5, 1.285, int(n), 16.0, **settings
    )
    return float(u[-1]) / 1.285 - 1.0


def rebound(runner: Runner, label: str, n: float, settings: dict) -> float:
    """First peak after the rebound from a wall, St = 152."""
    peak = validation_moving._rebound(runner, label, int(n), width=5, **settings)[2]
    return peak / 0.003 / 2.489 - 1.0


Case = Callable[[Runner, str, float, dict], float]
CASES: dict[str, Case] = {"array_drag": array_drag, "settling": settling, "rebound": rebound}
REFERENCE_RESOLUTION = 10

DOUBLE, SINGLE = {"accuracy.precision": "double"}, {"accuracy.precision": "single"}


def choices(case: str) -> list[tuple[str, str, float, dict]]:
    """(label, knob, D/h, settings) of every point of a case."""
    n = REFERENCE_RESOLUTION
    points = [("standard", "-", n, DOUBLE)]
    points += [(f"D/h {m}", "D/h", m, DOUBLE) for m in (6, 8, 14)]
    points.append(("single", "precision", n, SINGLE))
    points += [
        (f"{loops} loops", "forcing loops", n, DOUBLE | {"spheres.forcing_loops": loops})
        for loops in (2, 4)
    ]
    points.append(
        ("slip 1e-3", "slip tolerance", n,
         DOUBLE | {"spheres.forcing_loops": 10, "spheres.slip_tolerance": 1e-3})
    )  # fmt: skip
    points += [
        (f"retraction {r:g} h", "marker retraction", n, DOUBLE | {"spheres.retraction": r})
        for r in (0.0, 0.2)
    ]
    points.append(("no old pressure", "old pressure", n, DOUBLE | {"spheres.pressure_share": 0.0}))
    points += [
        ("D/h 6, single", "pair", 6, SINGLE),
        ("D/h 8, single", "pair", 8, SINGLE),
        ("D/h 14, 2 loops", "pair", 14, DOUBLE | {"spheres.forcing_loops": 2}),
    ]
    if case == "rebound":
        h_step = 1.5e-3
        points += [
            (f"{f:g} x dt", "time step", n, DOUBLE | {"step": f * h_step / n}) for f in (0.5, 1.5)
        ]
    if case == "settling":
        points += [
            (f"{f:g} x dt", "time step", n,
             DOUBLE | {"step": f * min(0.3 / n, 0.18 * 144.0 / n**2)})
            for f in (0.5, 1.5)
        ]  # fmt: skip
    for name, preset in PRESETS.items():
        settings = {"accuracy.precision": preset.precision}
        if preset.forcing_loops:
            settings["spheres.forcing_loops"] = preset.forcing_loops
        points.append((f"preset {name}", "preset", round(preset.resolution * n), settings))
    return points


def measure(case: str, label: str, knob: str, n: float, settings: dict, options) -> Point:
    folder = options.runs.resolve()
    name = f"{case}-{label}".replace(" ", "_").replace("/", "").replace(",", "")
    runner = PricedRunner(folder, Ranks.parse("1:1"))
    error = CASES[case](runner, name, n, settings)
    return Point(case, label, knob, error, runner.core_seconds, runner.megabytes)


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
    with file.open(newline="", encoding="utf-8") as stream:
        return [
            Point(
                row["case"], row["label"], row["knob"], float(row["error"]),
                float(row["core_seconds"]), float(row["megabytes"]),
            )
            for row in csv.DictReader(stream)
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
    parser.add_argument("--case", action="append", metavar="NAME", help=f"of {', '.join(CASES)}")
    parser.add_argument("--runs", type=Path, default=Path("runs/accuracy"), help="where runs go")
    parser.add_argument("--report", type=Path, help="folder of the report (default: RUNS/report)")


def run(options: argparse.Namespace) -> int:
    for name in options.case or []:
        if name not in CASES:
            raise unknown("case", name, CASES)
    report = options.report or options.runs / "report"
    report.mkdir(parents=True, exist_ok=True)
    cases = options.case or list(CASES)
    # What the table has of other cases stays.
    points = [p for p in read_table(report / "accuracy.csv") if p.case not in cases]
    for case in cases:
        for label, knob, n, settings in choices(case):
            point = measure(case, label, knob, n, settings, options)
            points.append(point)
            print(
                f"{case:12} {label:18} error {100 * point.error:+7.2f} %  "
                f"{point.core_seconds:8.1f} core-s {point.megabytes:7.0f} MB",
                flush=True,
            )
        write_table(report / "accuracy.csv", points)
    write_report(report, points, front)
    return 0
