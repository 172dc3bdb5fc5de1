"""Validation cases that end in a steady state: drag, torque, rotation. No study of its own."""

import math

import h5py
import numpy as np
from bedload_post.outputs import Run

from .validation_runs import DIFFUSION, Curve, Result, Row, Runner, drag_factor, from_coarser, of_loop, thin


def last_load(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque on the only mobile sphere in the last sample."""
    with h5py.File(run.folder / "spheres.h5") as file:
        return file["mobile/force"][-1], file["mobile/torque"][-1]


def rotation(runner: Runner) -> Result:
    """Torque on a sphere that turns in Stokes flow, D/h = 6 to 24."""
    length = 3.0
    # -8 pi mu R^3 omega in unbounded fluid; the mean rotation of a periodic box is zero, which raises
    # it by 1/(1 - volume fraction).
    exact = -8.0 * math.pi * 0.125 * 2.0 / (1.0 - math.pi / 6.0 / length**3)
    result = Result("Torque on a turning sphere in Stokes flow",
                    axes=("D/h", "|error of the torque| / %"), logarithmic=True)  # fmt: skip
    across, errors = [6, 8, 10, 12, 16, 20, 24], []
    for n in across:
        run = runner("rotation", f"rotation-{n}", {
            "grid.cells": [3 * n] * 3, "time.step": DIFFUSION / n**2,
            "time.end": 1.0 if n < 20 else 0.6,
        })  # fmt: skip
        torque = float(last_load(run)[1][2])
        errors.append(torque / exact - 1)
        result.rows.append(Row(f"torque, D/h = {n}", torque, exact, 0.015 if n < 12 else 0.007,
                               source="Stokes, 1/(1 - fraction)"))  # fmt: skip
    result.curves.append(Curve("torque", across, [100 * abs(e) for e in errors]))
    return result


def shear(runner: Runner) -> Result:
    """Rotation of a neutrally buoyant sphere in shear flow as Re goes to zero."""
    result = Result("A neutrally buoyant sphere in shear flow",
                    axes=("shear R^2 / nu", "rotation over shear rate"))  # fmt: skip
    reynolds, rates = [0.01, 0.1, 1.0], []
    for re in reynolds:
        viscosity = 0.25 / re
        h = 0.125
        step = min(DIFFUSION * h * h / viscosity, 0.01)
        run = runner("shear", f"shear-{re}", {
            "fluid.kinematic_viscosity": viscosity, "time.step": step,
            "time.end": max(9.0 / viscosity, 8.0 if re >= 1 else 0.0),
        })  # fmt: skip
        with h5py.File(run.folder / "spheres.h5") as file:
            rates.append(-float(file["mobile/angular_velocity"][-1][2]))
    result.rows.append(Row("rotation over shear rate, Re = 0.01", rates[0], 0.5, 0.01,
                           source="exact for Re = 0, unbounded"))  # fmt: skip
    for re, rate in zip(reynolds[1:], rates[1:], strict=True):
        result.rows.append(Row(f"rotation over shear rate, Re = {re}", rate, 0.5,
                               source="slower with inertia"))  # fmt: skip
    result.curves.append(Curve("D/h = 8, walls 6 D apart", reynolds, rates))
    return result


def stream(runner: Runner) -> Result:
    """Drag of a fixed sphere in a uniform stream, Re 20 to 200."""
    result = Result("A fixed sphere in a uniform stream", axes=("t U / D", "C_D"))
    # Clift, Grace and Weber 1978, table 5.2: 2.7 at Re 20, 1.087 at Re 100; their correlation for
    # 20 < Re < 260, 24/Re (1 + 0.1935 Re^0.6305): 0.775 at Re 200.
    for re, reference, grids in (
        (20, 2.7, ((8, 8.0), (8, 12.0))),
        (100, 1.087, ((8, 8.0), (8, 12.0))),
        (200, 0.775, ((8, 8.0), (12, 8.0))),
    ):
        for n, width in grids:
            bound = 0.03  # the curve is known to 2 %, a box 8 D wide adds 0.5 to 0.8 %
            step = min(0.4 / n, 0.18 * re / n**2)
            run = runner("stream", f"stream-{re}-{n}-{width:g}", {
                "fluid.kinematic_viscosity": 1.0 / re,
                "grid.cells": [16 * n, int(width * n), int(width * n)],
                "grid.length": [16.0, width, width], "time.step": step, "time.end": 15.0,
            }, {"ly": width, "lz": width, "y": 0.5 * width + 0.02, "z": 0.5 * width - 0.03})  # fmt: skip
            with h5py.File(run.folder / "spheres.h5") as file:
                time, force = file["mobile/time"][:], file["mobile/force"][:, 0]
            drag = force / (math.pi / 8.0)
            slip = float(run.history()["slip_rms"][-1])
            result.rows.append(Row(f"C_D, Re = {re}, D/h = {n}, box {width:g} D wide "
                                   f"(slip rms {100 * slip:.2f} % of U)", float(drag[-1]),
                                   reference, bound, source="Clift, Grace & Weber 1978"))  # fmt: skip
            keep = time > 1.0
            points = thin(time[keep], drag[keep], 100, digits=None)
            result.curves.append(Curve(f"Re {re}, D/h = {n}, {width:g} D", *points))
    return result


def touching(runner: Runner) -> Result:
    """Drag of two touching spheres along their line of centres in Stokes flow."""
    result = Result("Two touching spheres in Stokes flow", axes=("D/h", "error of K / %"))
    length, across, errors = 6.0, [6, 8], []
    ratio = 0.5 / length  # R over the period
    # Stimson and Jeffery 1926 at contact: each sphere has 0.6451 of its drag alone. Periodic images
    # slow both down by 2.837 R/L - 4.19 (R/L)^3 of the velocity that the force on them makes
    # (Hasimoto 1959).
    images = 2.837297 * ratio - 4.18879 * ratio**3
    single = 1.0 / (1.0 - images)
    pair = 1.0 / (1.0 / (2.0 * 0.6451) - images)
    coarser: dict[int, Run] = {}
    result.remarks.append("Images are taken to the third order in R/L for one sphere, without the "
                          "pair's own length: known to about 1 %.")  # fmt: skip
    for n in across:
        for alone, exact in ((1, single), (0, pair)):
            settings = {"grid.cells": [int(length * n)] * 3, "time.step": DIFFUSION / n**2,
                        "time.end": 0.2 * length**2}  # fmt: skip
            settings |= from_coarser(coarser.get(alone), 0.08 * length**2)
            run = runner("touching", f"touching-{n}-{alone}", settings, {"alone": alone})
            coarser[alone] = run
            k = drag_factor(run, length)
            slip = float(run.history()["slip_max"][-1])
            who = "one sphere" if alone else "two touching spheres"
            result.rows.append(Row(f"drag of {who} over 6 pi mu R U, D/h = {n} (largest slip "
                                   f"{100 * slip:.1f} %)", k, exact, 0.02,
                                   source="Hasimoto 1959" if alone else
                                   "Stimson & Jeffery 1926, Hasimoto 1959"))  # fmt: skip
            if not alone:
                errors.append(100 * (k / exact - 1))
    result.curves.append(Curve("pair", across, errors))
    return result


def on_wall(runner: Runner) -> Result:
    """Force and torque on a sphere that touches a wall in Stokes shear flow."""
    result = Result("A sphere that touches a wall in Stokes shear flow",
                    axes=("D/h", "error / %"))  # fmt: skip
    result.remarks.append(
        "The reference takes the images in the periodic plane into account by the leading term of a "
        "force beside one wall; the upper wall, nearer than the images, is left out: known to 2 %."
    )
    across = [8, 12]
    errors: dict[str, list[float]] = {"force": [], "torque": []}
    length, height, radius, run = 8.0, 5.0, 0.5, None
    for n in across:
        settings = {"grid.cells": [8 * n, 5 * n, 8 * n], "time.step": DIFFUSION / n**2,
                    "time.end": 12.0}  # fmt: skip
        run = runner("on_wall", f"on_wall-{n}", settings | from_coarser(run, 3.0))
        force, torque = (float(v[i]) for v, i in zip(last_load(run), (0, 2), strict=True))
        # The shear far above the sphere: what the upper wall's speed leaves after the mean velocity
        # that the sphere holds back, force x height of its centre over mu area.
        shear_above = (height - force * radius / length**2) / height
        # Each image in the plane of the wall slows the stream at the sphere by the leading term of a
        # force beside a wall, 12 h^2 x^2 / (8 pi mu r^5) F (Blake 1971).
        places = np.arange(-40, 41) * length
        x, z = np.meshgrid(places, places)
        r = np.hypot(x, z)
        sums = float(np.sum((x**2)[r > 0] / r[r > 0] ** 5))
        slower = force * 12.0 * radius**2 * sums / (8.0 * math.pi) / (shear_above * radius)
        exact_force = 1.7005 * 6.0 * math.pi * radius**2 * shear_above * (1.0 - slower)
        exact_torque = -0.944 * 4.0 * math.pi * radius**3 * shear_above
        result.rows.append(Row(f"force, D/h = {n}", force, exact_force, 0.05,
                               source="O'Neill 1968: 1.7005"))  # fmt: skip
        result.rows.append(Row(f"torque, D/h = {n}", torque, exact_torque, 0.03,
                               source="O'Neill 1968: 0.944"))  # fmt: skip
        errors["force"].append(100 * (force / exact_force - 1))
        errors["torque"].append(100 * (torque / exact_torque - 1))
    for name, values in errors.items():
        result.curves.append(Curve(name, across, values))
    return result


def wall_drag_and_lift(reynolds: float) -> tuple[float, float]:
    """C_D and C_L (force over pi/8 rho D^2 U^2) of a sphere at rest on a wall in shear, U the flow's speed at
    the height of its centre, Re = U D/nu from 1 to 200.

    Fits of Zeng, Najjar, Balachandar and Fischer (Phys. Fluids 21, 033302, 2009) to spectral simulations at a
    gap of 0.005 D. Without inertia they go over into O'Neill's drag, 24 1.7005/Re, and Leighton and Acrivos'
    lift, 9.22 rho (dU/dy)^2 R^4.
    """
    drag = 40.81 / reynolds * (1.0 + 0.104 * reynolds**0.753)
    return drag, 3.663 / (reynolds**2 + 0.1173) ** 0.22


def wall_lift(runner: Runner) -> Result:
    """Drag and lift of a sphere at rest on a wall in shear with inertia, Re = 2 and 10."""
    result = Result("A sphere at rest on a wall in shear flow with inertia, D/h = 8",
                    axes=("D over the box's width", "error / %"))  # fmt: skip
    n, height, y = 8, 6.0, 0.505
    for reynolds in (2.0, 10.0):
        viscosity = y / reynolds
        reference = wall_drag_and_lift(reynolds)
        errors: list[np.ndarray] = []
        lengths = (12.0, 20.0)
        for length in lengths:
            run = runner("on_wall", f"wall_lift-{reynolds:g}-{length:g}", {
                "grid.cells": [round(length * n), round(height * n), round(length * n)],
                "grid.length": [length, height, length], "boundary.y_upper_velocity": [height, 0.0, 0.0],
                "fluid.kinematic_viscosity": viscosity, "fluid.convection": "on", "accuracy.precision": "single",
                "time.step": min(0.09 / n, DIFFUSION / n**2 / viscosity), "time.end": 30.0,
            }, {"length": length, "height": height, "x": length / 3.0 + 0.03, "y": y,
                "z": 0.5 * length - 0.03})  # fmt: skip
            found = last_load(run)[0][:2] / (math.pi / 8.0 * y**2)
            errors.append(found / reference - 1.0)
        # Images slow the stream at the sphere by a share that falls as their number in a plane, 1/L^2.
        shares = np.array([1.0 / length**2 for length in lengths])
        free = (errors[1] * shares[0] - errors[0] * shares[1]) / (shares[0] - shares[1])
        for name, coefficient, error, wide, bound in zip(("C_D", "C_L"), reference, free, errors[1], (0.03, 0.06),
                                                         strict=True):  # fmt: skip
            what = f"{name} at Re = {reynolds:g}, without images (box 20 D wide: {100 * wide:+.1f} %)"
            result.rows.append(Row(what, coefficient * (1.0 + error), coefficient, bound,
                                   source="Zeng et al. 2009"))  # fmt: skip
            result.curves.append(Curve(f"{name}, Re = {reynolds:g}", [1.0 / length for length in lengths],
                                       [100.0 * float(e[0 if name == "C_D" else 1]) for e in errors]))  # fmt: skip
    result.remarks.append(
        "The shear flow is driven by a wall 6 D above. Forces at t = 30 over the shear rate, of boxes 12 and 20 D "
        "wide: the rows have what is left without what falls as 1/L^2. The fits are as remembered; their limits "
        "without inertia are those of theory (tests/postproc/test_fixed_spheres.py)."
    )
    return result


def _brenner(gap: float) -> float:
    """Drag over 6 pi mu R U of a sphere on its way to a wall at gap/R (Brenner 1961)."""
    alpha = math.acosh(1.0 + gap)
    total = 0.0
    for n in range(1, 400):
        big = (2 * n + 1) * alpha
        if big > 300:
            break
        above = 2 * math.sinh(big) + (2 * n + 1) * math.sinh(2 * alpha)
        below = 4 * math.sinh(0.5 * big) ** 2 - (2 * n + 1) ** 2 * math.sinh(alpha) ** 2
        total += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1)
    return 4.0 / 3.0 * math.sinh(alpha) * total


def _approaching(gap: float) -> float:
    """Drag over 6 pi mu R U of each of two equal spheres that approach each other at U and -U, gap/R apart:
    a sphere on its way to a plane without friction halfway (Brenner 1961)."""
    alpha = math.acosh(1.0 + 0.5 * gap)
    total = 0.0
    for n in range(1, 400):
        big = (2 * n + 1) * alpha
        if big > 300:
            break
        above = 4 * math.cosh(0.5 * big) ** 2 + (2 * n + 1) ** 2 * math.sinh(alpha) ** 2
        below = 2 * math.sinh(big) - (2 * n + 1) * math.sinh(2 * alpha)
        total += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (above / below - 1)
    return 4.0 / 3.0 * math.sinh(alpha) * total


# The grid resolves the more the shorter the steps, by a few per cent of the film: a quarter of the other cases' step is
# nearer to that of a turbulent flow.
OF_FILMS = 0.25
AT_TOUCH = "fix lubrication in a collision"


def _resolved_at_touch(who: str, step: float = 1.0) -> float:
    """G, as in liggghts_styles/formulas/lubrication.hpp, with a time step of so many times OF_FILMS, or as short as
    loops make it (of_loop)."""
    return 1.8 - 0.23 * math.log(step) if who == "wall" else 1.88 * step**-0.28


def _unresolved(who: str, cells: float, step: float = 1.0) -> float:
    """S, as there: share of the leading term that the grid does not resolve at a gap in cells."""
    if who == "wall":
        return math.exp(-_resolved_at_touch("wall", step) * cells - 0.8 * cells**2)
    return (1.0 - cells / (0.727 * step**0.28)) * math.exp(-0.37 * cells - 1.02 * cells**2)


def _of_approach(step: float) -> float:
    """nu dt/h^2 over that of OF_FILMS; of implicit diffusion what fix lubrication takes in its place."""
    number = step * DIFFUSION
    return (number if number <= DIFFUSION else min(8.0, max(DIFFUSION, 0.5 * number**1.5))) / (OF_FILMS * DIFFUSION)


# At which the held spheres say that they approach: the markers of a sphere stand where it says that it will be, in a
# long step a cell away at a speed of 1.
SLOW = 1e-3
STEPS_OF_A_FILM = 40  # of implicit diffusion, behind which markers' kept force has taken most of what it takes


def _end_of_film(step: float, n: int, explicit: float) -> float:
    """Time that a film has to come: `explicit` in explicit steps."""
    return explicit if step <= 1.0 else STEPS_OF_A_FILM * step * DIFFUSION / n**2


def _squeezed(runner: Runner, n: int, gap: float, step: float = OF_FILMS, loops: int = 1) -> float:
    """Force over 6 pi mu R U on a sphere that approaches a wall, `gap` cells from it; `step` in that of the other
    cases."""
    run = runner("on_wall", f"film-{n}-{gap}" + ("" if (step, loops) == (OF_FILMS, 1) else f"-{step:g}-{loops}"), {
        "grid.cells": [5 * n] * 3, "grid.length": [5.0, 5.0, 5.0],
        "boundary.y_upper_velocity": [0.0, 0.0, 0.0], "time.step": step * DIFFUSION / n**2,
        "time.end": _end_of_film(step, n, 0.6), "spheres.forcing_loops": loops,
    }, {"speed": SLOW, "length": 5.0, "height": 5.0, "x": 2.53, "z": 2.47, "y": 0.5 + gap / n})  # fmt: skip
    return float(last_load(run)[0][1]) / (3.0 * math.pi * SLOW)


def _squeezed_pair(
    runner: Runner, n: int, gap: float, direction: tuple, name: str, step: float = OF_FILMS, loops: int = 1,
) -> float:  # fmt: skip
    """The same of two spheres that approach each other along a direction; `step` in that of the other cases."""
    d = np.array(direction) / np.linalg.norm(direction)
    half = 0.5 * (1.0 + gap / n)
    values = {"length": 5.0}
    for axis, centre, part in zip("xyz", (2.53, 2.51, 2.47), d, strict=True):
        values |= {f"{axis}1": centre - half * part, f"{axis}2": centre + half * part,
                   f"u{axis}": SLOW * part}  # fmt: skip
    label = f"film-pair-{n}-{gap}-{name}" + ("" if (step, loops) == (OF_FILMS, 1) else f"-{step:g}-{loops}")
    run = runner("approach", label, {
        "grid.cells": [5 * n] * 3, "grid.length": [5.0, 5.0, 5.0], "time.step": step * DIFFUSION / n**2,
        "time.end": _end_of_film(step, n, 0.5), "spheres.forcing_loops": loops,
    }, values)  # fmt: skip
    with h5py.File(run.folder / "spheres.h5") as file:
        tags, forces = file["mobile/tag"][-2:], file["mobile/force"][-2:]
    first, second = forces[np.argsort(tags)]
    return 0.5 * float((second - first) @ d) / (3.0 * math.pi * SLOW)


def film(runner: Runner) -> Result:
    """What of the squeezing force the grid resolves at fixed gaps, and what lubrication has to add."""
    result = Result("Squeezing force at small gaps: what the grid misses",
                    axes=("gap / h", "share of the film's leading term"))  # fmt: skip
    result.remarks.append(
        "The leading term is 1/gap for a wall and 1/(2 gap) for each of two spheres, gap in radii. Fix "
        "lubrication adds the share exp(-a s - 0.8 s^2) at walls and (1 - s/s_0) exp(-0.37 s - 1.02 s^2) between "
        "spheres, s = gap/h, a = 1.8 - 0.23 ln(lambda/0.05), s_0 = 0.727 (lambda/0.05)^0.28, lambda = nu dt/h^2 over "
        "the number of forcing loops to the power of 1.3, above 0.2 lambda^1.5/2, at least 0.2 and at most 8: "
        "the bound is on what is left of the exact force then. The images in the periodic box make the forces on "
        "two spheres too high by as much as at 3 h, which is taken off."
    )
    for part in (_film_at_wall, _film_of_two, _film_in_other_steps, _film_in_implicit_steps, _film_at_touch):
        part(runner, result)
    across = np.linspace(0.05, 3.0, 60)
    for who in ("wall", "pair"):
        result.curves.append(Curve(f"fix lubrication, {who}", across.tolist(),
                                   [_unresolved(who, cells) for cells in across]))  # fmt: skip
    return result


# The exponentials are fits to these forces: what they leave is 1.4 % at walls and 3 % between spheres, whose images are
# known to as much.
FILM_BOUND = 0.03


def _film_at_wall(runner: Runner, result: Result) -> None:
    """A sphere that approaches a wall, over the gap."""
    for n, gaps in ((8, (0.1, 0.15, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0)), (12, (0.1, 0.3, 0.6, 1.0, 2.0))):
        shares = []
        for gap in gaps:  # in cells; R = n/2 cells
            exact, found = _brenner(2.0 * gap / n), _squeezed(runner, n, gap)
            leading = 0.5 * n / gap
            shares.append((exact - found) / leading)
            added = leading * _unresolved("wall", gap) if gap <= 2.0 else 0.0
            what = f"wall, gap {gap} h, D/h = {n}: resolved ({found:.2f}) and added ({added:.2f}) force"
            result.rows.append(Row(what, found + added, exact, FILM_BOUND, source="Brenner 1961"))
        result.curves.append(Curve(f"missing at a wall, D/h = {n}", gaps, shares, points=True))


def _film_of_two(runner: Runner, result: Result) -> None:
    """Two spheres that approach each other, over the gap, along the grid and across it; and where they touch."""
    for n, name, direction, gaps in (
        (8, "along x", (1, 0, 0), (0.1, 0.3, 0.6, 1.0, 3.0)),
        (8, "along (1, 1, 1)", (1, 1, 1), (0.1, 0.3, 0.6, 1.0, 3.0)),
        (12, "along x", (1, 0, 0), (0.1, 0.3, 1.0, 3.0)),
    ):  # fmt: skip
        raw = {gap: _squeezed_pair(runner, n, gap, direction, "x" if direction[1] == 0 else "xyz") for gap in gaps}
        images = raw[3.0] - _approaching(6.0 / n)
        shares = []
        if name == "along x":
            rest, touching = _approaching(0.2 / n) - 2.5 * n, _squeezed_pair(runner, n, 0.0, direction, "x") - images
            result.rows.append(Row(f"two spheres {name}, at the touch, D/h = {n}: film that the grid resolves, times h",
                                   (touching - rest) * 4.0 / n, _resolved_at_touch("pair"), 0.2, scale=1.0,
                                   source=AT_TOUCH))  # fmt: skip
        for gap in gaps[:-1]:
            exact, found = _approaching(2.0 * gap / n), raw[gap] - images
            leading = 0.25 * n / gap
            added = leading * _unresolved("pair", gap)
            shares.append((exact - found) / leading)
            what = f"two spheres {name}, gap {gap} h, D/h = {n}: resolved ({found:.2f}) and added ({added:.2f}) force"
            result.rows.append(Row(what, found + added, exact, 0.05, source="Brenner 1961"))
        result.curves.append(Curve(f"missing of two, {name}, D/h = {n}", gaps[:-1], shares, points=True))


def _film_in_other_steps(runner: Runner, result: Result) -> None:
    """The same with other steps and forcing loops, at a gap of 0.3 h."""
    exact, leading = _approaching(0.075), 20.0 / 3.0
    for name, step, loops in (("four times the step", 4.0, 1), ("a quarter of the step", 0.25, 1),
                              ("a sixteenth of the step", 0.0625, 1), ("two loops", 1.0, 2),
                              ("two loops, a quarter of the step", 0.25, 2), ("four loops", 1.0, 4)):  # fmt: skip
        found, images = (
            _squeezed_pair(runner, 8, gap, (1, 0, 0), "x", step * OF_FILMS, loops) for gap in (0.3, 3.0)
        )  # fmt: skip
        found -= images - _approaching(0.75)
        shorter = of_loop(step * OF_FILMS * DIFFUSION, loops) / (OF_FILMS * DIFFUSION)
        added = leading * _unresolved("pair", 0.3, shorter)
        what = f"two spheres along x, gap 0.3 h, D/h = 8, {name}: resolved ({found:.2f}) and added ({added:.2f}) force"
        result.rows.append(Row(what, found + added, exact, 0.05, source="Brenner 1961"))
        found = _squeezed(runner, 8, 0.3, step * OF_FILMS, loops)
        added = 2.0 * leading * _unresolved("wall", 0.3, shorter)
        what = f"wall, gap 0.3 h, D/h = 8, {name}: resolved ({found:.2f}) and added ({added:.2f}) force"
        result.rows.append(Row(what, found + added, _brenner(0.075), FILM_BOUND, source="Brenner 1961"))


def _film_in_implicit_steps(runner: Runner, result: Result) -> None:
    """Implicit diffusion: what the grid resolves grows from step to step; within 9 % after 40 steps."""
    exact, leading = _approaching(0.075), 20.0 / 3.0
    for number in (1.0, 2.0, 4.0, 7.2):
        step = number / DIFFUSION
        found, images = (_squeezed_pair(runner, 8, gap, (1, 0, 0), "x", step) for gap in (0.3, 3.0))
        found -= images - _approaching(0.75)
        added = leading * _unresolved("pair", 0.3, _of_approach(step))
        after = f"gap 0.3 h, D/h = 8, nu dt/h^2 = {number:g}, after {STEPS_OF_A_FILM} steps"
        result.rows.append(Row(f"two spheres along x, {after}: resolved ({found:.2f}) and added ({added:.2f}) force",
                               found + added, exact, 0.09, source="Brenner 1961"))  # fmt: skip
        found, added = _squeezed(runner, 8, 0.3, step), 2.0 * leading * _unresolved("wall", 0.3, _of_approach(step))
        result.rows.append(Row(f"wall, {after}: resolved ({found:.2f}) and added ({added:.2f}) force",
                               found + added, _brenner(0.075), 0.05, source="Brenner 1961"))  # fmt: skip


def _film_at_touch(runner: Runner, result: Result) -> None:
    """In a stretched collision, in which the fluid sees the spheres where they only touch: of the force all is the
    film's but what hardly changes with the gap, the difference of Brenner's to the leading term at h/10."""
    for n in (8, 12):
        rest = _brenner(0.2 / n) - 5.0 * n
        result.rows.append(Row(f"wall, at the touch, D/h = {n}: film that the grid resolves, times h",
                               (_squeezed(runner, n, 0.0) - rest) * 2.0 / n, _resolved_at_touch("wall"), 0.1,
                               source=AT_TOUCH))  # fmt: skip


CASES = {
    "rotation": rotation, "shear": shear, "stream": stream, "touching": touching, "on_wall": on_wall,
    "wall_lift": wall_lift, "film": film,
}  # fmt: skip
