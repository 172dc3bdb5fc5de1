"""Measurements as one line of JSON each: kernels by Google Benchmark, whole steps by short runs."""

import csv
import datetime
import json
import os
import platform
import subprocess
import tempfile
import tomllib
from collections.abc import Iterator
from math import prod
from pathlib import Path

from . import job
from .build import BIN, ROOT
from .errors import UserError
from .scenes import Scene

STEPS = 40  # of a scene; the first ones are dearer by a few per cent


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def circumstances() -> dict:
    """When, what and where: stands in every record."""
    commit = subprocess.run(
        ["git", "-C", str(ROOT), "describe", "--always", "--dirty"],
        capture_output=True, text=True, check=False,
    ).stdout.strip()  # fmt: skip
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "commit": commit or None,
        "processor": _processor(),
    }


def programs() -> dict[str, Path]:
    """Kernel benchmarks among the built programs (bench_NAME), by name."""
    return {file.name.removeprefix("bench_"): file for file in sorted(BIN.glob("bench_*"))}


def kernels(program: Path) -> Iterator[dict]:
    """Runs a Google Benchmark program; one record per benchmark in it."""
    done = subprocess.run(
        [str(program), "--benchmark_format=json"],
        stdout=subprocess.PIPE, text=True, env=job.environment(), check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise UserError(f"{program} ended with status {done.returncode}.")
    for entry in json.loads(done.stdout)["benchmarks"]:
        unit = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[entry["time_unit"]]
        counters = {
            key: value
            for key, value in entry.items()
            if isinstance(value, float) and key not in ("real_time", "cpu_time")
        }
        yield {"name": entry["name"], "seconds": entry["real_time"] * unit, **counters}


def whole_step(scene: Scene, ranks: job.Ranks) -> dict:
    """Runs `scene` for STEPS steps; time per step, cells per second, seconds per step by part."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        work = job.Job(scene, scene.default_model(), ranks, out, steps=STEPS)
        done = subprocess.run(
            work.command(), cwd=scene.folder, env=job.environment(), stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        if done.returncode != 0:
            words = done.stdout.strip()
            raise UserError(f"scene {scene.name} ended with status {done.returncode}: {words}")
        settings = tomllib.loads((out / "settings.toml").read_text(encoding="utf-8"))
        with (out / "timing.csv").open(newline="", encoding="utf-8") as stream:
            parts = {row["part"]: row for row in csv.DictReader(stream)}
    cells = prod(settings["grid"]["cells"])
    seconds = {name: float(row["seconds_mean_over_ranks"]) / STEPS for name, row in parts.items()}
    total = sum(seconds.values())
    return {
        "name": f"step/{scene.name}",
        "ranks": f"{ranks.fluid}:{ranks.dem}" if scene.moves_grains else f"{ranks.fluid}",
        "cells": cells,
        "seconds": total,
        "cells_per_second": cells / total,
        "parts": {name: round(value, 6) for name, value in seconds.items()},
    }


def print_record(record: dict) -> None:
    """One line on the terminal, flushed: a long series is readable while it runs."""
    print(json.dumps({**circumstances(), "cores": os.cpu_count(), **record}), flush=True)
