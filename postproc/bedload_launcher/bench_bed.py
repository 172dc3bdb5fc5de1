"""`bedload bench bed`: the coupled time step on the bed that a public code was measured on."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import prod

from . import job
from .build import ROOT
from .scenes import Scene
from .trial import run_trial
from .words import read_rows

SCENE = Scene(ROOT / "tests" / "performance" / "bed")
WARM_UP, STEPS = 70, 40  # steps 70 to 109 count
STEP_PARTS = {
    "fluid_s": ("fluid predictor", "pressure", "end of the step"),
    "markers_s": ("markers",),
    "exchange_s": ("exchange",),
    "dem_wait_s": ("waiting for LIGGGHTS",),
}


@dataclass(frozen=True)
class Bed:
    """One row of the benchmark."""

    name: str
    precision: str
    warm_up: int = WARM_UP
    steps: int = STEPS
    settings: Sequence[str] = ()
    variables: Mapping[str, str] = field(default_factory=dict)


# Ten times the spheres on ten times the cells: 50 rows of 40, a mobile one in every fourth pocket.
BEDS = (
    Bed("bed", "double"),
    Bed("bed", "single"),
    Bed("bed/three forcing loops", "double", settings=("spheres.forcing_loops=3",)),
    Bed("bed/implicit diffusion", "double", settings=('fluid.diffusion="implicit"',)),
    Bed("bed/all grains move", "double", variables={"held": "none"}),
    Bed(
        "bed/large", "double", 4, 8, ("grid.cells=[440,90,400]", "grid.length=[44.0,9.0,40.0]"),
        {"rows": "50", "columns": "40", "length": "44", "every": "4", "mobile": "500"},
    ),
)  # fmt: skip


def measure(bed: Bed, ranks: job.Ranks) -> dict:
    """Runs one bed; seconds per step by part, slip of the projected velocity, memory.

    rss_mb: the ranks' peaks added up, so that the code of libraries counts once a rank; pss_mb: largest
    memory of all ranks at one time, what they share with each other or other programs divided among them.
    """
    work = job.Job(
        SCENE, None, ranks, SCENE.folder, [f'accuracy.precision="{bed.precision}"', *bed.settings],
        bed.warm_up + bed.steps, fluid_options=("--warm-up", str(bed.warm_up)),
        variables=bed.variables,
    )  # fmt: skip
    trial = run_trial(work, lambda out: read_rows(out / "history.csv")[-1], bed.warm_up)
    last = trial.answer
    parts = {
        field: sum(trial.step_parts[name] for name in names)
        for field, names in STEP_PARTS.items()
    }
    return {
        "name": bed.name,
        "ranks": f"{ranks.fluid}:{ranks.dem}",
        "precision": bed.precision,
        "cells": prod(trial.cells),
        "forcing_loops": int(last["forcing_loops"]),
        "seconds_per_step": round(sum(parts.values()), 5),
        **{field: round(value, 5) for field, value in parts.items()},
        "slip_rms": float(last["slip_rms"]),
        "rss_mb": round((trial.fluid_bytes + trial.dem_bytes) / 1e6, 1),
        "pss_mb": round(trial.proportional_bytes / 1e6, 1),
    }


def rows(ranks: job.Ranks) -> Iterator[dict]:
    for bed in BEDS:
        yield measure(bed, ranks)
