"""What the hard cases ask of a run. No study of its own.

D = U = rho_f = 1 in all of them. Every bound has its reason beside it; a criterion is a list of checks,
each a number over its limit, and the worst of them is the run's verdict. Each would fail with the term
that its case is about (contact force, film, force or torque of the fluid) missing or of the wrong sign:
tests/postproc/test_criteria.py shows it on made-up runs.
"""

import math
from dataclasses import dataclass

import numpy as np

from .sphere_theory import film_speed, kicked_speed, spin_left, wet_restitution
from .trajectories import Trajectories

PASS, INACCURATE, UNSTABLE = "pass", "inaccurate", "unstable"
REFUSED = "refused"  # one sentence before the first step
STOPPED = "stopped"  # one sentence on the way: the flow grew past what the time step carries

SEVERITY = {PASS: 0, INACCURATE: 1, UNSTABLE: 2}
CELLS = 8  # to a diameter, where a criterion needs it

KICK_VISCOSITY = 0.02  # Re = 50
SPIN_VISCOSITY, SPIN_DENSITY = 0.02, 1.2
IMPACT_DENSITY = 8.0
PRESSED_DENSITY, PRESSED_GRAVITY, PRESSED_VISCOSITY = 8.0, 10.0, 1.0
WEDGED_GRAVITY = 5.0
PINNED_GRAVITY = 1.0
GRAIN_DENSITY = 2.5
CROWD_SPEED = 0.05
OVERLAPPING_SPEED = 0.1
DROPPED_GRAVITY, DROPPED = 0.5, 500
CORNER = 4.0


@dataclass(frozen=True)
class Verdict:
    """number: the worst of the case's numbers over its limit."""

    kind: str
    number: float
    words: str


@dataclass(frozen=True)
class Check:
    """A number that passes up to `good` and is a sign of instability beyond `bad`."""

    words: str
    value: float
    good: float
    bad: float = math.inf

    def verdict(self) -> Verdict:
        over = float(self.value) / self.good
        if math.isnan(over) or self.value > self.bad:
            return Verdict(UNSTABLE, over, self.words)
        return Verdict(PASS if self.value <= self.good else INACCURATE, over, self.words)


def worst(*checks: Check) -> Verdict:
    """Of the checks' verdicts the most severe one, among equals the one furthest over its limit."""

    def rank(v: Verdict) -> tuple:
        return SEVERITY[v.kind], math.inf if math.isnan(v.number) else v.number

    return max((check.verdict() for check in checks), key=rank)


def collision_depth(speed: float, dt: float) -> float:
    """Deepest overlap of a collision at `speed`: 1.09 u t* (actm_calibration.hpp), t* = 10 dt / 3.2 being
    the model's time scale, a tenth more for the steps, and 1e-3 D for a contact that lasts."""
    return 1.1 * 1.09 * speed * 10.0 * dt / 3.2 + 1e-3


def overlap(t: Trajectories, speed: float, dt: float) -> Check:
    """Nothing is entered deeper than a collision at `speed` explains; by a radius is a lost contact."""
    lost = max(float(np.min(t.radius)), collision_depth(speed, dt))
    return Check("overlap", t.deepest_overlap(), collision_depth(speed, dt), lost)


def outside(value: float, low: float, high: float) -> float:
    """At most 1 between two positive bounds; beyond them the factor by which it misses."""
    return max(value / high, low / value) if value > 0.0 else math.inf


def share_kept(density: float) -> float:
    """Share of its speed that a sphere keeps which is suddenly in fluid at rest: rho_p/(rho_p + 1/2)."""
    return density / (density + 0.5)


def largest_rise(series: np.ndarray) -> float:
    return float(np.max(np.diff(series), initial=0.0))


def slows_down(density: float, dt: float, t: Trajectories) -> Verdict:
    """Drag only takes: the speed falls from step to step, and by its end to a value between those of the
    standard drag alone and of standard drag with Basset's whole history force (sphere_theory.py).

    Bounds: a rise of 1 % of the start's speed is beyond the scatter of a sphere that moves over the cells
    (0.5 %), one of 20 % is a growing swing. The standard drag is known within 5 %.
    """
    speed = np.linalg.norm(t.velocity[:, 0], axis=1)
    end = float(t.time[-1] - t.time[0])

    def loss(last: float) -> float:
        """After what the added mass took at once."""
        return math.log(share_kept(density) / last) if last > 0.0 else math.inf

    least, most = (
        loss(kicked_speed(density, KICK_VISCOSITY, end, history)) for history in (False, True)
    )
    found = loss(float(t.velocity[-1, 0, 0]))
    return worst(
        Check("largest rise of the speed", largest_rise(speed), 0.01, 0.2),
        Check("loss of speed outside theory", outside(found, least, most), 1.05),
    )


def spin_falls(spin: float, dt: float, t: Trajectories) -> Verdict:
    """The spin only falls, the sphere stays (no lift without a stream), to 1 % of the surface's speed (20 %
    is a sphere that has run away), and the spin falls as in unsteady Stokes flow.

    It is judged when theory has a quarter of it left, or at the end. The torque is at least three quarters
    of theory's (walls and neighbours 4 D away); it is more by what inertia adds, at most a quarter, or by
    what the first step gives away: the layer of one cell that is taken along at once, on average at half
    the surface's speed, has 5 h/(2 R rho_p) of the sphere's angular momentum.
    """
    rate = t.angular_velocity[:, 0, 2] / spin
    drift = float(np.linalg.norm(t.velocity[-1, 0])) / (0.5 * spin)
    left = spin_left(SPIN_DENSITY, SPIN_VISCOSITY, t.time - t.time[0])
    when = int(np.argmax(left <= 0.25)) or len(left) - 1
    expected = -math.log(left[when])
    found = -math.log(rate[when]) if rate[when] > 0.0 else math.inf
    layer = math.log1p(2.5 / CELLS / 0.5 / SPIN_DENSITY)
    most = max(1.25 * expected, expected + layer)
    return worst(
        Check("rise of the spin", largest_rise(rate), 0.01, 0.2),
        Check("drift", drift, 0.01, 0.2),
        Check("loss of spin outside theory", outside(found, 0.75 * expected, most), 1.0),
    )


def rebounds_slower(stokes: float, dt: float, t: Trajectories) -> Verdict:
    """The wall is not entered deeper than a collision at the approach's speed explains. Up to St = 10
    there is no rebound (5 % of the start's speed: measured rebounds begin at St of 10); from 100 on the
    rebound is that of the measured law within 0.25 (0.1 of scatter, and a contact that lasts longer
    than the real one), and never faster than dry.

    The approach is taken where the gap is still two cells wide: below, the film is part of the impact.
    """
    v = t.velocity[:, 0, 1]
    gap = t.position[:, 0, 1] - 0.5
    far = np.flatnonzero(gap > 2.0 / CELLS)
    before = int(far[far < int(np.argmin(gap))][-1]) if len(far) and far[0] < np.argmin(gap) else 0
    approach = max(float(-v[max(before, 1)]), 1e-12)
    rebound = max(float(np.max(v)), 0.0)
    checks = [overlap(t, float(np.max(-v)), dt)]
    if stokes <= 10.0:
        checks.append(Check("rebound", rebound / float(np.max(-v)), 0.05, 1.0))
    else:
        gain = rebound / approach
        impact_stokes = stokes * (IMPACT_DENSITY + 0.5) / IMPACT_DENSITY * approach
        law = wet_restitution(impact_stokes)
        checks.append(Check("rebound off the measured law", abs(gain - law), 0.25))
        checks.append(Check("rebound over the dry one", gain / 0.97, 1.0, 2.0))
    return worst(*checks)


def settles_down(gap: float, dt: float, t: Trajectories) -> Verdict:
    """It comes down without swinging: never upwards faster than 1 % of the speed U of the case, and
    less deep than 0.01 D (the enduring contact asks for 1e-3 R). Until it touches it is not faster than
    the film lets it be, W gap/(6 pi mu R^2), a quarter more for the drag of a film one cell thin."""
    y, v = t.position[:, 0, 1] - 0.5, t.velocity[:, 0, 1]
    touched = int(np.argmax(y <= 0.0)) if (y <= 0.0).any() else len(y)
    weight = (PRESSED_DENSITY - 1.0) * PRESSED_GRAVITY * math.pi / 6.0
    allowed = 1.25 * film_speed(weight, gap, PRESSED_VISCOSITY)
    return worst(
        Check("speed upwards", float(np.max(v)), 0.01, 0.2),
        Check("overlap", float(-np.min(y)), 0.01, 0.2),
        Check("speed in the film", float(np.max(-v[:touched], initial=0.0)), allowed),
    )


def resting_height(opening: float) -> float:
    """Of a unit sphere on three others, `opening` apart, all at height 1."""
    return 1.0 + math.sqrt(1.0 - (1.0 + opening) ** 2 / 3.0)


def stays_wedged(opening: float, dt: float, t: Trajectories) -> Verdict:
    """It slides in and stops: by the end slower than 5 % of sqrt(g D), never 5 % faster than a fall
    through D / 2, and not lower than where all three spheres are touched by more than 0.02 D (the
    enduring contact's 5e-4 D is drawn out 2.6 times by the widest opening, and a wedge doubles the
    load). Three supports hold it from all sides, so that it stays however long it is watched."""
    speed = np.linalg.norm(t.velocity[:, 0], axis=1)
    scale = math.sqrt(WEDGED_GRAVITY)
    sunk = abs(float(t.position[-1, 0, 1]) - resting_height(opening))
    return worst(
        Check("speed at the end over sqrt(g D)", float(speed[-1]) / scale, 0.05, 0.5),
        Check("largest speed over sqrt(g D)", float(np.max(speed)) / scale, 1.05, 1.5),
        Check("distance from the wedge", sunk, 0.02, 0.5),
    )


def stays_pinned(density: float, dt: float, t: Trajectories) -> Verdict:
    """A grain between the wall and a sphere that falls on it: no overlap beyond a collision's at twice
    the mover's speed (the grain is hit and thrown on the wall), nothing faster than that, and the energy
    never above what came and what the two have fallen since, (rho_p - 1) g V y."""
    densities = np.array([GRAIN_DENSITY, density])
    energy = t.kinetic_energy(densities)
    fallen = np.sum((densities - 1.0) * t.radius**3 * (t.position[0, :, 1] - t.position[..., 1]), axis=1)
    came = energy[0] + PINNED_GRAVITY * fallen
    return worst(
        overlap(t, 2.0, dt),
        Check("largest speed", t.fastest(), 2.0, 10.0),
        Check("kinetic energy over what came", float(np.max((energy / came)[1:])), 1.0, 1.5),
        Check("mover's speed after the first step",
              float(-t.velocity[1, 1, 1]) / share_kept(density), 1.05),
    )  # fmt: skip


def energy_falls(inward: float, dt: float, t: Trajectories) -> Verdict:
    """The grains' kinetic energy never exceeds what they came with (1 % for the fluid's work while
    the shell closes), and at the end it is below what the fluid's added mass leaves at once; nothing is
    entered deeper than a collision explains."""
    energy = t.kinetic_energy()
    return worst(
        Check("growth of the kinetic energy", float(np.max(energy) / energy[0]) - 1.0, 0.01, 0.5),
        Check("energy left", float(energy[-1] / energy[0]), share_kept(GRAIN_DENSITY) ** 2),
        overlap(t, inward, dt),
    )


def crowd_calms(density: float, dt: float, t: Trajectories) -> Verdict:
    """The grains' kinetic energy never exceeds what they came with, and at the end it is below what the fluid's added
    mass leaves at once; nothing is entered deeper than a collision explains."""
    energy = t.kinetic_energy()
    return worst(
        Check("growth of the kinetic energy", float(np.max(energy) / energy[0]) - 1.0, 0.01, 0.5),
        Check("energy left", float(energy[-1] / energy[0]), share_kept(density) ** 2),
        overlap(t, CROWD_SPEED, dt),
    )


def parts_gently(start: float, dt: float, t: Trajectories) -> Verdict:
    """The two part no faster than the case's speed U = 1, ten times what they came with; the overlap is
    deepened by no more than a collision at their speed explains. At St = 1.4 nothing rebounds (measured
    rebounds begin at 10): what they came deeper is squeezed out again through the film of the contact, but
    for 2e-3 D at the end, twice what a contact that lasts has."""
    deep = t.overlaps()
    return worst(
        Check("largest speed", t.fastest(), 1.0, 5.0),
        Check("overlap added", float(np.max(deep)) - start, collision_depth(OVERLAPPING_SPEED, dt), start + 0.1),
        Check("added overlap left", float(deep[-1]) - start, 2e-3),
    )


def stays_slow(ratio: float, dt: float, t: Trajectories) -> Verdict:
    """Nothing is shot out: no grain faster than what fell on it (twice its speed, the most that an
    elastic impact of a heavy on a light sphere gives, and the speed of falling sqrt(2 g D)). Nothing is
    entered deeper than a collision at the fall's speed explains. The fluid takes its share of the
    large sphere's speed at once (5 %: gravity in that step)."""
    big = int(np.argmax(t.radius[0]))
    taken = float(-t.velocity[1, big, 1]) / share_kept(GRAIN_DENSITY)
    return worst(
        Check("largest speed", t.fastest(), 2.0 + math.sqrt(2.0), 10.0),
        Check("speed after the first step", taken, 1.05),
        overlap(t, 1.0, dt),
    )


def all_there(flow: str, dt: float, t: Trajectories) -> Verdict:
    """All grains remain, and none is faster than a free fall through half the box's height or the
    stream. No overlap deeper than of two that meet at the largest speed. In still fluid none falls
    faster than buoyancy and added mass let it, (rho_p - 1)/(rho_p + 1/2) g t (a tenth more for a grain
    that sinks in its neighbours' wake). A stream takes them along, at once by at least half of what the
    added mass gives a single sphere, 3/2 /(rho_p + 1/2), and not beyond its own mean."""
    end = float(t.time[-1] - t.time[0])
    fastest = t.fastest()
    checks = [
        Check("grains lost", float(abs(t.position.shape[1] - DROPPED)), 0.5, 0.5),
        Check("largest speed", fastest, 1.0 + math.sqrt(2 * 0.3 * 6.0), 20.0),
        overlap(t, 2.0 * fastest, dt),
    ]
    if flow == "still":
        fall = (GRAIN_DENSITY - 1.0) / (GRAIN_DENSITY + 0.5) * DROPPED_GRAVITY * end
        checks.append(Check("speed of the fall", float(np.max(-t.velocity[..., 1])), 1.1 * fall))
    else:
        along = float(np.mean(t.velocity[-1, :, 0]))
        checks.append(Check("mean speed along the stream",
                            outside(along, 0.75 / (GRAIN_DENSITY + 0.5), 1.0), 1.0))  # fmt: skip
    return worst(*checks)


def keeps_pair(_: int, dt: float, t: Trajectories) -> Verdict:
    """Two touching spheres on their way through the corner stay two slow spheres that never overlap by
    more than 0.02 D, and go by one period, not more: what they travel by their velocities is the change
    of their places to 1 % of D. The fluid takes its share of their speed, and they do go through."""
    start = np.linalg.norm(t.velocity[0], axis=1)
    end = np.linalg.norm(t.velocity[-1], axis=1)
    moved = t.position[-1] - t.position[0]
    lost = np.abs(t.nearest_image(moved - t.travel()))
    reached = (t.position[0, 0] + t.travel()[0])[[0, 2]]
    return worst(
        Check("overlap", t.deepest_overlap(), 0.02, 0.5),
        Check("speed over the start's", t.fastest() / 1.6 - 1.0, 0.02, 0.5),
        Check("place off the way travelled", float(np.max(lost)), 0.01, 0.5),
        Check("speed left", float(np.max(end / start)), share_kept(GRAIN_DENSITY)),
        Check("corner over the place reached", CORNER / float(np.min(reached)), 1.0),
    )


def carried(t: Trajectories, dt: float, stream: float, change: float) -> Verdict:
    """The grain is not faster than three times the stream, stays above the bed (the lowest place on
    four spheres is 1.207 D high), touches nothing deeper than its speed explains, and goes with the
    change of the stream by at least a tenth of it: one that nothing pushes stays where it is."""
    way = float(t.travel()[0, 0]) * math.copysign(1.0, change)
    wanted = 0.1 * abs(change) * float(t.time[-1] - t.time[0])
    return worst(
        Check("speed", t.fastest(), 3.0 * stream, 6.0 * stream),
        Check("1.15 D over the lowest height", 1.15 / float(np.min(t.position[:, 0, 1])), 1.0, 2.0),
        Check("a tenth of the stream's way over the grain's", wanted / way if way > 0.0 else math.inf, 1.0),
        overlap(t, t.fastest(), dt),
    )


def stays_in_stream(_: int, dt: float, t: Trajectories) -> Verdict:
    return carried(t, dt, 1.0, 1.0)


def follows_change(velocity: float, dt: float, t: Trajectories) -> Verdict:
    return carried(t, dt, max(1.0, abs(velocity)), velocity - 1.0)


def keeps_to_cfl(cfl: float, _: float, t: Trajectories) -> Verdict:
    return carried(t, cfl / 6, 1.0, 1.0)  # the length of a step at a speed of 1


stays_in_stream.__doc__ = keeps_to_cfl.__doc__ = follows_change.__doc__ = carried.__doc__


def stays_together(_, dt: float, t: Trajectories) -> Verdict:
    """Grains on the move: none faster than three times the stream, none entered deeper than that
    explains, and the stream takes them along on the mean."""
    along = float(np.mean(t.velocity[-1, :, 0]))
    return worst(
        Check("speed", t.fastest(), 3.0, 6.0),
        Check("a hundredth of the stream over the grains' mean", 0.01 / along if along > 0.0 else math.inf, 1.0),
        overlap(t, t.fastest(), dt),
    )


def slows_in_narrow_box(width: float, dt: float, t: Trajectories) -> Verdict:
    """Drag only takes, of a row of spheres as of one: the speed falls from step to step (bounds as in
    slows_down) to less than what the added mass leaves, in the direction of the kick: what the
    images do across it is no more than 2 % of it, by symmetry nothing."""
    speed = np.linalg.norm(t.velocity[:, 0], axis=1)
    across = float(np.max(np.abs(t.velocity[:, 0, 2])))
    return worst(
        Check("largest rise of the speed", largest_rise(speed), 0.01, 0.2),
        Check("speed left", float(t.velocity[-1, 0, 0]), share_kept(GRAIN_DENSITY)),
        Check("speed across", across, 0.02, 0.2),
    )


def moves_as_plug(layers: int, dt: float, t: Trajectories) -> Verdict:
    """The fluid can hardly pass, so it takes the grains along: at least at a tenth of its mean velocity
    of 0.5, at most at three times it, and none is pressed into another deeper than a collision at
    that speed explains."""
    along = float(np.mean(t.velocity[-1, :, 0]))
    return worst(
        Check("largest speed", t.fastest(), 1.5, 5.0),
        Check("a tenth of the stream over the grains' mean", 0.05 / along if along > 0.0 else math.inf, 1.0),
        overlap(t, max(0.5, t.fastest()), dt),
    )


def lands(gravity: float, dt: float, t: Trajectories) -> Verdict:
    """Never faster than a fall through D/2 in a vacuum, not deeper in the wall than that explains, and in
    the end at rest (5 % of sqrt(g D)): St is 44 at the impact, which rebounds and settles within the
    time of four falls."""
    scale = math.sqrt(gravity)
    return worst(
        Check("largest speed over sqrt(g D)", t.fastest() / scale, 1.0, 3.0),
        Check("speed at the end over sqrt(g D)", float(np.linalg.norm(t.velocity[-1, 0])) / scale, 0.05, 1.0),
        overlap(t, scale, dt / scale),
    )
