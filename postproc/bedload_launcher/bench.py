"""Measurements as one line of JSON each: kernels by programs bench_*, whole steps by short runs."""

import datetime
import json
import platform
import subprocess
from collections.abc import Iterator
from math import prod
from pathlib import Path

from . import job
from .build import BIN, ROOT
from .errors import UserError
from .machine import cores
from .scenes import Scene
from .trial import run_trial
from .version import commit

STEPS = 40  # of a scene; the first ones are dearer by a few per cent


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def circumstances() -> dict:
    """When, what and where: stands in every record."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "commit": commit() or None,
        "processor": _processor(),
        "cores": cores(),
    }


def kernel_names() -> list[str]:
    """Of the benchmarks that programs() has after a build."""
    return [file.stem.removeprefix("bench_") for file in sorted((ROOT / "tests/performance").glob("bench_*.cpp"))]


def programs() -> dict[str, Path]:
    """Kernel benchmarks among the built programs (bench_NAME), by name."""
    return {file.name.removeprefix("bench_"): file for file in sorted(BIN.glob("bench_*"))}


def kernels(program: Path, ranks: job.Ranks) -> Iterator[dict]:
    """Runs a program that prints one line of JSON per measurement; yields them as they come."""
    line = ["mpirun", "--quiet", "-np", str(ranks.fluid), str(program)]
    with subprocess.Popen(
        line, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, env=job.environment()
    ) as measurement:
        for text in measurement.stdout or ():
            if text.startswith("{"):
                yield json.loads(text)
    if measurement.returncode != 0:
        raise UserError(f"{program} ended with status {measurement.returncode}.")


def whole_step(scene: Scene, ranks: job.Ranks) -> dict:
    """Runs `scene` for STEPS steps; time per step, cells per second, seconds per step by part."""
    work = job.Job(scene, scene.default_model(), ranks, scene.folder, steps=STEPS)
    trial = run_trial(work)
    cells = prod(trial.cells)
    return {
        "name": f"step/{scene.name}",
        "ranks": f"{ranks.fluid}:{ranks.dem}" if scene.moves_grains else f"{ranks.fluid}",
        "cells": cells,
        "seconds": trial.step_seconds,
        "cells_per_second": cells / trial.step_seconds,
        "parts": {name: round(value, 6) for name, value in trial.step_parts.items()},
    }


def print_record(record: dict) -> None:
    """One line on the terminal at once: a long series can be read while it runs."""
    print(json.dumps({**record, **circumstances()}), flush=True)
