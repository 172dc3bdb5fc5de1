"""How densely spheres lie: their share of the volume between two heights; how far they overlap. No study of its own."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

FAR = 1e9  # a period that nothing reaches, for the direction that is not periodic


@dataclass(frozen=True)
class Bed:
    """Spheres in a box that is periodic along x and z: centres (n, 3), radii (n), lengths of the box along x and z."""

    position: np.ndarray
    radius: np.ndarray
    box: tuple[float, float]

    @property
    def volume(self) -> float:
        return float(np.sum(4.0 / 3.0 * np.pi * self.radius**3))

    def volume_below(self, height: float) -> float:
        """Volume of the spheres below the plane y = height: caps pi h^2 (3 R - h)/3."""
        h = np.clip(height - (self.position[:, 1] - self.radius), 0.0, 2.0 * self.radius)
        return float(np.sum(np.pi * h**2 * (3.0 * self.radius - h) / 3.0))

    def surface(self, floor: float) -> float:
        """Height of the bed's top: the layer of constant packing above `floor` with the same mean height of volume."""
        weight = self.radius**3
        return 2.0 * float(np.sum(weight * self.position[:, 1]) / weight.sum()) - floor

    def packing(self, floor: float = 0.0) -> float:
        """Share of the volume that the spheres take from one largest diameter above `floor` to one below the top."""
        diameter = 2.0 * float(self.radius.max())
        low, high = floor + diameter, self.surface(floor) - diameter
        if high - low < diameter:  # thin beds: all between the floor and the top
            low, high = floor, self.surface(floor)
        inside = self.volume_below(high) - self.volume_below(low)
        return inside / ((high - low) * self.box[0] * self.box[1])

    def overlap(self) -> float:
        """Largest overlap of two spheres, or of one with the floor y = 0 [L]; negative: the smallest gap."""
        period = (self.box[0], FAR, self.box[1])
        tree = cKDTree(np.mod(self.position, period), boxsize=period)
        pairs = tree.query_pairs(2.0 * float(self.radius.max()), output_type="ndarray")
        deepest = float(np.max(self.radius - self.position[:, 1]))
        if len(pairs) == 0:
            return deepest
        first, second = pairs.T
        apart = self.position[first] - self.position[second]
        for axis, length in ((0, self.box[0]), (2, self.box[1])):
            apart[:, axis] -= length * np.round(apart[:, axis] / length)
        distance = np.linalg.norm(apart, axis=1)
        return max(deepest, float(np.max(self.radius[first] + self.radius[second] - distance)))
