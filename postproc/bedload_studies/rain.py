"""Spheres at random places in the air, none touching another, and their sizes. No study of its own."""

from itertools import product

import numpy as np

from bedload_launcher.errors import UserError

SHARE = 0.2  # of the air's volume that the rain takes; random places are free up to about 0.35
TRIES = 10000  # for one sphere
GAP = 1e-3  # at least, over the diameter


def read_sizes(text: str) -> list[tuple[float, float]]:
    """'1:0.8 0.7:0.2' -> [(1.0, 0.8), (0.7, 0.2)], diameters and their shares of the number of grains."""
    sizes = []
    for word in text.replace(",", " ").split():
        diameter, _, share = word.partition(":")
        try:
            sizes.append((float(diameter), float(share)))
        except ValueError:
            raise UserError(f"--sizes has '{word}', but must be DIAMETER:SHARE, for instance 1:0.8 0.7:0.2.") from None
    if not sizes or min(min(pair) for pair in sizes) <= 0.0 or not np.isfinite(sizes).all():
        raise UserError(f"--sizes is '{text}', but diameters and shares are above 0.")
    if abs(sum(share for _, share in sizes) - 1.0) > 1e-6:
        total = sum(share for _, share in sizes)
        raise UserError(f"--sizes is '{text}', whose shares add up to {total:g}, but must be 1 in all.")
    return sizes


def diameters(sizes: list[tuple[float, float]], grains: int) -> np.ndarray:
    """As many of each size as its share says, rounded so that they are `grains` in all; the largest first."""
    ends = np.round(np.cumsum([0.0] + [share for _, share in sizes]) * grains).astype(int)
    ends[-1] = grains
    return np.sort(np.repeat([diameter for diameter, _ in sizes], np.diff(ends)))[::-1]


def height_of_rain(diameter: np.ndarray, box: tuple[float, float]) -> float:
    return float(np.sum(np.pi / 6.0 * diameter**3)) / (SHARE * box[0] * box[1])


def rain(diameter: np.ndarray, box: tuple[float, float], bottom: float, seed: int) -> np.ndarray:
    """Centres (n, 3) at random, one sphere after the other, each free of those before it.

    box: periodic lengths along x and z; bottom: lowest height of a centre. Bins of the largest diameter hold the
    spheres found, so that a sphere looks at 27 of them.
    """
    random = np.random.default_rng(seed)
    largest, height = float(diameter.max()), height_of_rain(diameter, box)
    count = tuple(max(1, int(length / ((1.0 + GAP) * largest))) for length in box)
    bins: dict[tuple[int, int, int], list[tuple[float, float, float, float]]] = {}
    found = np.empty((len(diameter), 3))

    def neighbours(key: tuple[int, int, int]):
        along = {(key[0] + a) % count[0] for a in (-1, 0, 1)}
        aside = {(key[2] + a) % count[1] for a in (-1, 0, 1)}
        for i, j, k in product(along, (key[1] - 1, key[1], key[1] + 1), aside):
            yield from bins.get((i, j, k), ())

    def free(x: float, y: float, z: float, d: float, key: tuple[int, int, int]) -> bool:
        for ox, oy, oz, od in neighbours(key):
            dx, dz = abs(x - ox), abs(z - oz)
            dx, dz = min(dx, box[0] - dx), min(dz, box[1] - dz)
            if dx * dx + (y - oy) ** 2 + dz * dz < (0.5 * (1.0 + GAP) * (d + od)) ** 2:
                return False
        return True

    for n, d in enumerate(diameter.tolist()):
        for _ in range(TRIES):
            x, y, z = (random.random(3) * (box[0], height, box[1]) + (0.0, bottom, 0.0)).tolist()
            key = (int(x / box[0] * count[0]), int(y / ((1.0 + GAP) * largest)), int(z / box[1] * count[1]))
            if free(x, y, z, d, key):
                break
        else:
            raise UserError(f"no place is free in the air for grain {n + 1} of {len(diameter)}: the box is too narrow.")
        bins.setdefault(key, []).append((x, y, z, d))
        found[n] = x, y, z
    return found
