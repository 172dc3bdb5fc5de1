"""Resting, creeping, jumping: the states of grains between collisions.

Definitions of Vowinckel, Kempe, Froehlich, "Impact of collision models on particle transport in
open channel flow". Between two collisions a grain

    rests   if its mean speed is under 0.01 u_b,
    creeps  if the two collisions lie closer than 0.58 D (sqrt(3)/3 D, the step from one pocket of
            the bed to the next), and
    jumps   otherwise;

    L_slip = int |omega x R| dt - int |u_p| dt          (0: rolls, negative: slides),

with R from the grain's centre straight down to the bed. The jump's height is the highest point over
the take-off.

Two things the definitions leave open are settled here. A contact may last, and several may overlap
(a grain in its pocket): a grain's time is cut wherever one of its contacts begins or ends. While it
touches something it rests by the same speed, and otherwise creeps, since it never leaves the bed.
And the record begins and ends somewhere: the first and the last phase count in the shares of time,
but are not `complete` and stay out of jump heights and slip lengths.

The samples come in blocks in the order of time, so that their number is bounded by the disk alone;
per grain and block the work is a few vectorised sweeps.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from .outputs import Collisions, Samples

RESTING, CREEPING, JUMPING = 0, 1, 2
NAMES = ("resting", "creeping", "jumping")
RESTING_SPEED = 0.01  # of u_b
CREEPING_DISTANCE = 0.58  # of D


@dataclass(frozen=True)
class Phases:
    """One row per phase, by grain and then by time. Lengths in [L], times in [T]."""

    tag: np.ndarray
    start: np.ndarray
    end: np.ndarray
    contact: np.ndarray  # the grain touches something all along
    complete: np.ndarray  # begins and ends within the record
    path: np.ndarray  # int |u_p| dt
    roll: np.ndarray  # int |omega x R| dt
    distance: np.ndarray  # between both ends, periodic images unwrapped
    height: np.ndarray  # highest point over the beginning
    state: np.ndarray

    @property
    def duration(self) -> np.ndarray:
        return self.end - self.start

    @property
    def slip(self) -> np.ndarray:
        """L_slip of each phase."""
        return self.roll - self.path

    def jumps(self) -> np.ndarray:
        """Which rows are complete jumps."""
        return self.complete & (self.state == JUMPING)

    def shares(self) -> np.ndarray:
        """Share of the time spent resting, creeping, jumping; shape (3), sum 1."""
        time = np.bincount(self.state, weights=self.duration, minlength=3)
        return time / max(time.sum(), np.finfo(float).tiny)


def classify(
    speed: np.ndarray,
    distance: np.ndarray,
    contact: np.ndarray,
    bulk_velocity: float,
    diameter: float,
) -> np.ndarray:
    """State of each phase from its mean speed, the distance of its ends and whether it touches.

    `speed` [L/T], `distance` [L] and `contact` are of one length; returns as many states.
    """
    moving = np.where(contact | (distance < CREEPING_DISTANCE * diameter), CREEPING, JUMPING)
    return np.where(speed < RESTING_SPEED * bulk_velocity, RESTING, moving)


def unwrap(position: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Continuous positions (n, 3) of one grain from those inside a periodic box.

    `periods` (3): edge lengths, infinity where not periodic. A grain moves less than half a box
    from one sample to the next.
    """
    step = np.diff(position, axis=0)
    periodic = np.isfinite(periods)
    turns = np.zeros_like(step)
    turns[:, periodic] = np.round(step[:, periodic] / periods[periodic])
    shift = np.where(periodic, periods, 0.0) * np.cumsum(turns, axis=0)
    return np.concatenate([position[:1], position[1:] - shift])


def timeline(
    start: np.ndarray, end: np.ndarray, first: float, last: float
) -> tuple[np.ndarray, np.ndarray]:
    """Cuts one grain's record wherever a contact begins or ends.

    `start`, `end` (n): its contacts in any order; `first`, `last`: the record. Returns the edges
    (m+1) of its phases and which of the m touch something (m).
    """
    inside = (end > first) & (start < last)
    start, end = np.maximum(start[inside], first), np.minimum(end[inside], last)
    edges = np.unique(np.concatenate([[first, last], start, end]))
    # Contacts begun less contacts ended, counted at each phase's beginning.
    begun = np.searchsorted(np.sort(start), edges[:-1], side="right")
    ended = np.searchsorted(np.sort(end), edges[:-1], side="right")
    return edges, begun > ended


class _Grain:
    """Running sums of one grain over its phases, fed with samples in the order of time."""

    def __init__(self, edges: np.ndarray, contact: np.ndarray, periods: np.ndarray):
        self.edges, self.contact, self._periods = edges, contact, periods
        # At each edge: int |u| dt, int |omega x R| dt, unwrapped position.
        self._at_edge = np.full((len(edges), 5), np.nan)
        self._top = np.full(len(edges) - 1, -np.inf)
        self._last: tuple[np.ndarray, np.ndarray] | None = None  # time (1), row (1, 7)

    def add(self, samples: Samples) -> None:
        """Takes in the next samples of this grain."""
        time, position = samples.time, samples.position
        spin, radius = samples.angular_velocity, samples.radius
        speed = np.linalg.norm(samples.velocity, axis=1)
        # |omega x R| with R = (0, -R, 0)
        rolling = radius * np.hypot(spin[:, 0], spin[:, 2])
        sums = np.zeros((len(time), 2))
        if self._last is not None:
            before, row = self._last
            time = np.concatenate([before, time])
            position = np.concatenate([row[:, 4:7], position])
            speed, rolling = np.append(row[:, 2], speed), np.append(row[:, 3], rolling)
            sums = np.concatenate([row[:, :2], sums])
        position = unwrap(position, self._periods)
        half_step = 0.5 * np.diff(time)
        sums[1:, 0] = sums[0, 0] + np.cumsum(half_step * (speed[1:] + speed[:-1]))
        sums[1:, 1] = sums[0, 1] + np.cumsum(half_step * (rolling[1:] + rolling[:-1]))

        values = np.column_stack([sums, position])
        here = slice(*np.searchsorted(self.edges, [time[0], time[-1]], side="left") + [0, 1])
        for column in range(values.shape[1]):
            at = self.edges[here]
            at = at[at <= time[-1]]
            self._at_edge[here.start : here.start + len(at), column] = np.interp(
                at, time, values[:, column]
            )
        self._raise_tops(time, position[:, 1])
        self._last = (
            time[-1:],
            np.column_stack([sums[-1:], speed[-1:], rolling[-1:], position[-1:]]),
        )

    def _raise_tops(self, time: np.ndarray, y: np.ndarray) -> None:
        phase = np.clip(np.searchsorted(self.edges, time, side="right") - 1, 0, len(self._top) - 1)
        starts = np.flatnonzero(np.diff(phase, prepend=-1))
        touched = phase[starts]
        self._top[touched] = np.maximum(self._top[touched], np.maximum.reduceat(y, starts))

    def columns(self) -> dict[str, np.ndarray]:
        path, roll = np.diff(self._at_edge[:, :2], axis=0).T
        position = self._at_edge[:, 2:]
        y = position[:, 1]
        top = np.maximum(self._top, np.maximum(y[1:], y[:-1]))
        complete = np.ones(len(path), dtype=bool)
        complete[[0, -1]] = False
        return {
            "start": self.edges[:-1],
            "end": self.edges[1:],
            "contact": self.contact,
            "complete": complete,
            "path": path,
            "roll": roll,
            "distance": np.linalg.norm(np.diff(position, axis=0), axis=1),
            "height": top - y[:-1],
        }


def _time_ranges(blocks: Iterable[Samples]) -> dict[int, tuple[float, float]]:
    """First and last sample time of each grain, by tag."""
    ranges: dict[int, tuple[float, float]] = {}
    for block in blocks:
        tags, first = np.unique(block.tag, return_index=True)
        _, from_end = np.unique(block.tag[::-1], return_index=True)
        last = len(block) - 1 - from_end
        for tag, a, b in zip(tags.tolist(), block.time[first], block.time[last], strict=True):
            ranges[tag] = (ranges.get(tag, (a, b))[0], b)
    return ranges


def _group(keys: np.ndarray) -> Iterable[tuple[int, np.ndarray]]:
    """(key, rows with that key in their order) for each different key."""
    order = np.argsort(keys, kind="stable")
    keys_sorted, starts = np.unique(keys[order], return_index=True)
    return zip(keys_sorted.tolist(), np.split(order, starts)[1:], strict=True)


def analyse(
    collisions: Collisions,
    blocks: Callable[[], Iterable[Samples]],
    periods: np.ndarray,
    bulk_velocity: float,
    diameter: float,
) -> Phases:
    """The phases of every mobile grain.

    `blocks()` yields the samples afresh (they are read twice), `periods` (3) are the periodic edge
    lengths [L] (infinity at walls), `bulk_velocity` is u_b [L/T], `diameter` D [L].
    """
    ranges = _time_ranges(blocks())
    # A collision of two mobile grains belongs to both.
    tag = np.concatenate([collisions.tag_i, collisions.tag_j])
    start, end = np.tile(collisions.start, 2), np.tile(collisions.end, 2)
    rows_of = dict(_group(tag))
    none = np.empty(0, dtype=int)
    grains = {}
    for grain, (first, last) in ranges.items():
        if last > first:
            rows = rows_of.get(grain, none)
            edges, contact = timeline(start[rows], end[rows], first, last)
            grains[grain] = _Grain(edges, contact, periods)
    for block in blocks():
        for grain, rows in _group(block.tag):
            if grain in grains:
                grains[grain].add(block.rows(rows))
    return _table(grains, bulk_velocity, diameter)


def _table(grains: dict[int, _Grain], bulk_velocity: float, diameter: float) -> Phases:
    parts = [
        {"tag": np.full(len(grain.contact), tag), **grain.columns()}
        for tag, grain in sorted(grains.items())
    ]
    names = [name for name in Phases.__dataclass_fields__ if name != "state"]
    columns = {n: np.concatenate([part[n] for part in parts] or [np.empty(0)]) for n in names}
    for flag in ("contact", "complete"):
        columns[flag] = columns[flag].astype(bool)
    speed = columns["path"] / np.maximum(columns["end"] - columns["start"], np.finfo(float).tiny)
    state = classify(speed, columns["distance"], columns["contact"], bulk_velocity, diameter)
    return Phases(**columns, state=state)
