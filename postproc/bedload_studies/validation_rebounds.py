"""Validation cases of spheres that meet a wall or each other. No study of its own."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from bedload_post.outputs import Run

from .sphere_theory import wet_restitution as fitted_restitution
from .validation_runs import Curve, Result, Row, Runner, reference_rows, thin


@dataclass(frozen=True)
class Impact:
    """One of the experiments of Gondret, Lance and Petit (2002): a steel sphere that falls onto a wall."""

    case: str  # in the reference file
    diameter: float  # m
    fluid_density: float  # kg/m3
    density_ratio: float
    viscosity: float  # m2/s
    speed: float  # m/s
    peak: float  # first one, in diameters
    height: int  # of the box, in diameters
    start: float  # gap at the start, in diameters
    step: float = 0.5  # of time, in cells s/m

    def stokes(self, speed: float) -> float:
        """St = rho_p u D/(9 rho_f nu)."""
        return self.density_ratio * speed * self.diameter / (9.0 * self.viscosity)

    def settings(self, n: int, step: float, width: int, end: float) -> dict[str, object]:
        lengths = (width, self.height, width)
        return {
            "grid.cells": [k * n for k in lengths], "grid.length": [k * self.diameter for k in lengths],
            "fluid.density": self.fluid_density, "fluid.kinematic_viscosity": self.viscosity,
            "time.step": step, "time.end": end, "reference.velocity": self.speed,
            "reference.height": self.height * self.diameter, "reference.diameter": self.diameter,
            "reference.sphere_density": self.density_ratio * self.fluid_density,
        }  # fmt: skip


ST152 = Impact("St152", 0.003, 935.0, 8.342, 1.070e-5, 0.585, 2.489, 9, 6.0)
# The same after a fall as in the experiment, where the sphere comes with the wake of its terminal velocity:
# what streams down behind it holds it back when it rises.
ST152_FALL = replace(ST152, height=24, start=20.0)
MEASURED_PEAKS = (ST152.peak, 0.0022337 / ST152.diameter, 0.00052021 / ST152.diameter)  # of the reference file
ST27 = Impact("St27", 0.006, 965.0, 8.083, 1.036e-4, 0.518, 0.329, 6, 3.5)


def _rebound(
    runner: Runner, label: str, n: int, offset=(0.0, 0.0, 0.0), impact: Impact = ST152,
    after: float = 0.048, width: int = 6, step: float | None = None, **more,
) -> tuple:  # fmt: skip
    """Time after the impact, gap over time, its first peak and the speed at the impact; `after`: how long
    it is followed then [s]."""
    diameter = impact.diameter
    h = diameter / n
    step = step or impact.step * h
    variables = more.pop("variables", {})
    gap = impact.start * diameter + offset[1] * h
    end = impact.start * diameter / impact.speed + 1 / 400.0 + after  # the push gains speed at 400/s
    run = runner("rebound", label, impact.settings(n, step, width, end) | more, variables | {
        "diameter": diameter, "density": impact.density_ratio * impact.fluid_density, "speed": impact.speed,
        "gap": gap, "step": step, "width": width * diameter, "height": impact.height * diameter,
        "x": 0.5 * width * diameter + offset[0] * h, "z": 0.5 * width * diameter + offset[2] * h,
    })  # fmt: skip
    motion = run.samples_of(1)
    time, high = motion.time, motion.position[:, 1] - 0.5 * diameter
    first = int(np.argmax(high <= 0.0))
    began = np.interp(0.0, [-high[first - 1], -high[first]], [time[first - 1], time[first]])
    speed = -float(motion.velocity[first - 1, 1])
    later = time > began + 0.005
    peak = float(high[later][: max(1, int(0.05 / step))].max())
    return time - began, high, peak, speed


def _peaks(time: np.ndarray, high: np.ndarray, least: float) -> list[float]:
    """Heights of the peaks after the first impact."""
    y = high[time > 0.0]
    tops = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:]) & (y[1:-1] > least)) + 1
    return [float(y[k]) for k in tops]


@dataclass(frozen=True)
class Bounce:
    """Speed towards the wall where a sphere passes a gap of D/10, and the speed back there over it."""

    speed: float
    restitution: float

    def measured(self, peak: float, peak_measured: float) -> "Bounce":
        """The restitution that would have reached the measured peak: on its way up the sphere's energy falls with
        its height, to first order in the difference."""
        return replace(self, restitution=self.restitution * math.sqrt(peak_measured / peak))


def _bounces(time: np.ndarray, high: np.ndarray, diameter: float) -> list[Bounce]:
    """All that come back as far as a gap of D/10."""
    off = high - 0.1 * diameter
    speed = np.gradient(high, time)
    crossings = np.flatnonzero((off[:-1] > 0.0) != (off[1:] > 0.0))

    def speed_at(k: int) -> float:
        share = off[k] / (off[k] - off[k + 1])
        return float(speed[k] + share * (speed[k + 1] - speed[k]))

    speeds = [speed_at(k) for k in crossings]
    return [Bounce(-before, -after / before) for before, after in zip(speeds, speeds[1:], strict=False) if before < 0.0]


def _restitution_between(stokes: float, ends: Sequence[tuple[float, float]]) -> float:
    """exp(a - b/St) through two pairs of Stokes number and restitution (the form of Legendre et al. 2005)."""
    (low, e_low), (high, e_high) = ends
    share = (1.0 / stokes - 1.0 / low) / (1.0 / high - 1.0 / low)
    return e_low ** (1.0 - share) * e_high**share


SOURCE = "Gondret et al. 2002"
# What the numerics alone may do to a first peak: where the sphere lies between the cells, the phase of the
# step at the touch, DEM steps, fluid step. Of the 5 % that a first peak may be off the measured one, a share
# that leaves the physics the rest.
NUMERICS = 0.02


def _beside_the_measured(stokes: int, diameter: float) -> Result:
    """A result with the measured gap over time as its first curve."""
    result = Result(f"Rebound from a wall, St = {stokes} (Gondret et al. 2002)",
                    axes=("t / s", "gap / D"))  # fmt: skip
    measured = reference_rows("gondret_2002.csv", f"St{stokes}")
    result.curves.append(Curve("measured", *thin(measured[:, 0], measured[:, 1] / diameter), True))
    return result


def rebound(runner: Runner) -> Result:
    """Rebound of a steel sphere from a wall in oil, St = 152, its later bounces, sixteen offsets."""
    diameter = ST152.diameter
    result = _beside_the_measured(152, diameter)
    result.remarks.append(
        "All rows but those that say otherwise are what a user gets by default: pushed over 5.5 D, then free. In the "
        "experiment the sphere came with the wake of a long fall, hence the rows of 20 D. Of the later bounces there "
        "is one measured point each, every 2 ms and read off a figure to some 0.04 mm (8 % of the third peak), which "
        "need not be the top: a third flight as long as the run's has its top 3 to 5 % above it. A collision that is "
        "stretched to ten steps delays what follows by up to 1.5 ms."
    )
    for n in (10, 15):
        time, high, peak, speed = _rebound(runner, f"rebound-{n}", n, after=0.16 if n == 10 else 0.048)
        result.rows.append(Row(f"first peak / D, D/h = {n} (impact at {speed:.3f} m/s)",
                               peak / diameter, 2.489, 0.05, source=SOURCE))  # fmt: skip
        result.curves.append(Curve(f"D/h = {n}", *thin(time, high / diameter)))
        if n > 10:
            continue
        later = _peaks(time, high, 0.05 * diameter)
        result.rows.append(Row("second peak / D, D/h = 10", later[1] / diameter, MEASURED_PEAKS[1], 0.1,
                               source=SOURCE))  # fmt: skip
        result.rows.append(Row("third peak / D, D/h = 10", later[2] / diameter, MEASURED_PEAKS[2],
                               source=SOURCE))  # fmt: skip
        base = peak
        tops = [top / diameter for top in (peak, *later[1:3])]
        result.rows += _restitution_rows(result, runner, _bounces(time, high, diameter), tops)
    time, high, peak, speed = _rebound(runner, "rebound-fall-10", 10, impact=ST152_FALL, after=0.16)
    result.curves.append(Curve("D/h = 10, pushed over 20 D", *thin(time, high / diameter)))
    tops = [peak, *_peaks(time, high, 0.05 * diameter)[1:3]]
    for name, top, due in zip(("first", "second", "third"), tops, MEASURED_PEAKS, strict=True):
        result.rows.append(Row(f"{name} peak / D, D/h = 10, pushed over 20 D (impact at {speed:.3f} m/s)",
                               top / diameter, due, source=SOURCE))  # fmt: skip
    finer = _rebound(runner, "rebound-half-step", 10, step=0.25 * diameter / 10)[2]
    result.rows.append(Row("first peak / D with half the fluid step", finer / diameter, base / diameter, NUMERICS,
                           source="the whole step"))  # fmt: skip
    published = {"lubrication_settings": "law published"}
    plain = _rebound(runner, "rebound-published-film", 10, variables=published)[2] / diameter
    result.rows.append(Row("first peak / D, D/h = 10, the published film within 2 h", plain, 2.489,
                           source=SOURCE))  # fmt: skip
    golden = np.array([0.8191725134, 0.6710436067, 0.5497004779])  # an even spread in three directions
    peaks = []
    for m in range(16):
        offset = tuple((m * golden) % 1.0)
        peaks.append(_rebound(runner, f"rebound-offset-{m}", 10, offset, width=5)[2] / diameter)
    mean = float(np.mean(peaks))
    result.rows.append(Row("lowest peak of 16 offsets, D/h = 10, box 5 D wide", min(peaks), mean, NUMERICS,
                           source="their mean"))  # fmt: skip
    result.rows.append(Row("highest peak of 16 offsets", max(peaks), mean, NUMERICS,
                           source="their mean"))  # fmt: skip
    result.rows.append(Row("mean of the 16 peaks", mean, 2.489, 0.05, source=SOURCE))
    return result


def _restitution_rows(result: Result, runner: Runner, bounces: list[Bounce], tops: list[float]) -> list[Row]:
    """Restitutions of the three bounces at St = 152 and of the one at 27, in the order of their Stokes numbers; and
    where the third measured peak lies beside the law that the measured bounces on either side of it are on."""
    time, high, top, _ = _rebound(runner, "rebound27-10", 10, impact=ST27, after=0.06)
    peaks = [(top / ST27.diameter, ST27.peak), *zip(tops, MEASURED_PEAKS, strict=True)]
    found = [_bounces(time, high, ST27.diameter)[0], *bounces[:3]]
    measured = [b.measured(*pair) for b, pair in zip(found, peaks, strict=True)]
    stokes = [ST27.stokes(found[0].speed), *(ST152.stokes(b.speed) for b in bounces[:3])]
    names = ["St = 27, first bounce", "first bounce", "second bounce", "third bounce"]
    rows = [
        Row(f"restitution, speeds at a gap of D/10, D/h = 10: {names[k]} (St = {stokes[k]:.0f} there)",
            found[k].restitution, measured[k].restitution, source=f"the measured peak, {SOURCE}")
        for k in np.argsort(stokes)
    ]  # fmt: skip
    first, second, third = 0, 2, 3
    ends = [(stokes[k], measured[k].restitution) for k in (first, second)]
    expected = tops[2] * (_restitution_between(stokes[third], ends) / found[third].restitution) ** 2
    rows.append(Row("third peak / D, D/h = 10, beside the bounces measured at St on either side", tops[2], expected,
                    source="exp(a - b/St) through these"))  # fmt: skip
    result.remarks.append(
        f"A law of the Stokes number through the bounces measured at St = {ends[0][0]:.0f} and {ends[1][0]:.0f} has "
        f"the third, at {stokes[third]:.0f}, rise to {expected:.3f} D. The run's is "
        f"{100 * (tops[2] / expected - 1):+.0f} % off that, the measured one "
        f"{100 * (MEASURED_PEAKS[2] / expected - 1):+.0f} %."
    )
    return rows


def rebound27(runner: Runner) -> Result:
    """Rebound at St = 27, where the film takes half of the speed, and what the numerics do to it."""
    diameter = ST27.diameter
    result = _beside_the_measured(27, diameter)
    result.remarks.append("All rows but those that say otherwise are what a user gets by default.")

    def peak(label: str, n: int = 10, **more) -> tuple:
        return _rebound(runner, f"rebound27-{label}", n, impact=ST27, after=0.06 if label in "8 10 12 16".split()
                        else 0.03, **more)  # fmt: skip

    for n in (8, 10, 12, 16):
        time, high, top, speed = peak(str(n), n)
        result.rows.append(Row(f"first peak / D, D/h = {n} (impact at {speed:.3f} m/s)", top / diameter,
                               ST27.peak, 0.05, source=SOURCE))  # fmt: skip
        result.curves.append(Curve(f"D/h = {n}", *thin(time, high / diameter)))
        if n == 10:
            base = top / diameter
    numerics: list[tuple[str, str, dict]] = [
        ("half the fluid step", "half-step", {"step": 0.5 * ST27.step * diameter / 10}),
        ("60 DEM steps to a fluid step", "dem-60", {"coupling.dem_steps": 60, "variables": {"dem_steps": 60}}),
    ]
    for name, label, more in numerics:
        result.rows.append(Row(f"first peak / D, {name}", peak(label, **more)[2] / diameter, base, NUMERICS,
                               source="the run with D/h = 10"))  # fmt: skip
    shifts = (0.2, 0.4, 0.6, 0.8)  # in cells; the phase of the step at the touch changes with them
    tops = [base] + [peak(f"offset-{o}", offset=(0.7 * o, o, 0.3 * o))[2] / diameter for o in shifts]
    mean = float(np.mean(tops))
    for name, top in (("lowest", min(tops)), ("highest", max(tops))):
        result.rows.append(Row(f"first peak / D, {name} of five releases up to 0.8 h higher", top, mean, NUMERICS,
                               source="their mean"))  # fmt: skip
    short = peak("5-steps", variables={"contact_settings": "collisionSteps 5"})[2] / diameter
    result.rows.append(Row("first peak / D, half the collision time (5 fluid steps)", short, base, NUMERICS,
                           source="the run with D/h = 10"))  # fmt: skip
    published = peak("published", variables={"lubrication_settings": "law published"})[2] / diameter
    result.rows.append(Row("first peak / D, D/h = 10, the published film within 2 h", published, ST27.peak,
                           source=SOURCE))  # fmt: skip
    return result


def _wet_restitution(runner: Runner, stokes: float, n: int = 10, density: float = 8.0,
                     collision_steps: int = 0) -> tuple[float, float]:  # fmt: skip
    """Speed after over speed before an impact, at gaps of D/20 and D/10, with e_dry 0.97.

    A sphere of 3 mm is pushed to 0.585 m/s (Stokes number rho_p u D/(9 rho_f nu)) and let go half a
    diameter above the wall. 0: it does not come back so far."""
    viscosity = density * ST152.speed * ST152.diameter / (9.0 * stokes)
    h = ST152.diameter / n
    # The jet of the fluid that the impact squeezes out grows with D/h, at one Courant number of the sphere.
    longest = ST152.step * min(1.0, 16.0 / n)
    impact = replace(ST152, density_ratio=density, viscosity=viscosity, height=7, start=4.0,
                     step=min(longest, 0.1 * h / viscosity))  # fmt: skip
    label = f"wet-{density:g}-{stokes:g}-{n}"
    more: dict = {}
    if collision_steps > 0:
        label += f"-{collision_steps}-steps"
        more["variables"] = {"contact_settings": f"collisionSteps {collision_steps}"}
    _rebound(runner, label, n, impact=impact, after=0.02, width=5, **more)
    motion = Run(runner.folder / label).samples_of(1)
    gap, speed = motion.position[:, 1] - 0.5 * impact.diameter, motion.velocity[:, 1]
    near, far = (_way_back(gap, speed, level * impact.diameter) for level in (0.05, 0.1))
    return near.restitution, far.restitution


def _way_back(gap: np.ndarray, speed: np.ndarray, level: float) -> Bounce:
    """Of a sphere that comes down, where it passes a gap; a restitution of 0 where it does not come back so far."""
    low = int(np.argmin(gap))
    top = low + int(np.argmax(gap[low:]))
    before = -float(np.interp(level, gap[low::-1], speed[low::-1]))
    if gap[top] <= level:
        return Bounce(before, 0.0)
    end = top + 1
    return Bounce(before, float(np.interp(level, gap[low:end], speed[low:end])) / before)


SCATTER = 0.1  # of measured restitutions about the fit
WITH_ADDED_MASS = "St*, the Stokes number with the added mass in it"  # axis of the figures


def with_added_mass(stokes: float, density_ratio: float) -> float:
    """(rho_p + rho_f/2) u D/(9 mu), in which rebounds of light and heavy spheres fall together, from
    rho_p u D/(9 mu)."""
    return stokes * (1.0 + 0.5 / density_ratio)


def fitted_curve(source: str, highest: float) -> Curve:
    numbers = np.geomspace(10.0, highest, 60)
    return Curve(source, *thin(numbers, np.array([fitted_restitution(n, 1.0) for n in numbers])))


def wet_restitution(runner: Runner) -> Result:
    """Wet over dry restitution of a sphere and a wall over the impact's Stokes number."""
    result = Result("Wet over dry restitution against a wall, e_dry = 0.97", axes=(WITH_ADDED_MASS, "e / e_dry"))
    dry, source = 0.97, "exp(-35/St*), Legendre et al. 2005"
    result.remarks.append(
        "The curve is a fit to experiments, St* = (rho_p + rho_f/2) u D/(9 mu), among them those of Joseph et al. 2001,"
        f" who saw no rebound below about St = 10; they scatter by {SCATTER:g}. Where the speeds are taken matters:"
        " each row's are those at a gap of D/10. Gondret's own bounce at St = 26 lies 0.1 above it."
    )
    result.curves.append(fitted_curve(source, 380.0))
    kinds = ((8.0, 10, (10, 20, 30, 50, 100, 200, 300)), (8.0, 15, (30, 100)),
             (2.5, 6, (30, 50, 100)), (2.5, 10, (30, 50, 100, 300)), (2.5, 15, (300,)), (2.5, 20, (300,)),
             (1.25, 6, (30, 50, 100)), (1.25, 10, (30, 50, 100)), (1.25, 20, (30,)))  # fmt: skip
    light_and_fast: dict[int, float] = {}  # by cells to a diameter
    for density, n, all_stokes in kinds:
        found = [_wet_restitution(runner, stokes, n, density) for stokes in all_stokes]
        result.curves.append(Curve(f"density ratio {density:g}, D/h = {n}",
                                   [with_added_mass(v, density) for v in all_stokes],
                                   [pair[1] / dry for pair in found], True))  # fmt: skip
        for stokes, pair in zip(all_stokes, found, strict=True):
            result.rows.append(Row(f"e/e_dry, St = {stokes}, density ratio {density:g}, D/h = {n} (at D/20: "
                                   f"{pair[0] / dry:.3f})", pair[1] / dry,
                                   fitted_restitution(with_added_mass(stokes, density), 1.0), SCATTER,
                                   scale=1.0, source=source))  # fmt: skip
            if (density, stokes) == (2.5, 300):
                light_and_fast[n] = pair[1] / dry
    short = _wet_restitution(runner, 300, 10, 2.5, collision_steps=5)[1] / dry
    result.rows.append(Row("the same at St = 300, density ratio 2.5, D/h = 10, half the collision time (5 fluid steps)",
                           short, light_and_fast[10], scale=1.0, source="ten fluid steps"))  # fmt: skip
    measured = fitted_restitution(with_added_mass(300.0, 2.5), 1.0)
    result.remarks.append(resolution_of_restitution(light_and_fast, short, measured))
    return result


def resolution_of_restitution(found: dict[int, float], short: float, measured: float) -> str:
    """What resolution (restitution by D/h) and collision time do to a fast light sphere, in words."""
    beside = {n: value - measured for n, value in found.items()}
    coarse = min(found)
    by_cells = ", ".join(f"{value:+.2f} at D/h = {n}" for n, value in beside.items())
    text = f"At St = 300 and a density ratio of 2.5 e/e_dry differs from the fit by {by_cells}; "
    if max(abs(value) for value in beside.values()) <= 0.5 * SCATTER:
        return text + f"half the collision time changes it by {short - found[coarse]:+.2f}."
    of_time = abs(short - found[coarse]) / abs(beside[coarse])
    return (
        text + f"half the collision time changes that by {100 * of_time:.0f} %. So "
        + ("resolution is missing." if of_time < 0.2 else "the length of the stretched collision counts, too.")
    )  # fmt: skip


ONTO_STOKES = 4.0 / 9.0  # St of onto_sphere over rho_p u D/(rho_f nu): m = m_p, R_eff = R/2


def _onto_sphere(
    runner: Runner, density: float, start_stokes: float, n: int, parts: int = 1, loops: int = 1,
) -> tuple[Run, Bounce]:  # fmt: skip
    """A sphere thrown at a fixed one with this St = m u/(6 pi mu R_eff^2); its way back at a gap of D/10. The step is
    divided into `parts`."""
    viscosity = ONTO_STOKES * density / start_stokes
    label = f"onto_sphere-{density:g}-{start_stokes:g}-{n}" + ("" if parts * loops == 1 else f"-{parts}-{loops}")
    run = runner("onto_sphere", label, {
        "grid.cells": [4 * n, 6 * n, 4 * n], "fluid.kinematic_viscosity": viscosity,
        "time.step": min(0.25 / n, 0.1 / (n * n * viscosity)) / parts, "reference.sphere_density": density,
    } | ({"spheres.forcing_loops": loops} if loops > 1 else {}), {"density": density})  # fmt: skip
    mobile = run.samples_of(2)
    return run, _way_back(mobile.position[:, 1] - 3.0, mobile.velocity[:, 1], 0.1)


def onto_sphere(runner: Runner) -> Result:
    """Wet over dry restitution of light spheres that come at a fixed one."""
    result = Result("Wet restitution against a fixed sphere, e_dry = 0.97", axes=(WITH_ADDED_MASS, "e / e_dry"))
    dry, source = 0.97, "exp(-35/St*), a fit to walls, Legendre et al. 2005"
    result.remarks.append(
        "St = m u/(6 pi mu R_eff^2), at which the film takes what it takes at a wall, St* the same with the added "
        "mass; speeds are those at a gap of D/10. The layer along a sphere, which is slower here at the same St, takes "
        "more than at a wall, so that less than the fit is expected: the measure is the finest grid, the bound the "
        "scatter of experiments."
    )
    result.curves.append(fitted_curve(source, 100.0))
    for density, start, grids in ((2.5, 80.0, (15, 10, 6)), (2.5, 150.0, (15, 10, 6)), (1.25, 150.0, (20, 15, 10, 6))):
        numbers, found = [], []
        for n in grids:
            bounce = _onto_sphere(runner, density, start, n)[1]
            stokes = start * bounce.speed
            numbers.append(with_added_mass(stokes, density))
            found.append(bounce.restitution / dry)
            what = f"e/e_dry, density ratio {density:g}, D/h = {n}, St = {stokes:.0f}"
            if n == grids[0]:
                result.rows.append(Row(what, found[-1], fitted_restitution(numbers[-1], 1.0), scale=1.0, source=source))
            else:
                result.rows.append(Row(what, found[-1], found[0], SCATTER, 1.0, f"D/h = {grids[0]}"))
        result.curves.append(Curve(f"density ratio {density:g}, St = {start:g} at the start, D/h = "
                                   + ", ".join(str(n) for n in grids), numbers, found, True))  # fmt: skip
    base = _onto_sphere(runner, 2.5, 80.0, 10)[1].restitution / dry
    for name, parts, loops in (("half the step", 2, 1), ("a quarter of the step", 4, 1), ("three forcing loops", 1, 3)):
        bounce = _onto_sphere(runner, 2.5, 80.0, 10, parts, loops)[1]
        result.rows.append(Row(f"e/e_dry, density ratio 2.5, D/h = 10, St = 35, {name}", bounce.restitution / dry,
                               base, NUMERICS if loops == 1 else None, 1.0, "one loop, the whole step"))  # fmt: skip
    return result


def kissing(runner: Runner) -> Result:
    """Drafting, kissing and tumbling of two spheres in a closed box."""
    result = Result("Drafting, kissing and tumbling", axes=("t / s", "y / cm"))
    run = runner("kissing", "kissing-10")
    first, second = run.samples_of(1), run.samples_of(2)
    apart = np.linalg.norm(first.position - second.position, axis=1) * 6.0 - 1.0
    time = first.time
    touch = time[np.argmax(apart < 0.02)] if (apart < 0.02).any() else float("nan")
    parted = time[(time > touch) & (apart > 0.1)]
    result.rows.append(Row("gap at the start / D", float(apart[0]), 1.04, 1e-6, source="set"))
    result.rows.append(Row("least gap / D", float(apart.min()), 0.0, 0.02, scale=1.0,
                           source="they touch"))  # fmt: skip
    result.rows.append(Row("first touch / s", float(touch)))
    result.rows.append(Row("part again (gap 0.1 D) / s", float(parted[0]) if len(parted) else math.nan))
    result.rows.append(Row("largest speed / cm/s", float(-first.velocity[:, 1].min())))
    result.curves += [Curve("leading sphere", *thin(time, first.position[:, 1])),
                      Curve("trailing sphere", *thin(time, second.position[:, 1])),
                      Curve("gap / D", *thin(time, apart))]  # fmt: skip
    return result


CASES = {
    "rebound": rebound, "rebound27": rebound27, "wet_restitution": wet_restitution, "onto_sphere": onto_sphere,
    "kissing": kissing,
}  # fmt: skip
