"""`bedload bench bed`: the coupled time step on the bed that a public code was measured on."""

import csv
import os
import subprocess
import tempfile
import threading
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from pathlib import Path

from . import job
from .build import ROOT
from .errors import UserError
from .scenes import Scene

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
LARGE = {
    "warm_up": 4,
    "steps": 8,
    "settings": ("grid.cells=[440,90,400]", "grid.length=[44.0,9.0,40.0]"),
    "variables": {"rows": "50", "columns": "40", "length": "44", "every": "4", "mobile": "500"},
}
BEDS = (
    Bed("bed", "double"),
    Bed("bed", "single"),
    Bed("bed/large", "double", **LARGE),
)


class MemoryWatch:
    """Peak resident memory of all processes under this one that are called bedload-*, summed up."""

    def __init__(self) -> None:
        self._peaks: dict[int, int] = {}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> "MemoryWatch":
        self._thread.start()
        return self

    def __exit__(self, *_) -> None:
        self._over.set()
        self._thread.join()

    @property
    def megabytes(self) -> float:
        return sum(self._peaks.values()) * 1024 / 1e6

    def _watch(self) -> None:
        while not self._over.wait(0.2):
            for pid in _descendants(os.getpid()):
                status = _status(pid)
                if status.get("Name", "").startswith("bedload-") and "VmHWM" in status:
                    self._peaks[pid] = int(status["VmHWM"].split()[0])


def _status(pid: int) -> dict[str, str]:
    try:
        text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    return {key: value.strip() for key, _, value in (line.partition(":") for line in text.split("\n"))}


def _descendants(pid: int) -> Iterator[int]:
    for tasks in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found = tasks.read_text(encoding="ascii").split()
        except OSError:
            continue
        for child in map(int, found):
            yield child
            yield from _descendants(child)


def measure(bed: Bed, ranks: job.Ranks) -> dict:
    """Runs one bed; seconds per step by part, slip of the projected velocity, memory."""
    with tempfile.TemporaryDirectory() as folder, MemoryWatch() as memory:
        out = Path(folder)
        settings = [f'accuracy.precision="{bed.precision}"', *bed.settings]
        work = job.Job(
            SCENE, None, ranks, out, settings, bed.warm_up + bed.steps,
            fluid_options=("--warm-up", str(bed.warm_up)),
            variables=bed.variables,
        )  # fmt: skip
        done = subprocess.run(
            work.command(), cwd=SCENE.folder, env=job.environment(), stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        if done.returncode != 0:
            raise UserError(f"{bed.name} ended with status {done.returncode}: {done.stdout.strip()}")
        cells = tomllib.loads((out / "settings.toml").read_text(encoding="utf-8"))["grid"]["cells"]
        with (out / "timing.csv").open(newline="", encoding="utf-8") as stream:
            seconds = {r["part"]: float(r["seconds_mean_over_ranks"]) for r in csv.DictReader(stream)}
        with (out / "history.csv").open(newline="", encoding="utf-8") as stream:
            last = list(csv.DictReader(stream))[-1]
    parts = {
        field: sum(seconds[name] for name in names) / bed.steps
        for field, names in STEP_PARTS.items()
    }
    return {
        "name": bed.name,
        "ranks": f"{ranks.fluid}:{ranks.dem}",
        "precision": bed.precision,
        "cells": prod(cells),
        "forcing_loops": int(last["forcing_loops"]),
        "seconds_per_step": round(sum(parts.values()), 5),
        **{field: round(value, 5) for field, value in parts.items()},
        "slip_rms": float(last["slip_rms"]),
        "rss_mb": round(memory.megabytes, 1),
    }


def rows(ranks: job.Ranks) -> Iterator[dict]:
    for bed in BEDS:
        yield measure(bed, ranks)
