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
per block the work is a few sweeps over all its grains at once.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from .frames import Frames, first_above, frames, group, known_columns, pieces
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
    """Continuous positions (m, ..., 3) from those inside a periodic box, m instants.

    `periods` (3): edge lengths, infinity where not periodic. A grain moves less than half a box
    from one sample to the next.
    """
    unwrapped = position.copy()
    for d in np.flatnonzero(np.isfinite(periods)):
        turns = np.round(np.diff(position[..., d], axis=0) / periods[d])
        if turns.any():
            unwrapped[1:, ..., d] -= periods[d] * np.cumsum(turns, axis=0)
    return unwrapped


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


class Ledger:
    """Running sums of all grains over their phases, fed with frames in the order of time.

    Grain g owns the rows first[g] .. first[g+1]-1 of the edges; a phase has the row of the edge that
    it begins with, so each grain's last row belongs to no phase.
    """

    def __init__(self, edges: dict[int, np.ndarray], periods: np.ndarray):
        self.tags = np.array(sorted(edges), dtype=np.int64)
        parts = [edges[tag] for tag in self.tags.tolist()]
        self.first = np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(int)
        self.edges = np.concatenate(parts or [np.empty(0)])
        self._periods = periods
        count = len(self.tags)
        self._next = self.first[:-1].copy()  # the first edge that is still ahead
        self._time = np.full(count, np.nan)  # of the last sample
        self._last = np.zeros((7, count))  # its sums (2), speeds (2) and unwrapped position (3)
        # At each edge: int |u| dt, int |omega x R| dt, unwrapped position.
        self._at_edge = np.full((5, len(self.edges)), np.nan)
        self._top = np.full(len(self.edges), -np.inf)

    def add(self, frames: Frames) -> None:
        """Takes in the next frames; grains that nobody announced are left out."""
        columns, grains = known_columns(frames.tag, self.tags)
        # Grains that were seen last at different instants (some new, say) go one after the other.
        before = self._time[grains]
        for time in np.unique(before):
            same = np.isnan(before) if np.isnan(time) else before == time
            self._add(frames.columns(columns[same]), grains[same], time)

    def _add(self, frames: Frames, grains: np.ndarray, before: float) -> None:
        time, position = frames.time, frames.position
        # |omega x R| with R = (0, -R, 0)
        rate = np.empty((2, *position.shape[:2]))
        np.sqrt(np.einsum("fnd,fnd->fn", frames.velocity, frames.velocity), out=rate[0])
        spin = frames.angular_velocity
        np.hypot(spin[..., 0], spin[..., 2], out=rate[1])
        rate[1] *= frames.radius
        sums = np.zeros((2, len(grains)))
        if not np.isnan(before):
            last = self._last[:, grains]
            time = np.concatenate([[before], time])
            position = np.concatenate([last[None, 4:].swapaxes(1, 2), position])
            rate = np.concatenate([last[2:4, None], rate], axis=1)
            sums = last[:2]
        path = np.empty((5, len(time), len(grains)))
        path[:2, 0] = sums
        # Trapezoidal sums: one half (t' - t) (q' + q) after the other.
        half = 0.5 * np.diff(time)[:, None]
        np.cumsum(half * (rate[:, 1:] + rate[:, :-1]), axis=1, out=path[:2, 1:])
        path[:2, 1:] += sums[:, None]
        path[2:] = np.moveaxis(unwrap(position, self._periods), 2, 0)

        rows, column = self._edges_until(time[-1], grains)
        at = np.clip(np.searchsorted(time, self.edges[rows], side="right") - 1, 0, None)
        after = np.minimum(at + 1, len(time) - 1)
        step = np.maximum(time[after] - time[at], np.finfo(float).tiny)
        share = (self.edges[rows] - time[at]) / step
        value = path[:, at, column]
        self._at_edge[:, rows] = value + share * (path[:, after, column] - value)
        self._raise_tops(time, path[3], rows, column, grains)
        self._time[grains] = time[-1]
        self._last[:2, grains], self._last[4:, grains] = path[:2, -1], path[2:, -1]
        self._last[2:4, grains] = rate[:, -1]
        self._next[grains] += np.bincount(column, minlength=len(grains))

    def _edges_until(self, time: float, grains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the edges still ahead up to `time`, grain by grain, and whose each one is."""
        begin, end = self._next[grains], self.first[grains + 1]
        return pieces(begin, first_above(self.edges, begin, end, time))

    def _raise_tops(self, time, y, rows, column, grains) -> None:
        """top of each phase <- max(top, highest sample in it)."""
        phase, start = segments(time, self.edges, rows, column, self._next[grains])
        filled = np.diff(start, append=y.size) > 0
        highest = np.maximum.reduceat(y.T.ravel(), start)[filled]
        phase = phase[filled]
        self._top[phase] = np.maximum(self._top[phase], highest)

    def columns(self) -> dict[str, np.ndarray]:
        """The phases' columns, by grain and then by time."""
        phase = np.ones(len(self.edges), dtype=bool)
        phase[self.first[1:] - 1] = False  # the last edge of each grain begins nothing
        begin = np.flatnonzero(phase)
        end = begin + 1
        change = self._at_edge[:, end] - self._at_edge[:, begin]
        y = self._at_edge[3]
        owner = np.repeat(np.arange(len(self.tags)), np.diff(self.first))[begin]
        return {
            "tag": self.tags[owner],
            "start": self.edges[begin],
            "end": self.edges[end],
            "complete": (begin > self.first[owner]) & (end < self.first[owner + 1] - 1),
            "path": change[0],
            "roll": change[1],
            "distance": np.linalg.norm(change[2:], axis=0),
            "height": np.maximum(self._top[begin], np.maximum(y[begin], y[end])) - y[begin],
        }


def segments(
    time: np.ndarray, edges: np.ndarray, rows: np.ndarray, column: np.ndarray, ahead: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cuts frames, read grain after grain, where phases begin.

    `rows` of `edges` lie within `time` (m), those of grain c have `column` c; `ahead` (n) is each
    grain's first edge that was still ahead before. Returns the phase of each segment, and where it
    starts among the n m samples in grain order; a segment may be empty.
    """
    count = len(ahead)
    # The phase under way, then one per edge; a grain not yet begun has none and lends its first.
    grain = np.concatenate([np.arange(count), column])
    under_way = np.maximum(ahead - 1, 0)
    phase = np.concatenate([under_way, rows])
    start = np.concatenate([np.zeros(count, dtype=int), np.searchsorted(time, edges[rows])])
    order = np.lexsort((phase, start, grain))
    return phase[order], (start + grain * len(time))[order]


def analyse(
    collisions: Collisions,
    ranges: dict[int, tuple[float, float]],
    blocks: Iterable[Samples],
    periods: np.ndarray,
    bulk_velocity: float,
    diameter: float,
) -> Phases:
    """The phases of every mobile grain.

    `ranges`: first and last sample of each grain by tag; `blocks`: the samples; `periods` (3): edge
    lengths [L], infinity at walls; `bulk_velocity` is u_b [L/T], `diameter` D [L].
    """
    # A collision of two mobile grains belongs to both.
    tag = np.concatenate([collisions.tag_i, collisions.tag_j])
    start, end = np.tile(collisions.start, 2), np.tile(collisions.end, 2)
    rows_of = dict(group(tag))
    none = np.empty(0, dtype=int)
    edges, contact = {}, {}
    for grain, (first, last) in sorted(ranges.items()):
        if last > first:
            rows = rows_of.get(grain, none)
            edges[grain], contact[grain] = timeline(start[rows], end[rows], first, last)
    ledger = Ledger(edges, periods)
    for part in frames(blocks):
        ledger.add(part)
    columns = ledger.columns()
    touches = np.concatenate(list(contact.values()) or [np.empty(0)]).astype(bool)
    duration = columns["end"] - columns["start"]
    speed = columns["path"] / np.maximum(duration, np.finfo(float).tiny)
    state = classify(speed, columns["distance"], touches, bulk_velocity, diameter)
    return Phases(**columns, contact=touches, state=state)
