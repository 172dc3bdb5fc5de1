"""Mobile grains as a run left them, as lines of a LIGGGHTS script for the next one to begin with."""

from pathlib import Path

import numpy as np
from bedload_post.outputs import MissingOutput, Run


def last_grains(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Tags (n), positions, velocities and spins (n, 3) at the last instant of the record."""
    last = None
    for block in run.sample_blocks():
        last = block
    if last is None or len(last) == 0:
        raise MissingOutput(f"{run.folder} has no samples of mobile spheres.")
    rows = last.time == last.time[-1]
    order = np.argsort(last.tag[rows])
    grains = last.rows(np.flatnonzero(rows)[order])
    return grains.tag, grains.position, grains.velocity, grains.angular_velocity


def write_grains(run: Run, file: Path) -> None:
    """Lines that put the grains of `run` there, type 2 of diameter 1, behind the bed's spheres."""
    tags, position, velocity, spin = last_grains(run)
    first = len(run.fixed_spheres()[1]) + 1  # the bed's spheres have the tags before
    lines = [f"# {len(tags)} grains as {run.name} left them."]
    lines += [f"create_atoms 2 single {_words(x)} units box" for x in position]
    for number, (v, w) in enumerate(zip(velocity, spin, strict=True), start=first):
        vx, vy, vz = (repr(float(c)) for c in v)
        wx, wy, wz = (repr(float(c)) for c in w)
        lines.append(
            f"set atom {number} vx {vx} vy {vy} vz {vz} omegax {wx} omegay {wy} omegaz {wz}"
        )
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _words(values: np.ndarray) -> str:
    return " ".join(repr(float(v)) for v in values)
