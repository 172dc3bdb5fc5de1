"""Validation cases: a thick bed under a viscous flow (Aussillous 2013, Biegert 2017). Cases of validation.py."""

from collections.abc import Callable
from functools import partial
from dataclasses import dataclass

import numpy as np

from bedload_post import flow_statistics
from bedload_post.batches import Estimate, estimate
from bedload_post.flow_statistics import FlowStatistics
from bedload_post.incipient_motion import flux_of
from bedload_post.outputs import Run

from .suspension_rheology import bed_under_flow
from .validation_runs import Curve, Result, Row, Runner, thin

GALILEO = 0.397
RHEOLOGY = "Boyer, Guazzelli & Pouliquen 2011"
LOOSE = 0.05  # grains' share of the volume at which the clear fluid begins
Changes = tuple[dict[str, object], dict[str, object]]  # of fluid.toml and of in.liggghts of the scene
MEASURED, COMPUTED = "Aussillous et al. 2013", "Biegert et al. 2017"


@dataclass(frozen=True)
class Reference:
    """Numbers of one flux: clear fluid's height over D, measured +- 0.5 and computed; Shields numbers."""

    reynolds: float
    height: float
    height_computed: float
    shields: float
    shields_computed: float
    flux: tuple[float, float]  # of the grains over the fluid's, range of the measurements
    changes: Changes = ({}, {})


CASES_OF_FLUX = (
    Reference(0.301, 7.05, 7.15, 0.24, 0.224, (5e-3, 1.9e-2)),
    Reference(0.402, 8.15, 8.31, 0.24, 0.222, (5e-3, 1.6e-2), (
        {"flow.bulk_velocity": 0.01806, "reference.velocity": 0.0493, "reference.height": 8.15,
         "start.velocity": 0.0493, "start.height": 14.4},
        {"bed_file": "bed_0.402.data"},
    )),
)


def height_above(y: np.ndarray, grains: np.ndarray, share: float, top: float) -> float:
    """Distance from the highest place where `grains` passes `share` to the upper wall at `top`; linear in between."""
    above = int(np.flatnonzero(grains > share)[-1])
    if above + 1 == len(y):
        return 0.0
    part = (grains[above] - share) / (grains[above] - grains[above + 1])
    return top - float(y[above] + part * (y[above + 1] - y[above]))


def height_of_stress(flux: float, stress: float, viscosity: float) -> float:
    """h of the plane Poiseuille flow with this flux and wall stress over rho: tau = 6 nu q/h^2."""
    return float(np.sqrt(6.0 * viscosity * flux / stress))


def height_of_flow(s: FlowStatistics) -> float:
    """The same of a run's flux of the fluid and the upper wall's stress."""
    return height_of_stress(fluxes(s)[0], float(s.wall_stress[1]) / s.density, s.viscosity)


def fluxes(s: FlowStatistics) -> tuple[float, float]:
    """Of the fluid and of the grains, for a unit width: sum over the planes of share, velocity and height."""
    dy = np.diff(s["y_face"])
    return float(np.sum(s["fluid"] * s["u"] * dy)), float(np.sum(s["mobile"] * s["grain_u"] * dy))


def surface_of(s: FlowStatistics) -> float:
    """The highest plane with more than half of the largest share of grains."""
    return float(s["y"][np.flatnonzero(s["grains"] > 0.5 * np.max(s["grains"]))[-1]])


def packing_inside(s: FlowStatistics, diameter: float) -> float:
    """Share of the grains from one diameter above the floor to one below the surface, as `./bedload settle` says it."""
    volume = s["grains"] * np.diff(s["y_face"])
    surface = 2.0 * float(np.sum(volume * s["y"]) / np.sum(volume))
    inside = (s["y"] > diameter) & (s["y"] < surface - diameter)
    return float(np.mean(s["grains"][inside] if inside.any() else s["grains"]))


def rows_of(s: FlowStatistics, top: float, reference: Reference, diameter: float) -> list[Row]:
    fluid, grains = fluxes(s)
    found = fluid / s.viscosity
    bulk = packing_inside(s, diameter)
    half = height_above(s["y"], s["grains"], 0.5 * bulk, top) / diameter
    loose = height_above(s["y"], s["grains"], LOOSE, top) / diameter
    stress = height_of_flow(s) / diameter

    def shields(height: float) -> float:
        return 6.0 * found / GALILEO**2 / height**2

    name = f"Re_b {reference.reynolds:g}"
    measured = f"{MEASURED}, +- 0.5; computed {reference.height_computed:g} ({COMPUTED})"
    low, high = reference.flux
    middle = 0.5 * (low + high)
    return [
        Row(f"{name}: Re_b of the fluid's flux", found, reference.reynolds, 0.02, source="set"),
        Row(f"{name}: h_f/D of the flux and the upper wall's stress", stress, reference.height,
            0.5 / reference.height, source=measured),
        Row(f"{name}: h_f/D, from half of the bed's packing to the wall", half, reference.height, source=measured),
        Row(f"{name}: h_f/D, from a packing of {LOOSE:g} to the wall", loose, reference.height, source=measured),
        Row(f"{name}: Shields number with the first of them", shields(stress), reference.shields, 0.15,
            source=f"{MEASURED}; computed {reference.shields_computed:g} ({COMPUTED})"),
        Row(f"{name}: flux of grains over fluid", grains / fluid, middle, (high - low) / (high + low),
            source=f"middle of {low:g} to {high:g}, {MEASURED}"),
        Row(f"{name}: the same beside what a suspension's rheology lets such a bed carry", grains / fluid,
            bed_under_flow(found / GALILEO**2, loose, LOOSE, surface_of(s) / diameter).flux / (found / GALILEO**2),
            source=RHEOLOGY),
        Row(f"{name}: packing from D above the floor to D below the surface", bulk, 0.609, 0.02, source=COMPUTED),
    ]  # fmt: skip


def flux_samples(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Times of the samples, and the grains' flux for a unit width in each."""
    times, values = [], []
    for block in run.sample_blocks():
        for time in np.unique(block.time):
            of = block.time == time
            times.append(float(time))
            values.append(float(flux_of(block.velocity[of, 0], block.radius[of], run.box[0] * run.box[2])))
    return np.array(times), np.array(values)


def fluxes_over_time(run: Run) -> tuple[float, float]:
    """Grains' flux for a unit width in the third and in the last quarter of the record, from the samples."""
    _, values = flux_samples(run)
    quarter = max(1, len(values) // 4)
    return float(np.mean(values[-2 * quarter : -quarter])), float(np.mean(values[-quarter:]))


# What a quarter of the time may change of the flux, for the flux's own bound (58 and 52 %) to say something.
STEADY = 0.2


def erosion_at(runner: Runner, reference: Reference) -> Result:
    """A thick bed of mobile grains under a viscous flow: h_f, Shields number, flux, profiles."""
    result = Result(f"Erosion of a thick bed by a viscous flow, Re_b {reference.reynolds:g}, D/h = 6",
                    axes=("share of the volume; velocity over the fluid's largest", "y / D"))  # fmt: skip
    result.remarks.append(
        "The number of grains sets the height of the clear fluid to within the bed's dilation, so that h_f and the "
        "Shields number test the stress over a bed that moves, and the flux tests how it moves. The box is "
        "8 D x 22.5 D x 6 D (11.3 D x 22.5 D x 11.3 D there), the bed as deep as there."
    )
    fluid, variables = reference.changes
    run = runner("../laminar_erosion", f"erosion-{reference.reynolds:g}", fluid, variables)
    s = flow_statistics.read(run)
    top, diameter = float(run.box[1]), run.diameter
    result.rows += rows_of(s, top, reference, diameter)
    before, last = fluxes_over_time(run)
    result.rows.append(Row(f"Re_b {reference.reynolds:g}: flux of grains, last quarter of the time over the third",
                           last / before, 1.0, STEADY, source="steady"))  # fmt: skip
    result.rows += without_rest(runner, reference)
    y, fastest = s["y"] / diameter, float(np.max(s["u"]))
    curve: Callable[[str, np.ndarray], Curve] = lambda label, x: Curve(
        f"Re_b {reference.reynolds:g}: {label}", np.round(x, 5).tolist(), np.round(y, 4).tolist()
    )
    result.curves += [curve("share of grains", s["grains"]), curve("fluid u", s["u"] / fastest),
                      curve("grains u", np.where(s["mobile"] > 1e-3, s["grain_u"], np.nan) / fastest)]  # fmt: skip
    return result


def without_rest(runner: Runner, reference: Reference) -> list[Row]:
    """The same with actm_hw, whose contacts have no friction at rest: h_f and the grains' flux."""
    fluid, variables = reference.changes
    label = f"erosion-{reference.reynolds:g}-actm_hw"
    run = runner("../laminar_erosion", label, fluid, dict(variables) | {"model": "actm_hw"})
    s = flow_statistics.read(run)
    flux, grains = fluxes(s)
    height = height_of_flow(s) / run.diameter
    before, last = fluxes_over_time(run)
    low, high = reference.flux
    name = f"Re_b {reference.reynolds:g}, actm_hw (no friction at rest)"
    return [
        Row(f"{name}: h_f/D of the flux and the upper wall's stress", height, reference.height, source=MEASURED),
        Row(f"{name}: flux of grains over fluid", grains / flux, 0.5 * (low + high),
            source=f"middle of {low:g} to {high:g}, {MEASURED}"),
        Row(f"{name}: flux of grains, last quarter of the time over the third", last / before, 1.0, source="steady"),
    ]  # fmt: skip


FIFTH = 500.0  # D^2/nu: as long as the scene says


def erosion_long(runner: Runner) -> Result:
    """The bed of Re_b 0.301 five times as long as the scene says: how its flux goes on."""
    result = Result("A thick bed under a viscous flow for a long time, Re_b 0.301, D/h = 6",
                    axes=("t nu / D^2", "flux of grains over fluid"))  # fmt: skip
    reference = CASES_OF_FLUX[0]
    run = runner("../laminar_erosion", f"erosion-{reference.reynolds:g}-long", {
        "time.end": 5.0 * FIFTH, "statistics.from": 3.0 * FIFTH, "accuracy.precision": "single",
    })  # fmt: skip
    s = flow_statistics.read(run)
    result.rows += rows_of(s, float(run.box[1]), reference, run.diameter)
    time, values = flux_samples(run)
    over_fluid = values / fluxes(s)[0]
    fifths = fifths_of(time, over_fluid)
    result.rows += [
        Row(f"flux of grains over fluid, t = {n * FIFTH:g} to {(n + 1) * FIFTH:g}", mean)
        for n, mean in enumerate(fifths)
    ]
    result.rows.append(Row("flux of grains, last fifth of the time over the fourth", fifths[4] / fifths[3], 1.0,
                           source="steady"))  # fmt: skip
    result.curves.append(Curve("flux of grains over fluid", *thin(time, over_fluid, digits=(3, 6))))
    result.curves += [Curve(f"{what} measured", [0.0, float(time[-1])], [flux, flux])
                      for what, flux in zip(("least", "most"), reference.flux, strict=True)]  # fmt: skip
    return result


def fifths_of(time: np.ndarray, values: np.ndarray) -> list[float]:
    """Means over each FIFTH of the time."""
    return [float(np.mean(values[(time >= n * FIFTH) & (time < (n + 1) * FIFTH)])) for n in range(5)]


SHIPPED, SHALLOW = "as shipped, bed of 15 D", "bed of 9 D"


def shallow(fluid: dict[str, object], variables: dict[str, object]) -> Changes:
    """Changes of the scene for the bed of 9 D, and more."""
    return (
        {"grid.cells": [48, 96, 36], "grid.length": [8.0, 16.0, 6.0], "flow.bulk_velocity": 0.0190,
         "start.height": 9.1} | fluid,
        {"bed_file": "bed_shallow.data", "length_y": 16.0} | variables,
    )  # fmt: skip


CHOICES: dict[str, Changes] = {
    SHALLOW: shallow({}, {}),
    "half the friction coefficient": shallow({}, {"friction": 0.075}),
    "twice the friction coefficient": shallow({}, {"friction": 0.3}),
    "box twice as long": shallow(
        {"grid.cells": [96, 96, 36], "grid.length": [16.0, 16.0, 6.0]},
        {"bed_file": "bed_long.data", "length_x": 16.0},
    ),
    "box of 12 D x 12 D": shallow(  # theirs: 11.3 D
        {"grid.cells": [72, 96, 72], "grid.length": [12.0, 16.0, 12.0]},
        {"bed_file": "bed_wide.data", "length_x": 12.0, "length_z": 12.0},
    ),
    "bed of 13 D": (
        {"grid.cells": [48, 120, 36], "grid.length": [8.0, 20.0, 6.0], "flow.bulk_velocity": 0.0152,
         "start.height": 13.1},
        {"bed_file": "bed_deep.data", "length_y": 20.0},
    ),
    SHIPPED: ({}, {}),
}  # fmt: skip


def flux_over_fluid(run: Run, s: FlowStatistics) -> Estimate:
    """Grains' flux over the fluid's in the time of the run's statistics."""
    time, values = flux_samples(run)
    return estimate(values[time >= run.value("statistics.from")] / fluxes(s)[0])


def sentences_of(found: dict[str, Estimate], base: str = SHALLOW) -> list[str]:
    """Which choices change the flux, and which cannot be told apart from that of `base`."""
    others = [name for name in found if name != base]
    apart = [name for name in others if found[name].is_apart_from(found[base])]
    alike = [name for name in others if name not in apart]
    return [
        f"The grains' flux {what} that of the {base} with: {', '.join(names)}."
        for names, what in ((apart, "differs from"), (alike, "is not told apart from"))
        if names
    ]


def beside(runner: Runner, result: Result, choices: dict[str, Changes], base: str) -> None:
    """Height and flux of each choice beside those of `base`, the first of them."""
    heights, fluxes_found = {}, {}
    for name, (fluid, variables) in choices.items():
        plain = f"erosion-{CASES_OF_FLUX[0].reynolds:g}"  # which the case erosion has, too
        label = plain if name == SHIPPED else f"{plain}-{name.replace(' ', '_')}"
        run = runner("../laminar_erosion", label, fluid, variables)
        s = flow_statistics.read(run)
        height = heights[name] = height_of_flow(s) / run.diameter
        flux = fluxes_found[name] = flux_over_fluid(run, s)
        result.rows += [
            Row(f"{name}: h_f/D of the flux and the upper wall's stress", height, heights[base], source=base),
            Row(f"{name}: flux of grains over fluid, +- {flux.half_width:.4f} (95 %)", flux.mean,
                fluxes_found[base].mean, source=base),
        ]  # fmt: skip
        surface = surface_of(s) / run.diameter
        result.curves.append(Curve(name, np.round(s["grains"], 5).tolist(),
                                   np.round(s["y"] / run.diameter - surface, 4).tolist()))  # fmt: skip
    result.remarks += sentences_of(fluxes_found, base)


def erosion_choices(runner: Runner) -> Result:
    """What box, friction coefficient and depth do to height and flux, each beside a bed of 9 D in the scene's box."""
    result = Result("Choices of laminar_erosion: Re_b 0.301, D/h = 6",
                    axes=("share of grains", "height over the bed's surface / D"))  # fmt: skip
    beside(runner, result, CHOICES, SHALLOW)
    return result


SIX_CELLS = "bed of 9 D at six cells to a diameter"
# The step as h^2 goes, so that its diffusion number is about the scene's (7.2; 8 here).
CELLS: dict[str, Changes] = {
    SIX_CELLS: shallow({}, {}),
    "eight cells to a diameter": shallow({"grid.cells": [64, 128, 48], "time.step": 0.125}, {}),
}


def erosion_cells(runner: Runner) -> Result:
    """What resolution does to height and flux of a bed of 9 D."""
    result = Result("Resolution of laminar_erosion: Re_b 0.301, bed of 9 D",
                    axes=("share of grains", "height over the bed's surface / D"))  # fmt: skip
    beside(runner, result, CELLS, SIX_CELLS)
    return result


AS_IT_IS = "bed of 9 D, friction at rest"
TWICE: dict[str, object] = {"coupling.dem_steps": 240}
FRICTIONS: dict[str, Changes] = {
    AS_IT_IS: shallow({}, {}),
    "twice the DEM steps": shallow(TWICE, {}),
    "no friction at rest": shallow({}, {"model": "actm_hw"}),
    "no friction at rest, twice the DEM steps": shallow(TWICE, {"model": "actm_hw"}),
}


def erosion_friction(runner: Runner) -> Result:
    """What friction at rest, and how fast friction stops slip, do to height and flux of a bed of 9 D."""
    result = Result("Friction in laminar_erosion: Re_b 0.301, bed of 9 D",
                    axes=("share of grains", "height over the bed's surface / D"))  # fmt: skip
    beside(runner, result, FRICTIONS, AS_IT_IS)
    return result


CASES: dict[str, Callable[[Runner], Result]] = {
    "erosion": partial(erosion_at, reference=CASES_OF_FLUX[0]),
    "erosion402": partial(erosion_at, reference=CASES_OF_FLUX[1]),
    "erosion_long": erosion_long,
    "erosion_choices": erosion_choices,
    "erosion_cells": erosion_cells,
    "erosion_friction": erosion_friction,
}
