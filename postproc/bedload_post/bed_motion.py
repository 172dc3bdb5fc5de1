"""bed_motion.png: where and when grains of a bed move, over x and time, and the bed's surface.

Both from the samples of spheres.h5. A grain moves when it is faster than 0.01 u_b (Vowinckel, Kempe & Froehlich); the
surface over a piece of the bed, one diameter long, is the mean over z of the highest grain's top.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .frames import frames
from .outputs import Run
from .states import RESTING_SPEED

MOST = 400  # instants that are drawn
NO_GRAIN = "#9ecae1"  # where no grain is
MOST_COLUMNS = 4  # panels in a row
FEWEST = 40  # grains, for a map to say more than their paths


def maps(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Instants (m) [T]; share of moving grains (m, n) over pieces of x, nan where none is; surface (m, n) [L]."""
    every = max(1, sum(len(time) for time, _ in run.instants()) // MOST // max(1, _grains(run)))
    pieces = max(1, int(run.box[0] / run.diameter))
    strips = max(1, int(run.box[2] / run.diameter))
    times, shares, tops = [], [], []
    seen = 0
    for part in frames(run.sample_blocks()):
        for row, time in enumerate(part.time):
            seen += 1
            if (seen - 1) % every:
                continue
            x = _place(part.position[row][:, 0], run.box[0], pieces)
            z = _place(part.position[row][:, 2], run.box[2], strips)
            fast = np.linalg.norm(part.velocity[row], axis=1) > RESTING_SPEED * run.bulk_velocity
            count = np.bincount(x, minlength=pieces)
            moving = np.bincount(x, weights=fast, minlength=pieces)
            with np.errstate(invalid="ignore"):
                shares.append(np.where(count > 0, moving / count, np.nan))
            top = np.full((pieces, strips), -np.inf)
            np.maximum.at(top, (x, z), part.position[row][:, 1] + part.radius[row])
            found = np.isfinite(top)
            total = np.where(found, top, 0.0).sum(axis=1)
            tops.append(np.where(found.any(axis=1), total / np.maximum(1, found.sum(axis=1)), np.nan))
            times.append(float(time))
    return np.array(times), np.array(shares), np.array(tops)


def compare(named: Sequence[tuple[str, Run]], file: Path, since: float = 0.0) -> bool:
    """Where and when grains move, one panel a run, on one scale, with a dashed line where the start-up ends (`since`
    [T], 0: none); False, and nothing drawn, without a bed's maps."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    found = [(name, run, *maps(run)[:2]) for name, run in named if _grains(run) >= FEWEST]
    found = [one for one in found if len(one[2]) >= 2]
    if not found:
        return False
    columns = min(len(found), MOST_COLUMNS)
    rows = -(-len(found) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(1.5 + 2.3 * columns, 4.5 * rows), layout="constrained", sharey=True, squeeze=False
    )
    for axis in axes.flat[len(found) :]:
        axis.set_axis_off()
    for axis, (name, run, time, share) in zip(axes.flat, found, strict=False):
        unit = run.diameter / run.bulk_velocity
        reach = (0.0, run.box[0] / run.diameter, time[0] / unit, time[-1] / unit)
        image = axis.imshow(
            share, origin="lower", aspect="auto", extent=reach, cmap="inferno", vmin=0, vmax=1, interpolation="nearest"
        )
        if since > 0.0:
            axis.axhline(since / unit, color="#00b0b0", ls="--", lw=1.5)
        axis.set(title=name, xlabel="x / D", facecolor=NO_GRAIN)
    for axis in axes[:, 0]:
        axis.set_ylabel("$t\\, u_b / D$")
    figure.colorbar(image, ax=axes[:, -1], label=f"share of grains faster than {RESTING_SPEED:g} $u_b$ (blue: none)")
    figure.savefig(file, dpi=90)
    plt.close(figure)
    return True


def _grains(run: Run) -> int:
    return len(np.unique(next(run.sample_blocks(rows=1)).tag))


def _place(x: np.ndarray, length: float, pieces: int) -> np.ndarray:
    return np.minimum((np.mod(x, length) / length * pieces).astype(int), pieces - 1)


def draw(run: Run, file: Path) -> bool:
    """Draws both maps; False, and nothing drawn, for fewer than FEWEST grains or two instants."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    if _grains(run) < FEWEST:
        return False
    time, share, top = maps(run)
    if len(time) < 2:
        return False
    unit = run.diameter / run.bulk_velocity
    reach = (0.0, run.box[0] / run.diameter, time[0] / unit, time[-1] / unit)
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 5.0), layout="constrained", sharey=True)
    for axis, values, name, colours in (
        (axes[0], share, "share of grains in motion (blue: no grain)", "inferno"),
        (axes[1], top / run.diameter, "bed's surface, y / D", "viridis"),
    ):
        image = axis.imshow(values, origin="lower", aspect="auto", extent=reach, cmap=colours, interpolation="nearest")
        figure.colorbar(image, ax=axis, location="top", label=name)
        axis.set(xlabel="x / D", facecolor=NO_GRAIN)
    axes[0].set_ylabel("t u_b / D")
    figure.savefig(file, dpi=110)
    plt.close(figure)
    return True
