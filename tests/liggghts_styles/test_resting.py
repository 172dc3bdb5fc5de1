"""Enduring contact: grains come to rest, stay at rest, and sink in no deeper than weight asks for."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, dump_now, kinetic_energy, read_dump
from study_slope import drift

D = 0.01
G = 9.81
RESTING_OVERLAP = 1e-3  # of the radius, the default of the keyword restingOverlap
FALL = 0.05  # impact speed [m/s]


def ring(count, height):
    """Centres of `count` touching spheres in a ring around the y axis."""
    radius = D / 2 / np.sin(np.pi / count)
    angles = 2 * np.pi * np.arange(count) / count
    return radius, [(radius * np.cos(a), height, radius * np.sin(a)) for a in angles]


def pocket(count, restitution, contact, drift=(0.0, 0.0)):
    """One sphere dropped into the pocket of `count` fixed ones, with a little sideways speed."""
    radius, centres = ring(count, 0.0)
    top = np.sqrt(D**2 - radius**2)
    fixed = [Sphere(c, diameter=D) for c in centres]
    mobile = Sphere((0.0, top + 1e-5, 0.0), velocity=(drift[0], -FALL, drift[1]), diameter=D)
    return Scene(
        [*fixed, mobile],
        box=((-0.05, 0.05), (-0.05, 0.05), (-0.05, 0.05)),
        restitution=restitution,
        contact=contact,
        lines=[
            f"group bed id 1:{count}",
            "group mobile subtract all bed",
            "fix hold bed freeze",
            f"fix weight all gravity {G} vector 0 -1 0",
        ],
        integrate="fix integrate mobile nve/sphere",
    )


@pytest.mark.parametrize("restitution", [0.3, 0.97])
@pytest.mark.parametrize("count", [3, 4])
@pytest.mark.parametrize("tangential", ["off", "haff_werner"])
def test_rest_in_a_pocket(tmp_path, count, restitution, tangential):
    """At rest after 2e5 steps (kinetic energy < 1e-10 of the impact's), and after 1e6 steps exactly
    there still. Overlap: each contact bears W / (count cos θ), and the stiffness lets the whole weight
    press in by restingOverlap; no contact bears more than W here."""
    scene = pocket(count, restitution, f"model actm tangential {tangential}", (0.011, 0.003))
    lines = ["run 200000", *dump_now("early.dump"), "run 800000"]
    end = scene.run(tmp_path, lines)
    early = read_dump(tmp_path / "early.dump")
    impact = 0.5 * scene.spheres[-1].mass * FALL**2
    mobile = scene.spheres[-1:]
    for state in (early, end):
        last = type(state)(*(a[-1:] for a in vars(state).values()))
        assert kinetic_energy(mobile, last) < 1e-10 * impact
    assert end.x[-1] == pytest.approx(early.x[-1], abs=1e-9 * D)
    overlaps = D - np.linalg.norm(end.x[:-1] - end.x[-1], axis=1)
    assert np.all(overlaps > 0)
    assert np.max(overlaps) < RESTING_OVERLAP * D / 2


@pytest.mark.parametrize("fluid", [0.0, 1000.0, 6000.0])
def test_resting_overlap_is_what_weight_asks_for(tmp_path, fluid):
    """On a flat wall one contact bears the whole weight: k δ^{3/2} = W with the k that lets the submerged
    weight W |1 - ρ_f/ρ_p| press in by restingOverlap, so without a fluid δ is that very number. Twice the
    stiffness would give 0.63 of it. (No fluid is here to carry the rest of W: δ is larger, or smaller.)"""
    submerged = abs(1 - fluid / Sphere((0, 0, 0)).density)
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-6, 0.0), velocity=(0, -1e-4, 0), diameter=D)],
        contact="model actm",
        restitution=0.5,
        properties=[f"fix m4 all property/global fluidDensity scalar {fluid}"] if fluid > 0 else [],
        lines=[
            f"fix weight all gravity {G} vector 0 -1 0",
            "fix floor all wall/gran model actm primitive type 1 yplane 0.0",
        ],
    )
    end = scene.run(tmp_path, 100000)
    expected = RESTING_OVERLAP * D / 2 * submerged ** (-2 / 3)
    assert D / 2 - end.x[0, 1] == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize(
    "lines",
    [
        ["fix a all gravity 4.0 vector 0 -1 0", f"fix b all gravity {G - 4} vector 0 -1 0"],
        ["group some type 1", "group none subtract all some", "fix a none gravity 500 vector 0 -1 0",
         f"fix b all gravity {G} vector 0 -1 0"],
    ],
    ids=["two for all", "one for others"],
)  # fmt: skip
def test_weight_is_what_all_fixes_gravity_come_to(tmp_path, lines):
    """Whatever their number, order and groups. The first one alone would give 1.8 times the overlap, or 0.07 of it."""
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-6, 0.0), velocity=(0, -1e-4, 0), diameter=D)],
        contact="model actm",
        restitution=0.5,
        lines=[*lines, "fix floor all wall/gran model actm primitive type 1 yplane 0.0"],
    )
    end = scene.run(tmp_path, 100000)
    assert D / 2 - end.x[0, 1] == pytest.approx(RESTING_OVERLAP * D / 2, rel=0.05)


@pytest.mark.parametrize("first", [0, 1])
def test_resting_overlap_of_unequal_spheres(tmp_path, first):
    """A sphere on top of a smaller, held, denser one: its own weight presses in by restingOverlap of the smaller
    radius. The larger one would give 2.5 times that, the weight of the held one 3.9 times."""
    small = 0.4 * D
    top = Sphere((0.0, (D + small) / 2 + 1e-6, 0.0), velocity=(0, -1e-4, 0), diameter=D)
    spheres = [top, Sphere((0.0, 0.0, 0.0), diameter=small, density=5000.0)]
    if first == 1:
        spheres.reverse()
    scene = Scene(
        spheres,
        contact="model actm",
        restitution=0.5,
        lines=[
            f"group held id {2 - first}",
            "group free subtract all held",
            "fix hold held freeze",
            f"fix weight all gravity {G} vector 0 -1 0",
            "fix upright free setforce 0.0 NULL 0.0",
        ],
        integrate="fix integrate free nve/sphere",
    )
    end = scene.run(tmp_path, 100000)
    assert (D + small) / 2 - end.x[first, 1] == pytest.approx(RESTING_OVERLAP * small / 2, rel=0.05)


def heap(restitution, tangential="history", layers=8, width=8, settings=""):
    """Grains (500, or as many as the layers hold) in a loose lattice above a floor, between walls.

    The collision time is short against the time in which a grain falls by its own size,
    g T_c²/D = 0.004, as in the channel scenes."""
    rng = np.random.default_rng(7)
    spheres = []
    for j in range(layers):
        for i in range(width):
            for k in range(width):
                if len(spheres) == 500:
                    break
                place = 1.04 * D * np.array([i + 0.6, j + 0.6, k + 0.6])
                spheres.append(
                    Sphere(place + rng.uniform(-0.015, 0.015, 3) * D, (0, -FALL, 0), diameter=D)
                )
    side = width * 1.04 * D + 0.2 * D
    contact = f"model actm tangential {tangential}"
    walls = [
        f"fix wall{n} all wall/gran {contact} primitive type 1 {axis}plane {place!r} {settings}"
        for n, (axis, place) in enumerate(
            [("x", 0.0), ("x", side), ("y", 0.0), ("z", 0.0), ("z", side)]
        )
    ]
    return Scene(
        spheres,
        box=((-0.01, side + 0.01), (-0.01, 0.15), (-0.01, side + 0.01)),
        restitution=restitution,
        friction=0.3,
        contact=contact,
        settings=settings,
        fluid_step=2e-4,
        lines=[*walls, f"fix weight all gravity {G} vector 0 -1 0"],
    )


@pytest.mark.parametrize("settings", ["", "stickAfter 20", "stickTime 4e-3"])
def test_stick_on_a_slope(tmp_path, settings):
    """Spheres that cannot roll (integrated without spin) on slopes of half and of twice the friction
    coefficient. Haff and Werner's law has no static part: on the gentle slope the sphere creeps at
    g sin θ m/d_t, d_t = 2/7 m/Δt_fluid. With stickAfter or stickTime it stands. On the steep one both slide with
    g (sin θ - μ cos θ): memory changes nothing where friction slides."""
    mu, step = 0.3, 2e-4
    stick = settings != ""
    contact = "model actm tangential haff_werner"
    slopes = [0.5 * mu, 2 * mu]
    end = []
    for n, slope in enumerate(slopes):
        scene = Scene(
            [Sphere((0.0, D / 2 - 1e-7, 0.0), (0, -1e-4, 0), diameter=D)],
            box=((-0.1, 0.5), (-0.02, 0.05), (-0.1, 0.1)),
            restitution=0.5,
            friction=mu,
            fluid_step=step,
            contact=contact,
            settings=settings,
            lines=[
                f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0 {settings}",
                f"fix weight all gravity {G} vector {slope!r} -1 0",
            ],
            integrate="fix integrate all nve",
        )
        lines = ["run 10000", *dump_now("early.dump"), "run 10000"]
        last = scene.run(tmp_path / str(n), lines)
        end.append((read_dump(tmp_path / str(n) / "early.dump"), last, 10000 * scene.dt))
    (early, last, _), (steep_early, steep, time) = end
    # The damping acts at the end of the step, before the weight's part of it: Δt_fluid + Δt.
    creep = G * np.sin(np.arctan(slopes[0])) * 3.5 * (step + scene.dt)
    if stick:
        assert np.abs(last.v[0, 0]) < 1e-6 * creep
        assert last.x[0, 0] - early.x[0, 0] < 1e-7 * D
    else:
        assert last.v[0, 0] == pytest.approx(creep, rel=0.01)
    angle = np.arctan(slopes[1])
    sliding = G * (np.sin(angle) - mu * np.cos(angle))
    assert (steep.v[0, 0] - steep_early.v[0, 0]) / time == pytest.approx(sliding, rel=1e-3)


@pytest.mark.parametrize("settings", ["stickAfter 20", "stickTime 4e-3"])
def test_static_friction_is_a_spring(tmp_path, settings):
    """A sphere that rests on a slope goes on by Δs = ΔF_t/k_t when the slope gets steeper, the normal load staying
    what it is: k_t = 2/7 F_n/δ, so Δs = 7/2 δ Δ(tan θ). It goes back when the slope does, and no creep is left.
    Bound: damping, taken at the middle of a step, lets the spring bear d Δt/(2m) = 0.4 % more than the weight."""
    contact = "model actm tangential haff_werner"
    slopes = [0.05, 0.15, 0.05]

    def weight(slope):  # with the normal component G on all of them
        return f"fix weight all gravity {G * np.hypot(1, slope)!r} vector {slope!r} -1 0"

    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-7, 0.0), (0, -1e-4, 0), diameter=D)],
        box=((-0.1, 0.5), (-0.02, 0.05), (-0.1, 0.1)),
        restitution=0.5,
        friction=0.3,
        fluid_step=2e-4,
        contact=contact,
        settings=settings,
        lines=[f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0 {settings}", weight(slopes[0])],
        integrate="fix integrate all nve",
    )
    lines = ["run 20000", *dump_now("0.dump")]
    for n, slope in enumerate(slopes[1:], 1):
        lines += ["unfix weight", weight(slope), "run 20000", *dump_now(f"{n}.dump")]
    scene.run(tmp_path, lines)
    states = [read_dump(tmp_path / f"{n}.dump") for n in range(len(slopes))]
    overlap = D / 2 - states[0].x[0, 1]
    expected = 3.5 * overlap * (slopes[1] - slopes[0])
    there, back = (states[n + 1].x[0, 0] - states[n].x[0, 0] for n in range(2))
    assert overlap > 1e-7 * D
    assert there == pytest.approx(expected, rel=0.01)
    assert back == pytest.approx(-there, rel=1e-6)


def overlaps(x):
    """Overlaps of all touching pairs [m]."""
    apart = np.linalg.norm(x[:, None] - x[None], axis=2)[np.triu_indices(len(x), 1)]
    return D - apart[apart < D]


# Friction with memory bears a load at rest, and a little rolling and twisting resistance stops grains
# that would roll or spin on without end: sliding friction alone brakes neither. Both are LIGGGHTS' own.
STATIC = dict(tangential="history rolling_friction epsd2", settings="torsionTorque on")
ROLLING = "fix m8 all property/global coefficientRollingFriction peratomtypepair 1 0.02"


def test_rest_in_a_heap(tmp_path):
    """A heap of 48 grains comes to rest: all energy, of spins too, below 1e-10 of the impact's after
    1e5 steps and 2e4 steps later, and no grain has moved by 1e-6 D in between. No grain sinks into
    another by more than on one contact the weight of all 48 would press. (500 grains over 1e6 steps:
    `python3 study_heap.py`.)"""
    scene = heap(0.5, layers=3, width=4, **STATIC)
    scene.properties.append(ROLLING)
    assert len(scene.spheres) == 48
    end = scene.run(tmp_path, ["run 100000", *dump_now("early.dump"), "run 20000"])
    early = read_dump(tmp_path / "early.dump")
    impact = 48 * 0.5 * scene.spheres[0].mass * FALL**2
    for state in (early, end):
        assert kinetic_energy(scene.spheres, state) < 1e-10 * impact
    assert np.max(np.abs(end.x - early.x)) < 1e-6 * D
    depth = overlaps(end.x)
    assert len(depth) > 60
    assert 0.3 * RESTING_OVERLAP * D / 2 < np.mean(depth)
    assert np.max(depth) < RESTING_OVERLAP * D / 2 * 48 ** (2 / 3)


@pytest.mark.parametrize(
    "model, angle, moves",
    [
        ("haff_werner", 11, (5e-3, 5e-2)),
        ("haff_werner stickAfter 20", 11, (-1e-4, 1e-4)),
        ("haff_werner stickAfter 20", 25, (0.5, 5)),
    ],
)
def test_a_slope_of_grains(tmp_path, model, angle, moves):
    """Loose layers on a rough slope: by the published law they creep far below the angle at which they give
    way (1.7e-2 sqrt(g D)); with static friction they stay there (what is left of settling is below 1e-4) and
    flow above it. Table in doc/tangential_haff_werner.md."""
    assert moves[0] < drift(tmp_path, model, 0.5, angle) < moves[1]
