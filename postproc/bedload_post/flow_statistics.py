"""statistics.h5 of one run, or of several that go on from each other, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .outputs import MissingOutput, Run, open_hdf5

FILE = "statistics.h5"
SQUARES = {"uu": ("u", "u"), "ww": ("w", "w"), "pp": ("p", "p"), "vv": ("v", "v"),
           "uv": ("u", "v"), "uw": ("u", "w"), "vw": ("v", "w")}  # fmt: skip


@dataclass(frozen=True)
class Spectra:
    """One-sided spectra at one height: `along["u_x"]` over wave numbers `k["x"]`, mode 0 left out."""

    height: float
    k: dict[str, np.ndarray]
    along: dict[str, np.ndarray]


@dataclass(frozen=True)
class FlowStatistics:
    """Averages over x, z and time; profiles as in fluid/output/README.md."""

    samples: int
    begin: float
    end: float
    driving: float
    wall_stress: np.ndarray
    u_tau: float  # nan where neither a wall nor a bed holds the flow
    stress_defect: float | None  # None with spheres
    viscosity: float
    density: float
    profiles: dict[str, np.ndarray]
    spectra: list[Spectra]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.profiles[name]

    @property
    def total_stress(self) -> np.ndarray:
        """mu d<u>/dy - rho <u v> at faces."""
        return self["viscous"] + self["turbulent"]

    def at_centres(self, name: str) -> np.ndarray:
        """A profile at the cell centres; those at faces as the mean of two."""
        values = self[name]
        return 0.5 * (values[1:] + values[:-1]) if len(values) > len(self["y"]) else values


def read(run: Run) -> FlowStatistics:
    """The statistics in a run's output folder."""
    path = run.folder / FILE
    if not path.is_file():
        raise MissingOutput(f"{run.folder} has no {FILE} (statistics.every in fluid.toml).")
    with open_hdf5(path) as file:
        numbers = {name: file.attrs[name] for name in file.attrs}
        profiles = {name: file["profiles"][name][:] for name in file["profiles"]}
        spectra = []
        for name in sorted(file.get("spectra", {}), key=lambda text: int(text.split("_")[1])):
            group, step = file["spectra"][name], file["spectra"].attrs["wavenumber_step"]
            lines = {f"{q}_{d}": group[f"{q}_along_{d}"][1:] for q in "uvw" for d in "xz"}
            k = {
                d: step[n] * np.arange(1, len(lines[f"u_{d}"]) + 1) for n, d in enumerate("xz")
            }
            spectra.append(Spectra(float(group.attrs["height"]), k, lines))
    return FlowStatistics(
        int(numbers["samples"]), float(numbers["begin"]), float(numbers["end"]),
        float(numbers["driving"]), numbers["wall_stress"], float(numbers.get("u_tau", np.nan)),
        numbers.get("stress_defect"), run.viscosity, run.value("fluid.density"), profiles, spectra,
    )  # fmt: skip


def _mean_of_product(one: FlowStatistics, name: str) -> np.ndarray:
    """<a b> = <a'b'> + <a><b>, the means brought to where the product stands."""
    first, second = (one[part] for part in SQUARES[name])
    points = len(one[name])
    return one[name] + _at(first, points) * _at(second, points)


def _at(values: np.ndarray, points: int) -> np.ndarray:
    if len(values) == points:
        return values
    inner = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([values[:1], inner, values[-1:]])


def _times(parts: Sequence[FlowStatistics]) -> np.ndarray:
    """Time that the samples of each piece stand for, each for as long as two are apart: `begin` is the first one's
    instant. One sample alone is taken for as long as those of the other pieces."""
    samples = np.array([part.samples for part in parts], dtype=float)
    apart = np.array([(part.end - part.begin) / max(part.samples - 1, 1) for part in parts])
    known = samples > 1
    return samples * np.where(known, apart, np.mean(apart[known]) if known.any() else 1.0)


def combine(parts: Sequence[FlowStatistics]) -> FlowStatistics:
    """One statistics of several pieces of the same flow, each weighted by its time."""
    if len(parts) == 1:
        return parts[0]
    weights = _times(parts)
    weights /= weights.sum()

    def mean(of):
        return sum(weight * of(part) for weight, part in zip(weights, parts, strict=True))

    profiles = {}
    for name in parts[0].profiles:
        if name not in SQUARES:
            profiles[name] = mean(lambda part, name=name: part[name])
    for name, (a, b) in SQUARES.items():
        product = mean(lambda part, name=name: _mean_of_product(part, name))
        points = len(product)
        profiles[name] = product - _at(profiles[a], points) * _at(profiles[b], points)
    spectra = [
        Spectra(
            first.height, first.k,
            {key: mean(lambda part, n=n, key=key: part.spectra[n].along[key]) for key in first.along},
        )
        for n, first in enumerate(parts[0].spectra)
    ]  # fmt: skip
    wall_stress = mean(lambda part: part.wall_stress)
    last = max(parts, key=lambda part: part.end)
    total = profiles["viscous"] + profiles["turbulent"]
    height = profiles["y_face"][-1]
    u_tau = float(np.sqrt(mean(lambda part: part.u_tau**2)))
    line = total[0] + (total[-1] - total[0]) * profiles["y_face"] / height
    return FlowStatistics(
        sum(part.samples for part in parts), min(part.begin for part in parts), last.end,
        float(mean(lambda part: part.driving)), wall_stress, u_tau,
        None if any(part.stress_defect is None for part in parts) else
        float(np.abs(total - line).max() / (last.density * u_tau**2)),
        last.viscosity, last.density, profiles, spectra,
    )  # fmt: skip


def read_all(folders: Sequence[Path]) -> FlowStatistics:
    """The statistics of several output folders of one flow as one."""
    return combine([read(Run(folder)) for folder in folders])


@dataclass(frozen=True)
class WallProfiles:
    """Profiles over the distance from the wall in wall units; both halves of a channel averaged."""

    u_tau: float
    reynolds: float  # with the half height
    y: np.ndarray  # cell centres, y+
    u: np.ndarray
    rms: dict[str, np.ndarray]  # u, v, w at the centres
    uv: np.ndarray
    y_face: np.ndarray
    stress: np.ndarray  # total, over rho u_tau^2, at faces


def wall_profiles(s: FlowStatistics) -> WallProfiles:
    """Both halves of a channel between two walls as one, in wall units.

    rms at the centres: v'v' there is the mean of the two faces.
    """
    planes = len(s["y"])
    half = (planes + 1) // 2
    height = s["y_face"][-1]
    length = s.viscosity / s.u_tau

    def fold(values, sign):
        return 0.5 * (values + sign * values[::-1])

    centre = slice(0, half)
    rms = {
        q: np.sqrt(np.maximum(fold(s.at_centres(q + q), 1), 0.0))[centre] / s.u_tau for q in "uvw"
    }
    faces = slice(0, planes // 2 + 1)
    return WallProfiles(
        s.u_tau, 0.5 * height / length,
        s["y"][centre] / length, fold(s["u"], 1)[centre] / s.u_tau, rms,
        fold(s.at_centres("uv"), -1)[centre] / s.u_tau**2,
        s["y_face"][faces] / length,
        fold(s.total_stress, -1)[faces] / (s.density * s.u_tau**2),
    )  # fmt: skip
