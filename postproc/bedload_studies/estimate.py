"""`./bedload estimate` judged: three scenes predicted, then run to their end.

Each is predicted twice: as the command does it, and from trials on less than half of the scene's cells, so that
the scaling is judged even where the machine could try the scene itself. Time is that of the whole job, from
mpirun's start to its end. It fails beyond 20 % in time or 10 % in memory; times need a quiet machine.
"""

import argparse
import csv
import math
from dataclasses import dataclass
from pathlib import Path

from bedload_launcher import cost
from bedload_launcher import job
from bedload_launcher.errors import unknown
from bedload_launcher.scenes import choose_model, find_scene
from bedload_launcher.trial import run_trial
from bedload_launcher.words import say

TIME_LIMIT, MEMORY_LIMIT = 0.2, 0.1
PART = 0.4  # of the scene's cells that the second prediction may try


@dataclass(frozen=True)
class Case:
    """A scene made short."""

    scene: str
    settings: tuple[str, ...]
    what: str


CASES = {
    "channel": Case(
        "channel180", ("time.end=2.0",), "a channel without grains, a step that follows the flow",
    ),
    "grain": Case(
        "exposed_sphere", ("time.end=3.2",), "a bed with one grain, eighty steps",
    ),
    "bed": Case("setup2_small", ("time.end=1.3",), "a bed with 125 grains, twenty steps"),
}  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """A prediction beside what was measured."""

    case: str
    trial: str
    steps: int
    predicted_s: float
    measured_s: float
    predicted_mb: float
    measured_mb: float

    @property
    def time_error(self) -> float:
        return self.predicted_s / self.measured_s - 1.0

    @property
    def memory_error(self) -> float:
        return self.predicted_mb / self.measured_mb - 1.0

    @property
    def holds(self) -> bool:
        return abs(self.time_error) <= TIME_LIMIT and abs(self.memory_error) <= MEMORY_LIMIT

    def row(self) -> dict:
        return {
            "case": self.case, "tried": self.trial, "steps": self.steps,
            "predicted s": f"{self.predicted_s:.2f}", "measured s": f"{self.measured_s:.2f}",
            "time %": f"{100 * self.time_error:+.1f}", "predicted MB": f"{self.predicted_mb:.0f}",
            "measured MB": f"{self.measured_mb:.0f}", "memory %": f"{100 * self.memory_error:+.1f}",
            "holds": "yes" if self.holds else "NO",
        }  # fmt: skip


def judge(name: str, ranks: job.Ranks) -> list[Judged]:
    """Predicts twice, then runs to the end."""
    case = CASES[name]
    scene = find_scene(case.scene)
    whole = job.Job(scene, choose_model(scene, None), ranks, scene.folder, case.settings)
    cells = scene.cells(list(case.settings))
    found = [
        cost.estimate(whole, cells, say, most)
        for most in (cost.MANY_CELLS, int(PART * math.prod(cells)))
    ]
    run = run_trial(whole)
    return [
        Judged(name, " x ".join(map(str, e.trial_cells)), run.steps, e.seconds, run.wall_seconds,
               1e-6 * (e.fluid_bytes + e.dem_bytes), 1e-6 * (run.fluid_bytes + run.dem_bytes))
        for e in found
    ]  # fmt: skip


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--case", action="append", metavar="NAME", help=f"of {', '.join(CASES)}")
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--out", type=Path, default=Path("runs/estimate"), help="folder of the table")


def run(options: argparse.Namespace) -> int:
    for name in options.case or []:
        if name not in CASES:
            raise unknown("case", name, CASES)
    ranks = job.Ranks.parse(options.ranks)
    options.out.mkdir(parents=True, exist_ok=True)
    judged = [j for name in options.case or CASES for j in judge(name, ranks)]
    rows = [j.row() for j in judged]
    with (options.out / "estimate.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    for row in (dict.fromkeys(rows[0]) | {name: name for name in rows[0]}, *rows):
        print("".join(f"{row[name]!s:>{16 if name == 'tried' else 13}}" for name in rows[0]))
    return 0 if all(j.holds for j in judged) else 1
