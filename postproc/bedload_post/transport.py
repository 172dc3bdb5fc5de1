"""What the grains of one run do after the start-up: series, distributions, profiles over height.

Velocities are in u_b, lengths in D, angular velocities in u_b/D. All samples count alike, however many
grains there are at an instant: runs sample at equal intervals.
"""

from dataclasses import dataclass, field

import numpy as np

from .batches import FEWEST_BATCHES, Estimate, batches_of, estimate
from .frames import Frames, frames, known_columns, time_ranges
from .outputs import MissingOutput, Run
from .states import CREEPING, JUMPING, NAMES, Phases, analyse

HEIGHT_EDGES = np.linspace(1.0, 6.0, 251)  # y/D
SPIN_EDGES = np.linspace(-3.0, 3.0, 241)  # omega_3 D/u_b
VELOCITY_EDGES = np.linspace(-0.5, 1.5, 201)  # u_p/u_b


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
    by_height: np.ndarray = field(default_factory=lambda: np.zeros((3, len(HEIGHT_EDGES) - 1)))
    spins: np.ndarray = field(default_factory=lambda: np.zeros((3, len(SPIN_EDGES) - 1)))
    velocities: np.ndarray = field(default_factory=lambda: np.zeros((3, len(VELOCITY_EDGES) - 1)))

    def series(self, name: str) -> np.ndarray:
        return np.concatenate(getattr(self, name))

    def mean(self, name: str) -> Estimate:
        """Mean of a series with its interval."""
        return estimate(self.series(name), self.batches, self.series("count"))

    def share_of(self, state: int) -> Estimate:
        """Share of time in `state`."""
        return estimate(self.series("share")[:, state], self.batches, self.series("count"))

    @property
    def samples(self) -> int:
        return sum(map(len, self.time))

    def height_pdf(self) -> tuple[np.ndarray, np.ndarray]:
        """(y/D, probability density) of the grains' centres."""
        return _density(HEIGHT_EDGES, self.by_height[0])

    def over_height(self, row: int) -> tuple[np.ndarray, np.ndarray]:
        """(y/D, mean omega_3 (row 1) or mean u_p (row 2)); where at least 50 samples lie."""
        enough = self.by_height[0] >= 50
        with np.errstate(invalid="ignore"):
            return _centres(HEIGHT_EDGES)[enough], (self.by_height[row] / self.by_height[0])[enough]

    def spin_pdf(self, state: int) -> tuple[np.ndarray, np.ndarray]:
        return _density(SPIN_EDGES, self.spins[state])

    def velocity_pdf(self, state: int) -> tuple[np.ndarray, np.ndarray]:
        return _density(VELOCITY_EDGES, self.velocities[state])


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

    def __init__(self, phases: Phases, bulk_velocity: float, diameter: float):
        self.result = Transport(phases)
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

        place, inside = _bins(HEIGHT_EDGES, height)
        for row, weight in enumerate((None, spin[inside].ravel(), velocity[inside].ravel())):
            r.by_height[row] += np.bincount(place, weight, minlength=r.by_height.shape[1])
        for counts, edges, values in (
            (r.spins, SPIN_EDGES, spin),
            (r.velocities, VELOCITY_EDGES, velocity),
        ):
            place, inside = _bins(edges, values)
            place += counts.shape[1] * state[inside].ravel()
            counts += np.bincount(place, minlength=counts.size).reshape(counts.shape)

    def _states(self, time: np.ndarray, grains: np.ndarray) -> np.ndarray:
        """State of each grain (n) at each instant (m); shape (m, n)."""
        state = np.empty((len(time), len(grains)), dtype=np.int64)
        phases = self.result.phases
        for column, grain in enumerate(grains.tolist()):
            rows = slice(self._rows[grain], self._rows[grain + 1])
            start, of_phase = phases.start[rows], phases.state[rows]
            first = max(int(np.searchsorted(start, time[0], side="right")) - 1, 0)
            last = int(np.searchsorted(start, time[-1], side="right"))
            begins = np.searchsorted(time, start[first + 1 : last])
            counts = np.diff(begins, prepend=0, append=len(time))
            state[:, column] = np.repeat(of_phase[first:last], counts)
        return state


def measure(run: Run, since: float = 0.0) -> Transport:
    """Everything about the grains of `run` from the time `since` on."""
    ranges = time_ranges(run.instants(since=since))
    if not any(last > first for first, last in ranges.values()):
        raise MissingOutput(f"{run.folder} has no mobile sphere with two samples after t = {since:g}.")
    phases = analyse(
        run.collisions(), ranges, run.sample_blocks(since=since), run.periods,
        run.bulk_velocity, run.diameter,
    )  # fmt: skip
    counter = _Counter(phases, run.bulk_velocity, run.diameter)
    for part in frames(run.sample_blocks(since=since)):
        counter.add(part)
    record = max(last for _, last in ranges.values()) - min(first for first, _ in ranges.values())
    counter.result.batches = batches_of(record * run.bulk_velocity / run.box[0])
    return counter.result


def creeping_slip(phases: Phases, diameter: float, edges: np.ndarray) -> tuple[np.ndarray, ...]:
    """(L/D, mean L_slip/D, its standard error) of complete creeping phases, by their length L."""
    rows = phases.complete & (phases.state == CREEPING)
    length, slip = phases.path[rows] / diameter, phases.slip[rows] / diameter
    place = np.digitize(length, edges) - 1
    bins = [slip[place == b] for b in range(len(edges) - 1)]
    kept = [b for b, values in enumerate(bins) if len(values) > 1]
    return (
        np.array([length[place == b].mean() for b in kept]),
        np.array([bins[b].mean() for b in kept]),
        np.array([bins[b].std(ddof=1) / np.sqrt(len(bins[b])) for b in kept]),
    )


def jump_heights(phases: Phases, diameter: float) -> np.ndarray:
    """Heights over the take-off of all complete jumps, in D."""
    return phases.height[phases.complete & (phases.state == JUMPING)] / diameter
