"""The hard cases of `./bedload study stability`: scenes that break codes of this kind.

Each case varies one knob and the time step, given as the Courant number c = U dt / h of the case's own
velocity U = 1. A case ends at one physical time, whatever its step: a short step has to hold as long. What it
asks of a run is a function in criteria.py; it can fail.
"""

import itertools
import math
import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from . import criteria
from .criteria import (
    CORNER,
    CROWD_SPEED,
    DROPPED,
    DROPPED_GRAVITY,
    GRAIN_DENSITY,
    IMPACT_DENSITY,
    KICK_VISCOSITY,
    OVERLAPPING_SPEED,
    PINNED_GRAVITY,
    PRESSED_DENSITY,
    PRESSED_GRAVITY,
    PRESSED_VISCOSITY,
    SPIN_DENSITY,
    SPIN_VISCOSITY,
    WEDGED_GRAVITY,
    Verdict,
)
from .small_scenes import Ball, SmallScene, Vector


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
    long: bool = False  # hours: only asked for by name or with --long


CROWD_SPACING = 1.0625  # D; the gap is half a cell


def vector(values: Iterable[float]) -> Vector:
    """Three numbers."""
    x, y, z = values
    return x, y, z


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
    return SmallScene((4.0, 4.0, 4.0), 8, SPIN_VISCOSITY, 2.0 * dt / spin, 15.0 / spin, [ball])


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
        (3.0, 3.0, 3.0), 8, PRESSED_VISCOSITY, dt, 2.25, [ball], gravity=PRESSED_GRAVITY
    )


# --- Wedged between three fixed spheres (on two it would lie on a saddle and roll off) ----------------


def wedged(opening: float, dt: float) -> SmallScene:
    reach = (1.0 + opening) / math.sqrt(3.0)  # of the supports from the axis
    height = criteria.resting_height(opening) + 0.01
    balls = [
        Ball((2.0 + reach * math.cos(a), 1.0, 2.0 + reach * math.sin(a)), mobile=False)
        for a in (0.1, 0.1 + 2.0 * math.pi / 3.0, 0.1 + 4.0 * math.pi / 3.0)
    ]
    balls.append(Ball((2.0, height, 2.0), density=8.0))
    return SmallScene((4.0, 4.0, 4.0), 8, 0.05, dt, 7.5, balls, gravity=WEDGED_GRAVITY)


# --- Between the wall and a sphere that falls on it ------------------------------------------------


def pinned(density: float, dt: float) -> SmallScene:
    balls = [
        Ball((1.52, 0.501, 1.49), density=GRAIN_DENSITY),
        Ball((1.54, 1.8, 1.5), density=density, velocity=(0.0, -1.0, 0.0)),
    ]
    return SmallScene((3.0, 4.0, 3.0), 8, 0.02, dt, 3.0, balls, gravity=PINNED_GRAVITY)


# --- Thirteen spheres, twelve contacts on one ------------------------------------------------------


def cluster(inward: float, dt: float) -> SmallScene:
    a = 1.002 / math.sqrt(2.0)
    shell = [
        np.array(p) * a
        for p in itertools.product((-1, 0, 1), repeat=3)
        if sum(abs(n) for n in p) == 2
    ]
    centre = np.array([2.51, 2.53, 2.49])
    balls = [Ball(vector(centre))]
    balls += [Ball(vector(centre + s), velocity=vector(-inward * s)) for s in shell]
    return SmallScene((5.0, 5.0, 5.0), 8, 0.01, dt, 1.5, balls)


# --- Light spheres half a cell apart, each kicked against its neighbours -----------------------------


def crowd(density: float, dt: float) -> SmallScene:
    """They carry more fluid to and fro than they weigh: an answer of the fluid that comes too strong grows."""
    balls = [
        Ball(vector(0.52 + CROWD_SPACING * np.array(place)), density=density,
             velocity=(CROWD_SPEED * (-1) ** sum(place), 0.0, 0.0))
        for place in itertools.product(range(4), range(3), range(4))
    ]  # fmt: skip
    wide = 4.0 * CROWD_SPACING
    return SmallScene((wide, wide, wide), 8, 0.02, dt, 1.5, balls)


# --- Overlap at the start --------------------------------------------------------------------------


def overlapping(overlap: float, dt: float) -> SmallScene:
    balls = [
        Ball((1.5 + 0.5 * overlap, 2.02, 1.99)),
        Ball((2.5 - 0.5 * overlap, 2.02, 1.99), velocity=(-OVERLAPPING_SPEED, 0.0, 0.0)),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.02, dt, 2.25, balls)


# --- Size ratio four -------------------------------------------------------------------------------


def big_on_small(ratio: float, dt: float) -> SmallScene:
    rng = random.Random(7)
    small = [
        Ball((0.8 + 1.3 * i + 0.1 * rng.random(), 0.6, 0.8 + 1.3 * k + 0.1 * rng.random()))
        for i in range(5)
        for k in range(5)
    ]
    big = Ball((3.3, 1.3 + 0.5 * ratio, 3.4), diameter=ratio, velocity=(0.0, -1.0, 0.0))
    return SmallScene((7.0, 8.0, 7.0), 6, 0.02, dt, 3.0, [*small, big], gravity=1.0)


# --- Five hundred grains at once -------------------------------------------------------------------


def dropped(flow: str, dt: float) -> SmallScene:
    rng = random.Random(11)
    sites = list(itertools.product(range(8), range(8), range(8)))[:DROPPED]
    balls = [
        Ball(vector(0.6 + 1.125 * n + 0.05 * rng.uniform(-1, 1) for n in site), density=GRAIN_DENSITY)
        for site in ((i, j, k) for j, i, k in sites)
    ]
    keys = {}
    if flow == "turbulent":
        keys = {
            "start.from": '"logarithmic"', "start.velocity": "1.0", "start.disturbance": "0.5",
            "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0",
        }  # fmt: skip
    return SmallScene(
        (9.0, 12.0, 9.0), 6, 0.005, dt, 3.0, balls, gravity=DROPPED_GRAVITY, keys=keys
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


# --- Each collision model, and grains that are much lighter than those they roll on -------------------


def each_model(model: str, dt: float) -> SmallScene:
    scene = bed_scene(6, dt, 4.0, 1.0)
    *bed, grain = scene.balls
    # rpm's force begins 2 h before the touch. A grain that is put where it acts, 0.1 D deep in it, say, is thrown
    # off, the faster the stiffer the model, which is with shorter steps: a scene's mistake, and no hard case.
    lifted = replace(grain, position=(2.0, 1.65, 1.0), velocity=(0.5, -0.5, 0.0))
    return replace(scene, model=model, balls=[*bed, lifted])


def light_on_moving_bed(density: float, dt: float) -> SmallScene:
    """A grain of `density` among twelve that the stream moves over a wall."""
    balls = [Ball((0.5 + i, 0.501, 0.5 + k), density=GRAIN_DENSITY) for i in range(4) for k in range(3)]
    balls.append(Ball((2.0, 1.21, 1.0), density=density))
    flow = {
        "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0",
        "start.from": '"logarithmic"', "start.velocity": "1.0", "start.disturbance": "0.2",
    }  # fmt: skip
    return SmallScene(
        (4.0, 5.0, 3.0), 6, 0.005, dt, 4.0, balls, gravity=0.3, y_ends=("no_slip", "free_slip"), keys=flow
    )


# --- A box as narrow as is allowed, and a channel filled with grains ----------------------------------


def narrow(width: float, dt: float) -> SmallScene:
    """A kicked sphere beside its own periodic images."""
    ball = Ball((2.03, 2.01, 0.5 * width), velocity=(1.0, 0.0, 0.0))
    return SmallScene((4.0, 4.0, width), 8, KICK_VISCOSITY, dt, 2.0, [ball])


def plug(layers: int, dt: float) -> SmallScene:
    """Layers of grains from wall to wall, pushed through by the fluid's mean velocity."""
    balls = [
        Ball((0.52 + 1.04 * i, 0.515 + 1.03 * j, 0.52 + 1.04 * k), density=GRAIN_DENSITY)
        for i in range(layers) for j in range(4) for k in range(3)
    ]  # fmt: skip
    keys = {"flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "0.5"}
    return SmallScene((8.0, 4.125, 3.125), 8, 0.05, dt, 1.0, balls, keys=keys)


# --- Pulled on the wall by a hundred times U^2/D -------------------------------------------------------


def heavy_fall(gravity: float, dt: float) -> SmallScene:
    """From half a diameter, to a speed of sqrt(g D) at most: the step is shorter by that."""
    ball = Ball((1.52, 1.0, 1.49), density=IMPACT_DENSITY)
    speed = math.sqrt(gravity)
    return SmallScene(
        (3.0, 4.0, 3.0), 8, 0.02 * speed, dt / speed, 4.0 / speed, [ball], gravity=gravity
    )


# --- One large grain among small ones -----------------------------------------------------------------


def mixture(ratio: float, dt: float) -> SmallScene:
    """A large sphere settles on a layer of small ones between it and the wall."""
    balls = [Ball((0.75 + 1.5 * i, 0.51, 0.75 + 1.5 * k)) for i in range(8) for k in range(8)]
    balls.append(Ball((6.1, 1.2 + 0.5 * ratio, 5.9), diameter=ratio))
    return SmallScene((12.0, 14.0, 12.0), 5, 0.05, dt, 3.0, balls, gravity=0.5)


# --- Only with --long: a bed of two thousand grains on the move ----------------------------------------


def moving_bed(steps: int, dt: float) -> SmallScene:
    balls = [
        Ball((0.51 + 1.02 * i, 0.51 + 1.01 * j, 0.51 + 1.02 * k), density=GRAIN_DENSITY)
        for j in range(5) for i in range(25) for k in range(16)
    ]  # fmt: skip
    keys = {
        "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0", "output.spheres_every": "0.5",
        "start.from": '"logarithmic"', "start.velocity": "1.0", "start.height": "5.0",
        "start.disturbance": "0.2",
    }  # fmt: skip
    return SmallScene(
        (25.6, 10.0, 16.4), 5, 0.005, dt, steps * dt, balls, gravity=0.1,
        y_ends=("no_slip", "free_slip"), keys=keys,
    )  # fmt: skip


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
            "wedged", "wedged between three fixed spheres", "opening/D", (0.1, 0.4, 0.6),
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
            "crowd", "light spheres half a cell apart, each kicked against its neighbours", "rho_p/rho_f",
            (0.5, 0.6, 1.0, 2.5), (0.1, 0.3), crowd, criteria.crowd_calms,
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
        HardCase(
            "models", "each collision model on a bed under a stream", "model",
            ("rpm", "rpm_hw", "actm", "actm_hw"), (0.1, 0.3, 0.6), each_model, criteria.stays_in_stream,
        ),
        HardCase(
            "light", "a light grain on a moving bed", "rho_p/rho_f", (0.3, 0.8, 1.0), (0.1, 0.3),
            light_on_moving_bed, criteria.stays_together,
        ),
        HardCase(
            "narrow", "a periodic box as narrow as is allowed", "width/D", (1.5, 2.0, 3.0), (0.1, 0.3),
            narrow, criteria.slows_in_narrow_box,
        ),
        HardCase(
            "plug", "a plug of grains that fills the channel", "layers", (1, 4), (0.1, 0.3), plug,
            criteria.moves_as_plug,
        ),
        HardCase(
            "heavy_fall", "a fall under a hundred times U^2/D", "g D/U^2", (100.0,), (0.1, 0.3),
            heavy_fall, criteria.lands,
        ),
        HardCase(
            "mixture", "one large grain among small ones", "ratio", (8.0,), (0.1, 0.3), mixture,
            criteria.stays_slow,
        ),
        HardCase(
            "moving_bed", "two thousand grains on the move", "steps", (10_000,), (0.3,), moving_bed,
            criteria.stays_together, long=True,
        ),
    )
}  # fmt: skip
