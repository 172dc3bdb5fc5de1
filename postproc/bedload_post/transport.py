"""What the grains of one run do after the start-up: series, distributions, profiles over height.

Velocities are in u_b, lengths in D, angular velocities in u_b/D. All grains of an instant count alike, however many
they are, and an instant by the time that it stands for (batches.InstantWeights).
"""

import math
from dataclasses import dataclass, field

import numpy as np

from scipy.stats import t as student

from .batches import (
    FEWEST_BATCHES, Estimate, InstantWeights, batches_of, estimate_over_time, half_width_of, half_widths, second_half,
)  # fmt: skip
from .frames import Frames, first_above, frames, known_columns, pieces, time_ranges
from .outputs import MissingOutput, Run
from .states import CREEPING, JUMPING, NAMES, RESTING, RESTING_SPEED, Phases, analyse

SPIN_EDGES = np.linspace(-3.0, 3.0, 241)  # omega_3 D/u_b
VELOCITY_EDGES = np.linspace(-0.5, 1.5, 201)  # u_p/u_b
PARTS = 10  # of the record, each with histograms of its own: their scatter is the interval
FEWEST_SAMPLES = 50  # in a bin of height whose mean is shown
COARSE = 5  # bins of height in one of the coarse profile, 0.1 D


@dataclass
class Transport:
    """Sums over the samples of one run; histograms leave out what lies beyond their edges."""

    phases: Phases
    batches: int = FEWEST_BATCHES  # of one flow-through time or longer where the record allows it
    time: list[np.ndarray] = field(default_factory=list)
    count: list[np.ndarray] = field(default_factory=list)  # of the grains, per instant
    velocity: list[np.ndarray] = field(default_factory=list)  # mean over the grains, per instant
    height: list[np.ndarray] = field(default_factory=list)
    spin: list[np.ndarray] = field(default_factory=list)
    share: list[np.ndarray] = field(default_factory=list)  # of the grains in each state, (m, 3)
    moving: list[np.ndarray] = field(default_factory=list)  # share of the grains above 0.01 u_b
    heights: np.ndarray = field(default_factory=lambda: height_edges(6.0))  # edges of the bins in y/D
    # By part of the record: samples, sum of spin, sum of velocity over height; by state otherwise.
    height_parts: np.ndarray = field(init=False)
    moving_parts: np.ndarray = field(init=False)  # of grains that do not rest
    spin_parts: np.ndarray = field(default_factory=lambda: _empty(SPIN_EDGES))
    velocity_parts: np.ndarray = field(default_factory=lambda: _empty(VELOCITY_EDGES))
    # Samples and sum of |omega_3| by part and state, whatever its size.
    spin_sums: np.ndarray = field(default_factory=lambda: np.zeros((2, PARTS, len(NAMES))))

    def __post_init__(self) -> None:
        self.height_parts, self.moving_parts = _empty(self.heights), _empty(self.heights)

    @property
    def by_height(self) -> np.ndarray:
        """Samples, sum of spin, sum of velocity over height; shape (3, bins)."""
        return self.height_parts.sum(axis=0)

    @property
    def spins(self) -> np.ndarray:
        """Samples over spin by state; shape (3, bins)."""
        return self.spin_parts.sum(axis=0)

    @property
    def velocities(self) -> np.ndarray:
        """Samples over velocity by state; shape (3, bins)."""
        return self.velocity_parts.sum(axis=0)

    def series(self, name: str) -> np.ndarray:
        return np.concatenate(getattr(self, name))

    def mean(self, name: str) -> Estimate:
        """Mean of a series with its interval."""
        return self.over_time(self.series(name))

    def share_of(self, state: int) -> Estimate:
        """Share of time in `state`."""
        return self.over_time(self.series("share")[:, state])

    def over_time(self, values: np.ndarray) -> Estimate:
        """Mean of values (m) that are means over the grains of each instant."""
        return estimate_over_time(self.series("time"), values, batches=self.batches, counts=self.series("count"))

    def halves(self, name: str, state: int | None = None) -> tuple[Estimate, Estimate]:
        """Means of the first and the second half of the record; of the share of a `state`, say."""
        time, values, counts = self.series("time"), self.series(name), self.series("count")
        values = values if state is None else values[:, state]
        middle, batches = second_half(time), max(2, self.batches // 2)
        first, second = (
            estimate_over_time(time[half], values[half], batches=batches, counts=counts[half])
            for half in (slice(middle), slice(middle, None))
        )
        return first, second

    @property
    def samples(self) -> int:
        return sum(map(len, self.time))

    def height_pdf(self) -> tuple[np.ndarray, np.ndarray]:
        """(y/D, probability density) of the grains' centres."""
        return _density(self.heights, self.by_height[0])

    def over_height(self, row: int) -> tuple[np.ndarray, np.ndarray]:
        """(y/D, mean omega_3 (row 1) or mean u_p (row 2)); where at least 50 samples lie."""
        sums = self.by_height
        enough = sums[0] >= FEWEST_SAMPLES
        return _centres(self.heights)[enough], sums[row][enough] / sums[0][enough]

    def over_height_interval(self, row: int) -> np.ndarray:
        """Half widths of the 95 % intervals of over_height, from the record's parts; nan where fewer
        than three parts have samples."""
        enough = self.by_height[0] >= FEWEST_SAMPLES
        with np.errstate(invalid="ignore", divide="ignore"):
            means = self.height_parts[:, row] / self.height_parts[:, 0]
        return half_widths(means)[enough]

    def coarse_profile(self, row: int, resting: bool = True) -> "Profile":
        """Mean omega_3 (row 1) or u_p (row 2) over slices of 0.1 D, of all grains or of those that do not
        rest; slices with at least 50 samples in at least three parts of the record."""
        sums = self.height_parts if resting else self.moving_parts
        sums = sums.reshape(PARTS, 3, -1, COARSE).sum(axis=3)
        samples = sums[:, 0].sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            half = half_widths(sums[:, row] / sums[:, 0])
        kept = (samples >= FEWEST_SAMPLES) & np.isfinite(half)
        mean = sums[:, row].sum(axis=0)[kept] / samples[kept]
        return Profile(_centres(self.heights[::COARSE])[kept], mean, half[kept], samples[kept])

    def low_height(self, share: float = 0.05) -> tuple[float, float]:
        """y/D below which `share` of the samples lies, to a bin of 0.02, and the half width of its interval, no less
        than half a bin."""
        y = _centres(self.heights)
        parts = [_quantile(y, counts, share) for counts in self.height_parts[:, 0]]
        half = half_width_of(parts)
        return _quantile(y, self.by_height[0], share), max(half, 0.5 * (y[1] - y[0]))

    def _by_part(self, rows: np.ndarray, *weights: np.ndarray) -> list[np.ndarray]:
        """Sums of `weights` (a value a phase) over the phases `rows` that begin in each part of the record."""
        time = np.concatenate(self.time)
        through = (self.phases.start[rows] - time[0]) / max(time[-1] - time[0], 1e-300)
        part = np.clip((PARTS * through).astype(np.intp), 0, PARTS - 1)
        return [np.bincount(part, weight[rows], PARTS) for weight in weights]

    def slip_ratio(self) -> tuple[float, float]:
        """L_slip/L of all complete creeping phases together and the half width of its interval."""
        phases = self.phases
        rows = np.flatnonzero(phases.complete & (phases.state == CREEPING))
        return ratio_of_sums(*self._by_part(rows, phases.slip, phases.path))

    def mean_jump_height(self, diameter: float) -> tuple[float, float]:
        """Mean height of all complete jumps in D and the half width of its interval; jumps of the same time are no
        independent ones."""
        heights = self.phases.height / diameter
        return ratio_of_sums(*self._by_part(np.flatnonzero(self.phases.jumps()), heights, np.ones_like(heights)))

    def spin_pdf(self, state: int) -> tuple[np.ndarray, np.ndarray]:
        return _density(SPIN_EDGES, self.spins[state])

    def velocity_pdf(self, state: int) -> tuple[np.ndarray, np.ndarray]:
        return _density(VELOCITY_EDGES, self.velocities[state])

    def pdf_interval(self, name: str, state: int = 0, width: int = 1) -> np.ndarray:
        """Half widths of the 95 % intervals of a PDF ("height", "spin", "velocity"), smoothed over
        `width` bins, from the record's parts."""
        counts = getattr(self, f"{name}_parts")[:, state]
        total = counts.sum(axis=1, keepdims=True)
        edges = {"height": self.heights, "spin": SPIN_EDGES, "velocity": VELOCITY_EDGES}[name]
        with np.errstate(invalid="ignore", divide="ignore"):
            densities = counts / (total * np.diff(edges))
        return half_widths(np.stack([smooth(d, width) for d in densities]))

    def mean_spin(self, state: int) -> tuple[float, float]:
        """Mean |omega_3| in a state and the half width of its interval; nan where there is none."""
        samples, sums = self.spin_sums[..., state]
        total = samples.sum()
        with np.errstate(invalid="ignore", divide="ignore"):
            half = half_width_of(sums / samples)
        return (float(sums.sum() / total) if total else float("nan")), half

    def spread_of_height(self) -> tuple[float, float]:
        """Standard deviation of y/D and the half width of its interval."""
        counts = self.height_parts[:, 0]
        y = _centres(self.heights)
        mean = (y * counts.sum(axis=0)).sum() / max(counts.sum(), 1.0)
        square, half = _mean_and_interval((y - mean) ** 2, counts)
        spread = float(np.sqrt(square))
        return spread, half / (2.0 * spread) if spread > 0 else 0.0


def ratio_of_sums(above: np.ndarray, below: np.ndarray) -> tuple[float, float]:
    """R = sum a/sum b over the parts of a record and the half width of its interval,

        t_{0.975, n-1} sqrt(n/(n-1) sum (a - R b)^2)/sum b

    with n the parts whose b is not zero: the others say nothing of R. nan where all b are zero, and for the interval
    where fewer than three are not.
    """
    if not below.sum():
        return float("nan"), float("nan")
    ratio, n = float(above.sum() / below.sum()), int((below > 0).sum())
    if n < 3:
        return ratio, float("nan")
    scatter = np.sqrt(n / (n - 1) * ((above - ratio * below) ** 2).sum())
    return ratio, float(student.ppf(0.975, n - 1) * scatter / below.sum())


@dataclass(frozen=True)
class Profile:
    """Means over slices of the height y/D with the half widths of their intervals."""

    height: np.ndarray
    mean: np.ndarray
    half: np.ndarray
    samples: np.ndarray

    def largest(self, low: float, high: float) -> tuple[float, float, float] | None:
        """(mean, half width, y/D) of the slice between both heights with the largest |mean|."""
        rows = np.flatnonzero((self.height >= low) & (self.height < high))
        if len(rows) == 0:
            return None
        row = rows[np.argmax(np.abs(self.mean[rows]))]
        return float(self.mean[row]), float(self.half[row]), float(self.height[row])

    def between(self, low: float, high: float) -> tuple[float, float] | None:
        """Mean of all samples between both heights and its half width, that of the slices as if they rose
        and fell together."""
        rows = (self.height >= low) & (self.height < high)
        total = self.samples[rows].sum()
        if not total:
            return None
        weights = self.samples[rows] / total
        return float((weights * self.mean[rows]).sum()), float((weights * self.half[rows]).sum())


def height_edges(top: float) -> np.ndarray:
    """Edges of bins of 0.02 in y/D from the floor to above `top`, in whole slices of 0.1."""
    slices = math.ceil(top / 0.1 - 1e-9)
    return np.linspace(0.0, 0.1 * slices, COARSE * slices + 1)


def _quantile(y: np.ndarray, counts: np.ndarray, share: float) -> float:
    """Middle `y` of the bin in which `share` of the samples is reached, to rounding; nan without samples."""
    below = np.cumsum(counts)
    if not below[-1]:
        return float("nan")
    return float(y[np.searchsorted(below, (share - 1e-12) * below[-1])])


def _mean_and_interval(values: np.ndarray, counts: np.ndarray) -> tuple[float, float]:
    """Mean of `values` (bins) over the samples of all parts (parts, bins), and its half width."""
    total = float(counts.sum())
    with np.errstate(invalid="ignore", divide="ignore"):
        means = (values * counts).sum(axis=1) / counts.sum(axis=1)
    mean = float((values * counts.sum(axis=0)).sum() / total) if total else float("nan")
    return mean, half_width_of(means)


def _empty(edges: np.ndarray) -> np.ndarray:
    return np.zeros((PARTS, 3, len(edges) - 1))


def smooth(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean over `width` bins: histograms of a short record are ragged."""
    return np.convolve(values, np.full(width, 1.0 / width), mode="same") if width > 1 else values


def _centres(edges: np.ndarray) -> np.ndarray:
    return 0.5 * (edges[1:] + edges[:-1])


def _density(edges: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    area = max(float(counts.sum()), 1.0) * np.diff(edges)
    return _centres(edges), counts / area


def _bins(edges: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray | slice]:
    """Bin of each value between equal edges, and which values lie between them at all."""
    count = len(edges) - 1
    place = (values - edges[0]) * (count / (edges[-1] - edges[0]))
    if place.min() >= 0 and place.max() < count:
        return place.astype(np.intp).ravel(), slice(None)
    inside = (place >= 0) & (place < count)
    return place[inside].astype(np.intp), inside


class _Counter:
    """Adds frames to a Transport."""

    def __init__(
        self, phases: Phases, bulk_velocity: float, diameter: float, instants: np.ndarray, heights: np.ndarray
    ):
        self.result = Transport(phases, heights=heights)
        self._weight = InstantWeights(instants)
        self._first = instants[0]
        self._length = max(instants[-1] - instants[0], 1e-300)
        self._velocity, self._diameter = bulk_velocity, diameter
        self._tags, first = np.unique(phases.tag, return_index=True)
        self._rows = np.append(first, len(phases.tag))

    def add(self, part: Frames) -> None:
        columns, grains = known_columns(part.tag, self._tags)
        if len(columns) == 0:  # grains with a single sample have no phases
            return
        part = part.columns(columns)
        velocity = part.velocity[..., 0] / self._velocity
        height = part.position[..., 1] / self._diameter
        spin = part.angular_velocity[..., 2] * (self._diameter / self._velocity)
        state = self._states(part.time, grains)
        r = self.result
        r.time.append(part.time)
        r.count.append(np.full(len(part.time), len(columns)))
        for name, values in (("velocity", velocity), ("height", height), ("spin", spin)):
            getattr(r, name).append(values.mean(axis=1))
        r.share.append(np.stack([(state == s).mean(axis=1) for s in range(len(NAMES))], axis=1))
        speed = np.linalg.norm(part.velocity, axis=2) / self._velocity
        r.moving.append((speed > RESTING_SPEED).mean(axis=1))

        through = (part.time - self._first) / self._length
        of_part = np.clip((PARTS * through).astype(np.intp), 0, PARTS - 1)
        of_part = np.repeat(of_part[:, None], height.shape[1], axis=1)
        sample = np.broadcast_to(self._weight(part.time)[:, None], height.shape)
        place, inside = _bins(r.heights, height)
        place += r.height_parts.shape[2] * of_part[inside].ravel()
        counted = sample[inside].ravel()
        weights = (counted, counted * spin[inside].ravel(), counted * velocity[inside].ravel())
        moves = (state != RESTING)[inside].ravel()
        for row, weight in enumerate(weights):
            for parts, kept in ((r.height_parts, slice(None)), (r.moving_parts, moves)):
                sums = np.bincount(place[kept], weight[kept], parts[:, row].size)
                parts[:, row] += sums.reshape(PARTS, -1)
        for counts, edges, values in (
            (r.spin_parts, SPIN_EDGES, spin),
            (r.velocity_parts, VELOCITY_EDGES, velocity),
        ):
            place, inside = _bins(edges, values)
            place += counts.shape[2] * (3 * of_part[inside] + state[inside]).ravel()
            counts += np.bincount(place, sample[inside].ravel(), counts.size).reshape(counts.shape)
        place = (len(NAMES) * of_part + state).ravel()
        for total, of_sample in zip(r.spin_sums, (sample, sample * np.abs(spin)), strict=True):
            total += np.bincount(place, of_sample.ravel(), total.size).reshape(total.shape)

    def _states(self, time: np.ndarray, grains: np.ndarray) -> np.ndarray:
        """State of each grain (n) at each instant (m); shape (m, n)."""
        phases = self.result.phases
        begin, end = self._rows[grains], self._rows[grains + 1]
        first = np.maximum(first_above(phases.start, begin, end, time[0]) - 1, begin)
        last = first_above(phases.start, begin, end, time[-1])
        rows, column = pieces(first, last)
        # A phase has the instants from its beginning to the next one's; each grain's first has those before, too.
        begins = np.searchsorted(time, phases.start[rows])
        begins[np.cumsum(last - first) - (last - first)] = 0
        ends = np.where(np.diff(column, append=-1) != 0, len(time), np.append(begins[1:], 0))
        return np.repeat(phases.state[rows], ends - begins).reshape(len(grains), len(time)).T


def measure(run: Run, since: float = 0.0) -> Transport:
    """Everything about the grains of `run` from the time `since` on.

    Raises UnknownContacts, too, where the run was cut off or wrote of no collisions.
    """
    ranges = time_ranges(run.instants(since=since))
    if not any(last > first for first, last in ranges.values()):
        raise MissingOutput(f"{run.folder} has no mobile sphere with two samples after t = {since:g}.")
    phases = analyse(
        run.contacts(), ranges, run.sample_blocks(since=since), run.periods,
        run.bulk_velocity, run.diameter,
    )  # fmt: skip
    instants = run.sample_times(since=since)
    heights = height_edges(run.box[1] / run.diameter)
    counter = _Counter(phases, run.bulk_velocity, run.diameter, instants, heights)
    for part in frames(run.sample_blocks(since=since)):
        counter.add(part)
    counter.result.batches = batches_of((instants[-1] - instants[0]) * run.bulk_velocity / run.box[0])
    return counter.result


def creeping_slip(phases: Phases, diameter: float, edges: np.ndarray) -> tuple[np.ndarray, ...]:
    """(L/D, mean L_slip/D, half width of its 95 % interval) of complete creeping phases, by their length L."""
    rows = phases.complete & (phases.state == CREEPING)
    length, slip = phases.path[rows] / diameter, phases.slip[rows] / diameter
    place = np.digitize(length, edges) - 1
    bins = [slip[place == b] for b in range(len(edges) - 1)]
    kept = [b for b, values in enumerate(bins) if len(values) > 1]
    return (
        np.array([length[place == b].mean() for b in kept]),
        np.array([bins[b].mean() for b in kept]),
        np.array([half_width_of(bins[b]) for b in kept]),
    )


def jump_heights(phases: Phases, diameter: float) -> np.ndarray:
    """Heights over the take-off of all complete jumps, in D."""
    return phases.height[phases.complete & (phases.state == JUMPING)] / diameter
