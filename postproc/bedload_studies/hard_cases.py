"""The hard cases of `./bedload study stability`: scenes that break codes of this kind.

Each case varies one knob and the time step, given as the Courant number c = U dt / h of the case's own
velocity U = 1. What it asks of a run is a function in criteria.py; it can fail.
"""

import itertools
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from . import criteria
from .criteria import (
    CORNER,
    DROPPED,
    DROPPED_GRAVITY,
    GRAIN_DENSITY,
    IMPACT_DENSITY,
    KICK_VISCOSITY,
    OVERLAPPING_SPEED,
    PRESSED_DENSITY,
    PRESSED_GRAVITY,
    PRESSED_VISCOSITY,
    SPIN_DENSITY,
    SPIN_VISCOSITY,
    WEDGED_GRAVITY,
    Verdict,
)
from .small_scenes import Ball, SmallScene


@dataclass(frozen=True)
class HardCase:
    """scene(value, dt) builds a run; judge(value, dt, trajectories) says how it went."""

    name: str
    question: str
    knob: str
    values: Sequence
    courant: Sequence[float]
    scene: Callable[..., SmallScene]
    judge: Callable[..., Verdict]


# --- A sphere kicked in fluid at rest: added mass against mass, from bubbles to lead ----------------


def kicked(density: float, dt: float) -> SmallScene:
    ball = Ball((2.03, 2.01, 1.98), density=density, velocity=(1.0, 0.0, 0.0))
    return SmallScene((4.0, 4.0, 4.0), 8, KICK_VISCOSITY, dt, 2.0, [ball])



def kicked_by_step(density: float, dt: float) -> SmallScene:
    """The same with forces and motion exchanged once per step."""
    return replace(kicked(density, dt), keys={"coupling.exchange": '"step"'})


# --- A fast spin ----------------------------------------------------------------------------------


def spinning(spin: float, dt: float) -> SmallScene:
    ball = Ball((2.03, 2.01, 1.98), density=SPIN_DENSITY, spin=(0.0, 0.0, spin))
    return SmallScene((4.0, 4.0, 4.0), 8, SPIN_VISCOSITY, 2.0 * dt / spin, 200.0 * dt / spin, [ball])


# --- Impact on a wall, St = rho_p u D / (9 rho_f nu) ------------------------------------------------


def impact(stokes: float, dt: float) -> SmallScene:
    """From where the sphere still reaches the wall: Stokes' drag stops it after St D / 2."""
    gap = min(0.8, 0.2 * stokes)
    ball = Ball((1.52, 0.5 + gap, 1.49), density=IMPACT_DENSITY, velocity=(0.0, -1.0, 0.0))
    viscosity = IMPACT_DENSITY / (9.0 * stokes)
    return SmallScene((3.0, 4.0, 3.0), 8, viscosity, dt, 2.0, [ball])


def impact_in_one_step(stokes: float, dt: float) -> SmallScene:
    """The same with one step of LIGGGHTS to a step of the fluid."""
    keys = {"coupling.exchange": '"step"', "coupling.dem_steps": "1"}
    return replace(impact(stokes, dt), keys=keys)


# --- Pressed into a gap below zeta_min, in a very viscous fluid -------------------------------------


def pressed(gap: float, dt: float) -> SmallScene:
    ball = Ball((1.52, 0.5 + gap, 1.49), density=PRESSED_DENSITY)
    return SmallScene(
        (3.0, 3.0, 3.0), 8, PRESSED_VISCOSITY, dt, 60 * dt, [ball], gravity=PRESSED_GRAVITY
    )


# --- Wedged between two fixed spheres ---------------------------------------------------------------


def wedged(opening: float, dt: float) -> SmallScene:
    half = 0.5 * (1.0 + opening)
    height = criteria.resting_height(opening) + 0.01
    balls = [
        Ball((2.0 - half, 1.0, 2.0), mobile=False),
        Ball((2.0 + half, 1.0, 2.0), mobile=False),
        Ball((2.0, height, 2.0), density=8.0),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.05, dt, 100 * dt, balls, gravity=WEDGED_GRAVITY)


# --- Between the wall and a sphere that falls on it ------------------------------------------------


def pinned(density: float, dt: float) -> SmallScene:
    balls = [
        Ball((1.52, 0.501, 1.49)),
        Ball((1.54, 1.8, 1.5), density=density, velocity=(0.0, -1.0, 0.0)),
    ]
    return SmallScene((3.0, 4.0, 3.0), 8, 0.02, dt, 80 * dt, balls, gravity=1.0)


# --- Thirteen spheres, twelve contacts on one ------------------------------------------------------


def cluster(inward: float, dt: float) -> SmallScene:
    a = 1.002 / math.sqrt(2.0)
    shell = [
        np.array(p) * a
        for p in itertools.product((-1, 0, 1), repeat=3)
        if sum(map(abs, p)) == 2
    ]
    centre = np.array([2.51, 2.53, 2.49])
    balls = [Ball(tuple(centre))]
    balls += [Ball(tuple(centre + s), velocity=tuple(-inward * s)) for s in shell]
    return SmallScene((5.0, 5.0, 5.0), 8, 0.01, dt, 40 * dt, balls)


# --- Overlap at the start --------------------------------------------------------------------------


def overlapping(overlap: float, dt: float) -> SmallScene:
    balls = [
        Ball((1.5 + 0.5 * overlap, 2.02, 1.99)),
        Ball((2.5 - 0.5 * overlap, 2.02, 1.99), velocity=(-OVERLAPPING_SPEED, 0.0, 0.0)),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.02, dt, 60 * dt, balls)


# --- Size ratio four -------------------------------------------------------------------------------


def big_on_small(ratio: float, dt: float) -> SmallScene:
    rng = random.Random(7)
    small = [
        Ball((0.8 + 1.3 * i + 0.1 * rng.random(), 0.6, 0.8 + 1.3 * k + 0.1 * rng.random()))
        for i in range(5)
        for k in range(5)
    ]
    big = Ball((3.3, 1.3 + 0.5 * ratio, 3.4), diameter=ratio, velocity=(0.0, -1.0, 0.0))
    return SmallScene((7.0, 8.0, 7.0), 6, 0.02, dt, 60 * dt, [*small, big], gravity=1.0)


# --- Five hundred grains at once -------------------------------------------------------------------


def dropped(flow: str, dt: float) -> SmallScene:
    rng = random.Random(11)
    sites = list(itertools.product(range(8), range(8), range(8)))[:DROPPED]
    balls = [
        Ball(tuple(0.6 + 1.125 * n + 0.05 * rng.uniform(-1, 1) for n in site), density=GRAIN_DENSITY)
        for site in ((i, j, k) for j, i, k in sites)
    ]
    keys = {}
    if flow == "turbulent":
        keys = {
            "start.from": '"logarithmic"', "start.velocity": "1.0", "start.disturbance": "0.5",
            "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0",
        }  # fmt: skip
    return SmallScene(
        (9.0, 12.0, 9.0), 6, 0.005, dt, 60 * dt, balls, gravity=DROPPED_GRAVITY, keys=keys
    )


# --- Through a corner where periods and ranks meet -------------------------------------------------


def through_corner(ranks: int, dt: float) -> SmallScene:
    balls = [
        Ball((3.4, 2.0, 3.4), velocity=(1.0, 0.3, 1.0), density=GRAIN_DENSITY),
        Ball((2.692, 2.0, 2.692), velocity=(1.0, 0.3, 1.0), density=GRAIN_DENSITY),
    ]
    return SmallScene((CORNER, 4.0, CORNER), 8, 0.01, dt, 1.5, balls)


# --- A coarse bed under a fast stream, and a stream that changes at once ----------------------------


def bed_scene(cells: int, dt: float, end: float, velocity: float, keys=None) -> SmallScene:
    balls = [
        Ball((0.5 + i, 0.5, 0.5 + k), mobile=False) for i in range(4) for k in range(3)
    ]
    balls.append(Ball((2.0, 0.5 + math.sqrt(0.5) + 0.001, 1.0), density=1.3))
    flow = {
        "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": repr(velocity),
        "start.from": '"logarithmic"', "start.velocity": "1.0", "start.height": "1.0",
        "start.disturbance": "0.2",
    }  # fmt: skip
    return SmallScene(
        (4.0, 5.0, 3.0), cells, 0.005, dt, end, balls, gravity=0.3,
        y_ends=("no_slip", "free_slip"), keys=flow | (keys or {}),
    )  # fmt: skip


def coarse_bed(cells: int, dt: float) -> SmallScene:
    return bed_scene(cells, dt, 4.0, 1.0)


def at_the_limit(cfl: float, longest: float) -> SmallScene:
    """The step follows the flow up to the scheme's limit, sqrt(3)."""
    return bed_scene(6, longest, 4.0, 1.0, {"time.cfl": repr(cfl)})


def new_driving(velocity: float, dt: float) -> SmallScene:
    """The start field has the mean velocity 1; from the first step on it is held at `velocity`."""
    return bed_scene(6, dt, 2.0, velocity)



CASES = {
    case.name: case
    for case in (
        HardCase(
            "density_ratio", "a kicked sphere, from bubble to lead", "rho_p/rho_f",
            (0.3, 0.5, 0.8, 1.0, 1.2, 8.0, 50.0), (0.1, 0.3, 0.6, 1.0), kicked, criteria.slows_down,
        ),
        HardCase(
            "density_ratio_step", "the same, forces exchanged once per step", "rho_p/rho_f",
            (0.5, 1.0, 1.2, 1.5, 2.0, 2.5, 8.0, 50.0), (0.1, 0.3, 0.6), kicked_by_step,
            criteria.slows_down,
        ),
        HardCase(
            "spin", "a fast spin", "omega D/U", (2.0, 20.0, 100.0), (0.1, 0.3, 0.6),
            spinning, criteria.spin_falls,
        ),
        HardCase(
            "impact", "a fall on a wall", "St", (0.1, 1.0, 10.0, 100.0, 1000.0, 5000.0),
            (0.1, 0.3, 0.6), impact, criteria.rebounds_slower,
        ),
        HardCase(
            "impact_1_step", "a fall on a wall, one step of LIGGGHTS to a step", "St",
            (0.1, 1.0, 10.0, 100.0, 1000.0, 5000.0), (0.1, 0.3, 0.6), impact_in_one_step,
            criteria.rebounds_slower,
        ),
        HardCase(
            "pressed", "pressed on a wall in a very viscous fluid", "gap/D",
            (1e-2, 1e-3, 1e-5), (0.01, 0.1, 0.3), pressed, criteria.settles_down,
        ),
        HardCase(
            "wedged", "wedged between two fixed spheres", "opening/D", (0.3, 0.8, 0.95),
            (0.1, 0.3, 0.6), wedged, criteria.stays_wedged,
        ),
        HardCase(
            "pinned", "a grain between the wall and a sphere that falls on it", "rho of the mover",
            (2.5, 8.0, 50.0), (0.1, 0.3, 0.6), pinned, criteria.stays_pinned,
        ),
        HardCase(
            "cluster", "twelve contacts at once", "inward speed", (0.05, 0.5),
            (0.1, 0.3, 0.6), cluster, criteria.energy_falls,
        ),
        HardCase(
            "overlap", "two spheres that overlap at the start", "overlap/D", (0.01, 0.05, 0.2),
            (0.1, 0.3), overlapping, criteria.parts_gently,
        ),
        HardCase(
            "size_ratio", "a large sphere falls on small ones", "ratio", (2.0, 4.0), (0.1, 0.3),
            big_on_small, criteria.stays_slow,
        ),
        HardCase(
            "dropped", "five hundred grains dropped at once", "fluid", ("still", "turbulent"),
            (0.1, 0.3), dropped, criteria.all_there,
        ),
        HardCase(
            "corner", "a touching pair through a periodic corner on a rank corner", "fluid ranks",
            (1, 2, 4), (0.1, 0.3, 0.6), through_corner, criteria.keeps_pair,
        ),
        HardCase(
            "coarse", "a grain on a bed under a stream", "D/h", (6, 8), (0.1, 0.3, 0.6, 0.9),
            coarse_bed, criteria.stays_in_stream,
        ),
        HardCase(
            "cfl", "the step as long as the flow allows", "CFL number", (0.8, 1.2, 1.6, 1.73),
            (3.0,), at_the_limit, criteria.keeps_to_cfl,
        ),
        HardCase(
            "driving", "the stream changes at once", "new bulk velocity", (2.0, 0.0, -1.0),
            (0.1, 0.3), new_driving, criteria.follows_change,
        ),
    )
}  # fmt: skip
