"""The hard cases of `./bedload study stability`: scenes that break codes of this kind.

Each case varies one knob and the time step, given as the Courant number c = U dt / h of the case's own
velocity U = 1. What it asks of a run is a function that returns a Verdict; it can fail.
"""

import itertools
import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .small_scenes import Ball, SmallScene
from .trajectories import Trajectories

PASS, INACCURATE, UNSTABLE = "pass", "inaccurate", "unstable"
REFUSED = "refused"  # one sentence before the first step
STOPPED = "stopped"  # one sentence on the way: the flow grew past what the time step carries


@dataclass(frozen=True)
class Verdict:
    kind: str
    number: float
    words: str


Judge = Callable[[Trajectories], Verdict]


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


def grade(number: float, good: float, bad: float, words: str) -> Verdict:
    """pass up to `good`, unstable beyond `bad` or where it is not a number, inaccurate between."""
    if not math.isfinite(number) or number > bad:
        return Verdict(UNSTABLE, number, words)
    return Verdict(PASS if number <= good else INACCURATE, number, words)


# --- A sphere kicked in fluid at rest: added mass against mass, from bubbles to lead ----------------

KICK_VISCOSITY = 0.02  # Re = 50


def kicked(density: float, dt: float) -> SmallScene:
    ball = Ball((2.03, 2.01, 1.98), density=density, velocity=(1.0, 0.0, 0.0))
    return SmallScene((4.0, 4.0, 4.0), 8, KICK_VISCOSITY, dt, 2.0, [ball])


def slows_down(density: float, dt: float, t: Trajectories) -> Verdict:
    """Drag only takes: the speed falls from step to step.

    The first step may differ: the fluid around a sphere that is suddenly there takes up its motion at
    once, and the sphere keeps a share rho_p / (rho_p + 1/2) of its speed. Bounds: a rise of 1 % of the
    start's speed is beyond the scatter of a sphere that moves over the cells (0.5 %); a rise of 20 %
    is a growing swing.
    """
    speed = np.linalg.norm(t.velocity[:, 0], axis=1)
    return grade(float(np.max(np.diff(speed), initial=0.0)), 0.01, 0.2, "largest rise of the speed")


# --- A fast spin ----------------------------------------------------------------------------------


def spinning(spin: float, dt: float) -> SmallScene:
    ball = Ball((2.03, 2.01, 1.98), density=1.2, spin=(0.0, 0.0, spin))
    return SmallScene((4.0, 4.0, 4.0), 8, 0.02, 2.0 * dt / spin, 200.0 * dt / spin, [ball])


def spin_falls(spin: float, dt: float, t: Trajectories) -> Verdict:
    """The spin only falls, and the sphere stays (no lift without a stream), to 1 % of the surface's
    speed; 20 % is a sphere that has run away."""
    rate = t.angular_velocity[:, 0, 2] / spin
    drift = np.linalg.norm(t.velocity[-1, 0]) / (0.5 * spin)
    rise = float(np.max(np.diff(rate), initial=0.0))
    return grade(max(rise, float(drift)), 0.01, 0.2, "rise of the spin, or drift")


# --- Impact on a wall, St = rho_p u D / (9 rho_f nu) ------------------------------------------------

IMPACT_DENSITY = 8.0


def impact(stokes: float, dt: float) -> SmallScene:
    ball = Ball((1.52, 1.3, 1.49), density=IMPACT_DENSITY, velocity=(0.0, -1.0, 0.0))
    viscosity = IMPACT_DENSITY / (9.0 * stokes)
    # Fluid that was at rest takes part of the speed; the way to the wall is 0.8 D.
    return SmallScene((3.0, 4.0, 3.0), 8, viscosity, dt, 2.0, [ball])


def rebounds_slower(stokes: float, dt: float, t: Trajectories) -> Verdict:
    """No rebound is faster than the fastest approach, and the wall is not entered deeper than the
    collision time allows: 1.09 u t*, t* = 10 dt / 3.2 (the model's own overlap), and 1e-3 D."""
    v = t.velocity[:, 0, 1]
    gain = float(np.max(v) / max(-np.min(v), 1e-12))
    overlap = float(0.5 - np.min(t.position[:, 0, 1]))
    allowed = 1.1 * 1.09 * float(-np.min(v)) * 10 * dt / 3.2 + 1e-3
    return grade(max(gain, overlap / allowed), 1.0, 2.0, "rebound speed or overlap over its limit")


# --- Pressed into a gap below zeta_min, in a very viscous fluid -------------------------------------


def pressed(gap: float, dt: float) -> SmallScene:
    ball = Ball((1.52, 0.5 + gap, 1.49), density=8.0)
    return SmallScene((3.0, 3.0, 3.0), 8, 1.0, dt, 60 * dt, [ball], gravity=10.0)


def settles_down(_: float, dt: float, t: Trajectories) -> Verdict:
    """It comes down without swinging: never upwards faster than 1 % of the speed U of the case, and
    less deep than 0.01 D (the enduring contact asks for 1e-3 R)."""
    up = float(np.max(t.velocity[:, 0, 1]))
    overlap = float(0.5 - np.min(t.position[:, 0, 1]))
    return grade(max(up, overlap), 0.01, 0.2, "speed upwards, or overlap")


# --- Wedged between two fixed spheres ---------------------------------------------------------------


def wedged(opening: float, dt: float) -> SmallScene:
    half = 0.5 * (1.0 + opening)
    height = 1.0 + math.sqrt(max(1.0 - half * half, 0.0)) + 0.01
    balls = [
        Ball((2.0 - half, 1.0, 2.0), mobile=False),
        Ball((2.0 + half, 1.0, 2.0), mobile=False),
        Ball((2.0, height, 2.0), density=8.0),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.05, dt, 100 * dt, balls, gravity=5.0)


def stays_wedged(_: float, dt: float, t: Trajectories) -> Verdict:
    """It slides in and stops: by the end slower than 5 % of sqrt(g D), never faster than it falls."""
    speed = np.linalg.norm(t.velocity[:, 0], axis=1)
    scale = math.sqrt(5.0)
    worst = max(float(np.max(speed)) / scale - 1.0, float(speed[-1]) / scale)
    return grade(worst, 0.05, 0.5, "speed over sqrt(g D)")


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


def energy_falls(_: float, dt: float, t: Trajectories) -> Verdict:
    """The grains' kinetic energy never exceeds what they came with (1 % for the fluid's work while
    the shell closes)."""
    energy = t.kinetic_energy()
    return grade(float(np.max(energy) / energy[0] - 1.0), 0.01, 0.5, "growth of the kinetic energy")


# --- Overlap at the start --------------------------------------------------------------------------


def overlapping(overlap: float, dt: float) -> SmallScene:
    balls = [
        Ball((1.5 + 0.5 * overlap, 2.02, 1.99)),
        Ball((2.5 - 0.5 * overlap, 2.02, 1.99), velocity=(-0.1, 0.0, 0.0)),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.02, dt, 60 * dt, balls)


def parts_gently(_: float, dt: float, t: Trajectories) -> Verdict:
    """The two part no faster than the case's speed U = 1, ten times what they came with."""
    return grade(t.fastest(), 1.0, 5.0, "largest speed")


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


def stays_slow(_: float, dt: float, t: Trajectories) -> Verdict:
    """Nothing is shot out: no grain faster than what fell on it (twice its speed, the most that an
    elastic impact of a heavy on a light sphere gives, and the speed of falling sqrt(2 g D))."""
    return grade(t.fastest(), 2.0 + math.sqrt(2.0), 10.0, "largest speed")


# --- Five hundred grains at once -------------------------------------------------------------------


def dropped(flow: str, dt: float) -> SmallScene:
    rng = random.Random(11)
    sites = list(itertools.product(range(8), range(8), range(8)))[:500]
    balls = [
        Ball(tuple(0.6 + 1.125 * n + 0.05 * rng.uniform(-1, 1) for n in site), density=2.5)
        for site in ((i, j, k) for j, i, k in sites)
    ]
    keys = {}
    if flow == "turbulent":
        keys = {
            "start.from": '"logarithmic"', "start.velocity": "1.0", "start.disturbance": "0.5",
            "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0",
        }  # fmt: skip
    return SmallScene(
        (9.0, 12.0, 9.0), 6, 0.005, dt, 60 * dt, balls, gravity=0.5, keys=keys
    )


def all_there(_: str, dt: float, t: Trajectories) -> Verdict:
    """All grains remain, inside the box, and none is faster than a free fall through half the box's
    height or the stream."""
    if t.position.shape[1] != 500:
        return Verdict(UNSTABLE, t.position.shape[1], "grains left")
    return grade(t.fastest(), 1.0 + math.sqrt(2 * 0.3 * 6.0), 20.0, "largest speed")


# --- Through a corner where periods and ranks meet -------------------------------------------------


def through_corner(ranks: int, dt: float) -> SmallScene:
    balls = [
        Ball((3.4, 2.0, 3.4), velocity=(1.0, 0.3, 1.0), density=2.5),
        Ball((2.692, 2.0, 2.692), velocity=(1.0, 0.3, 1.0), density=2.5),
    ]
    return SmallScene((4.0, 4.0, 4.0), 8, 0.01, dt, 1.5, balls)


def keeps_pair(_: int, dt: float, t: Trajectories) -> Verdict:
    """Two touching spheres on their way through the corner stay two slow spheres that never overlap by
    more than 0.02 D; their sampled places jump by one period, not more."""
    gap = t.pair_gap(0, 1)
    return grade(max(float(-np.min(gap)), t.fastest() / 1.6 - 1.0), 0.02, 0.5, "overlap or speed")


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


def new_driving(velocity: float, dt: float) -> SmallScene:
    """The start field has the mean velocity 1; from the first step on it is held at `velocity`."""
    return bed_scene(6, dt, 2.0, velocity)


def stays_in_stream(velocity: float, dt: float, t: Trajectories) -> Verdict:
    """The grain is not faster than three times the stream, and it stays above the bed."""
    stream = max(1.0, abs(velocity)) if velocity < 5 else 1.0
    low = float(np.min(t.position[:, 0, 1]))
    worst = max(t.fastest() / (3.0 * stream), 1.15 / low)
    return grade(worst, 1.0, 2.0, "speed over three times the stream, or height too low")


CASES = {
    case.name: case
    for case in (
        HardCase(
            "density_ratio", "a kicked sphere, from bubble to lead", "rho_p/rho_f",
            (0.3, 0.5, 0.8, 1.0, 1.2, 8.0, 50.0), (0.1, 0.3, 0.6, 1.0), kicked, slows_down,
        ),
        HardCase(
            "spin", "a fast spin", "omega D/U", (2.0, 20.0, 100.0), (0.1, 0.3, 0.6),
            spinning, spin_falls,
        ),
        HardCase(
            "impact", "a fall on a wall", "St", (0.1, 1.0, 10.0, 100.0, 1000.0, 5000.0),
            (0.1, 0.3, 0.6), impact, rebounds_slower,
        ),
        HardCase(
            "pressed", "pressed on a wall in a very viscous fluid", "gap/D",
            (1e-2, 1e-3, 1e-5), (0.01, 0.1, 0.3), pressed, settles_down,
        ),
        HardCase(
            "wedged", "wedged between two fixed spheres", "opening/D", (0.3, 0.8, 0.95),
            (0.1, 0.3, 0.6), wedged, stays_wedged,
        ),
        HardCase(
            "cluster", "twelve contacts at once", "inward speed", (0.05, 0.5),
            (0.1, 0.3, 0.6), cluster, energy_falls,
        ),
        HardCase(
            "overlap", "two spheres that overlap at the start", "overlap/D", (0.01, 0.05, 0.2),
            (0.1, 0.3), overlapping, parts_gently,
        ),
        HardCase(
            "size_ratio", "a large sphere falls on small ones", "ratio", (2.0, 4.0), (0.1, 0.3),
            big_on_small, stays_slow,
        ),
        HardCase(
            "dropped", "five hundred grains dropped at once", "fluid", ("still", "turbulent"),
            (0.1, 0.3), dropped, all_there,
        ),
        HardCase(
            "corner", "a touching pair through a periodic corner on a rank corner", "fluid ranks",
            (1, 2, 4), (0.1, 0.3, 0.6), through_corner, keeps_pair,
        ),
        HardCase(
            "coarse", "a grain on a bed under a stream", "D/h", (6, 8), (0.1, 0.3, 0.6, 0.9),
            coarse_bed, stays_in_stream,
        ),
        HardCase(
            "driving", "the stream changes at once", "new bulk velocity", (2.0, 0.0, -1.0),
            (0.1, 0.3), new_driving, stays_in_stream,
        ),
    )
}  # fmt: skip
