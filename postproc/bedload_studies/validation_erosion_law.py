"""Validation case: how the flux of grains of a thick bed grows with the Shields number (Kidanemariam & Uhlmann 2014).
A case of validation.py."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from bedload_post import flow_statistics
from bedload_post.flow_statistics import FlowStatistics
from bedload_post.outputs import Run
from scipy.stats import t as student

from .suspension_rheology import BedUnderFlow, bed_under_flow
from .validation_erosion import RHEOLOGY, Changes, flux_samples, fluxes, height_above, surface_of
from .validation_runs import Curve, Result, Row, Runner

CUBE = "Kidanemariam & Uhlmann 2014"
GALILEO = (9.0, 7.4, 6.1, 5.0)  # Ga: gravity alone varies, which the flow hardly feels
REYNOLDS = 250.0  # Re_b = q_f/nu
DENSITY = 2.5  # rho_p/rho_f
BED, CLEAR_HEIGHT = 9.1, 10.0  # D: height of bed_shallow.data at the start, of the fluid above it
TOP = 19.0  # D: the box
STEP = 0.005  # D^2/nu
STRAIN = 6.0 * REYNOLDS / CLEAR_HEIGHT**2  # nu/D^2: shear rate at the bed's surface
END = 32.0  # D^2/nu: until the layers that move have taken in the fluid by which they dilate
# A tangential damper that Coulomb's friction limits, as theirs, and one that bears loads at rest, too.
DAMPER, AT_REST = "actm_hw", "actm_hw_static"
CLEAR = 0.1  # grains' share of the volume at which the clear fluid begins (Kidanemariam & Uhlmann 2014, from memory)


def law_run(galileo: float, model: str) -> Changes:
    """Changes of fluid.toml and in.liggghts of `laminar_erosion` for a bed of 9 D of that Galileo number under a flow
    of Re_b = 250. The friction coefficient is that of the paper, 0.4."""
    gravity = round(galileo**2 / (DENSITY - 1.0), 6)
    fluid: dict[str, object] = {
        "grid.cells": [48, round(6.0 * TOP), 36], "grid.length": [8.0, TOP, 6.0],
        "fluid.gravity": [0.0, -gravity, 0.0], "fluid.diffusion": "explicit",
        "flow.bulk_velocity": REYNOLDS / TOP,
        "start.velocity": REYNOLDS / CLEAR_HEIGHT, "start.height": BED,
        "time.step": STEP, "time.end": END, "coupling.dem_steps": 15,
        "output.spheres_every": 0.1, "statistics.from": END / 2.0,
        "reference.velocity": REYNOLDS / CLEAR_HEIGHT, "reference.height": CLEAR_HEIGHT,
        "reference.sphere_density": DENSITY, "accuracy.precision": "single",
    }  # fmt: skip
    return fluid, {"model": model, "bed_file": "bed_shallow.data", "length_y": TOP, "density": DENSITY,
                   "gravity": gravity, "friction": 0.4}  # fmt: skip


@dataclass(frozen=True)
class Point:
    """One run of the law: Shields numbers of the upper wall's stress and of the parabola, flux over Ga^2 nu, and that
    of a suspension's rheology."""

    stress: float
    parabola: float
    flux: float
    rheology: float
    rows: list[Row]


def viscous_flux(run: Run) -> float:
    """Ga^2 nu = (rho_p/rho_f - 1) g D^3/nu, to which the flux for a unit width is referred."""
    return run.submerged_weight / run.value("fluid.density") * run.diameter**3 / run.viscosity


def law_point(run: Run, window: tuple[float, float]) -> tuple[float, float]:
    """Shields number of the upper wall's stress and the grains' flux over Ga^2 nu, means over `window`."""

    def mean(time: np.ndarray, values: np.ndarray) -> float:
        return float(np.mean(values[(time >= window[0]) & (time <= window[1])]))

    history = run.history()
    stress = mean(history["time"], np.abs(history["wall_stress_upper"]))
    return stress / (run.submerged_weight * run.diameter), mean(*flux_samples(run)) / viscous_flux(run)


def power_law(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float]:
    """Exponent n and factor c of y = c x^n by least squares of the logarithms, and half of the exponent's 95 %
    interval from the scatter about the line (Student's t with two degrees of freedom less than points)."""
    log_x, log_y = np.log(x), np.log(y)
    exponent, offset = np.polyfit(log_x, log_y, 1)
    freedom = len(x) - 2
    scatter = np.sum((log_y - exponent * log_x - offset) ** 2) / freedom
    error = np.sqrt(scatter / np.sum((log_x - log_x.mean()) ** 2))
    return float(exponent), float(np.exp(offset)), float(student.ppf(0.975, freedom) * error)


def shields_of_parabola(run: Run, s: FlowStatistics) -> tuple[float, float]:
    """Clear height over D and the Shields number 6 q_f/(nu Ga^2) (D/h_f)^2 of the plane Poiseuille flow in it, with
    h_f from where the grains' share of the volume is CLEAR."""
    height = height_above(s["y"], s["grains"], CLEAR, float(run.box[1])) / run.diameter
    return height, 6.0 * fluxes(s)[0] / viscous_flux(run) / height**2


def rheology_of_run(run: Run, s: FlowStatistics, height: float) -> BedUnderFlow:
    """What a suspension's rheology has under the fluid's flux in that clear height over D."""
    return bed_under_flow(fluxes(s)[0] / viscous_flux(run), height, CLEAR, surface_of(s) / run.diameter)


def flux_below(s: FlowStatistics, height: float) -> float:
    """Share of the grains' flux below a height."""
    flux = s["mobile"] * s["grain_u"] * np.diff(s["y_face"])
    return float(np.sum(flux[s["y"] < height]) / np.sum(flux))


def point_of(run: Run, name: str) -> Point:
    """Means over the second half of the run."""
    begin, middle, end = END / 2.0, 0.75 * END, END
    stress, flux = law_point(run, (begin, end))
    settling = law_point(run, (middle, end))[1] / law_point(run, (begin, middle))[1]
    s = flow_statistics.read(run)
    height, parabola = shields_of_parabola(run, s)
    rheology = rheology_of_run(run, s, height)
    return Point(stress, parabola, flux, rheology.flux, [
        Row(f"{name}: Shields number of the upper wall's stress", stress, rheology.wall_stress, source=RHEOLOGY),
        Row(f"{name}: h_f/D, from a packing of {CLEAR:g} to the wall", height),
        Row(f"{name}: Shields number of the parabola over that height", parabola),
        Row(f"{name}: flux of grains / (Ga^2 nu)", flux, rheology.flux, source=RHEOLOGY),
        Row(f"{name}: flux of grains over fluid", fluxes(s)[1] / fluxes(s)[0]),
        Row(f"{name}: flux, second half of that time over the first", settling, 1.0, STEADY, source="steady"),
        Row(f"{name}: share of the flux more than 2 D below the bed's surface",
            flux_below(s, surface_of(s) - 2.0 * run.diameter)),
        Row(f"{name}: share of the flux in the lowest third of the bed", flux_below(s, surface_of(s) / 3.0)),
    ])  # fmt: skip


# What half of the averaged time may change of the flux: as much alters the exponent by 0.1 between the ends.
STEADY = 0.15


def erosion_law(runner: Runner) -> Result:
    """Flux of the grains over the Shields number, in viscous units: q_p/(Ga^2 nu) grows as its cube."""
    result = Result(f"Flux of the grains over the Shields number, Re_b = {REYNOLDS:g}, D/h = 6",
                    axes=("Shields number", "flux of grains / (Ga^2 nu)"), logarithmic=True)  # fmt: skip
    result.remarks.append(
        f"A bed of 9 D of grains of rho_p/rho_f = {DENSITY:g} under a laminar flow of Re_b = {REYNOLDS:g}; gravity "
        f"alone varies. Means over the second half of a strain of about {STRAIN * END:.0f} at the bed's surface. "
        "Kidanemariam and Uhlmann's Shields number is that of the plane Poiseuille flow over the clear height. "
        "The bound asks that the exponent is nearer to 3 than to 2 or 4."
    )

    def point(galileo: float, model: str, name: str) -> Point:
        run = runner("../laminar_erosion", f"erosion-law-{galileo:g}-{model}", *law_run(galileo, model))
        found = point_of(run, name)
        result.rows.extend(found.rows)
        return found

    points = [point(galileo, DAMPER, f"Ga = {galileo:g}") for galileo in GALILEO]
    point(GALILEO[1], AT_REST, f"Ga = {GALILEO[1]:g}, with friction at rest")
    flux = np.array([point.flux for point in points])
    shields, stress = np.array([p.parabola for p in points]), np.array([p.stress for p in points])
    exponent, factor, half = power_law(shields, flux)
    other, other_factor, other_half = power_law(stress, flux)
    result.rows += [
        Row(f"exponent of the Shields number (parabola, as theirs), +- {half:.2f} (95 %)", exponent, 3.0, 0.5 / 3.0,
            source=CUBE),
        Row("flux / (Ga^2 nu) at a Shields number of 1 by that fit", factor),
        Row(f"exponent of the Shields number (upper wall's stress), +- {other_half:.2f} (95 %)", other, 3.0,
            source=CUBE),
        Row("flux / (Ga^2 nu) at a Shields number of 1 by that fit (wall's stress)", other_factor),
    ]  # fmt: skip
    result.rows += [
        Row(f"exponent between the Shields numbers {one.parabola:.2f} and {two.parabola:.2f}",
            float(np.log(two.flux / one.flux) / np.log(two.parabola / one.parabola)), 3.0, source=CUBE)
        for one, two in zip(points, points[1:], strict=False)
    ]  # fmt: skip
    ends = np.array([shields.min(), shields.max()])
    cube = float(np.exp(np.mean(np.log(flux) - 3.0 * np.log(shields))))
    result.curves += [
        Curve("runs", np.round(shields, 5).tolist(), np.round(flux, 6).tolist(), points=True),
        Curve("runs, Shields number of the upper wall's stress", np.round(stress, 5).tolist(),
              np.round(flux, 6).tolist(), points=True),
        Curve(f"fit, exponent {exponent:.2f} +- {half:.2f}", ends.tolist(), (factor * ends**exponent).tolist()),
        Curve(f"rheology of a suspension, {RHEOLOGY}", np.round(shields, 5).tolist(),
              np.round([point.rheology for point in points], 6).tolist()),
        Curve(f"cube, {cube:.2f} times", ends.tolist(), (cube * ends**3).tolist()),
    ]  # fmt: skip
    return result


CASES: dict[str, Callable[[Runner], Result]] = {"erosion_law": erosion_law}
