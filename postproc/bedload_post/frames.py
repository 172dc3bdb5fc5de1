"""Samples by instant: the same grains at successive times, as arrays (instants, grains).

A run samples all its grains at each instant in the same order, so a block of rows is a rectangle and
its sums run over whole columns at once. Where grains come or go within a block, one rectangle ends and
the next one begins.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from .outputs import PER_GRAIN, Motion, Samples


class Frames(Motion):
    """time (m), tag (n); position, velocity and angular_velocity (m, n, 3), radius (m, n)."""

    def columns(self, which: np.ndarray) -> "Frames":
        """Some of the grains, by their places."""
        if len(which) == len(self.tag) and np.array_equal(which, np.arange(len(which))):
            return self
        parts = (getattr(self, name)[:, which] for name in PER_GRAIN)
        return Frames(self.time, self.tag[which], *parts)


def grains_per_instant(time: np.ndarray, tag: np.ndarray) -> int:
    """n where the rows are whole instants of the same n grains in the same order, else 0."""
    count = int(np.searchsorted(time, time[0], side="right")) if len(time) else 0
    if count == 0 or len(time) % count:
        return 0
    times, tags = time.reshape(-1, count), tag.reshape(-1, count)
    whole = (times == times[:, :1]).all() and (tags == tags[0]).all()
    return count if whole and (np.diff(times[:, 0]) > 0).all() else 0


def group(keys: np.ndarray) -> Iterable[tuple[int, np.ndarray]]:
    """(key, rows with that key in their order) for each different key."""
    order = np.argsort(keys, kind="stable")
    keys_sorted, starts = np.unique(keys[order], return_index=True)
    return zip(keys_sorted.tolist(), np.split(order, starts)[1:], strict=True)


def frames(blocks: Iterable[Samples]) -> Iterator[Frames]:
    """Rectangles of the samples in the order of time, each with all grains of its instants."""
    for block in blocks:
        count = grains_per_instant(block.time, block.tag)
        if count:
            yield _rectangle(block, count)
        else:
            ordered = block.rows(np.lexsort((block.tag, block.time)))
            for rows, count in same_grains(ordered.time, ordered.tag):
                yield _rectangle(ordered.rows(rows), count)


def same_grains(time: np.ndarray, tag: np.ndarray) -> Iterator[tuple[slice, int]]:
    """Rows of successive instants with the same grains, and how many these are.

    The rows are in the order of time, and of `tag` at each instant.
    """
    first = np.flatnonzero(np.diff(time, prepend=-np.inf) > 0)  # row of each instant
    counts = np.diff(first, append=len(time))
    others = np.append(True, counts[1:] != counts[:-1])  # than at the instant before
    instant = np.repeat(np.arange(len(first)), counts)
    rows = np.flatnonzero(~others[instant])
    others[instant[rows[tag[rows] != tag[rows - counts[instant[rows]]]]]] = True
    begin = np.flatnonzero(others)
    ends = np.append(first[begin[1:]], len(time))
    for start, end, count in zip(first[begin], ends, counts[begin], strict=True):
        yield slice(int(start), int(end)), int(count)


def _rectangle(block: Samples, count: int) -> Frames:
    parts = (getattr(block, name) for name in PER_GRAIN)
    return Frames(
        block.time[::count],
        block.tag[:count],
        *(part.reshape(-1, count, *part.shape[1:]) for part in parts),
    )


def time_ranges(instants: Iterable[tuple[np.ndarray, np.ndarray]]) -> dict[int, tuple[float, float]]:
    """First and last sample time of each grain, by tag, from blocks of (time, tag)."""
    ranges: dict[int, tuple[float, float]] = {}
    for time, tag in instants:
        count = grains_per_instant(time, tag)
        if count:
            tags, first, last = tag[:count], time[:count], time[-count:]
        else:
            tags, at_first = np.unique(tag, return_index=True)
            _, from_end = np.unique(tag[::-1], return_index=True)
            first, last = time[at_first], time[len(tag) - 1 - from_end]
        for one, a, b in zip(tags.tolist(), first.tolist(), last.tolist(), strict=True):
            ranges[one] = (ranges.get(one, (a, b))[0], b)
    return ranges


def known_columns(tag: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which of `tag` (n) are in the sorted `known`, and where there."""
    place = np.searchsorted(known, tag)
    if len(known) == 0:
        return np.zeros(0, dtype=int), place[:0]
    columns = np.flatnonzero(known[np.minimum(place, len(known) - 1)] == tag)
    return columns, place[columns]


def first_above(values: np.ndarray, begin: np.ndarray, end: np.ndarray, limit: float) -> np.ndarray:
    """Of ascending pieces begin ... end (n) of `values` where in each the first one above `limit` stands, or its end.

    All pieces are halved at once: a loop over the grains takes longer than all else where there are many.
    """
    low, high = begin.copy(), end.copy()
    while (open_ := low < high).any():
        middle = (low + high) // 2
        below = open_ & (values[np.where(open_, middle, 0)] <= limit)
        low = np.where(below, middle + 1, low)
        high = np.where(open_ & ~below, middle, high)
    return low


def pieces(begin: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All rows of the pieces begin ... end (n), one piece after the other, and which piece each row is of."""
    counts = end - begin
    column = np.repeat(np.arange(len(begin)), counts)
    within = np.arange(len(column)) - np.repeat(np.cumsum(counts) - counts, counts)
    return begin[column] + within, column
