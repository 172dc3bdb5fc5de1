"""Means over a correlated record with a confidence interval from batches.

The record is cut into K equal batches; where one is much longer than the memory of the signal, the
batch means are as good as independent and

    mean +- t_{0.975, K-1} s / sqrt(K),        s: their standard deviation,

holds the true mean in 95 % of all records. `memory` is the correlation of neighbouring batch means;
well above zero, the batches are too short and the interval too narrow.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

MOST_BATCHES = 10
FEWEST_BATCHES = 4  # t_{0.975, 3} = 3.2; with fewer the interval says little


def batches_of(memory_times: float) -> int:
    """How many batches a record of so many memory times bears: none shorter than one of them."""
    return int(min(max(memory_times, FEWEST_BATCHES), MOST_BATCHES))


@dataclass(frozen=True)
class Estimate:
    """A mean, the half width of its 95 % interval (nan below two batches), and the batch means."""

    mean: float
    half_width: float
    batches: np.ndarray

    @property
    def memory(self) -> float:
        """Correlation of a batch's mean with the next one's."""
        deviation = self.batches - self.batches.mean()
        square = float((deviation**2).sum())
        return float((deviation[1:] * deviation[:-1]).sum()) / square if square > 0 else 0.0

    def __str__(self) -> str:
        return f"{self.mean:.3f} ± {self.half_width:.3f}"


def estimate(
    values: np.ndarray, batches: int = MOST_BATCHES, weights: np.ndarray | None = None
) -> Estimate:
    """From a series of equal steps in time, at least one value to a batch.

    `weights`: how many samples each value is the mean of; None: of equally many.
    """
    count = min(batches, len(values))
    weights = np.ones(len(values)) if weights is None else weights
    parts = zip(np.array_split(values, count), np.array_split(weights, count), strict=True)
    means = np.array([np.average(part, weights=weight) for part, weight in parts])
    half_width = np.nan
    if count > 1:
        half_width = student.ppf(0.975, count - 1) * means.std(ddof=1) / np.sqrt(count)
    return Estimate(float(np.average(values, weights=weights)), float(half_width), means)
