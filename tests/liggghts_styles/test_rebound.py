"""Dry head-on collisions: rebound speed and duration, second order in the DEM step."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, read_table

RESTITUTION = [0.3, 0.5, 0.7, 0.9, 0.97, 0.99]
PHASES = 7  # sub-step positions at the first touch
SPEED = 0.1
STEP = 1e-3
DURATION = 10 * STEP
KINDS = ["pair", "size 1:4", "density 1:3", "frozen", "moving", "wall"]
MOVING = -0.03
CONTACT = "model actm tangential haff_werner"


def matrix():
    """Type i meets its own type, and the wall (the last type), with RESTITUTION[i]."""
    n = len(RESTITUTION) + 1
    e = np.full((n, n), 0.9)
    for i, value in enumerate(RESTITUTION):
        e[i, i] = e[i, -1] = e[-1, i] = value
    return e


def make_scene(substeps, wall="primitive"):
    """All kinds of partner x restitution x phase in one box, each collision on its own line in x.

    Returns the scene and per collision (kind, e, tag of the mover, of its partner, gap, radii)."""
    spheres, cases = [], []
    dt = STEP / substeps
    for k, kind in enumerate(KINDS):
        for t, e in enumerate(RESTITUTION):
            for p in range(PHASES):
                y, z = 0.03 * t + 0.015, 0.03 * (k * PHASES + p) + 0.015
                gap = SPEED * dt * (2 + (p + 0.37) / PHASES)
                mover = dict(velocity=(-SPEED, 0, 0), type=t + 1)
                if kind == "wall":
                    spheres.append(Sphere((0.005 + gap, y, z), **mover))
                    cases.append((kind, e, len(spheres), None, gap, 0.005))
                    continue
                big = dict(diameter=0.02) if kind == "size 1:4" else {}
                if kind == "size 1:4":
                    mover["diameter"] = 0.005
                if kind == "density 1:3":
                    big = dict(density=7500.0)
                drift = MOVING if kind == "moving" else 0.0
                still = Sphere((0.1, y, z), type=t + 1, velocity=(drift, 0, 0), **big)
                reach = (still.diameter + mover.get("diameter", 0.01)) / 2
                mover["velocity"] = (drift - SPEED, 0, 0)
                spheres += [still, Sphere((0.1 + reach + gap, y, z), **mover)]
                cases.append((kind, e, len(spheres), len(spheres) - 1, gap, reach))
    groups = {kind: [c[3] for c in cases if c[0] == kind] for kind in ("frozen", "moving")}
    n = len(RESTITUTION) + 1
    walls = {
        "primitive": [f"fix floor all wall/gran {CONTACT} primitive type {n} xplane 0.0"],
        "mesh": [
            f"fix cad all mesh/surface file floor.stl type {n}",
            f"fix floor all wall/gran {CONTACT} mesh n_meshes 1 meshes cad",
        ],
    }[wall]
    lines = [
        "group frozen id " + " ".join(map(str, groups["frozen"])),
        "group moving id " + " ".join(map(str, groups["moving"])),
        "fix hold frozen freeze",
        f"fix drive moving move linear {MOVING} 0.0 0.0 units box",
        "group free subtract all frozen moving",
        *walls,
        "fix table all collision/table file table.csv",
    ]
    box = ((-0.02, 0.3), (0.0, 0.03 * len(RESTITUTION)), (0.0, 0.03 * PHASES * len(KINDS)))
    scene = Scene(
        spheres,
        box=box,
        restitution=matrix(),
        fluid_step=STEP,
        substeps=substeps,
        lines=lines,
        contact=CONTACT,
        integrate="fix integrate free nve/sphere",
    )
    return scene, cases


def floor_stl(y, z):
    """The rectangle x = 0, 0..y, 0..z as two triangles."""
    corners = [[(0, 0), (y, 0), (y, z)], [(0, 0), (y, z), (0, z)]]
    facets = "".join(
        "facet normal 1 0 0\nouter loop\n"
        + "".join(f"vertex 0 {a!r} {b!r}\n" for a, b in triangle)
        + "endloop\nendfacet\n"
        for triangle in corners
    )
    return f"solid floor\n{facets}endsolid floor\n"


def measure(folder, substeps, wall="primitive"):
    """Errors of rebound speed and duration, from the straight paths before and after: per collision
    (kind, e, relative error of e, relative error of the duration)."""
    scene, cases = make_scene(substeps, wall)
    folder.mkdir(exist_ok=True)
    (folder / "floor.stl").write_text(floor_stl(scene.box[1][1], scene.box[2][1]))
    steps = 18 * substeps
    end = scene.run(folder, steps)
    result = []
    for kind, e, mover, partner, gap, reach in cases:
        x, v = end.x[mover - 1, 0], end.v[mover - 1, 0]
        if partner is None:
            apart, opening = x - reach, v
        else:
            apart = x - end.x[partner - 1, 0] - reach
            opening = v - end.v[partner - 1, 0]
        assert apart > 0, (kind, e)
        lasted = (steps * scene.dt - apart / opening) - gap / SPEED
        result.append((kind, e, opening / (e * SPEED) - 1, lasted / DURATION - 1))
    return result


@pytest.fixture(scope="module")
def at_fifteen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fifteen")
    return measure(folder, 15), read_table(folder / "table.csv")


@pytest.mark.parametrize("kind", KINDS)
def test_rebound_and_duration(at_fifteen, kind):
    """The issue's bounds: 0.2 % of e u_in and 0.5 % of T_c. Measured: 0.02 % and 0.02 %; a first-order
    treatment of damping or first touch gives 1.1 % at e = 0.3 and fails."""
    mine = [r for r in at_fifteen[0] if r[0] == kind]
    assert len(mine) == len(RESTITUTION) * PHASES
    assert max(abs(r[2]) for r in mine) < 2e-3
    assert max(abs(r[3]) for r in mine) < 5e-3


def test_second_order(tmp_path, at_fifteen):
    """Doubling the steps divides the largest error by four."""
    coarse = np.array([[abs(r[2]), abs(r[3])] for r in at_fifteen[0]]).max(0)
    fine = np.array([[abs(r[2]), abs(r[3])] for r in measure(tmp_path, 30)]).max(0)
    order = np.log2(coarse / fine)
    assert np.all(order > 1.6), order


def test_mesh_wall_as_primitive_wall(tmp_path, at_fifteen):
    """The same numbers on a mesh wall, to round-off of the surface search."""
    mesh = measure(tmp_path, 15, wall="mesh")
    for (kind, e, *a), (_, _, *b) in zip(mesh, at_fifteen[0]):
        if kind == "wall":
            assert a == pytest.approx(b, abs=1e-9), e


def test_table_has_every_collision(at_fifteen):
    """One row per collision, with impact and rebound speed, duration and momentum as they were."""
    results, table = at_fifteen
    assert len(table["tag_i"]) == len(results)
    assert np.count_nonzero(table["tag_j"] == -1) == len(RESTITUTION) * PHASES
    assert table["impact_speed_normal"] == pytest.approx(SPEED, rel=1e-9)
    lasted = table["time_end"] - table["time_start"]
    assert lasted == pytest.approx(DURATION, rel=5e-3)
    mass = Sphere((0, 0, 0)).mass
    walls = table["tag_j"] == -1
    change = mass * (table["impact_speed_normal"] + table["rebound_speed_normal"])[walls]
    assert table["impulse_normal"][walls] == pytest.approx(change, rel=1e-9)
    assert np.max(table["impulse_tangential"]) < 1e-12 * np.max(table["impulse_normal"])


def test_table_has_the_place_of_every_collision(at_fifteen):
    """Where the surfaces met: on the wall x = 0, or at the partner's surface, which is 0.1 plus its radius
    and where it has moved to; across it to the last digit, along it within the way of a step."""
    table = at_fifteen[1]
    scene, cases = make_scene(15)
    row = {(i, j): n for n, (i, j) in enumerate(zip(table["tag_i"], table["tag_j"], strict=True))}
    for kind, e, mover, partner, *_ in cases:
        n = row[(mover, -1) if partner is None else (partner, mover)]
        met = 0.0
        if partner is not None:
            other = scene.spheres[partner - 1]
            met = 0.1 + other.diameter / 2 + other.velocity[0] * table["time_start"][n]
        assert table["x"][n] == pytest.approx(met, abs=SPEED * scene.dt), (kind, e)
        across = scene.spheres[mover - 1].position[1:]
        assert (table["y"][n], table["z"][n]) == pytest.approx(across, abs=1e-12), (kind, e)
