"""The same run on any number of ranks, in pieces, restarted, after clear, with spheres coming and
going."""

import json
from pathlib import Path

import numpy as np
import pytest

from liggghts_script import PROGRAM, Scene, Sphere, dump_now, read_dump, read_table, run_script

D = 0.01
SIDE = 0.06
CONTACTS = {
    "actm": "model actm tangential haff_werner",
    "rpm": "model rpm tangential haff_werner",
    "hertz": "model hertz tangential haff_werner",
    "rolling film": "model actm tangential haff_werner",
}
FILMS = {
    "rpm": [],
    "rolling film": [
        "fix h all property/global fluidCellSize scalar 2e-4",
        "fix film all lubrication viscosity 1e-2 range 4e-4 tangential on",
    ],
}
STIFF = [
    "fix m6 all property/global youngsModulus peratomtype 5e6",
    "fix m7 all property/global poissonsRatio peratomtype 0.3",
]


def rain(model):
    """60 spheres that fall onto a floor and onto each other, in a box periodic in x and z: contacts
    across rank boundaries in all directions and across periodic faces."""
    rng = np.random.default_rng(2)
    spheres = []
    for n in range(60):
        i, j, k = np.unravel_index(n, (5, 3, 4))
        place = np.array([(i + 0.4) * SIDE / 5, (j + 0.55) * 1.05 * D, (k + 0.4) * SIDE / 4])
        place += rng.uniform(-0.03, 0.03, 3) * D
        velocity = (0.3, -0.3, 0.2) + 0.1 * rng.normal(size=3)
        spin = 20 * rng.normal(size=3)
        spheres.append(Sphere(tuple(place), tuple(velocity), tuple(spin), diameter=D))
    contact = CONTACTS[model]
    settings = "range 4e-4" if model == "rpm" else ""
    film = FILMS.get(model, ["fix film all lubrication viscosity 1e-2 range 4e-4"])
    return Scene(
        spheres,
        box=((0.0, SIDE), (-0.01, SIDE), (0.0, SIDE)),
        boundary="p f p",
        restitution=0.8,
        contact=contact,
        settings=settings,
        skin=2e-3,
        properties=STIFF if model == "hertz" else [],
        lines=[
            *film,
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0 {settings}",
            "fix weight all gravity 9.81 vector 0 -1 0",
            "fix table all collision/table file table.csv every 200",
        ],
    )


def difference(a, b):
    """Largest difference of position [D], velocity and spin [of the largest]; positions modulo the
    periodic box."""
    shift = a.x - b.x
    shift[:, [0, 2]] -= SIDE * np.round(shift[:, [0, 2]] / SIDE)
    parts = [np.max(np.abs(shift)) / D]
    parts += [np.max(np.abs(p - q)) / np.max(np.abs(p)) for p, q in ((a.v, b.v), (a.spin, b.spin))]
    return max(parts)


STEPS = 600


@pytest.mark.parametrize("model", CONTACTS)
def test_ranks(tmp_path, model):
    """1, 2 and 4 ranks differ by round-off only (it grows with each collision: 1e-16 to 1e-11 over
    600 steps; a contact forgotten or counted twice at a boundary gives 1e-3 and more), and the
    collision tables have the same rows."""
    scene = rain(model)
    states = {n: scene.run(tmp_path / str(n), STEPS, ranks=n) for n in (1, 2, 4)}
    tables = {n: read_table(tmp_path / str(n) / "table.csv") for n in states}
    assert len(tables[1]["tag_i"]) > 60
    assert np.any(tables[1]["tag_j"] == -1) and np.any(tables[1]["tag_j"] > 0)
    for n in (2, 4):
        assert difference(states[1], states[n]) < 1e-9
        for column, values in tables[1].items():
            if column in "xyz":
                continue  # a periodic image may stand for the other
            scale = np.max(np.abs(values)) or 1.0
            order = [np.lexsort((t["time_start"], t["tag_j"], t["tag_i"])) for t in (tables[1], tables[n])]
            assert values[order[0]] == pytest.approx(
                tables[n][column][order[1]], abs=1e-7 * scale
            ), column


@pytest.mark.parametrize("model", ["actm", "rpm", "rolling film"])
def test_run_in_pieces(tmp_path, model):
    """`run` split in pieces, in the midst of contacts, is the same run to round-off. (LIGGGHTS' own
    hertz takes its damping at another velocity in the first step of each piece: 4e-3.)"""
    scene = rain(model)
    whole = scene.run(tmp_path / "whole", STEPS)
    pieces = scene.run(tmp_path / "pieces", ["run 151", "run 1", "run 149", f"run {STEPS - 301}"])
    assert difference(whole, pieces) < 1e-9


@pytest.mark.parametrize(
    ("model", "ranks"),
    [(m, r) for m in CONTACTS for r in (1, 2) if (m, r) != ("rolling film", 1)],
)
def test_restart_in_mid_contact(tmp_path, model, ranks):
    """A run that is written down at step 200, with dozens of contacts under way, and read again goes
    on as the run in two pieces does, to round-off of the order of sums (spheres are read in another
    order); the collision tables agree too."""
    scene = rain(model)
    first = scene.run(tmp_path, ["run 200", "write_restart state.bin", "run 200"], ranks)
    before = read_table(tmp_path / "table.csv")
    head = scene.head()
    start = head.index("read_data spheres.data")
    head[start] = "read_restart state.bin"
    head.pop(0)
    (tmp_path / "table.csv").rename(tmp_path / "first.csv")
    lines = [*head, "thermo 1000000", "run 200", *dump_now("again.dump")]
    run_script(tmp_path, lines, ranks)
    again = read_dump(tmp_path / "again.dump")
    assert difference(first, again) < 1e-11
    after = read_table(tmp_path / "table.csv")
    late = before["time_end"] > 200 * scene.dt
    assert np.count_nonzero(late) > 20
    for column in ("time_start", "impact_speed_normal", "impulse_normal"):
        a, b = np.sort(before[column][late]), np.sort(after[column][after["time_end"] > 200 * scene.dt])
        assert a == pytest.approx(b, abs=1e-9 * np.max(a)), column


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("settings", ["", "stickAfter 2"])
def test_restart_files_written_as_the_run_goes_keep_contacts(tmp_path, settings, ranks):
    """`restart 200` writes spheres of step 200 and, between spheres, contacts of step 199 (LIGGGHTS' own order of
    things). The run that reads them makes up for the one step, at velocities half a step later: the heap goes on as
    it did, while contacts that begin anew lose the force they bear."""
    scene = rain("actm")
    scene.settings = settings
    whole = scene.run(tmp_path, ["restart 200 state.*.bin", "run 250"], ranks)
    head = scene.head()
    head[head.index("read_data spheres.data")] = "read_restart state.200.bin"
    (tmp_path / "table.csv").rename(tmp_path / "first.csv")
    run_script(tmp_path, [*head[1:], "thermo 1000000", "run 50", *dump_now("again.dump")], ranks)
    # 3e-5 and, where a spring against slip is begun half a step later, 2e-3; contacts that begin anew: 0.5.
    assert difference(whole, read_dump(tmp_path / "again.dump")) < 1e-2


@pytest.mark.parametrize("film", ["actm", "rolling film"])
def test_restart_of_single_contacts_is_bit_for_bit(tmp_path, film):
    """With one partner each there is no order of sums: a pair and a wall contact, in mid-contact, go
    on with the very same numbers as without the restart, even without any split."""
    contact = CONTACTS["actm"]
    scene = Scene(
        [
            Sphere((0.0, 0.03, 0.0), (0.1, 0.01, 0.0), (1, 2, 3)),
            Sphere((D + 1e-5, 0.03, 0.0)),
            Sphere((0.0, D / 2 + 1e-5, 0.03), (0.02, -0.1, 0.0)),
        ],
        contact=contact,
        restitution=0.7,
        lines=[
            *FILMS.get(film, ["fix film all lubrication viscosity 1e-2 range 4e-4"]),
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0",
        ],
    )
    whole = scene.run(tmp_path, ["run 40", "write_restart state.bin", "run 60"])
    straight = scene.run(tmp_path / "straight", 100)
    head = scene.head()
    head[head.index("read_data spheres.data")] = "read_restart state.bin"
    run_script(tmp_path, [*head[1:], "run 60", *dump_now("again.dump")])
    again = read_dump(tmp_path / "again.dump")
    for name in ("x", "v", "spin"):
        assert np.array_equal(getattr(whole, name), getattr(again, name)), name
        assert np.array_equal(getattr(whole, name), getattr(straight, name)), name


def test_restart_of_a_hardened_contact_is_bit_for_bit(tmp_path):
    """A sphere hit on a wall with a force of 30 times what its impact asks for: in the hardened part, where
    it is written down, the restarted run goes on with the very same numbers."""
    contact = CONTACTS["actm"]
    u, step = 0.1, 1e-3
    sphere = Sphere((0.0, D / 2 + 1e-5, 0.0), (0.0, -u, 0.0))
    push = 30 * sphere.mass * u / (10 * step)
    scene = Scene(
        [sphere],
        contact=contact,
        restitution=0.7,
        lines=[
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0",
            f"fix push all addforce 0.0 {-push!r} 0.0",
        ],
    )
    whole = scene.run(tmp_path, ["run 30", *dump_now("middle.dump"), "write_restart state.bin", "run 60"])
    deep = D / 2 - read_dump(tmp_path / "middle.dump").x[0, 1]
    assert deep > 1.3 * 0.34 * u * 10 * step
    head = scene.head()
    head[head.index("read_data spheres.data")] = "read_restart state.bin"
    run_script(tmp_path, [*head[1:], "run 60", *dump_now("again.dump")])
    again = read_dump(tmp_path / "again.dump")
    for name in ("x", "v", "spin"):
        assert np.array_equal(getattr(whole, name), getattr(again, name)), name


@pytest.mark.parametrize("again", [False, True], ids=["pieces", "restart"])
def test_a_contact_follows_its_sphere_to_another_rank_at_the_start_of_a_run(tmp_path, again):
    """Two spheres that are in contact while the one that keeps it crosses the border of the ranks, x = 0, without new
    lists: the next `run` gives it to the other rank, or write_restart does. There is one row, that of a single rank."""
    small = (-0.03, 0.03)
    scene = Scene(
        [Sphere((-1e-4, 0.0, 0.0), (0.3, 0.0, 0.0)), Sphere((D - 1e-4 + 1e-6, 0.0, 0.0), (0.2, 0.0, 0.0))],
        box=((-0.1, 0.1), small, small),
        restitution=0.8,
        skin=0.02,
        lines=["fix table all collision/table file table.csv"],
    )
    scene.run(tmp_path / "one", 300)
    ranks = tmp_path / "ranks"
    pieces = ["run 50", "write_restart state.bin", *([] if again else ["run 50", "run 200"])]
    scene.run(ranks, pieces, ranks=2)
    if again:
        head = scene.head()
        head[head.index("read_data spheres.data")] = "read_restart state.bin"
        run_script(ranks, [*head[1:], "run 50", "run 200"], 2)
    one, found = (read_table(folder / "table.csv") for folder in (tmp_path / "one", ranks))
    for column, values in one.items():
        assert found[column] == pytest.approx(values, rel=1e-9, abs=1e-15), column


def test_a_contact_with_a_wall_outlives_other_fixes(tmp_path):
    """A fix that stands before the wall's goes between two runs: the contact has one row all the same."""
    contact = CONTACTS["actm"]
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-6, 0.0), (0.0, -0.1, 0.0))],
        lines=[
            "fix nothing all property/global nothing scalar 1",
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0",
            "fix table all collision/table file table.csv",
        ],
    )
    end = scene.run(tmp_path, ["run 50", "unfix nothing", "run 250"])
    table = read_table(tmp_path / "table.csv")
    assert list(table["tag_j"]) == [-1]
    assert table["impulse_normal"] == pytest.approx(scene.spheres[0].mass * (0.1 + end.v[0, 1]), rel=1e-9)


@pytest.mark.parametrize("ranks", [1, 2])
def test_contacts_under_way_stand_beside_the_table(tmp_path, ranks):
    """Two spheres fall on a floor, one on either rank: at the end of the first run both touch it, and have rows with
    its end and the impulse so far; at the end of the second the table has them, and nothing is under way."""
    contact = CONTACTS["actm"]
    scene = Scene(
        [Sphere((x, D / 2 + 1e-6, 0.0), (0.0, -0.1, 0.0)) for x in (-0.05, 0.05)],
        lines=[
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0",
            "fix table all collision/table file table.csv",
        ],
    )
    first = scene.run(tmp_path / "first", 50, ranks)
    under_way = read_table(tmp_path / "first" / "table_open.csv")
    assert not read_table(tmp_path / "first" / "table.csv")
    assert list(under_way["tag_i"]) == [1, 2] and list(under_way["tag_j"]) == [-1, -1]
    assert under_way["time_end"] == pytest.approx(50 * scene.dt, rel=1e-9)
    assert under_way["time_start"] == pytest.approx(1e-6 / 0.1, rel=1e-6)
    # The last step has made half of its kick: of 50, at up to three times their mean force.
    gained = scene.spheres[0].mass * (0.1 + first.v[:, 1])
    assert under_way["impulse_normal"] == pytest.approx(gained, rel=0.03)
    scene.run(tmp_path / "whole", ["run 50", "run 250"], ranks)
    assert len(read_table(tmp_path / "whole" / "table.csv")["tag_i"]) == 2
    assert not read_table(tmp_path / "whole" / "table_open.csv")


def test_any_number_of_contacts_goes_through_a_restart(tmp_path):
    """A large sphere that a hundred small ones hit at once, from all sides: each contact has its row."""
    count, large = 100, 8 * D
    n = np.arange(count) + 0.5
    y, turn = 1 - 2 * n / count, np.pi * (3 - np.sqrt(5)) * n
    ways = np.column_stack([np.sqrt(1 - y**2) * np.cos(turn), y, np.sqrt(1 - y**2) * np.sin(turn)])
    places = ways * ((large + D) / 2 + 1e-6)
    scene = Scene(
        [Sphere((0.0, 0.0, 0.0), diameter=large),
         *(Sphere(tuple(x), tuple(-0.1 * way)) for x, way in zip(places, ways, strict=True))],
        lines=["fix table all collision/table file table.csv"],
    )  # fmt: skip
    scene.run(tmp_path / "whole", ["run 60", "run 300"])
    scene.run(tmp_path, ["run 60", "write_restart state.bin"])
    assert len(read_table(tmp_path / "table_open.csv")["tag_i"]) == count
    head = scene.head()
    head[head.index("read_data spheres.data")] = "read_restart state.bin"
    run_script(tmp_path, [*head[1:], "run 300"])
    whole, parts = read_table(tmp_path / "whole" / "table.csv"), read_table(tmp_path / "table.csv")
    assert len(whole["tag_i"]) == count and list(whole["tag_j"]) == list(parts["tag_j"])
    assert parts["impulse_normal"] == pytest.approx(whole["impulse_normal"], rel=1e-9)


def test_a_run_that_goes_on_twice_has_each_row_once(tmp_path):
    """Restarted into a new table, written down there, and taken up again at that place, as after a crash: rows
    behind it go, though the table holds only a part of all collisions so far."""
    scene = rain("actm")
    scene.run(tmp_path, ["run 200", "write_restart a.bin", "run 200"])
    first = read_table(tmp_path / "table.csv")

    def go_on(state, steps):
        head = [line.replace("table.csv", "second.csv") for line in scene.head()]
        head[head.index("read_data spheres.data")] = f"read_restart {state}"
        run_script(tmp_path, [*head[1:], *steps])
        return read_table(tmp_path / "second.csv")

    once = go_on("a.bin", ["run 100", "write_restart b.bin", "run 100"])
    twice = go_on("b.bin", ["run 100"])
    assert 20 < len(once["tag_i"]) == np.count_nonzero(first["time_end"] > 200 * scene.dt)
    assert len(once["tag_i"]) > 5 + np.count_nonzero(once["time_end"] < 300 * scene.dt)
    for column, values in once.items():
        scale = np.max(np.abs(values))
        assert twice[column] == pytest.approx(values, abs=1e-9 * scale), column


def floor_mesh(side, pieces):
    """A flat floor at y = 0 of pieces x pieces squares of two triangles each, as STL text."""
    edge = np.linspace(-0.02, side + 0.02, pieces + 1)
    facets = []
    for a, b in zip(edge, edge[1:]):
        for c, d in zip(edge, edge[1:]):
            for corners in ([(a, c), (b, d), (b, c)], [(a, c), (a, d), (b, d)]):
                vertices = "".join(f"vertex {p!r} 0 {q!r}\n" for p, q in corners)
                facets.append(f"facet normal 0 1 0\nouter loop\n{vertices}endloop\nendfacet\n")
    return "solid floor\n" + "".join(facets) + "endsolid floor\n"


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("tangential", ["haff_werner", "history", "haff_werner stick"])
def test_restart_in_mid_contact_on_a_mesh(tmp_path, tangential, ranks):
    """Twelve spheres in contact with a mesh wall of 32 triangles (inside of them, as pairs of spheres
    too), written down in mid-contact: the restarted run ends with the numbers of the run without
    a restart, to round-off. A contact whose history is lost is calibrated anew at the speed it has
    then, and rebounds 10 % and more off."""
    settings = "stickAfter 1" if "stick" in tangential else ""
    contact = f"model actm tangential {tangential.split()[0]}"
    rng = np.random.default_rng(8)
    side = 0.06
    spheres = []
    for n in range(12):
        place = np.array([0.011 + 0.0125 * (n % 4), D / 2 + 1e-5, 0.011 + 0.0125 * (n // 4)])
        velocity = (0.03 * rng.normal(), -0.1, 0.03 * rng.normal())
        spheres.append(Sphere(tuple(place), velocity, tuple(rng.normal(size=3)), diameter=D))
    scene = Scene(
        spheres,
        box=((-0.03, 0.09), (-0.01, 0.05), (-0.03, 0.09)),
        restitution=0.7,
        contact=contact,
        settings=settings,
        lines=[
            "fix cad all mesh/surface file floor.stl type 1",
            f"fix floor all wall/gran {contact} mesh n_meshes 1 meshes cad {settings}",
            "fix table all collision/table file table.csv",
        ],
    )
    tmp_path.mkdir(exist_ok=True)
    (tmp_path / "floor.stl").write_text(floor_mesh(side, 4))
    whole = scene.run(tmp_path, ["run 60", "write_restart state.bin", "run 200"], ranks)
    assert np.all(whole.v[:, 1] > 0.04)  # all have rebounded, in contact at step 60
    head = scene.head()
    head[head.index("read_data spheres.data")] = "read_restart state.bin"
    run_script(tmp_path, [*head[1:], "run 200", *dump_now("again.dump")], ranks)
    assert difference(whole, read_dump(tmp_path / "again.dump")) < 1e-11


def test_clear(tmp_path):
    """After `clear` the styles are there again and the same run gives the same numbers."""
    scene = rain("actm")
    once = scene.run(tmp_path / "once", 200)
    lines = [*scene.head(), "run 77", "clear", *scene.script(200)]
    (tmp_path / "spheres.data").write_text(scene.data_file())
    run_script(tmp_path, lines)
    twice = read_dump(tmp_path / "end.dump")
    assert np.array_equal(once.x, twice.x) and np.array_equal(once.v, twice.v)


def test_spheres_come_and_go(tmp_path):
    """Spheres deleted in mid-contact and created take nothing from the others and inherit nothing:
    the remaining pair rebounds with e_dry, and so does the new one."""
    e = 0.8
    scene = Scene(
        [
            Sphere((0.0, 0.0, 0.0), (0.1, 0, 0)),
            Sphere((D + 1e-5, 0.0, 0.0)),
            Sphere((0.0, 0.03, 0.0), (0.1, 0, 0)),
            Sphere((D + 1e-5, 0.03, 0.0)),
        ],
        restitution=e,
        lines=["fix table all collision/table file table.csv"],
    )
    lines = [
        "run 50",
        "group gone id 2",
        "delete_atoms group gone compress no",
        f"create_atoms 1 single {D + 0.05} 0.06 0.0 units box",
        "group new id 5",
        f"set group new diameter {D} density 2500.0",
        "set group new vx -0.1",
        f"create_atoms 1 single {0.05 - 1e-5} 0.06 0.0 units box",
        "group new2 id 6",
        f"set group new2 diameter {D} density 2500.0",
        "run 300",
    ]
    end = scene.run(tmp_path, lines)
    opening = [end.v[2, 0] - end.v[1, 0], end.v[3, 0] - end.v[4, 0]]
    assert opening == pytest.approx([0.1 * e] * 2, rel=2e-3)
    # Sphere 1 keeps the speed that it had when its partner vanished.
    assert 0 < end.v[0, 0] < 0.1


@pytest.mark.parametrize("ranks", [1, 2, 4])
@pytest.mark.parametrize("gone", [1, 2])
def test_the_contact_of_a_sphere_that_is_deleted_has_its_row(tmp_path, ranks, gone):
    """One of two spheres leaves the box in mid-contact, where LIGGGHTS deletes it when it builds lists:
    the contact ends with it, whichever of its partners keeps it and on whatever rank."""
    left = 0.1 - 5e-4
    pair = [Sphere((left, 0.0, 0.0), (0.1, 0, 0)), Sphere((left - D - 1e-5, 0.0, 0.0), (0.2, 0, 0))]
    scene = Scene(
        pair if gone == 1 else pair[::-1],
        restitution=0.8,
        lines=["fix table all collision/table file table.csv", "neigh_modify every 1 check no"],
    )
    end = scene.run(tmp_path, 100, ranks)
    assert list(end.tag) == [3 - gone]
    table = read_table(tmp_path / "table.csv")
    assert list(zip(table["tag_i"], table["tag_j"])) == [(1, 2)]
    # The other has lost the momentum that the table says, a part of a whole collision's.
    assert 0.12 < end.v[0, 0] < 0.19
    taken = pair[0].mass * (0.2 - end.v[0, 0])
    assert table["impulse_normal"] == pytest.approx(taken, rel=0.05)


def sums_of_a_step(folder, monkeypatch, places, film):
    """Sums over two ranks in a step: the difference of runs of 20 and 40 steps. The ranks part the row of
    spheres at x = 0; those beside the middle come towards it."""
    spheres = [Sphere((x, 0.0, 0.0), (-0.01 * np.sign(x), 0.0, 0.0)) for x in places]
    small = (-0.03, 0.03)
    scene = Scene(spheres, box=((-0.1, 0.1), small, small), lines=film)
    monkeypatch.setenv("LD_PRELOAD", str(Path(PROGRAM).parent / "count_use.so"))
    sums = []
    for steps in (20, 40):
        counts = folder / f"{len(places)}-{len(film)}-{steps}"
        counts.mkdir()
        monkeypatch.setenv("BEDLOAD_COUNTS", str(counts))
        scene.run(folder, steps, ranks=2)
        told = [json.loads(file.read_text()) for file in counts.glob("*.json")]
        sums.append([t["sums"] for t in told if t["program"] == "liggghts-with-styles"])
        assert len(sums[-1]) == 2 and len(set(sums[-1])) == 1
    return (sums[1][0] - sums[0][0]) / 20


@pytest.mark.parametrize("row, most", [("apart", 1), ("pair", 1), ("three", 3)])
def test_sums_over_ranks(tmp_path, monkeypatch, row, most):
    """Films take one sum over the ranks in a step, and where some share a sphere one more in each iteration:
    two films of one sphere are solved for in two. So it is with no film at all."""
    near = D + 1e-4
    places = {"apart": [-0.02, 0.02], "pair": [-near / 2, near / 2], "three": [-near, 0.0, near + 1e-4]}[row]
    film = ["fix film all lubrication viscosity 1e-2 range 4e-4"]
    without = sums_of_a_step(tmp_path, monkeypatch, places, [])
    assert sums_of_a_step(tmp_path, monkeypatch, places, film) - without == pytest.approx(most, abs=0.051)
