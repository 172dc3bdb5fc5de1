"""path.png: the way of one grain, seen from the side and from above, coloured by its state."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402
from matplotlib.collections import EllipseCollection, LineCollection  # noqa: E402

from .outputs import Run, Samples  # noqa: E402
from .states import NAMES, RESTING, Phases, unwrap  # noqa: E402

COLOURS = ("#7a3b8f", "#e08214", "#1b7fbd")  # resting, creeping, jumping
MOST_POINTS = 20_000  # of one line in the figure


def chosen_grain(phases: Phases) -> int:
    """The tag of the grain with the longest path."""
    tags, rows = np.unique(phases.tag, return_inverse=True)
    return int(tags[np.argmax(np.bincount(rows, weights=phases.path))])


def state_at(time: np.ndarray, phases: Phases, tag: int) -> np.ndarray:
    """State of one grain at the given instants."""
    rows = np.flatnonzero(phases.tag == tag)
    at = np.searchsorted(phases.start[rows], time, side="right") - 1
    return phases.state[rows[np.clip(at, 0, len(rows) - 1)]]


def shares_of(phases: Phases, tag: int, first: float, last: float) -> np.ndarray:
    """Share of the time from `first` to `last` that one grain spends in each state, as drawn."""
    rows = phases.tag == tag
    spent = np.minimum(phases.end[rows], last) - np.maximum(phases.start[rows], first)
    time = np.bincount(phases.state[rows], weights=np.maximum(spent, 0.0), minlength=len(NAMES))
    return time / max(time.sum(), np.finfo(float).tiny)


def thinned(samples: Samples, periods: np.ndarray, most: int) -> tuple[Samples, np.ndarray]:
    """About `most` of one grain's samples and its way through them, unwrapped before, as it may cross the box in
    between."""
    every = slice(None, None, max(1, len(samples) // most))
    return samples.rows(every), unwrap(samples.position, periods)[every]


def _circles(axes, centres: np.ndarray, radii: np.ndarray, **style) -> None:
    axes.add_collection(
        EllipseCollection(
            2 * radii, 2 * radii, np.zeros_like(radii), offsets=centres, units="xy",
            transOffset=axes.transData, **style,
        )
    )  # fmt: skip


def _images(centres: np.ndarray, radii: np.ndarray, run: Run, low, high):
    """The bed's periodic images between `low` and `high` along x."""
    period = run.periods[0]
    if not np.isfinite(period):
        return centres, radii
    shifts = period * np.arange(np.floor(low / period), np.floor(high / period) + 1)
    moved = np.concatenate([centres + [shift, 0.0, 0.0] for shift in shifts])
    return moved, np.tile(radii, len(shifts))


def _line(axes, points: np.ndarray, state: np.ndarray) -> None:
    segments = np.stack([points[:-1], points[1:]], axis=1)
    colours = np.array(COLOURS)[state[:-1]]
    axes.add_collection(LineCollection(segments, colors=colours, linewidths=2, zorder=4))
    rests = points[state == RESTING]  # a rest is a point, no line
    axes.plot(rests[:, 0], rests[:, 1], ".", color=COLOURS[RESTING], ms=7, mew=0, zorder=5)


def draw(
    run: Run, phases: Phases, samples: Samples, tag: int, file: Path, dpi: int = 150
) -> None:
    """Draws the path of the grain `tag`, whose samples are given, into `file`."""
    diameter, box = run.diameter, run.box
    samples, points = thinned(samples, run.periods, MOST_POINTS)
    points /= diameter
    state = state_at(samples.time, phases, tag)
    mean = np.mean(samples.velocity[:, 0]) / run.bulk_velocity

    low, high = points[:, 0].min() - 1.0, points[:, 0].max() + 1.0
    if high - low < 6.0:
        middle = 0.5 * (low + high)
        low, high = middle - 3.0, middle + 3.0
    bed, radii = _images(*run.fixed_spheres(), run, low * diameter, high * diameter)
    bed, radii = bed / diameter, radii / diameter
    top = max(points[:, 1].max() + 0.8, (bed[:, 1] + radii).max(initial=0.0) + 1.5)
    side = [points[:, 2].min() - 1.5, points[:, 2].max() + 1.5]

    shape = [top, side[1] - side[0]]
    width = 11.0
    scale = min((width - 1.2) / (high - low), 3.2 / max(shape))
    figure, (from_side, from_above) = plt.subplots(
        2, 1, sharex=True, figsize=(width, scale * sum(shape) + 2.2), height_ratios=shape,
        layout="constrained",
    )  # fmt: skip
    near = np.abs(_nearest_image(bed[:, 2] - np.median(points[:, 2]), run.periods[2] / diameter))
    in_plane = near < 0.75
    grey = {"facecolor": "#c9c5bd", "edgecolor": "#98938a", "linewidth": 0.6}
    _circles(from_side, bed[in_plane][:, :2], radii[in_plane], zorder=1, **grey)
    for shift in (-1, 0, 1):
        if shift == 0 or np.isfinite(run.periods[2]):
            above = bed[:, [0, 2]] + [0.0, shift * box[2] / diameter if shift else 0.0]
            _circles(from_above, above, radii, zorder=1, **grey)
    for axes, other in ((from_side, 1), (from_above, 2)):
        _line(axes, points[:, [0, other]], state)
        ends = points[[0, -1]][:, [0, other]]
        both = np.full(2, samples.radius[0] / diameter)
        _circles(axes, ends, both, facecolor="none", edgecolor="#333333", linewidth=1, zorder=5)
        axes.set_aspect("equal")
        axes.set_facecolor("#f4f8fb")
    from_side.set(xlim=(low, high), ylim=(0.0, top), ylabel="y / D")
    from_above.set(ylim=side, xlabel="x / D (periodic images in a row)", ylabel="z / D")
    shares = shares_of(phases, tag, samples.time[0], samples.time[-1])
    for name, colour, share in zip(NAMES, COLOURS, shares, strict=True):
        from_side.plot([], [], color=colour, lw=3, label=f"{name} {100 * share:.1f} %")
    from_side.legend(ncol=3, loc="lower right", bbox_to_anchor=(1.0, 1.0), frameon=False)
    figure.suptitle(
        f"{run.name}: path of grain {tag} over {samples.time[-1] - samples.time[0]:.3g} time units,"
        f" mean velocity {mean:.3f} u$_b$",
        fontsize=12,
    )
    figure.savefig(file, dpi=dpi)
    plt.close(figure)


def _nearest_image(distance: np.ndarray, period: float) -> np.ndarray:
    if not np.isfinite(period):
        return distance
    return distance - period * np.round(distance / period)
