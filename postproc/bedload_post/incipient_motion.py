"""Onset of motion: transport rate and share of moving grains over the Shields number, and their threshold.

    theta = u_tau^2 / ((s - 1) g D),   q* = q / sqrt((s - 1) g D^3),   s = rho_p/rho_f,

with u_tau the friction velocity of the bed without mobile grains and q the grains' volume that passes a
unit width in a unit of time: the sum of V u_p over the grains of an area A of bed, over A, with V = 4/3 pi R^3
of each grain.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .batches import Estimate

IN_MOTION = 0.1  # share of moving grains at the threshold (Vowinckel, Kempe & Froehlich)
# Shields number at which single grains move that stand 0.82 D above the grains under them, as in the pockets of
# a hexagonal layer: Fenton & Abbott, Proc. R. Soc. Lond. A 352 (1977). Shields' curve is for level beds.
EXPOSED_THRESHOLD = 0.01
WONG_PARKER_THRESHOLD, WONG_PARKER_POWER, WONG_PARKER_FACTOR = 0.047, 1.6, 4.93


@dataclass(frozen=True)
class Point:
    """What one run gives; estimates carry 95 % intervals."""

    model: str
    shields: float
    moving: Estimate  # share of the grains faster than 0.01 u_b
    not_resting: Estimate  # share of time creeping or jumping between two collisions
    velocity: Estimate  # mean of the grains over u_b
    transport: Estimate  # q*


@dataclass(frozen=True)
class Threshold:
    """A critical Shields number and the interval in which it is, whose ends are 0 and inf where the points do not reach
    them; nan where they do not reach the number."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        if math.isnan(self.value):
            return "not found"
        high = f"to {self.high:.4f}" if math.isfinite(self.high) else "or more"
        return f"{self.value:.4f} ({self.low:.4f} {high})"

    def holds(self, value: float) -> bool:
        return self.low <= value <= self.high

    def is_open_towards(self, value: float) -> bool:
        """Whether the interval has no end on the side of `value`, which then is not told apart."""
        return self.low == 0.0 if value < self.value else math.isinf(self.high)


UNKNOWN = Threshold(math.nan, math.nan, math.nan)


def wong_parker(shields):
    """q* over a plane bed of gravel, Wong & Parker 2006, Eq. (24): 4.93 (theta - 0.047)^1.6."""
    excess = np.maximum(np.asarray(shields, dtype=float) - WONG_PARKER_THRESHOLD, 0.0)
    return WONG_PARKER_FACTOR * excess**WONG_PARKER_POWER


def shields_curve(diameter_number: float) -> float:
    """Critical Shields number of Shields' diagram, Soulsby & Whitehouse 1997:

        0.30/(1 + 1.2 D*) + 0.055 (1 - exp(-0.020 D*)),   D* = D ((s - 1) g/nu^2)^(1/3).
    """
    d = diameter_number
    return 0.30 / (1.0 + 1.2 * d) + 0.055 * (1.0 - math.exp(-0.020 * d))


def flux_of(velocity: np.ndarray, radius: np.ndarray, area: float) -> np.ndarray:
    """q [L^2/T] of grains of velocity u_p along x and radius R, summed over the last axis; `area` of the bed [L^2]."""
    return (4.0 / 3.0 * math.pi * radius**3 * velocity).sum(axis=-1) / area


def flux_scale(diameter: float, weight: float) -> float:
    """q/q* = sqrt((s - 1) g D^3) [L^2/T]; `weight` (s - 1) g [L/T^2]."""
    return math.sqrt(weight * diameter**3)


def crossing(shields: ArrayLike, share: ArrayLike, level: float = IN_MOTION) -> float:
    """Shields number at which `share` passes `level` upwards for the last time, by straight lines
    between the points; nan where all are on one side."""
    theta, values = np.asarray(shields, dtype=float), np.asarray(share, dtype=float)
    order = np.argsort(theta)
    theta, values = theta[order], values[order]
    below = np.flatnonzero(values < level)
    if len(below) == 0 or below[-1] + 1 >= len(values):
        return math.nan
    k = below[-1]
    part = (level - values[k]) / (values[k + 1] - values[k])
    return float(theta[k] + part * (theta[k + 1] - theta[k]))


def threshold_of_share(points: Sequence[Point], level: float = IN_MOTION) -> Threshold:
    """Where `level` of the grains are in motion: the crossing of the means by straight lines, which is a guess.

    Between two Shields numbers nothing is known but that the share grows: the interval is from the last one at which
    the share's whole interval is below `level` to the first beyond the crossing at which all of it is above.
    """
    theta = np.array([p.shields for p in points])
    mean = np.array([p.moving.mean for p in points])
    half = np.array([p.moving.half_width for p in points])
    value = crossing(theta, mean, level)
    if math.isnan(value):
        return UNKNOWN
    below, above = theta[mean + half < level], theta[(mean - half > level) & (theta > value)]
    return Threshold(value, float(below.max(initial=0.0)), float(above.min(initial=math.inf)))


def threshold_of_transport(
    points: Sequence[Point], power: float = WONG_PARKER_POWER, draws: int = 2000
) -> Threshold:
    """Shields number at which q* goes to zero: the zero of the straight line through (theta, q*^(1/power)),
    least squares weighted by the intervals; its own interval from normal draws of the points, which scatter
    sqrt(chi^2/(n - 2)) times as far as their intervals say where the line misses them by more than these.

    Only points whose intervals of q* and of the share in motion leave zero out take part; with fewer than three, or
    where the line meets zero at no positive Shields number, it is not known.
    """
    taken = [p for p in points if all(e.mean - e.half_width > 0.0 for e in (p.moving, p.transport))]
    if len(taken) < 3:
        return UNKNOWN
    theta = np.array([p.shields for p in taken])
    mean = np.array([p.transport.mean for p in taken])
    deviation = np.array([p.transport.half_width for p in taken]) / 1.96
    value, misfit = _line(theta, mean, deviation, power)
    if not value > 0.0:
        return UNKNOWN
    deviation *= math.sqrt(max(1.0, misfit))
    random = np.random.default_rng(1)
    zeros = [
        _line(theta, np.maximum(random.normal(mean, deviation), 1e-12), deviation, power)[0]
        for _ in range(draws)
    ]
    low, high = np.nanquantile(zeros, [0.025, 0.975])
    return Threshold(value, max(0.0, float(low)), float(high))


def _line(theta: np.ndarray, rate: np.ndarray, deviation: np.ndarray, power: float) -> tuple[float, float]:
    """Zero of the weighted line through rate^(1/power), nan for one that does not rise, and chi^2 of the
    points over their number less two."""
    root = rate ** (1.0 / power)
    spread = deviation * root / (power * rate)  # of the root, by its derivative
    weights = 1.0 / np.maximum(spread, 1e-3 * root)
    slope, intercept = np.polyfit(theta, root, 1, w=weights)
    square = float((((root - slope * theta - intercept) * weights) ** 2).sum())
    return float(-intercept / slope) if slope > 0 else math.nan, square / max(len(theta) - 2, 1)


def complement(share: Estimate) -> Estimate:
    """The estimate of one minus a share."""
    return Estimate(1.0 - share.mean, share.half_width, 1.0 - share.batches)


def diameter_number(diameter: float, weight: float, viscosity: float) -> float:
    """D* = D ((s - 1) g/nu^2)^(1/3); `weight` (s - 1) g [L/T^2]."""
    return diameter * (weight / viscosity**2) ** (1.0 / 3.0)


def shields_threshold(diameter: float, friction_velocity: float, viscosity: float) -> float:
    """The Shields number at which gravity has grains of this bed lie on Shields' curve.

    D* holds gravity, and gravity follows from u_tau and the Shields number, (s - 1) g = u_tau^2/(theta D):
    the fixed point theta = shields_curve(D*(theta)).
    """
    theta = 0.05
    for _ in range(100):
        weight = friction_velocity**2 / (theta * diameter)
        theta = shields_curve(diameter_number(diameter, weight, viscosity))
    return theta
