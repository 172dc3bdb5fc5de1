"""Validation cases: a thick bed under a viscous flow (Aussillous 2013, Biegert 2017), and how its flux grows with
the Shields number (Kidanemariam & Uhlmann 2014). No study of its own."""

from collections.abc import Callable
from functools import partial
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from bedload_post import flow_statistics
from bedload_post.batches import Estimate, estimate
from bedload_post.flow_statistics import FlowStatistics
from bedload_post.outputs import Run

from .validation_runs import Curve, Result, Row, Runner, thin

GALILEO = 0.397
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
        Row(f"{name}: packing from D above the floor to D below the surface", bulk, 0.609, 0.02, source=COMPUTED),
    ]  # fmt: skip


def flux_samples(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Times of the samples, and the grains' flux for a unit width in each."""
    times, values = [], []
    for block in run.sample_blocks():
        for time in np.unique(block.time):
            of = block.time == time
            times.append(float(time))
            values.append(float(np.sum(block.velocity[of, 0])))
    one = np.pi / 6.0 * run.diameter**3 / (run.box[0] * run.box[2])
    return np.array(times), one * np.array(values)


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


def told_apart(one: Estimate, other: Estimate) -> bool:
    """Whether the difference of two independent means is larger than its 95 % interval."""
    return abs(one.mean - other.mean) > float(np.hypot(one.half_width, other.half_width))


def sentences_of(found: dict[str, Estimate], base: str = SHALLOW) -> list[str]:
    """Which choices change the flux, and which cannot be told apart from that of `base`."""
    others = [name for name in found if name != base]
    apart = [name for name in others if told_apart(found[name], found[base])]
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


DEEP = 13.0  # D: depth of bed_deep.data
STRESSES = (1.0, 1.4, 2.0, 2.8)  # over that of Re_b = 0.301
CLEAR = 0.1  # grains' share of the volume at which the clear fluid begins (Kidanemariam & Uhlmann 2014, from memory)
CUBE = "Kidanemariam & Uhlmann 2014"


@dataclass(frozen=True)
class Friction:
    """Runs of the law with one model of friction; means are taken over `window` (begin, end), where the stress is
    larger as many times sooner. `changes`: variables of the script beside the model."""

    model: str
    what: str
    window: tuple[float, float]
    changes: dict[str, object]

    def label(self, stress: float) -> str:
        return f"erosion-deep-{stress:g}-{self.model}"


AT_REST = Friction("actm_hw_static", "friction at rest", (100.0, 140.6), {})
# Kidanemariam & Uhlmann (arXiv 1409.0339): a tangential damper, limited by Coulomb's friction of coefficient 0.4.
DAMPER = Friction("actm_hw", "no friction at rest, coefficient 0.4", (200.0, 300.0), {"friction": 0.4})


def deep(stress: float, height: float, friction: Friction) -> Changes:
    """Changes of fluid.toml and in.liggghts for the bed of 13 D under `stress` times the stress of Re_b = 0.301, in a
    channel whose clear height is `height` times as high: the flux is stress height^2 times. All times are `stress`
    times shorter, so that the bed's surface is sheared as far in as many steps. The flow starts as the parabola above
    the bed: from rest, the push that sets it in motion loosens the whole bed, which then takes thousands of time units
    to settle again."""
    clear = CASES_OF_FLUX[0].height * height
    top = float(round(DEEP + clear))
    begin, end = friction.window
    fluid: dict[str, object] = {
        "grid.cells": [48, round(6.0 * top), 36], "grid.length": [8.0, top, 6.0],
        "flow.bulk_velocity": round(0.0190 * 16.0 / top * stress * height**2, 6),
        "reference.velocity": round(0.0427 * stress * height, 6), "reference.height": round(clear, 3),
        "start.from": "laminar", "start.velocity": round(0.0427 * stress * height, 6), "start.height": DEEP,
        "time.step": round(0.2 / stress, 6), "time.end": round(end / stress, 6),
        "output.spheres_every": round(2.0 / stress, 6), "statistics.from": round(begin / stress, 6),
    }  # fmt: skip
    return fluid, {"bed_file": "bed_deep.data", "length_y": top, "model": friction.model} | friction.changes


def law_point(run: Run, window: tuple[float, float]) -> tuple[float, float]:
    """Shields number of the upper wall's stress and the grains' flux over Ga^2 nu, means over `window`."""

    def mean(time: np.ndarray, values: np.ndarray) -> float:
        return float(np.mean(values[(time >= window[0]) & (time <= window[1])]))

    weight = run.submerged_weight * run.diameter  # (rho_p - rho_f) g D
    scale = weight / run.value("fluid.density") * run.diameter**2 / run.viscosity  # Ga^2 nu
    history = run.history()
    stress = mean(history["time"], np.abs(history["wall_stress_upper"]))
    return stress / weight, mean(*flux_samples(run)) / scale


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
    return height, 6.0 * fluxes(s)[0] / s.viscosity / GALILEO**2 / height**2


def surface_of(s: FlowStatistics) -> float:
    """The highest plane with more than half of the largest share of grains."""
    return float(s["y"][np.flatnonzero(s["grains"] > 0.5 * np.max(s["grains"]))[-1]])


def flux_below(s: FlowStatistics, height: float) -> float:
    """Share of the grains' flux below a height."""
    flux = s["mobile"] * s["grain_u"] * np.diff(s["y_face"])
    return float(np.sum(flux[s["y"] < height]) / np.sum(flux))


@dataclass(frozen=True)
class Point:
    """One run of the law: Shields numbers of the upper wall's stress and of the parabola, flux over Ga^2 nu."""

    stress: float
    parabola: float
    flux: float
    rows: list[Row]


def point_of(run: Run, name: str, factor: float, window: tuple[float, float]) -> Point:
    """Means over the window, `factor` times sooner; profiles over the time of the run's statistics."""
    begin, end = (time / factor for time in window)
    stress, flux = law_point(run, (begin, end))
    middle = 0.5 * (begin + end)
    settling = law_point(run, (middle, end))[1] / law_point(run, (begin, middle))[1]
    s = flow_statistics.read(run)
    height, parabola = shields_of_parabola(run, s)
    return Point(stress, parabola, flux, [
        Row(f"{name}: Shields number of the upper wall's stress", stress),
        Row(f"{name}: h_f/D, from a packing of {CLEAR:g} to the wall", height),
        Row(f"{name}: Shields number of the parabola over that height", parabola),
        Row(f"{name}: flux of grains / (Ga^2 nu)", flux),
        Row(f"{name}: flux of grains over fluid", fluxes(s)[1] / fluxes(s)[0]),
        Row(f"{name}: flux, second half of that time over the first", settling, 1.0, source="steady"),
        Row(f"{name}: share of the flux more than 2 D below the bed's surface",
            flux_below(s, surface_of(s) - 2.0 * run.diameter)),
        Row(f"{name}: share of the flux in the lowest third of the bed", flux_below(s, surface_of(s) / 3.0)),
    ])  # fmt: skip


def erosion_law(runner: Runner, friction: Friction) -> Result:
    """Flux of the grains over the Shields number, in viscous units: q_p/(Ga^2 nu) grows as its cube."""
    result = Result(f"Flux of the grains over the Shields number, D/h = 6, {friction.what}",
                    axes=("Shields number", "flux of grains / (Ga^2 nu)"), logarithmic=True)  # fmt: skip
    result.remarks.append(
        "A bed of 13 D under flows that shear it as far in as many steps (a collision is as many times shorter where "
        "the stress is larger); means over the same part of each. The pressure gradient pulls "
        "at the grains inside the bed, too: at the depth z stress over weight is theta/phi (D/z + 2 D/h_f), which does "
        "not fall below 2 theta D/(phi h_f) however deep the bed is, and where that is above the grains' friction all "
        "of them move. So the channel is made as many times higher as the stress is larger. The bound asks that the "
        "exponent is nearer to 3 than to 2 or 4."
    )
    points = []
    for factor in STRESSES:
        run = runner("../laminar_erosion", friction.label(factor), *deep(factor, factor, friction))
        points.append(point_of(run, f"{factor:g} times the stress", factor, friction.window))
        result.rows += points[-1].rows
    flux = np.array([point.flux for point in points])
    shields, parabola = np.array([p.stress for p in points]), np.array([p.parabola for p in points])
    exponent, factor, half = power_law(shields, flux)
    other, _, other_half = power_law(parabola, flux)
    result.rows += [
        Row(f"exponent of the Shields number (upper wall's stress), +- {half:.2f} (95 %)", exponent, 3.0, 0.5 / 3.0,
            source=CUBE),
        Row("flux / (Ga^2 nu) at a Shields number of 1 by that fit", factor),
        Row(f"exponent of the Shields number (parabola), +- {other_half:.2f} (95 %)", other, 3.0, source=CUBE),
    ]  # fmt: skip
    result.rows += [
        Row(f"exponent between the Shields numbers {one.stress:.2f} and {two.stress:.2f}",
            float(np.log(two.flux / one.flux) / np.log(two.stress / one.stress)), 3.0, source=CUBE)
        for one, two in zip(points, points[1:], strict=False)
    ]  # fmt: skip
    ends = np.array([shields.min(), shields.max()])
    cube = float(np.exp(np.mean(np.log(flux) - 3.0 * np.log(shields))))
    result.curves += [
        Curve("runs", np.round(shields, 5).tolist(), np.round(flux, 6).tolist(), points=True),
        Curve("runs, Shields number of the parabola", np.round(parabola, 5).tolist(), np.round(flux, 6).tolist(),
              points=True),
        Curve(f"fit, exponent {exponent:.2f} +- {half:.2f}", ends.tolist(), (factor * ends**exponent).tolist()),
        Curve(f"cube, {cube:.2f} times", ends.tolist(), (cube * ends**3).tolist()),
    ]  # fmt: skip
    return result


CASES: dict[str, Callable[[Runner], Result]] = {
    "erosion": partial(erosion_at, reference=CASES_OF_FLUX[0]),
    "erosion402": partial(erosion_at, reference=CASES_OF_FLUX[1]),
    "erosion_long": erosion_long,
    "erosion_choices": erosion_choices,
    "erosion_cells": erosion_cells,
    "erosion_friction": erosion_friction,
    "erosion_law": partial(erosion_law, friction=AT_REST),
    "erosion_law_damper": partial(erosion_law, friction=DAMPER),
}
