"""Validation of spheres that slide and roll at gaps below a cell. No study of its own.

What the grid resolves, what `fix lubrication tangential on` adds, and both against exact resistances.
"""

import math
from collections.abc import Callable

import h5py
import numpy as np
from scipy.special import exp1

from .validation_runs import DIFFUSION, Curve, Result, Row, Runner, from_coarser, of_loop
from .validation_steady import last_load

# Rates k of the logarithms that the grid lacks, E1(k s) at walls and E1(k s^2)/2 between spheres, s = gap/h, sliding
# and rolling, as in liggghts_styles/formulas/tangential_lubrication.hpp.
UNRESOLVED_SLIDE_ROLL = {"wall": (3.1, 2.4), "pair": (1.27, 4.8)}


# What markers leave that stand back, A exp(-a s - b s^2), sliding and rolling, up to 1.25 h, as there.
LEFT_BY_MARKERS = ((1.33, 1.75, 1.5), (0.583, 1.85, 1.55))
# Mean torque over 6 pi mu R^3 omega of two spheres that turn the same way, and against each other, over the gap in
# cells, D/h = 8, with all markers: `_turning_pair` at commit 3988db8, before markers stood back.
WITH_ALL_MARKERS = {0.002: (1.962, 1.593), 0.5: (1.711, 1.469), 1.0: (1.588, 1.404)}


# Of sliding and rolling, that a grid with shorter steps resolves by itself: A, a, b times ln(0.2/lambda).
OF_SHORT_STEPS = ((0.19, 0.3, 1.3), (0.11, 0.0, 0.9))


def _of_short_steps(cells: float, number: float) -> list[float]:
    return [math.log(0.2 / number) * size * math.exp(-cells * (a + b * cells)) for size, a, b in OF_SHORT_STEPS]


def left_by_markers(cells: float, number: float) -> tuple[float, float]:
    """The logarithm that markers leave at a gap in cells with lambda = `number`, of sliding and of rolling."""
    left = (size * math.exp(-cells * (a + b * cells)) for size, a, b in LEFT_BY_MARKERS)
    slide, roll = (
        max(0.0, part - more) for part, more in zip(left, _of_short_steps(cells, number), strict=True)
    )
    return slide, roll


def _lacks(cells: float, number: float) -> list[float]:
    """The logarithms that the grid lacks between spheres at a gap in cells, of sliding and of rolling."""
    return [
        max(0.0, 0.5 * float(exp1(rate * cells**2)) - more)
        for rate, more in zip(UNRESOLVED_SLIDE_ROLL["pair"], _of_short_steps(cells, number), strict=True)
    ]


GOLDMAN = "Goldman, Cox & Brenner 1967"
EXPERIMENTS = 0.1  # their own scatter, and what the unknown gap of 3e-7 to 3e-6 R adds and takes

# Two equal spheres: what they do, what they say of it, the leading coefficients of sliding and rolling, and the
# exact load over the gap x in radii (Jeffrey and Onishi 1984, to the order x log x).
Exact = Callable[[float], float]
PAIRS: tuple[tuple[str, dict[str, float], tuple[float, float], Exact], ...] = (
    ("pass each other, force", {"uz": 1.0}, (1 / 3, 0.0), lambda x: 1.2720 - math.log(x) / 3),
    ("turn the same way, torque", {"spin1": 2.0, "spin2": 2.0}, (1 / 3, 0.0),
     lambda x: 4 / 3 * (0.6754 - (0.25 + 0.312 * x) * math.log(x))),
    ("turn against each other, torque", {"spin1": 2.0, "spin2": -2.0}, (0.0, 1 / 5),
     lambda x: 4 / 3 * (0.7302 - (0.15 + 0.064 * x) * math.log(x))),
)  # fmt: skip


def _beside_wall(gap: float) -> np.ndarray:
    """Resistance [[force by sliding, by turning], [torque by sliding, by turning]] of a sphere beside a wall, in
    6 pi mu R (1, R; R, R^2), gap in radii: expansion of Goldman, Cox and Brenner (1967) on to the order gap, fitted
    to the series of O'Neill (1964) and Dean and O'Neill (1963): within 0.05 % for gaps up to 0.05 and 0.6 % up to
    0.125, the part between both motions within 0.15 and 2.6 %."""
    log = -math.log(gap)
    slide = 8 / 15 * log + 0.95429 + 64 / 375 * gap * log + 0.42945 * gap
    mixed = 2 / 15 * log - 0.25725 + 86 / 375 * gap * log + 0.142 * gap
    turn = 8 / 15 * log + 0.49452 + 88 / 125 * gap * log + 0.49 * gap
    return np.array([[slide, -mixed], [-mixed, turn]])


def _left_at_wall(cells: float, n: int, number: float) -> tuple[float, float, float]:
    """What markers leave at a wall that stand back, at a gap in cells with n cells to a diameter and lambda = `number`,
    as there: of the way along the wall, what ties it to the turning, and of the turning."""
    shorter, s, c = math.log(DIFFUSION / number), cells, min(1.0 / n, 0.25)
    resolved = shorter * math.exp(-1.2 * s * (1.0 + s))
    way = 1.85 * math.exp(-s * (1.1 + 2.25 * s)) - 0.15 * resolved - 0.113 * shorter * math.exp(s * (1.4 - 2.5 * s))
    tie = (0.39 + 11.2 * c**2) * math.exp(-s * (1.0 + 2.3 * s)) - (0.1 + 1.65 * c**2) * resolved
    turn = (0.485 + 170.0 * c**4) * math.exp(-s * (1.95 + 2.0 * s)) - (0.15 + 60.0 * c**4) * resolved
    if way <= 0.0:
        return 0.0, 0.0, max(0.0, turn)
    tie = min(max(0.0, tie), way)
    return way, tie, max(turn, tie**2 / way)


def _wall_film(cells: float, n: int, number: float) -> np.ndarray:
    """What fix lubrication and the coupling add to it at a gap in cells with n cells to a diameter."""
    arm = 1.0 + cells / n  # to the middle of the gap, in radii
    slide, roll = (float(exp1(k * cells)) for k in UNRESOLVED_SLIDE_ROLL["wall"])
    motions = np.array([[1.0, -arm], [-0.5, -0.5 * arm]])  # spin as of one that rolls forwards
    way, tie, turn = _left_at_wall(cells, n, number)
    left = np.array([[way, -arm * tie], [-arm * tie, arm**2 * turn]]) / 3.0
    return motions.T @ np.diag([slide / 3, 0.8 * roll]) @ motions + left


def _wall_box(n: int, gap: float, end: float, step: float = 1.0) -> tuple[dict[str, object], dict[str, object]]:
    """Settings and variables of a sphere `gap` cells above the wall of a box 8 D wide."""
    settings = {
        "grid.cells": [8 * n, 5 * n, 8 * n], "grid.length": [8.0, 5.0, 8.0],
        "boundary.y_upper_velocity": [0.0, 0.0, 0.0], "time.step": step * DIFFUSION / n**2, "time.end": end,
    }  # fmt: skip
    return settings, {"length": 8.0, "height": 5.0, "x": 4.03, "z": 3.97, "y": 0.5 + gap / n}


def _sliding_held(runner: Runner, result: Result) -> None:
    """Held spheres beside a wall: what the grid resolves, and with what the film adds."""
    names = (("sliding, force", "along", 1.0, 0), ("turning, torque", "spin", -2.0, 1))
    curves: dict[str, list[tuple[float, float]]] = {}
    for name, variable, value, motion in names:
        run = None
        for n, gap, step, loops in ((8, 0.2, 1.0, 1), (8, 0.1, 1.0, 1), (8, 0.05, 1.0, 1), (8, 0.5, 1.0, 1),
                                    (12, 0.1, 1.0, 1), (12, 0.2, 1.0, 1), (8, 0.05, 0.25, 1), (8, 0.2, 0.25, 1),
                                    (8, 0.2, 0.0625, 1), (8, 0.2, 0.25, 2), (6, 0.05, 1.0, 1), (6, 0.2, 1.0, 1),
                                    (4, 0.05, 1.0, 1), (4, 0.2, 1.0, 1)):  # fmt: skip
            short = (step, loops) != (1.0, 1)
            settings, values = _wall_box(n, gap, 3.0 if step > 0.1 else 1.5, step)
            run = runner("on_wall", f"sliding-{variable}-{n}-{gap}" + (f"-{step:g}-{loops}" if short else ""),
                         settings | {"spheres.forcing_loops": loops} | from_coarser(run, 0.7),
                         values | {variable: value})  # fmt: skip
            force, torque = last_load(run)
            loads = (-force[0] / (3.0 * math.pi), torque[2] / (1.5 * math.pi))
            exact = _beside_wall(2.0 * gap / n)[:, motion]
            added = _wall_film(gap, n, of_loop(step * DIFFUSION, loops))[:, motion]
            which = f"gap {gap} h, D/h = {n}" + (f", {step:g} of the step, {loops} loops" if short else "")
            for k, (found, part, should) in enumerate(zip(loads, added, exact, strict=True)):
                total, parts = float(found + part), f"resolved ({found:.3f}) and added ({part:.3f})"
                if k == motion:
                    # The fits of k leave 3.4 % at most; images in the box and the drag itself are worth 1 %, what
                    # four cells make of a sphere that turns 2 % more.
                    share = f"resolved ({found:.3f}, {100 * (found / should - 1):+.1f} %) and added ({part:.3f})"
                    result.rows.append(Row(f"wall, {name}, {which}: {share}", total, float(should),
                                           0.04 if n > 4 else 0.06, source=GOLDMAN))  # fmt: skip
                    if not short and n >= 8:
                        curves.setdefault(f"wall, {name}, D/h = {n}", []).append(
                            (gap, float((should - found) / (8 / 15)))
                        )
                else:
                    what = f"wall, {name.split(',')[0]}, {('force', 'torque')[k]}, {which}: {parts}"
                    result.rows.append(Row(f"{what}, error in the load above", total, float(should),
                                           scale=float(exact[motion]), source=GOLDMAN))  # fmt: skip
    for label, places in curves.items():
        x, y = zip(*sorted(places), strict=True)
        result.curves.append(Curve(f"missing: {label}", x, y, points=True))


def _sliding_pairs(runner: Runner, result: Result) -> None:
    """Two equal spheres, held, that pass each other, turn the same way, or roll on each other."""
    n = 8
    for name, values, part, exact in PAIRS:
        run = None
        for gap in (0.2, 0.1, 0.05):
            half = 0.5 * (1.0 + gap / n)
            places = {"x1": 2.53 - half, "x2": 2.53 + half, "y1": 2.51, "y2": 2.51, "z1": 2.47, "z2": 2.47, "ux": 0.0}
            run = runner("approach", f"sliding-pair-{'-'.join(values)}{values.get('spin2', '')}-{gap}", {
                "grid.cells": [5 * n] * 3, "grid.length": [5.0, 5.0, 5.0], "time.step": DIFFUSION / n**2,
                "time.end": 1.5,
            } | from_coarser(run, 0.7), {"length": 5.0} | places | values)  # fmt: skip
            with h5py.File(run.folder / "spheres.h5") as file:
                order = np.argsort(file["mobile/tag"][-2:])
                force, torque = (file[f"mobile/{what}"][-2:][order] for what in ("force", "torque"))
            if "uz" in values:
                found = float(force[1, 2] - force[0, 2]) / (6.0 * math.pi)
            else:
                found = -float(torque[0, 1] + math.copysign(1.0, values["spin2"]) * torque[1, 1]) / (3.0 * math.pi)
            gap_in_radii = 2.0 * gap / n
            should = exact(gap_in_radii)
            arm = 1.0 if "uz" in values else (1.0 + gap / n) ** 2
            added = arm * sum(c * lack for c, lack in zip(part, _lacks(gap, DIFFUSION), strict=True))
            share = f"resolved ({found:.3f}, {100 * (found / should - 1):+.1f} %) and added ({added:.3f})"
            result.rows.append(Row(f"two spheres {name}, gap {gap} h, D/h = {n}: {share}", found + added, should,
                                   0.04, source="Jeffrey & Onishi 1984"))  # fmt: skip


def _turning_pair(runner: Runner, gap: float, other: float, step: float = 1.0, loops: int = 1) -> float:
    """Mean torque of two held spheres that say they turn at 2 and at `other`, over 6 pi mu R^3 omega; `step` in that
    of the other cases."""
    n, length = 8, 4.0
    half = 0.5 * (1.0 + gap / n)
    label = f"sliding-left-{gap}-{other:g}" + ("" if (step, loops) == (1.0, 1) else f"-{step:g}-{loops}")
    run = runner("approach", label, {
        "grid.cells": [round(length) * n] * 3, "grid.length": [length] * 3,
        "time.step": step * DIFFUSION / n**2, "time.end": 0.8, "spheres.forcing_loops": loops,
    }, {"length": length, "x1": 2.03 - half, "x2": 2.03 + half, "y1": 2.01, "y2": 2.01, "z1": 1.97, "z2": 1.97,
        "ux": 0.0, "spin1": 2.0, "spin2": other})  # fmt: skip
    with h5py.File(run.folder / "spheres.h5") as file:
        torque = file["mobile/torque"][-2:][np.argsort(file["mobile/tag"][-2:])]
    return -float(torque[0, 1] + math.copysign(1.0, other) * torque[1, 1]) / (3.0 * math.pi)


def _left_rows(runner: Runner, result: Result) -> None:
    """What the grid resolves with markers that stand back, and with what they leave, against all markers."""
    for gap, all_markers in WITH_ALL_MARKERS.items():
        motions = zip((2.0, -2.0), ("the same way", "against each other"), (1 / 3, 1 / 5),
                      left_by_markers(gap, DIFFUSION), all_markers, strict=True)  # fmt: skip
        for other, words, part, left, should in motions:
            found = _turning_pair(runner, gap, other)
            parts = f"resolved ({found:.3f}) and left by markers ({part * left:.3f})"
            what = f"two spheres turn {words}, gap {gap} h: {parts}"
            result.rows.append(Row(what, found + part * left, should, 0.02, source="all markers, commit 3988db8"))


def _step_rows(runner: Runner, result: Result) -> None:
    """The same two with shorter steps and more loops, which leave less slip."""
    for step, loops, words in ((0.25, 1, "a quarter of the step"), (0.0625, 1, "a sixteenth of the step"),
                               (0.25, 2, "a quarter of the step, two loops")):  # fmt: skip
        number = of_loop(step * DIFFUSION, loops)
        for gap in (0.05, 0.2):
            for name, values, part, exact in PAIRS[1:]:
                found, should = _turning_pair(runner, gap, values["spin2"], step, loops), exact(0.25 * gap)
                added = (1.0 + gap / 8) ** 2 * sum(c * lack for c, lack in zip(part, _lacks(gap, number), strict=True))
                parts = f"resolved ({found:.3f}, {100 * (found / should - 1):+.1f} %) and added ({added:.3f})"
                what = f"two spheres {name}, gap {gap} h, D/h = 8, {words}: {parts}"
                result.rows.append(Row(what, found + added, should, 0.04, source="Jeffrey & Onishi 1984"))


def _sliding_free(runner: Runner, result: Result) -> None:
    """A free sphere pulled along the wall, with and without the films."""
    pull = 0.1
    force = pull / (3.0 * math.pi)
    for switch in ("off", "on"):
        run = None
        for n, gap in ((8, 0.2), (8, 0.1), (8, 0.05), (12, 0.1), (12, 0.2), (12, 0.15), (6, 0.075), (4, 0.05)):
            u, spin = np.linalg.solve(_beside_wall(2.0 * gap / n), [force, 0.0]) * (1.0, 2.0)
            settings, values = _wall_box(n, gap, 3.0)
            run = runner("sliding", f"sliding-free-{switch}-{n}-{gap}", settings | from_coarser(run, 0.8),
                         values | {"tangential": switch, "force": pull, "u": u, "spin": -spin})  # fmt: skip
            motion = run.samples_of(1)
            found = motion.velocity[-1, 0], -motion.angular_velocity[-1, 2]
            lost = (motion.position[-1, 1] - 0.5) * n / gap - 1.0
            what = (f"free sphere pulled along a wall, gap {gap} h ({100 * lost:+.1f} % at the end), D/h = {n}, "
                    f"tangential {switch}")  # fmt: skip
            # With the films as good as the forces above; the spin is a tenth of the velocity or less.
            bounds = (0.04, 0.02) if switch == "on" else (None, None)
            result.rows.append(Row(f"{what}: velocity", float(found[0]), float(u), bounds[0], source=GOLDMAN))
            result.rows.append(Row(f"{what}: spin times R, error in the velocity", 0.5 * float(found[1]),
                                   0.5 * float(spin), bounds[1], float(u), GOLDMAN))  # fmt: skip


def sliding(runner: Runner) -> Result:
    """Spheres that slide along, turn and roll beside a wall or each other at gaps below a cell: what the grid
    resolves, and what `fix lubrication tangential on` adds."""
    result = Result("Sliding and rolling at gaps below a cell", axes=("gap / h", "logarithm that the grid lacks"))
    result.remarks.append(
        "Forces in 6 pi mu R U, torques in 6 pi mu R^3 omega and 6 pi mu R^2 U. Resolved: the fluid's load on spheres "
        "that are held and say they move. Added: what fix lubrication with `tangential on` and the coupling (what "
        "markers leave that stand back) add, the published leading terms with E1(k gap/h), between spheres "
        "E1(k (gap/h)^2)/2, as the logarithm. The published models have "
        "none: the free spheres with `tangential off` show what that costs. The references are expansions "
        "for small gaps; the box is 8 D wide (12 D: force of sliding +0.5 %)."
    )
    _sliding_held(runner, result)
    _sliding_pairs(runner, result)
    _left_rows(runner, result)
    _step_rows(runner, result)
    _sliding_free(runner, result)
    across = np.geomspace(0.04, 1.0, 40)
    for n, motion in enumerate(("sliding", "rolling")):
        at_wall = [float(_wall_film(cells, 8, DIFFUSION)[n, n] / (8 / 15)) for cells in across]
        name = ("sliding, force", "turning, torque")[n]
        result.curves.append(Curve(f"added: wall, {name}", across.tolist(), at_wall))
        of_pair = [_lacks(cells, DIFFUSION)[n] for cells in across]
        result.curves.append(Curve(f"added: spheres, {motion}", across.tolist(), of_pair))
    return result


def _carty(reynolds: float) -> float:
    """Drag coefficient of polished spheres that roll down a smooth plane, experiments at Re 0.1 to 1e5."""
    return 1.2 + 321.906 / reynolds


ROLLING = "Carty 1957 and later experiments, as fitted by Chhabra & Ferreira 1999"


def _rolling(runner: Runner, label: str, nominal: float, drag: float, settings: str) -> tuple[float, float]:
    """Reynolds number and drag coefficient of a sphere that rolls down a plane at its terminal speed; `drag` is
    the coefficient that would make its speed 1, `nominal` the Reynolds number then."""
    n, ratio, slope = 10, 2.5, math.radians(30.0)
    along = drag * (math.pi / 8.0) / ((ratio - 1.0) * math.pi / 6.0)
    down = along / math.tan(slope)
    settings_of_fluid = {
        "fluid.kinematic_viscosity": 1.0 / nominal, "fluid.gravity": [along, -down, 0.0],
        "time.step": min(0.03, 2.0 * nominal / n**2),
    }  # fmt: skip
    variables = {"density": ratio, "along": along, "down": down, "lubrication_settings": settings}
    run = runner("rolling", label, settings_of_fluid, variables)
    motion = run.samples_of(1)
    speed = float(np.mean(motion.velocity[motion.time > 0.75 * motion.time[-1], 0]))
    return speed * nominal, drag / speed**2


def rolling(runner: Runner) -> Result:
    """A sphere rolls down a plane: drag with and without the films against sliding and rolling."""
    result = Result("A sphere rolls down a plane, D/h = 10", axes=("Re", "drag coefficient"), logarithmic=True)
    result.remarks.append(
        "The weight along the plane over pi/8 rho_f D^2 V^2, at the terminal speed V; Re = V D/nu. A film's drag and "
        "torque go with the logarithm of the gap, so that roughness decides how fast a sphere rolls: by Goldman, Cox & "
        "Brenner's leading terms C_D Re changes by -24 (8/15 - 2/15 - 2/15 + 8/15) = -19.2 for each unit of ln(gap), "
        "the drag of a sphere that rolls without slipping. The experiments were made with polished spheres; their gap "
        "is not known (a root-mean-square roughness of 10 nm on a radius of 10 mm would be 1e-6 R). The published "
        "models have no such films: the rows with `tangential off` show what that costs."
    )
    reynolds = np.geomspace(30.0, 500.0, 40)
    result.curves.append(Curve(ROLLING, reynolds.tolist(), [_carty(r) for r in reynolds]))
    kinds = (
        ("tangential off", "tangential off", 0.5, None),
        ("tangential on, gapMin 1e-3 (default)", "tangential on", 0.7, None),
        ("tangential on, gapMin 1e-6", "tangential on gapMin 1e-6", 1.0, EXPERIMENTS),
    )
    found: dict[tuple[str, float], tuple[float, float]] = {}
    for words, settings, share, bound in kinds:
        for nominal in (100.0, 300.0):
            label = f"rolling-{settings.replace(' ', '-')}-{nominal:g}"
            at, drag = found[settings, nominal] = _rolling(runner, label, nominal, share * _carty(nominal), settings)
            result.rows.append(Row(f"drag coefficient at Re {at:.0f}, {words}", drag, _carty(at), bound,
                                   source=ROLLING))  # fmt: skip
        points = [found[settings, nominal] for nominal in (100.0, 300.0)]
        result.curves.append(Curve(words, [p[0] for p in points], [p[1] for p in points], True))
    for nominal in (100.0, 300.0):
        rough, polished = (found[settings, nominal] for settings in ("tangential on", "tangential on gapMin 1e-6"))
        # What does not follow the gap, 1.2 in the fit, is the same at nearly the same Reynolds number.
        per_log = ((polished[1] - 1.2) * polished[0] - (rough[1] - 1.2) * rough[0]) / math.log(1e3)
        # At 300 the wake is unsteady: 2 % of the speed are 4 of these units.
        result.rows.append(Row(f"C_D Re by a gap smaller by e, about Re {nominal:g}", per_log, 19.2,
                               0.1 if nominal < 200.0 else None, source=GOLDMAN))  # fmt: skip
    return result


CASES = {"sliding": sliding, "rolling": rolling}
