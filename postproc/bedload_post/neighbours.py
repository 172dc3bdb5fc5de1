"""Whether several grains in one box feel each other: several far apart then stand for several runs.

The nearest other grain is looked for over the periodic ends. A grain's wake and its turbulence are gone some
five diameters away; so grains are near within NEAR. Two more tests: the correlation of the velocities of two
grains at the same instant, zero where they know nothing of each other, and the mean velocity of grains that
have another one near, beside that of those that have none.
"""

from dataclasses import dataclass

import numpy as np

from .batches import half_width_of
from .frames import frames
from .outputs import Run

NEAR = 5.0  # D
PARTS = 10  # of the record, for the intervals


@dataclass(frozen=True)
class Neighbours:
    """Of the grains of one run; half widths are of 95 % intervals, nan where too little is there."""

    share_near: float  # of the time with another grain within NEAR
    closest: float  # D
    correlation: float  # of u_p, mean over the pairs
    correlation_interval: float
    velocity_near: float  # u_b
    velocity_far: float
    velocity_difference_interval: float

    @property
    def independent(self) -> bool | None:
        """None where it cannot be told; False where a test finds that they feel each other."""
        tests = []
        if np.isfinite(self.correlation_interval):
            tests.append(abs(self.correlation) <= self.correlation_interval)
        if np.isfinite(self.velocity_difference_interval):
            difference = abs(self.velocity_near - self.velocity_far)
            tests.append(difference <= self.velocity_difference_interval)
        return all(tests) if tests else None

    def sentence(self) -> str:
        verdict = {True: "no influence on each other found", False: "they feel each other",
                   None: "too short to tell whether they feel each other"}[self.independent]  # fmt: skip
        together = "" if np.isnan(self.correlation_interval) else (
            f", velocities of two correlate by {self.correlation:.2f} ± {self.correlation_interval:.2f}"
        )  # fmt: skip
        beside = "" if np.isnan(self.velocity_difference_interval) else (
            f", near ones go by {self.velocity_near - self.velocity_far:+.3f} ± "
            f"{self.velocity_difference_interval:.3f} u_b faster than far ones"
        )  # fmt: skip
        return (
            f"another grain is within {NEAR:g} D for {100 * self.share_near:.1f} % of the time "
            f"(closest {self.closest:.2f} D){together}{beside}: {verdict}"
        )


def distances(position: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Distance to the nearest other grain, shape (m, n), of n grains at m instants (m, n, 3)."""
    nearest = np.empty(position.shape[:2])
    for grain in range(position.shape[1]):  # one after the other: all pairs of a block would take a gigabyte
        apart = position - position[:, grain : grain + 1]
        for d in np.flatnonzero(np.isfinite(periods)):
            apart[..., d] -= periods[d] * np.round(apart[..., d] / periods[d])
        found = np.sqrt((apart**2).sum(axis=2))
        found[:, grain] = np.inf
        nearest[:, grain] = found.min(axis=1)
    return nearest


def measure(run: Run, since: float = 0.0) -> Neighbours | None:
    """From `since` on; None where there are fewer than two grains that stay."""
    nearest: list[np.ndarray] = []
    speed: list[np.ndarray] = []
    for part in frames(run.sample_blocks(since=since)):
        if len(part.tag) < 2 or (speed and speed[0].shape[1] != len(part.tag)):
            return None
        nearest.append(distances(part.position, run.periods) / run.diameter)
        speed.append(part.velocity[..., 0] / run.bulk_velocity)
    return of_series(np.concatenate(nearest), np.concatenate(speed)) if speed else None


def of_series(nearest: np.ndarray, speed: np.ndarray) -> Neighbours:
    """From distances to the nearest [D] and velocities [u_b] of n grains at m instants, both (m, n)."""
    near = nearest < NEAR
    fluctuation = speed - speed.mean(axis=0)
    deviation = np.maximum(fluctuation.std(axis=0), np.finfo(float).tiny)
    count = speed.shape[1]
    # Mean over the pairs of u_i' u_j'/(s_i s_j), at each instant.
    scaled = fluctuation / deviation
    pairs = 0.5 * (scaled.sum(axis=1) ** 2 - (scaled**2).sum(axis=1)) / (0.5 * count * (count - 1))
    parts = np.array([part.mean() for part in np.array_split(pairs, min(PARTS, len(pairs)))])
    differences = []
    for u, close in zip(np.array_split(speed, PARTS), np.array_split(near, PARTS), strict=True):
        if close.any() and not close.all():
            differences.append(u[close].mean() - u[~close].mean())
    return Neighbours(
        float(near.mean()), float(nearest.min()), float(pairs.mean()), half_width_of(parts),
        float(speed[near].mean()) if near.any() else float("nan"),
        float(speed[~near].mean()) if not near.all() else float("nan"),
        half_width_of(differences),
    )  # fmt: skip
