"""The mobile spheres of one run, from its start to its end, beside what they can touch."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bedload_post.frames import Frames, frames
from bedload_post.outputs import MissingOutput, Run
from scipy.spatial import cKDTree

ALL_ROWS = 1 << 40  # in one block


@dataclass(frozen=True)
class Trajectories(Frames):
    """Of a run in which no sphere comes or goes. box, periods (3): edges, infinite between walls; bed
    (k, 3), bed_radius (k): fixed spheres."""

    box: np.ndarray
    periods: np.ndarray
    bed: np.ndarray
    bed_radius: np.ndarray

    @classmethod
    def of(cls, folder: Path) -> "Trajectories":
        run = Run(folder)
        rectangles = list(frames(run.sample_blocks(ALL_ROWS)))
        if len(rectangles) != 1:
            raise MissingOutput("spheres came or went")
        (f,) = rectangles
        return cls(
            f.time, f.tag, f.position, f.velocity, f.angular_velocity, f.radius,
            run.box, run.periods, *run.fixed_spheres(),
        )  # fmt: skip

    def fastest(self) -> float:
        """Largest speed of any sphere at any time; not a number where a value is none."""
        return float(np.max(np.linalg.norm(self.velocity, axis=2)))

    def kinetic_energy(self, densities: Sequence[float] | np.ndarray = (1.0,)) -> np.ndarray:
        """Sum of rho R^3 (u^2 / 2 + R^2 omega^2 / 5) over the spheres, shape (m): energy over 4/3 pi.
        densities: of each sphere, or one of all."""
        u2 = np.sum(self.velocity**2, axis=2)
        w2 = np.sum(self.angular_velocity**2, axis=2)
        return np.sum(np.asarray(densities) * self.radius**3 * (0.5 * u2 + 0.2 * self.radius**2 * w2), axis=1)

    def travel(self) -> np.ndarray:
        """Way of each sphere from its start to its end, the velocities summed up, shape (n, 3)."""
        return np.trapz(self.velocity, self.time, axis=0)

    def nearest_image(self, apart: np.ndarray) -> np.ndarray:
        wide = np.isfinite(self.periods)
        apart = apart.copy()
        apart[..., wide] -= self.periods[wide] * np.round(apart[..., wide] / self.periods[wide])
        return apart

    def overlaps(self) -> np.ndarray:
        """Deepest overlap of a mobile sphere with another one, the bed, or a wall at each instant;
        negative: the narrowest gap. Shape (m)."""
        deepest = np.full(len(self.time), -np.inf)
        for m in range(len(self.time)):
            x, r = self.position[m], self.radius[m]
            all_x, all_r = np.concatenate([x, self.bed]), np.concatenate([r, self.bed_radius])
            ways = [self._deepest_of_pairs(all_x, all_r, len(x))]
            for axis in np.flatnonzero(~np.isfinite(self.periods)):
                ways += [np.max(r - x[:, axis]), np.max(x[:, axis] + r - self.box[axis])]
            deepest[m] = max(map(float, ways))
        return deepest

    def _deepest_of_pairs(self, x: np.ndarray, r: np.ndarray, mobile: int) -> float:
        """Deepest overlap of the pairs of which one is among the first `mobile` spheres. Where some overlap, the
        deepest one is among those no farther apart than two of the largest radius; of many spheres few are."""
        wide = np.isfinite(self.periods)
        edges = np.where(wide, self.periods, 0.0)  # 0: not periodic
        inside = x.copy()
        inside[:, wide] %= edges[wide]
        inside[:, wide] *= inside[:, wide] < edges[wide]  # a remainder may be rounded up to the edge
        pairs = cKDTree(inside, boxsize=edges).query_pairs(2.0 * float(np.max(r)), output_type="ndarray")
        i, j = pairs[pairs[:, 0] < mobile].T
        if len(i):
            deepest = float(np.max(r[i] + r[j] - np.linalg.norm(self.nearest_image(x[i] - x[j]), axis=1)))
            if deepest >= 0.0:
                return deepest
        gap = np.linalg.norm(self.nearest_image(x[:mobile, None] - x[None]), axis=2) - r[:mobile, None] - r[None]
        gap[np.arange(mobile), np.arange(mobile)] = np.inf
        return -float(np.min(gap))

    def deepest_overlap(self) -> float:
        return float(np.max(self.overlaps()))
