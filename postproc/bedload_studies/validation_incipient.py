"""Incipient motion of one grain in a pocket: at which Shields number it leaves, beside statics. A case of
validation.py."""

import math
from dataclasses import dataclass

import h5py
import numpy as np
from bedload_post.outputs import Run

from .validation_runs import Curve, Result, Row, Runner, of_loop
from .validation_sliding import left_by_markers
from .validation_steady import last_load

GRAIN, POCKET = 17, 2.0  # its tag and its place along x at rest
DENSITY_DIFFERENCE, WEIGHT = 1.5, math.pi / 6.0  # rho_p - rho_f; W/((rho_p - rho_f) g D^3)
SPIN = 0.5  # of the second held run, with the shear, about as fast as a free grain's

# The pocket of a square layer. Over the ridge between the two spheres downstream the grain turns about the line
# through their centres: the direction from there to the grain stands at this angle to the vertical (35.3 degrees),
# and each of the two normals has this part in the plane of the flow.
REPOSE, IN_PLANE = math.atan(0.5 / math.sqrt(0.5)), math.sqrt(0.75)

LEFT = 0.2  # D, displacement along x of a grain that has left: the ridge is at 0.5, soft models give way by 0.05
GATHERING, CREEP = 1.2, 2e-5  # growth of its speed in a tenth of the run, and speed [nu/D]
HALVINGS = 7
REPULSION = 0.1  # D, the paper's range 2h
GAP, TIME_STEP = 2e-4, 0.02  # of the scene: D, D^2/nu


@dataclass(frozen=True)
class Loads:
    """What the flow does to a held grain, linear in its spin s (clockwise seen along z, as the shear turns it):
    force along x F + F_s s, torque T + T_s s, and the stress of the flow."""

    force: float
    force_of_spin: float
    torque: float
    torque_of_spin: float
    stress: float

    def statics(self, friction: float) -> float:
        """Shields number at which the grain leaves.

        Where the spheres upstream bear nothing any more, along the normal and across it
            N = W cos a + F sin a,   W sin a = F cos a + F_t,   T = F_t R cos b,
        (the points of contact are R cos b from the grain's axis), and either it rolls, s = 0, or friction slips,
        F_t = mu N / cos b, with the spin that is left.
        """
        sine, cosine = math.sin(REPOSE), math.cos(REPOSE)

        def balance(spin: float) -> tuple[float, float, float]:
            """Weight, friction that the torque asks for, most that there is."""
            force = self.force + self.force_of_spin * spin
            asked = (self.torque + self.torque_of_spin * spin) / (0.5 * IN_PLANE)
            weight = (force * cosine + asked) / sine
            return weight, asked, friction * (weight * cosine + force * sine) / IN_PLANE

        lacking = [asked - most for _, asked, most in (balance(0.0), balance(1.0))]  # linear in the spin
        spin = lacking[0] / (lacking[0] - lacking[1]) if lacking[0] > 0.0 else 0.0
        return self.stress * WEIGHT / balance(spin)[0]


def _left_by_markers(n: int) -> tuple[float, float]:
    """Force and torque by spin, as in Loads, of what the coupling gives back of the sliding and rolling films
    between the grain and the four spheres: the fluid's load lacks it, as markers stand back from the cells that two
    spheres share (logarithms_left_by_markers in liggghts_styles/formulas/tangential_lubrication.hpp)."""
    slide, roll = left_by_markers(GAP * n, of_loop(TIME_STEP * n**2))
    effective, arm = 0.25, 0.5  # D; viscosity 1
    normals = [(x, math.sqrt(0.5), z) for x in (-0.5, 0.5) for z in (-0.5, 0.5)]  # towards the grain
    force = sum(2.0 * math.pi * effective * slide * arm * y for _, y, _ in normals)
    torque = -(arm**2) * math.pi * effective * (2.0 * slide + 1.2 * roll) * sum(1.0 - z * z for *_, z in normals)
    return force, torque


def _settings(n: int) -> dict[str, object]:
    return {"grid.cells": [4 * n, 5 * n, 4 * n]}


def held_loads(runner: Runner, n: int) -> Loads:
    """Two runs with the grain held in its pocket, without and with spin."""
    still, spun = (
        runner("incipient", f"incipient-held-{spin:g}-{n}", _settings(n) | {"time.end": 10.0},
               {"hold": 1, "spin": -spin}) for spin in (0.0, SPIN)
    )  # fmt: skip
    (force, torque), (more_force, more_torque) = (
        (float(f[0]), -float(t[2])) for f, t in (last_load(still), last_load(spun))
    )
    stress = -float(still.history()["wall_stress_upper"][-1])
    force_of_film, torque_of_film = _left_by_markers(n)
    return Loads(force, (more_force - force) / SPIN + force_of_film,
                 torque, (more_torque - torque) / SPIN + torque_of_film, stress)  # fmt: skip


def leaves(run: Run) -> bool:
    """Whether the grain has left, or is about to: just above the threshold its speed grows slowly, as the films behind
    it open, and is far above the creep of a grain that stays, which does not grow."""
    grain = run.samples_of(GRAIN)
    if np.max(np.abs(grain.position[:, 0] - POCKET)) > LEFT:
        return True
    tenth = len(grain.time) // 10
    before, last = (
        float(np.mean(grain.velocity[part, 0])) for part in (slice(-2 * tenth, -tenth), slice(-tenth, None))
    )
    return last > GATHERING * before and last > CREEP


def at_shields(
    runner: Runner, loads: Loads, shields: float, model: str, friction: float, n: int, end: float = 45.0
) -> Run:
    """The grain free to go, at a Shields number that the weight sets."""
    gravity = loads.stress / (DENSITY_DIFFERENCE * shields)
    repulsive = model.startswith("rpm")
    return runner("incipient", f"incipient-{model}-{friction:g}-{n}-{shields:.4f}",
                  _settings(n) | {"fluid.gravity": [0.0, -gravity, 0.0], "time.end": end},
                  {"gravity": gravity, "model": model, "friction": friction, "repulsion_range": REPULSION}
                  | ({"gap": 0.99 * REPULSION} if repulsive else {}))  # fmt: skip


def critical_shields(runner: Runner, loads: Loads, model: str, friction: float, n: int) -> float:
    """By halves, between 0.5 and 1.6 of what statics asks: known to 0.5 % then."""
    exact = loads.statics(friction)
    low, high = math.log(0.5 * exact), math.log(1.6 * exact)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if leaves(at_shields(runner, loads, math.exp(middle), model, friction, n)):
            high = middle
        else:
            low = middle
    return math.exp(0.5 * (low + high))


# Collision model, friction coefficient, cells to a diameter.
POINTS = [
    ("actm", 0.0, 8), ("actm_hw", 0.15, 8), ("actm_hw", 0.8, 8),
    ("actm_hw_static", 0.15, 8), ("actm_hw_static", 0.8, 8), ("actm_hw_static", 0.8, 12),
    ("rpm", 0.0, 8), ("rpm_hw", 0.15, 8), ("rpm_hw", 0.8, 8),
]  # fmt: skip


def incipient(runner: Runner) -> Result:
    """Critical Shields number of one grain on a square layer in a viscous shear flow, for each collision model."""
    result = Result("Incipient motion of a grain in a pocket, viscous shear flow",
                    axes=("friction coefficient", "critical Shields number"))  # fmt: skip
    loads = {n: held_loads(runner, n) for n in sorted({n for *_, n in POINTS})}
    found: dict[str, list[tuple[float, float]]] = {}
    of_statics: dict[bool, list[float]] = {True: [], False: []}
    for model, friction, n in POINTS:
        repulsive = model.startswith("rpm")
        value, exact = critical_shields(runner, loads[n], model, friction, n), loads[n].statics(friction)
        result.rows.append(Row(f"{model}, friction coefficient {friction:g}, D/h = {n}", value, exact,
                               None if repulsive else 0.05, source="statics"))  # fmt: skip
        of_statics[repulsive].append(value / exact)
        found.setdefault(f"{model}, D/h = {n}", []).append((friction, value))
    coefficients = np.linspace(0.0, 0.8, 33)
    result.curves.append(Curve("statics, D/h = 8", coefficients.tolist(),
                               [loads[8].statics(c) for c in coefficients]))  # fmt: skip
    for name, points in found.items():
        result.curves.append(Curve(name, [c for c, _ in points], [value for _, value in points], points=True))
    contact, repulsion = of_statics[False], of_statics[True]
    result.remarks.append(
        "Statics: the weight at which force and torque of the flow, from runs with the grain held in the pocket, lift "
        "it over the ridge; no model is in it but friction. Found by halves, to 0.5 %; the bound leaves room for the "
        "slip that friction without memory needs to bear a torque (actm_hw). With contacts at the touch (actm) grains "
        f"leave at {min(contact):.2f} to {max(contact):.2f} of that Shields number; with the repulsion of "
        f"{REPULSION:g} D (rpm) at {min(repulsion):.2f} to {max(repulsion):.2f}: it holds the grain higher, in faster "
        "fluid and a shallower pocket. Friction lowers the threshold, because the torque helps where the grain rolls. "
        "Such layers were measured by Agudo & Wierschem (Phys. Fluids 24, 2012), whose text was not at hand."
    )
    return result


FINEST = 24  # cells to a diameter, the reference of pocket()


def _in_a_stream(runner: Runner, n: int) -> np.ndarray:
    """Drag, lift and torque about z, means over 0.9 D/u, of a grain held in its pocket in a stream of Re = 200."""
    run = runner("incipient", f"pocket-{n}", _settings(n) | {
        "fluid.kinematic_viscosity": 0.005, "fluid.convection": "on", "fluid.diffusion": "auto",
        "fluid.gravity": [0.0, -0.3, 0.0], "boundary.y": ["no_slip", "free_slip"],
        "boundary.y_upper_velocity": [0.0, 0.0, 0.0], "flow.driving": "bulk_velocity", "flow.bulk_velocity": 1.0,
        "start.from": "logarithmic", "start.velocity": 1.0, "start.height": 1.0, "start.disturbance": 0.0,
        "time.step": 0.3 / n, "time.end": 3.0, "coupling.dem_steps": 15, "reference.velocity": 1.0,
        "output.spheres_every": 0.3,
    }, {"hold": 1, "gravity": 0.3})  # fmt: skip
    with h5py.File(run.folder / "spheres.h5") as file:
        force, torque = (np.mean(file[f"mobile/{what}"][-3:], axis=0) for what in ("force", "torque"))
    return np.array([force[0], force[1], torque[2]])


def pocket(runner: Runner) -> Result:
    """A grain held in its pocket in a stream: what drag, lift and torque depend on the grid."""
    result = Result("Load on a grain in its pocket in a stream, Re = 200",
                    axes=("D/h", f"load over that with D/h = {FINEST}"))  # fmt: skip
    result.remarks.append(
        "The flow starts from a logarithmic profile over a square layer, bulk velocity 1 over 5 D, nu = 0.005; loads "
        "are means from t = 2.4 to 3. The four neighbours share cells with most of the grain's lower half, where "
        "markers stand back. The bounds are what that costs on coarse grids: a tenth with six cells, a twentieth from "
        "eight on, and of the torque up to an eighth."
    )
    # Drag, lift, torque.
    bounds = {6: (0.1, 0.1, 0.1), 8: (0.03, 0.05, 0.12), 10: (0.03, 0.05, 0.05), 12: (0.03, 0.02, 0.05)}
    finest = _in_a_stream(runner, FINEST)
    shares = {n: _in_a_stream(runner, n) / finest for n in bounds}
    for k, name in enumerate(("drag", "lift", "torque")):
        for n in bounds:
            result.rows.append(Row(f"{name}, D/h = {n}", float(shares[n][k] * finest[k]), float(finest[k]),
                                   bounds[n][k], source=f"D/h = {FINEST}"))  # fmt: skip
        result.curves.append(Curve(name, list(shares), [float(share[k]) for share in shares.values()], points=True))
    return result


CASES = {"incipient": incipient, "pocket": pocket}
