"""Hard cases of dry contact, at one DEM step per fluid step and at fifteen: nothing gains energy,
nothing blows up, and what has a known answer gets it."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, dump_now, kinetic_energy, read_dump
from test_energy import Start

D = 0.01
RHO = 2500.0
MU = 1e-3  # dynamic viscosity [Pa s], known by its property only: St_crit of enduring contact
VISCOUS = [f"fix m4 all property/global fluidViscosity scalar {MU}"]
ACTM = "model actm tangential haff_werner"
FLOOR = f"fix floor all wall/gran {ACTM} primitive type 1 yplane 0.0"
SUBSTEPS = [1, 15]


def above_floor(spheres, step, substeps, **others):
    """Spheres over the wall y = 0."""
    return Scene(spheres, fluid_step=step, substeps=substeps, contact=ACTM, lines=[FLOOR], **others)


def energy_series(folder, scene, pieces):
    """Kinetic energy at the start and after each piece of the run [J], and the states."""
    lines = []
    for n, steps in enumerate(pieces):
        lines += [f"run {steps}", *dump_now(f"at{n}.dump")]
    scene.run(folder, lines)
    states = [Start(scene.spheres)]
    states += [read_dump(folder / f"at{n}.dump") for n in range(len(pieces))]
    return np.array([kinetic_energy(scene.spheres, s) for s in states]), states


def rebound(damping, speed, until=20.0, h=2e-3):
    """Speed with which x'' = -x^{3/2} - 2λ x', begun at x = 0 with `speed`, comes back to x = 0, and the time
    that takes; or the speed back at the time `until`. It is a contact of actm in the lengths and times of
    its calibration (Runge and Kutta's two stages)."""
    def force(x, v):
        return -max(x, 0.0) ** 1.5 - 2 * damping * v

    x, v, time = 0.0, speed, 0.0
    while time < until:
        middle = v + 0.5 * h * force(x, v)
        after = v + h * force(x + 0.5 * h * v, middle)
        if x + h * middle < 0:
            share = x / (-h * middle)
            return -(v + (after - v) * share), time + share * h
        x, v, time = x + h * middle, after, time + h
    return -v, time


def damping_and_duration(restitution):
    """λ at which an impact with the speed of the calibration comes back with e of it, by bisection, and how
    long that takes."""
    low, high = 0.0, 2.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rebound(middle, 1.0)[0] > restitution else (low, middle)
    return low, rebound(low, 1.0)[1]


@pytest.mark.parametrize("substeps", SUBSTEPS)
@pytest.mark.parametrize("restitution", [0.3, 0.97])
def test_impacts_from_stokes_0_1_to_5000(tmp_path, substeps, restitution):
    """Eleven impact speeds on a wall, five positions of the first touch each. Above St_crit = 5 the
    rebound is e within what the table of doc/normal_actm.md says of that many steps (3.5 % and
    0.02 %). Below, contacts are calibrated for the speed at St_crit: they rebound as the integrated
    equation of such a contact does, slower than e (by 0.6 % of e = 0.97 at St = 2.6; twice or half of
    St_crit is 0.4 % off). A start of the damping one step late gives 3 % at fifteen steps."""
    step = 1e-5  # T_c = 1e-4 s: overlap below 1 % of D at St 5000
    stokes = np.geomspace(0.1, 5000, 11)
    speeds = stokes * 9 * MU / (RHO * D)
    damping, duration = damping_and_duration(restitution)
    spheres, wanted = [], []
    for n, u in enumerate(speeds):
        for p in range(5):
            gap = u * step / substeps * (1 + (p + 0.4) / 5)
            spheres.append(Sphere((0.015 * p, D / 2 + gap, 0.015 * n), (0, -u, 0), diameter=D))
            time = (60 - (1 + (p + 0.4) / 5) / substeps) / 10  # behind the first touch, in T_c
            r = min(stokes[n] / 5, 1)
            wanted.append(u / r * rebound(damping, r, time * duration)[0])
    box = ((-0.02, 0.1), (-0.01, 0.05), (-0.02, 0.2))
    scene = above_floor(spheres, step, substeps, box=box, restitution=restitution, properties=VISCOUS)
    end = scene.run(tmp_path, 60 * substeps)
    error = {1: 0.035, 15: 2e-4}[substeps] * restitution
    assert (end.v[:, 1] - wanted) / np.repeat(speeds, 5) == pytest.approx(0, abs=error)


def around(reach):
    """Centres of the twelve neighbours of a sphere in the densest packing."""
    a = reach / np.sqrt(2)
    return [
        a * np.array(c, float)
        for c in [
            (s, t, 0) for s in (1, -1) for t in (1, -1)
        ] + [(s, 0, t) for s in (1, -1) for t in (1, -1)] + [(0, s, t) for s in (1, -1) for t in (1, -1)]
    ]


@pytest.mark.parametrize("substeps", SUBSTEPS)
@pytest.mark.parametrize("restitution", [0.3, 0.97])
def test_twelve_contacts_at_once(tmp_path, substeps, restitution):
    """Twelve spheres that close in on one, which spins fast, within a step of each other: 36 contacts
    in all. Energy falls from piece to piece, momentum stays zero, all are apart again in the end."""
    u, step = 0.1, 1e-4
    rng = np.random.default_rng(4)
    spheres = [Sphere((0, 0, 0), spin=(300.0, -200.0, 100.0), diameter=D)]
    for c in around(D):
        n = c / np.linalg.norm(c)
        place = c * (1 + (0.1 + 0.9 * rng.random()) * u * step / D)
        spheres.append(Sphere(tuple(place), tuple(-u * n), diameter=D))
    scene = Scene(spheres, restitution=restitution, fluid_step=step, substeps=substeps, contact=ACTM)
    energy, states = energy_series(tmp_path, scene, [4 * substeps] * 10 + [200 * substeps])
    assert np.all(np.diff(energy) <= 2e-3 * energy[0])  # elastic energy comes back as kinetic energy
    assert np.max(energy[1:]) < energy[0] * (1 + 1e-3)
    momentum = np.sum(states[-1].v, 0)
    assert np.max(np.abs(momentum)) < 1e-12 * u
    apart = np.linalg.norm(states[-1].x[1:] - states[-1].x[0], axis=1)
    assert np.all(apart > D)
    # The fast spin was passed on to the twelve.
    assert np.linalg.norm(states[-1].spin[0]) < 0.95 * np.linalg.norm(spheres[0].spin)


@pytest.mark.parametrize("substeps", SUBSTEPS)
def test_wedged_between_wall_and_mover(tmp_path, substeps):
    """A driven sphere presses a grain against a wall until they overlap by 4 % of D together, and
    goes away again. The grain shares the overlap evenly, never moves faster than 1.5 times the mover
    while it is pressed, and leaves at less than e times the speed it was hit with."""
    v, step, e = 0.02, 1e-4, 0.8
    grain = Sphere((0.0, D / 2 + 1e-6, 0.0), diameter=D)
    mover = Sphere((0.0, 1.5 * D + 2e-6, 0.0), (0, -v, 0), diameter=D)
    squeeze = round(0.04 * D / v / step) * substeps
    scene = Scene(
        [grain, mover],
        box=((-0.02, 0.02), (-0.01, 0.05), (-0.02, 0.02)),
        restitution=e,
        fluid_step=step,
        substeps=substeps,
        contact=ACTM,
        lines=[
            "group mover id 2",
            "group free id 1",
            f"fix floor all wall/gran {ACTM} primitive type 1 yplane 0.0",
            f"fix drive mover move linear 0.0 {-v} 0.0 units box",
        ],
        integrate="fix integrate free nve/sphere",
    )
    lines = []
    for n in range(10):
        lines += [f"run {squeeze // 10}", *dump_now(f"in{n}.dump")]
    lines += ["unfix drive", f"fix drive mover move linear 0.0 {v} 0.0 units box"]
    lines += [f"run {3 * squeeze}"]
    end = scene.run(tmp_path, lines)
    pressed = [read_dump(tmp_path / f"in{n}.dump") for n in range(10)]
    assert max(abs(s.v[0, 1]) for s in pressed) < 1.5 * v
    last = pressed[-1]
    overlaps = D / 2 - last.x[0, 1], D - (last.x[1, 1] - last.x[0, 1])
    assert sum(overlaps) == pytest.approx(0.04 * D, rel=0.02)
    assert overlaps[0] == pytest.approx(overlaps[1], rel=0.25)
    assert abs(end.v[0, 1]) < (1 + e) * v


def heavy_on_light(folder, hardening, ratio):
    """A sphere of `ratio` times the mass falls on a grain on a wall. Largest overlap over that of an impact at
    its speed, 0.34 u T_c, and the kinetic energy over that which came, after each half of a fluid step."""
    u, step = 0.1, 2e-4
    settings = f"hardening {hardening}"
    mover = Sphere((0.02 * D, 1.5 * D + 3e-6, 0.01 * D), (0, -u, 0), diameter=D, density=RHO * ratio)
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-6, 0.0), diameter=D), mover],
        box=((-0.02, 0.02), (-0.01, 0.05), (-0.02, 0.02)),
        restitution=0.97,
        fluid_step=step,
        contact=ACTM,
        settings=settings,
        properties=VISCOUS,
        lines=[f"{FLOOR} {settings}"],
    )
    energy, states = energy_series(folder, scene, [8] * 120)
    deepest = max(max(D / 2 - s.x[0, 1], D - np.linalg.norm(s.x[1] - s.x[0])) for s in states)
    return deepest / (0.34 * u * 10 * step), energy / energy[0]


@pytest.mark.parametrize("ratio", [20, 64])
def test_a_heavy_mass_leans_on_a_light_grain(tmp_path, ratio):
    """Both contacts of the grain know its own mass alone: without hardening it is entered 3.0 and 4.6 times as
    deep as an impact (ratio^{2/5} is 3.3 and 5.3), with it 1.4 and 1.5 times. The energy never grows,
    and the mover comes back with nearly all of it."""
    soft, _ = heavy_on_light(tmp_path / "off", "off", ratio)
    hard, energy = heavy_on_light(tmp_path / "on", "on", ratio)
    assert soft > 0.8 * ratio**0.4
    assert 1.1 < hard < 1.8
    assert np.max(energy) < 1 + 1e-3
    assert energy[-1] > 0.85


def test_a_step_that_grows_finds_the_second_spring_softer(tmp_path):
    """A heavy sphere is deep in a light grain when the step becomes eight times as long, as `time.cfl` may let it: the
    spring of the short step has ω Δt = 2.4 in the long one, beyond what leapfrog bears. No energy is made."""
    u, ratio, steps = 0.1, 64, 120
    mover = Sphere((0.0, 1.5 * D + 3e-6, 0.0), (0, -u, 0), diameter=D, density=RHO * ratio)
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-6, 0.0), diameter=D), mover],
        box=((-0.02, 0.02), (-0.01, 0.05), (-0.02, 0.02)),
        restitution=0.97,
        fluid_step=2e-4,
        substeps=steps,
        contact=ACTM,
        properties=VISCOUS,
        lines=[FLOOR],
    )
    lines = ["run 560", *dump_now("0.dump"), f"timestep {8 * scene.dt!r}"]
    for n in range(1, 60):
        lines += ["run 8", *dump_now(f"{n}.dump")]
    scene.run(tmp_path, lines)
    states = [read_dump(tmp_path / f"{n}.dump") for n in range(60)]
    overlap = D - np.linalg.norm(states[0].x[1] - states[0].x[0])
    assert overlap > 1.12 * 0.34 * u * 10 * scene.fluid_step, "not in the second spring yet"
    energy = np.array([kinetic_energy(scene.spheres, state) for state in states])
    assert np.max(energy) < (1 + 1e-3) * 0.5 * mover.mass * u**2


def test_hardening_leaves_impacts_alone(tmp_path):
    """The rebounds of test_impacts_..., with and without, bit for bit."""
    ends = []
    for hardening in ("off", "on"):
        settings = f"hardening {hardening}"
        spheres = [Sphere((0.015 * n, D / 2 + 1e-6, 0), (0, -0.02 * 4**n, 0), diameter=D) for n in range(4)]
        scene = above_floor(spheres, 1e-5, 15, box=((-0.02, 0.1), (-0.01, 0.05), (-0.02, 0.2)), restitution=0.9,
                            settings=settings)  # fmt: skip
        scene.lines = [f"{FLOOR} {settings}"]
        ends.append(scene.run(tmp_path / hardening, 60 * 15))
    assert np.all(ends[0].v[:, 1] > 0)
    assert np.array_equal(ends[0].v, ends[1].v)


@pytest.mark.parametrize("substeps", SUBSTEPS)
@pytest.mark.parametrize("tangential", ["haff_werner", "history"])
def test_shot_into_a_wedge(tmp_path, substeps, tangential):
    """A grain shot between two held spheres that stand closer than it is wide, spinning and aslant:
    it comes out again or stays, with less energy than before."""
    contact = f"model actm tangential {tangential}"
    rng = np.random.default_rng(9)
    spheres, grains = [], []
    for n in range(30):
        at = np.array([0.05 * n, 0.0, 0.0])
        for side in (-1, 1):
            spheres.append(Sphere(tuple(at + (side * 0.95 * D, 0, 0)), diameter=D, type=1))
        angle = rng.uniform(-0.3, 0.3)
        u = 10 ** rng.uniform(-0.7, 0.3)
        place = at + (5e-4 * rng.uniform(-1, 1), 0.0055, 0.0)
        velocity = (u * np.sin(angle), -u * np.cos(angle), 0.01 * u)
        spheres.append(Sphere(tuple(place), velocity, tuple(u / D * rng.normal(size=3)), diameter=D))
        grains.append(len(spheres) - 1)
    held = " ".join(str(n + 1) for n in range(len(spheres)) if n not in grains)
    scene = Scene(
        spheres,
        box=((-0.03, 1.5), (-0.1, 0.1), (-0.05, 0.05)),
        restitution=0.9,
        friction=0.3,
        fluid_step=1e-4,
        substeps=substeps,
        contact=contact,
        lines=[f"group bed id {held}", "group free subtract all bed", "fix hold bed freeze"],
        integrate="fix integrate free nve/sphere",
    )
    lines = []
    for n in range(8):
        lines += [f"run {20 * substeps}", *dump_now(f"at{n}.dump")]
    scene.run(tmp_path, lines)
    mass, inertia = spheres[grains[0]].mass, spheres[grains[0]].inertia

    def each(state):
        v, w = state.v[grains], state.spin[grains]
        return 0.5 * mass * np.sum(v**2, 1) + 0.5 * inertia * np.sum(w**2, 1)

    before = each(Start(spheres))
    after = [each(read_dump(tmp_path / f"at{n}.dump")) for n in range(8)]
    assert np.max(after / before) < 1 + {1: 0.01, 15: 1e-3}[substeps]
    assert np.median(after[-1] / before) < 0.95


@pytest.mark.parametrize("substeps", SUBSTEPS)
def test_fast_spin(tmp_path, substeps):
    """A sphere that falls on a wall with a surface speed of 300 times its own: the normal rebound is
    that of a sphere without spin, friction gives μ (1 + e) u of sideways speed and no more, and the
    spin falls by that impulse times R."""
    u, e, mu, step = 0.05, 0.9, 0.2, 2e-5
    spin = 300 * u / (D / 2)
    sphere = Sphere((0, D / 2 + 1.3 * u * step / substeps, 0), (0, -u, 0), (0, 0, spin), diameter=D)
    scene = above_floor([sphere], step, substeps, restitution=e, friction=mu)
    end = scene.run(tmp_path, 20 * substeps)
    close = {1: 0.01, 15: 5e-4}[substeps]
    assert end.v[0, 1] == pytest.approx(e * u, rel=close)
    assert -end.v[0, 0] == pytest.approx(mu * (1 + e) * u, rel=0.02)
    impulse = sphere.mass * abs(end.v[0, 0])
    assert spin - end.spin[0, 2] == pytest.approx(impulse * D / 2 / sphere.inertia, rel=1e-2)


@pytest.mark.parametrize("substeps", SUBSTEPS)
def test_size_ratio_four_dropped_together(tmp_path, substeps):
    """Sixty spheres of diameters D/4 to D dropped as one into a pit of walls, the small below the
    large (64 times their mass): kinetic plus potential energy never grows, none is shot out or lost,
    and most of the energy is gone in the end."""
    rng = np.random.default_rng(12)
    spheres = []
    for n in range(60):
        i, j, k = n % 3, n // 9, n // 3 % 3
        d = D / 4 if j < 3 else D
        place = D * (np.array([i + 0.7, j + 0.6, k + 0.7]) + rng.uniform(-0.05, 0.05, 3))
        spheres.append(Sphere(tuple(place), (0, -0.05, 0), diameter=d))
    side = 3.4 * D
    walls = [("x", 0.0), ("x", side), ("y", 0.0), ("z", 0.0), ("z", side)]
    scene = Scene(
        spheres,
        box=((-0.01, side + 0.01), (-0.01, 0.2), (-0.01, side + 0.01)),
        restitution=0.8,
        fluid_step=1e-4,
        substeps=substeps,
        contact=ACTM,
        lines=[
            *(
                f"fix wall{n} all wall/gran {ACTM} primitive type 1 {a}plane {p}"
                for n, (a, p) in enumerate(walls)
            ),
            "fix weight all gravity 9.81 vector 0 -1 0",
        ],
    )
    energy, states = energy_series(tmp_path, scene, [500 * substeps] * 8)
    mass = np.array([s.mass for s in spheres])
    total = energy + [9.81 * np.sum(mass * s.x[:, 1]) for s in states]
    assert np.all(np.diff(total) < 1e-3 * total[0])
    assert len(states[-1].x) == 60
    assert np.max(states[-1].x[:, 1]) < 0.09
    assert energy[-1] < 0.05 * np.max(energy)


@pytest.mark.parametrize("substeps", SUBSTEPS)
def test_overlapping_start(tmp_path, substeps):
    """Spheres put into overlap, by 1 to 50 % of D. At rest they stay so, for no energy is in them;
    closing, they leave with no more than e times the speed; opening, they keep their speed."""
    u, e = 0.05, 0.9
    depths = [0.01, 0.1, 0.3, 0.5]
    spheres = []
    for n, depth in enumerate(depths):
        for k, closing in enumerate((0.0, u, -u)):
            at = (0.0, 0.03 * n, 0.03 * k)
            spheres.append(Sphere(at, (closing, 0, 0), diameter=D))
            spheres.append(Sphere((D * (1 - depth), *at[1:]), diameter=D))
    scene = Scene(
        spheres,
        box=((-0.05, 0.05), (-0.02, 0.15), (-0.02, 0.1)),
        restitution=e,
        fluid_step=1e-4,
        substeps=substeps,
        contact=ACTM,
    )
    end = scene.run(tmp_path, 40 * substeps)
    opening = (end.v[1::2, 0] - end.v[::2, 0]).reshape(4, 3)
    assert np.all(opening[:, 0] == 0)
    assert opening[:, 1] == pytest.approx(e * u, rel={1: 0.04, 15: 2e-3}[substeps])
    assert opening[:, 2] == pytest.approx(u, rel=1e-12)


@pytest.mark.parametrize("substeps", SUBSTEPS)
def test_slow_impacts_of_unequal_masses(tmp_path, substeps):
    """A small sphere that a large one hits at less than g T_c/2, both in free fall, at eight phases of the step: such
    a contact is as stiff as the large one's weight asks for, and it is the small one that it moves. e = 0.9 comes back
    (0.85 at the slowest, where the contact is at its softest); where the step was measured against the large mass
    alone, 0.75 to 23 at size ratio ten."""
    step, e = 1e-3, 0.9
    spheres, speeds = [], []
    for n, (ratio, u) in enumerate([(r, u) for r in (4, 10) for u in (0.04, 0.005)]):
        small = D / ratio
        for k in range(8):
            gap = u * step / substeps * (k / 8 + 0.3)
            x, z = 0.02 * k, 0.02 * n
            spheres += [Sphere((x, 0.3, z), diameter=D),
                        Sphere((x, 0.3 + (D + small) / 2 + gap, z), (0, -u, 0), diameter=small)]  # fmt: skip
            speeds.append(u)
    falling = [f"fix g all gravity {9.81} vector 0 -1 0"]
    scene = Scene(spheres, restitution=e, fluid_step=step, substeps=substeps, contact=ACTM, lines=falling,
                  box=((-0.05, 0.25), (-0.2, 0.4), (-0.05, 0.15)))  # fmt: skip
    state = energy_series(tmp_path, scene, [round(0.05 / step * substeps)])[1][-1]
    parting = (state.v[1::2, 1] - state.v[0::2, 1]) / np.array(speeds)
    assert parting == pytest.approx(e, abs=0.07)
