"""Validation of many spheres together: viscosity of a suspension, settling beside each other. No study of its own."""

from dataclasses import dataclass

import numpy as np
from bedload_post.batches import estimate
from bedload_post.outputs import Run
from bedload_post.summary import relative_stress
from scipy.optimize import brentq

from .sphere_theory import VOLUME, standard_drag_coefficient
from .validation_runs import DIFFUSION, Curve, Result, Row, Runner, marks

FRACTIONS = (0.1, 0.2, 0.3)
BATCHES = 6


@dataclass(frozen=True)
class Suspension:
    """A run of `suspension`: cells to a diameter, volume fraction, and what differs from its scene."""

    cells: int
    fraction: float
    label: str = ""  # of the run's folder
    what: str = ""
    films: str = ""  # settings of fix lubrication
    height: float = 5.0  # between the walls [D]

    def settings(self, viscosity: float) -> dict[str, object]:
        """Of fluid.toml; the walls' speeds keep the shear rate at 1."""
        box, half = [8.0, self.height, 8.0], 0.5 * self.height
        return {
            "grid.cells": [round(self.cells * length) for length in box], "grid.length": box,
            "boundary.y_lower_velocity": [-half, 0.0, 0.0], "boundary.y_upper_velocity": [half, 0.0, 0.0],
            "time.step": DIFFUSION / self.cells**2 / viscosity,
        }  # fmt: skip

    def variables(self) -> dict[str, object]:
        """Of in.liggghts."""
        walls = {"fraction": self.fraction, "length_y": self.height, "wall_speed": 0.5 * self.height}
        return walls | ({"lubrication_settings": self.films} if self.films else {})


SUSPENSIONS = (
    *(Suspension(6, fraction) for fraction in FRACTIONS),
    Suspension(8, 0.2),
    Suspension(6, 0.3, "-rough", ", roughness 0.01 R", "gapMin 0.01"),
    Suspension(6, 0.3, "-rough-tall", ", roughness 0.01 R, walls 10 D apart", "gapMin 0.01", height=10.0),
    Suspension(6, 0.3, "-normal", ", no film against sliding, roughness 0.025 R", "tangential off gapMin 0.025"),
)


def eilers_viscosity(fraction):
    """Relative viscosity of a suspension of spheres, Eilers' fit with a largest packing of 0.6."""
    return (1.0 + 1.25 * fraction / (1.0 - fraction / 0.6)) ** 2


def zarraga_viscosity(fraction):
    """The same, fit of Zarraga, Hill and Leighton (J. Rheol. 44, 2000) to their suspensions without Brownian motion."""
    return np.exp(-2.34 * fraction) / (1.0 - fraction / 0.62) ** 3


def richardson_zaki_exponent(reynolds: float) -> float:
    """n of (1 - phi)^n at the Reynolds number of a sphere alone, Garside and Al-Dibouni (Ind. Eng. Chem. 16, 1977):
    (5.1 - n)/(n - 2.7) = 0.1 Re^0.9."""
    ratio = 0.1 * reynolds**0.9
    return (5.1 + 2.7 * ratio) / (1.0 + ratio)


def settling_reynolds(galileo: float) -> float:
    """Re = u D/nu of a sphere alone: C_D Re^2 = 4/3 Ga^2."""
    return float(brentq(lambda re: standard_drag_coefficient(re) * re**2 - 4.0 / 3.0 * galileo**2, 1e-6, 800.0))


def _fraction(run: Run, volume: float) -> float:
    return float(run.history()["mobile_spheres"][-1]) * VOLUME / volume


def _viscosity(run: Run) -> np.ndarray:
    """Relative viscosity, by what the fluid and spheres give to the walls, per row of history.csv."""
    return relative_stress(run, "wall") + relative_stress(run, "grain")


def _of_one_sphere(runner: Runner, n: int, width: int) -> float:
    """Intrinsic viscosity (stress - 1)/phi of one sphere in the middle of a shear cell `width` D wide."""
    viscosity, half = 25.0, 0.5 * width
    run = runner("shear", f"one-{n}-{width}", {
        "grid.cells": [n * width] * 3, "grid.length": [float(width)] * 3,
        "boundary.y_lower_velocity": [-half, 0.0, 0.0], "boundary.y_upper_velocity": [half, 0.0, 0.0],
        "time.step": DIFFUSION / n**2 / viscosity, "time.end": 0.02 * width**2,
    }, {"length": float(width)})  # fmt: skip
    return float(_viscosity(run)[-1] - 1.0) * width**3 / VOLUME


def suspension(runner: Runner) -> Result:
    """Relative viscosity of neutrally buoyant spheres in shear: one sphere, and volume fractions of 0.1 to 0.3."""
    result = Result("Viscosity of a suspension of spheres, shear R^2/nu = 0.1",
                    axes=("volume fraction", "relative viscosity"))  # fmt: skip
    # Walls and images raise what one sphere adds by a share that falls with the cell's volume.
    narrow, wide = 4, 6
    for n in (6, 8):
        added = (_of_one_sphere(runner, n, narrow), _of_one_sphere(runner, n, wide))
        free = (added[1] * wide**3 - added[0] * narrow**3) / (wide**3 - narrow**3)
        # Markers at the depth that is right for drag, which grows as R; what a sphere adds here grows as R^3.
        result.rows.append(Row(f"viscosity that one sphere adds over its volume fraction, D/h = {n}", free, 2.5,
                               0.03, source="Einstein 1906"))  # fmt: skip
    viscosity = 2.5
    found: dict[str, list[tuple[float, float]]] = {}
    for case in SUSPENSIONS:
        label = f"suspension-{case.fraction:g}-{case.cells}{case.label}"
        run = runner("suspension", label, case.settings(viscosity), case.variables())
        there = _fraction(run, 64.0 * case.height)
        mean = estimate(_viscosity(run)[run.history()["time"] > 4.0], BATCHES)
        reference = float(eilers_viscosity(there))
        name = f"D/h = {case.cells}{case.what}"
        # Eilers and Zarraga differ by 16 % at 0.3.
        result.rows.append(Row(
            f"relative viscosity at {there:.3f}, {name}, +- {mean.half_width:.2f} (95 %)", mean.mean, reference,
            0.15, source=f"Eilers; Zarraga et al. 2000 have {float(zarraga_viscosity(there)):.2f}",
        ))  # fmt: skip
        found.setdefault(name, []).append((there, mean.mean))
    for name, points in found.items():
        result.curves.append(marks(name, points))
    across = np.linspace(0.0, 0.32, 60)
    for name, fit in (("Eilers", eilers_viscosity), ("Zarraga et al. 2000", zarraga_viscosity)):
        result.curves.append(Curve(name, across.tolist(), fit(across).tolist()))
    result.remarks.append(
        "Means over a strain of 4 to 10 of what the fluid and the spheres give to the walls, with actm_hw and a "
        "friction coefficient of 0.15; walls 5 D apart and films down to a roughness of 0.001 R where nothing else is "
        "said. What "
        "one sphere adds is of two cells, 4 D and 6 D wide, less what falls with the cell's volume."
    )
    return result


def mean_fall(run: Run, since: float) -> np.ndarray:
    """Mean of all spheres' speed downwards at each instant."""
    means = []
    for block in run.sample_blocks(since=since):
        first = np.flatnonzero(np.diff(block.time, prepend=-np.inf))
        means.append(-np.add.reduceat(block.velocity[:, 0], first) / np.diff(first, append=len(block)))
    return np.concatenate(means)


def structure_factor(fraction: float) -> float:
    """S(0) of hard spheres at random places, Carnahan and Starling (J. Chem. Phys. 51, 1969)."""
    return (1.0 - fraction) ** 4 / ((1.0 + 2.0 * fraction) ** 2 + fraction**3 * (fraction - 4.0))


def slower_by_images(fraction: float, spheres: float) -> float:
    """By how much `spheres` of a periodic box settle more slowly than in an endless suspension, over the speed of one
    alone. Hasimoto (J. Fluid Mech. 5, 1959) has 1.7601 (phi/N)^(1/3) for one sphere and its images; of many at random
    places the share S(0) of the force is not evened out, in a fluid of the suspension's viscosity (Ladd, J. Chem. Phys.
    93, 1990). Stokes flow."""
    images = 1.7601 * (fraction / spheres) ** (1.0 / 3.0)
    return images * structure_factor(fraction) / float(eilers_viscosity(fraction))


def hindered(runner: Runner) -> Result:
    """Settling of many spheres beside each other, Ga = 10, volume fractions of 0.1 to 0.3."""
    galileo = 10.0
    alone = settling_reynolds(galileo)
    exponent = richardson_zaki_exponent(alone)
    result = Result("Many spheres that settle beside each other, Ga = 10, D/h = 6",
                    axes=("volume fraction", "speed over that of a sphere alone"))  # fmt: skip
    points: dict[float, list[tuple[float, float]]] = {}
    for fraction, width in [(fraction, 8.0) for fraction in FRACTIONS] + [(0.1, 12.0)]:
        settings = {"grid.cells": [round(6 * width)] * 3, "grid.length": [width] * 3}
        label = f"hindered-{fraction:g}" + ("" if width == 8.0 else f"-{width:g}")
        run = runner("hindered", label, settings, {"fraction": fraction, "length": width})
        there = _fraction(run, width**3)
        mean = estimate(mean_fall(run, since=20.0) * galileo / alone, BATCHES)
        slower = slower_by_images(there, there * width**3 / VOLUME)
        points.setdefault(width, []).append((there, mean.mean + slower))
        result.rows.append(Row(
            f"speed at {there:.3f} over that of a sphere alone: in a box {width:g} D wide {mean.mean:.3f} +- "
            f"{mean.half_width:.3f} (95 %), and {slower:.3f} that its images take", mean.mean + slower,
            (1.0 - there) ** exponent, 0.15, source="Richardson & Zaki 1954, n of Garside & Al-Dibouni 1977",
        ))  # fmt: skip
    for width, of_width in points.items():
        result.curves.append(marks(f"box {width:g} D wide, images made up for", of_width))
    across = np.linspace(0.0, 0.32, 60)
    result.curves.append(Curve(f"(1 - phi)^{exponent:.2f}", across.tolist(), ((1.0 - across) ** exponent).tolist()))
    result.remarks.append(
        f"A sphere alone: Re = {alone:.2f} (Schiller & Naumann). Means from t = 20 to 100 D/u_g. What images take of "
        "the speed falls with the width of the box: 1.7601 (phi/N)^(1/3) S(0)/mu_r (Hasimoto 1959; Ladd 1990; Stokes "
        "flow). The law is fitted to suspensions in vessels and known to about a tenth; spheres in periodic boxes "
        "settle by about as much more slowly (Yin & Koch 2007, from memory), hence the bound."
    )
    return result


CASES = {"suspension": suspension, "hindered": hindered}
