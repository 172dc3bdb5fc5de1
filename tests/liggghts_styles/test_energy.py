"""What a contact may not make: energy, momentum, angular momentum."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, dump_now, read_dump, read_table

D = 0.01
SPEED = 0.1


def cluster(rng, count, kind):
    """`count` spheres of various sizes grown from the first: each overlaps one neighbour by up to
    3 %, others perhaps more; random velocities and spins, on the whole inwards."""
    size = rng.uniform(0.5, 1.0, count) * D
    place = [np.zeros(3)]
    while len(place) < count:
        n = len(place)
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        at = rng.integers(n)
        new = place[at] + direction * rng.uniform(0.97, 1.0) * (size[at] + size[n]) / 2
        if all(np.linalg.norm(new - p) > 0.9 * (size[n] + d) / 2 for p, d in zip(place, size)):
            place.append(new)
    place = np.array(place)
    velocity = SPEED * rng.normal(size=(count, 3)) - 20 * SPEED * (place - place.mean(0))
    spin = SPEED / D * rng.normal(size=(count, 3))
    return place - place.mean(0), velocity, spin, size, kind


def clusters(number, seed, restitution):
    """`number` clusters of 2 to 12 spheres, far apart from each other in one box."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(number ** (1 / 3)))
    spheres, owner = [], []
    for n in range(number):
        kind = int(rng.integers(len(restitution)))
        where = 0.15 * (np.array(np.unravel_index(n, (side,) * 3)) + 0.5)
        for x, v, w, d, k in zip(*cluster(rng, int(rng.integers(2, 13)), kind)[:4], [kind] * 12):
            spheres.append(Sphere(tuple(where + x), tuple(v), tuple(w), float(d), 2500.0, k + 1))
            owner.append(n)
    box = ((0.0, 0.15 * side),) * 3
    return spheres, np.array(owner), box


def energies(spheres, owner, state):
    """Kinetic energy per cluster [J]."""
    m = np.array([s.mass for s in spheres])
    inertia = np.array([s.inertia for s in spheres])
    each = 0.5 * m * np.sum(state.v**2, 1) + 0.5 * inertia * np.sum(state.spin**2, 1)
    return np.bincount(owner, each)


@pytest.mark.parametrize("tangential", ["haff_werner", "off"])
def test_energy_never_grows(tmp_path, tangential):
    """1200 clusters: at no time more kinetic energy than at the start. The allowance is that of the
    integrator at e = 1, where nothing is lost (measured: 3e-6)."""
    restitution = [0.3, 0.9, 1.0]
    matrix = np.full((3, 3), 0.5)
    np.fill_diagonal(matrix, restitution)
    spheres, owner, box = clusters(1200, 11, restitution)
    lines = []
    for n in range(5):
        lines += ["run 60" if n < 3 else "run 400", *dump_now(f"at{n}.dump")]
    scene = Scene(
        spheres,
        box=box,
        restitution=matrix,
        friction=0.4,
        contact=f"model actm tangential {tangential}",
    )
    scene.run(tmp_path, lines)
    start = energies(spheres, owner, Start(spheres))
    kinds = np.array([s.type for s in spheres])[np.unique(owner, return_index=True)[1]]
    for n in range(5):
        now = energies(spheres, owner, read_dump(tmp_path / f"at{n}.dump"))
        assert np.max(now / start) < 1 + 1e-4
        assert np.max((now / start)[kinds == 1]) < 1 + 1e-12
    # The models did act: clusters with e = 0.3 lost a good part.
    assert np.median((now / start)[kinds == 1]) < 0.9


class Start:
    """The initial state in the form of a dump."""

    def __init__(self, spheres):
        self.x = np.array([s.position for s in spheres])
        self.v = np.array([s.velocity for s in spheres])
        self.spin = np.array([s.spin for s in spheres])


def angular_momentum(spheres, state):
    """About the origin [kg m²/s]."""
    m = np.array([s.mass for s in spheres])[:, None]
    inertia = np.array([s.inertia for s in spheres])[:, None]
    return np.sum(m * np.cross(state.x, state.v) + inertia * state.spin, 0)


@pytest.mark.parametrize(
    "contact", ["model actm tangential haff_werner", "model rpm tangential haff_werner"]
)
def test_momentum_of_an_oblique_pair(tmp_path, contact):
    """Momentum and angular momentum about any point of an isolated pair of unequal spheres stay to
    round-off, through a collision that turns both spins. Wrong arms or a torque of opposite sense
    on the partner would change it by 10 %."""
    a = Sphere((-0.00755, 0.002, 0.0), (0.1, 0.0, 0.02), (3.0, 20.0, -10.0), 0.01)
    b = Sphere((0.0, 0.0, 0.001), (0.0, 0.05, 0.0), (0.0, -5.0, 2.0), 0.004, 7500.0)
    rpm = "rpm" in contact
    scene = Scene(
        [a, b],
        contact=contact,
        settings="range 5e-4 strength 40" if rpm else "",
    )
    if rpm:
        # Gravity sets the scale of the force; it acts on neither of the two here.
        scene.lines = ["group none type 1", "group weightless subtract none all"]
        scene.lines += ["fix weight weightless gravity 9.81 vector 0 -1 0"]
    end = scene.run(tmp_path, 600)
    start = Start(scene.spheres)
    m = np.array([s.mass for s in scene.spheres])[:, None]
    before, after = np.sum(m * start.v, 0), np.sum(m * end.v, 0)
    assert after == pytest.approx(before, rel=1e-12, abs=1e-14 * np.max(np.abs(before)))
    assert np.max(np.abs(end.v - start.v)) > 0.02
    assert np.max(np.abs(end.spin - start.spin)) > 1
    l0, l1 = (angular_momentum(scene.spheres, s) for s in (start, end))
    assert l1 == pytest.approx(l0, abs=1e-11 * np.max(np.abs(l0)))


def test_a_pair_that_meets_again_remembers_nothing(tmp_path):
    """A sphere that a frictionless wall throws back on the one it came from, spinning now: the spring of
    `tangential history` begins anew. LIGGGHTS forgets it at the latest when lists are built, so a run that
    builds them in each step has to give the same; the old spring would push sideways by some per cent."""
    wall = f"fix wall all wall/gran model actm tangential off primitive type 1 xplane {1.6 * D}"
    ends = []
    for n, often in enumerate(("", "neigh_modify every 1 check no")):
        scene = Scene(
            [Sphere((0.0, 0.0, 0.0)), Sphere((1.001 * D, 0.0, 0.0), (-SPEED, 0.5 * SPEED, 0.0))],
            skin=0.05,
            friction=0.5,
            contact="model actm tangential history",
            lines=["group still id 1", "fix hold still freeze", wall,
                   "fix table all collision/table file table.csv", *([often] if often else [])],
        )  # fmt: skip
        ends.append(scene.run(tmp_path / str(n), 900))
    table = read_table(tmp_path / "0" / "table.csv")
    assert list(table["tag_j"]) == [2, -1, 2], "pair, wall, pair"
    for found, wanted in ((ends[0].v, ends[1].v), (ends[0].spin, ends[1].spin)):
        assert found == pytest.approx(wanted, abs=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.parametrize("place", [0.0, 0.1], ids=["in the box", "across its periodic end"])
def test_equal_masses_of_unequal_size(tmp_path, place):
    """A slow contact takes its stiffness from the heavier partner. Of two that weigh the same, to the last bit, it is
    the same one on either side of a periodic end; where each side took its own, momentum grew to 3.6 times m u."""
    u = 2e-3
    large = Sphere((place - 0.005, 0.0, 0.0), (u, 0.0, 0.0), diameter=D, density=1000.0)
    small = Sphere((place + 0.0026, 0.0, 0.0), (-u, 0.0, 0.0), diameter=D / 2, density=8000.0)
    if place > 0:
        small.position = (small.position[0] - 0.2, 0.0, 0.0)
    scene = Scene(
        [large, small], boundary="p p p", contact="model actm tangential off",
        properties=["fix m4 all property/global fluidDensity scalar 1000",
                    "fix m5 all property/global fluidViscosity scalar 1e-3"],
        lines=["fix weight all gravity 9.81 vector 0 -1 0"],
    )  # fmt: skip
    end = scene.run(tmp_path, 2000)
    assert end.v[0, 0] < 0 < end.v[1, 0]  # they came off each other
    assert end.v[0, 0] + end.v[1, 0] == pytest.approx(0.0, abs=1e-9 * u)
    assert np.all(np.abs(end.v[:, 0]) < u)
