"""The mobile spheres of one run as arrays over samples and spheres."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bedload_post.outputs import Run, Samples


@dataclass(frozen=True)
class Trajectories:
    """n samples of m spheres: time (n); position, velocity, angular_velocity (n, m, 3); radius (m).

    Only for runs in which no sphere comes or goes.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    radius: np.ndarray
    periods: np.ndarray

    @classmethod
    def of(cls, folder: Path) -> "Trajectories":
        run = Run(folder)
        blocks = list(run.sample_blocks())
        names = Samples.__dataclass_fields__
        all_rows = Samples(*(np.concatenate([getattr(b, n) for b in blocks]) for n in names))
        order = np.lexsort((all_rows.tag, all_rows.time))
        rows = all_rows.rows(order)
        spheres = len(np.unique(rows.tag))
        shape = (len(rows) // spheres, spheres)
        vectors = (rows.position, rows.velocity, rows.angular_velocity)
        return cls(
            rows.time.reshape(shape)[:, 0], *(v.reshape(*shape, 3) for v in vectors),
            rows.radius.reshape(shape)[0], run.periods,
        )  # fmt: skip

    def fastest(self) -> float:
        """Largest speed of any sphere at any time; not a number where a value is none."""
        return float(np.max(np.linalg.norm(self.velocity, axis=2)))

    def kinetic_energy(self) -> np.ndarray:
        """Sum of R^3 (u^2 / 2 + R^2 omega^2 / 5) over the spheres, shape (n): energy over 4/3 pi rho."""
        u2 = np.sum(self.velocity**2, axis=2)
        w2 = np.sum(self.angular_velocity**2, axis=2)
        return np.sum(self.radius**3 * (0.5 * u2 + 0.2 * self.radius**2 * w2), axis=1)

    def pair_gap(self, i: int, j: int) -> np.ndarray:
        """Distance between the surfaces of two spheres over time, the nearest images taken."""
        apart = self.position[:, i] - self.position[:, j]
        wide = np.isfinite(self.periods)
        apart[:, wide] -= self.periods[wide] * np.round(apart[:, wide] / self.periods[wide])
        return np.linalg.norm(apart, axis=1) - self.radius[i] - self.radius[j]
