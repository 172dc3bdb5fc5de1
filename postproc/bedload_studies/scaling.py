"""What a rank sends and holds when ranks and box grow together: counted messages and bytes, grains included.

Each fluid rank has the same share of cells and grains; ranks may outnumber the cores, for nothing is timed. Counts come
from a preloaded library (tests/performance/count_use.cpp): those of a step as the difference of two runs of different
length over it, those of start and end as what is left.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import Scene

from .small_scenes import Ball, SmallScene

SHARE = (4.0, 3.0, 4.0)  # of the box, for each rank along y and z [D]
CELLS = 6  # to a diameter
GRAINS, FIXED = 6, 2  # for each fluid rank
RANKS = (2, 4, 8, 16)
SHORT = 4  # steps of the shorter run; the longer has twice as many
MEANINGS = {
    "messages": "messages in a step", "bytes_sent": "bytes sent in a step", "sums": "global sums in a step",
    "start_messages": "messages at start and end", "start_bytes_sent": "bytes sent at start and end",
    "start_gathered": "bytes gathered at start and end", "peak_bytes": "peak memory / MB",
}  # fmt: skip


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--fluid-ranks", type=int, nargs="+", default=list(RANKS), metavar="N",
        help=f"fluid ranks, powers of two (default: {' '.join(map(str, RANKS))})",
    )  # fmt: skip
    parser.add_argument("--dem-share", type=int, default=4, help="fluid ranks to one of LIGGGHTS (default: 4)")


def division(ranks: int) -> tuple[int, int]:
    """Blocks along y and z, as square as powers of two allow."""
    along_z = 1
    while along_z * along_z * 2 <= ranks:
        along_z *= 2
    return ranks // along_z, along_z


def scene(ranks: int) -> tuple[SmallScene, int]:
    """The box of `ranks` shares and its blocks along z; in each share grains on a lattice, falling, and fixed ones."""
    along_y, along_z = division(ranks)
    x, y, z = SHARE
    balls = [
        Ball((x * (i + 0.5) / 3.0, y * (j + 0.35 + 0.3 * (i % 2)), z * (k + 0.25 + 0.5 * m)))
        for j in range(along_y) for k in range(along_z) for i in range(3) for m in range(GRAINS // 3)
    ]  # fmt: skip
    balls += [
        Ball((0.5 * x, y * j + 0.5, z * (k + 0.25 + 0.5 * m)), mobile=False)
        for j in range(along_y) for k in range(along_z) for m in range(FIXED)
    ]  # fmt: skip
    keys = {"ranks.along_z": str(along_z), "output.spheres_every": "1e9", "checkpoint.wall_every": "0.0"}
    length = (x, y * along_y, z * along_z)
    return SmallScene(length, CELLS, 0.02, 0.02, 1e6, balls, gravity=1.0, keys=keys), along_z


def counted(ranks: int, dem: int, steps: int) -> list[dict]:
    """Counts of each process of a run."""
    with tempfile.TemporaryDirectory(prefix="bedload-scaling-") as name:
        folder = Path(name)
        scene(ranks)[0].write(folder / "scene")
        counts, out = folder / "counts", folder / "out"
        counts.mkdir()
        out.mkdir()
        work = job.Job(Scene(folder / "scene"), None, job.Ranks(ranks, dem), out, steps=steps)
        more = {"LD_PRELOAD": str(job.BIN / "count_use.so"), "BEDLOAD_COUNTS": str(counts)}
        done = subprocess.run(
            work.command(), cwd=folder / "scene", env=job.environment() | more, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", check=False, preexec_fn=job.dies_with_us(),
        )  # fmt: skip
        if done.returncode != 0:
            raise UserError(f"a run on {ranks} fluid ranks ended with status {done.returncode}: {done.stdout[-300:]}")
        return [json.loads(file.read_text(encoding="utf-8")) for file in counts.glob("*.json")]


def largest(counts: list[dict], program: str, name: str) -> int:
    return max(count[name] for count in counts if count["program"] == program)


def row(ranks: int, dem: int, program: str, once: list[dict], twice: list[dict]) -> dict[str, float]:
    """The numbers of the busiest rank of `program`."""
    found: dict[str, float] = {}
    for name in ("messages", "bytes_sent", "sums"):
        found[name] = (largest(twice, program, name) - largest(once, program, name)) / SHORT
    for name in ("messages", "bytes_sent", "gathered"):
        step = found.get(name, 0.0)
        found[f"start_{name}"] = largest(once, program, name) - SHORT * step
    found["peak_bytes"] = largest(twice, program, "peak_bytes") / 1e6
    return found


def run(options: argparse.Namespace) -> int:
    for ranks in options.fluid_ranks:
        if ranks < 1 or ranks & (ranks - 1):
            raise UserError(f"--fluid-ranks has {ranks}, but must be powers of two.")
    if options.dem_share < 1:
        raise UserError(f"--dem-share is {options.dem_share}, but must be at least 1.")
    print(f"The busiest rank of each program; {SHARE[0]:g} x {SHARE[1]:g} x {SHARE[2]:g} D, {GRAINS} grains and "
          f"{FIXED} fixed spheres to a fluid rank.\n")  # fmt: skip
    head = ["program", "ranks (y x z, or LIGGGHTS)", *MEANINGS.values()]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for ranks in options.fluid_ranks:
        dem = max(1, ranks // options.dem_share)
        once, twice = counted(ranks, dem, SHORT), counted(ranks, dem, 2 * SHORT)
        y, z = division(ranks)
        for program, name in (("bedload-fluid", f"{ranks} ({y} x {z})"), ("bedload-dem", str(dem))):
            found = row(ranks, dem, program, once, twice)
            cells = [f"{found[key]:.0f}" for key in MEANINGS]
            print("| " + " | ".join([program, name, *cells]) + " |", flush=True)
    return 0
