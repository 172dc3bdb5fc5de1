"""How fast the analysis of a long run is: 1e8 made-up samples of 500 grains with 1e6 collisions.

The samples repeat one block on the disk (a virtual dataset), with times of their own, so that the file
stays small; they are read, unpacked and summed up as those of a run.
"""

import argparse
import json
import resource
import tempfile
import time
from pathlib import Path

import h5py
import numpy as np
from bedload_launcher.bench import circumstances
from bedload_launcher.numbers import whole
from bedload_post.outputs import COLLISIONS, OPEN_CONTACTS, Run
from bedload_post.transport import measure

GRAINS = 500
BLOCK = 2_000  # instants on the disk
LEAST = 2 * GRAINS  # samples: two instants, without which nothing has moved
STEP = 0.1
SETTINGS = """\
boundary.x = "periodic"
boundary.y = ["no_slip", "free_slip"]
boundary.z = "periodic"
grid.length = [52.0, 10.0, 27.0]
reference.velocity = 1.0
reference.diameter = 1.0
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--samples", type=whole(LEAST), default=10**8, help="default: 1e8")
    parser.add_argument("--collisions", type=whole(0), default=10**6, help="default: 1e6")


def write_samples(folder: Path, instants: int, random: np.random.Generator) -> None:
    """spheres.h5: grains that drift along x, hop and spin, `instants` times."""
    rows = BLOCK * GRAINS
    at = np.arange(BLOCK)[:, None]
    phase = random.random((1, GRAINS))
    hop = np.abs(np.sin(0.3 * at + 6.0 * phase))
    position = np.stack(
        [np.mod(52.0 * (at / BLOCK + phase), 52.0), 1.3 + 0.5 * hop, 27.0 * phase + 0 * hop], axis=-1
    )
    velocity = np.stack([0.26 + 0.1 * hop, 0.1 * hop, 0 * hop], axis=-1)
    spin = np.stack([0 * hop, 0 * hop, -0.2 * hop], axis=-1)
    block = {"position": position, "velocity": velocity, "angular_velocity": spin}
    with h5py.File(folder / "block.h5", "w") as file:
        for name, values in block.items():
            file.create_dataset(name, data=values.reshape(rows, 3), chunks=(1024, 3))
        file.create_dataset("radius", data=np.full(rows, 0.5), chunks=(1024,))
        file.create_dataset("tag", data=np.tile(np.arange(1, GRAINS + 1), BLOCK), chunks=(1024,))
    with h5py.File(folder / "block.h5") as file, h5py.File(folder / "spheres.h5", "w") as spheres:
        for name, values in file.items():
            layout = h5py.VirtualLayout((instants * GRAINS, *values.shape[1:]), values.dtype)
            for first in range(0, instants * GRAINS, rows):
                count = min(rows, instants * GRAINS - first)
                layout[first : first + count] = h5py.VirtualSource(values)[:count]
            spheres.create_virtual_dataset(f"mobile/{name}", layout)
        chunks = (min(1024, instants * GRAINS),)
        times = spheres.create_dataset("mobile/time", (instants * GRAINS,), "f8", chunks=chunks)
        for first in range(0, instants, BLOCK):
            part = np.arange(first, min(first + BLOCK, instants)) * STEP
            times[first * GRAINS : (first + len(part)) * GRAINS] = np.repeat(part, GRAINS)


def write_collisions(folder: Path, count: int, end: float, random: np.random.Generator) -> None:
    """collisions.csv, and no contact under way at the end."""
    start = np.sort(random.random(count)) * end
    rows = np.column_stack(
        [random.integers(1, GRAINS + 1, count), np.full(count, 9999), start, start + 0.3]
    )
    for table, shown in ((COLLISIONS, rows), (OPEN_CONTACTS, rows[:0])):
        np.savetxt(
            folder / table, shown, delimiter=",", fmt=["%d", "%d", "%.9g", "%.9g"],
            header="tag_i,tag_j,time_start,time_end", comments="",
        )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    instants = round(options.samples / GRAINS)
    random = np.random.default_rng(7)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "settings.toml").write_text(SETTINGS, encoding="utf-8")
        write_samples(folder, instants, random)
        write_collisions(folder, options.collisions, instants * STEP, random)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        began, used = time.perf_counter(), time.process_time()
        result = measure(Run(folder))
        record = {
            "name": "analysis",
            "samples": instants * GRAINS,
            "collisions": options.collisions,
            "phases": len(result.phases.tag),
            "seconds": time.perf_counter() - began,
            "processor_seconds": time.process_time() - used,
            "peak_memory_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
            "memory_before_MB": before / 1024,
        }
    print(json.dumps(record | circumstances()))
    return 0
