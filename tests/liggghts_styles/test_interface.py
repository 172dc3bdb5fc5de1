"""What LIGGGHTS users lean on: combinations with shipped models, values of a contact in dumps."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, read_table, run_script

D = 0.01


def pair(gap=1e-5):
    """A sphere that meets another one aslant."""
    return [Sphere((0, 0, 0), (0.1, 0.03, 0)), Sphere((D + gap, 0, 0))]


SHIPPED = [
    "fix m6 all property/global youngsModulus peratomtype 5e6",
    "fix m7 all property/global poissonsRatio peratomtype 0.3",
    "fix m8 all property/global coefficientRollingFriction peratomtypepair 1 0.05",
    "fix m9 all property/global characteristicVelocity scalar 0.1",
]
COMBINATIONS = [
    *(
        f"{normal} tangential haff_werner{rolling}"
        for normal in ("actm", "hertz", "hooke")
        for rolling in ("", " rolling_friction cdt", " rolling_friction epsd2")
    ),
    "actm tangential history",
    "actm tangential off",
    "actm tangential haff_werner cohesion off",
    "rpm tangential haff_werner",
    "rpm tangential off",
]


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_combinations(tmp_path, combination):
    """Each runs, for pairs and walls; spheres rebound, friction turns both of them the same way round
    and leaves the momentum as it was."""
    rpm = "rpm" in combination
    settings = "range 2e-4 strength 1e3" if rpm else ""
    contact = f"model {combination}"
    wall = f"fix floor all wall/gran {contact} primitive type 1 yplane -0.05 {settings}"
    weight = "fix weight none gravity 9.81 vector 0 -1 0"
    scene = Scene(
        pair(3e-4 if rpm else 1e-5),  # rpm: from beyond its range
        restitution=0.8,
        contact=contact,
        settings=settings,
        properties=SHIPPED,
        lines=[wall, *(["group some type 1", "group none subtract all some", weight] if rpm else [])],
    )
    end = scene.run(tmp_path, 800 if rpm else 400)
    assert np.sum(end.v, 0) == pytest.approx([0.1, 0.03, 0], abs=1e-12)
    opening = end.v[1, 0] - end.v[0, 0]
    assert opening == pytest.approx(0.1 if rpm else 0.08, rel=0.03)
    if "off" in combination.split("cohesion")[0]:
        assert np.all(end.spin == 0)
    else:
        assert np.all(end.spin[:, 2] < -0.1)


def test_values_of_a_contact_in_dump_local(tmp_path):
    """compute pair/gran/local shows the contact's history in the order that normal_actm.md and
    tangential_haff_werner.md give; normal and tangential force there make up the force that LIGGGHTS
    shows, the calibration speed is the impact speed, both step numbers are that of the dump."""
    names = ["id1", "id2", "periodic", "fx", "fy", "fz"]
    names += ["k", "d", "birth_overlap", "speed", "force", "step", "settling", "lost", "impact"]
    names += ["onset", "slope", "load"]
    names += ["hw_fx", "hw_fy", "hw_fz", "hw_step"]
    columns = " ".join(f"c_values[{n + 1}]" for n in range(len(names)))
    Scene(pair(), restitution=0.8).run(
        tmp_path,
        [
            "compute values all pair/gran/local id force history",
            f"dump local all local 40 local.dump {columns}",
            "run 40",
            "undump local",
        ],
    )
    row = (tmp_path / "local.dump").read_text().splitlines()[-1]
    value = dict(zip(names, map(float, row.split()), strict=True))
    assert (value["id1"], value["id2"]) == (1, 2)
    assert value["step"] == value["hw_step"] == 40
    assert value["impact"] == 1
    # 1.1 times the impact's own overlap, which is 0.34 u T_c at e = 1 and a tenth less at 0.8.
    assert value["onset"] == pytest.approx(1.1 * 0.34 * 0.9 * 0.1 * 10 * 1e-3, rel=0.02)
    assert value["slope"] > 0
    assert value["load"] == 0  # no fluid
    # The line of centres has turned by a thousandth at the first touch.
    assert value["speed"] == pytest.approx(0.1, rel=1e-3)
    assert value["k"] > 0 and value["d"] > 0 and value["birth_overlap"] == 0
    friction = np.array([value["hw_fx"], value["hw_fy"], value["hw_fz"]])
    assert friction @ friction <= (0.15 * value["force"]) ** 2 * (1 + 1e-5)
    shown = np.array([value["fx"], value["fy"], value["fz"]])
    assert shown @ shown == pytest.approx(value["force"] ** 2 + friction @ friction, rel=1e-4)


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_an_enduring_contact_pays_for_its_stiffness(tmp_path, restitution):
    """A grain is pressed on a floor by a sphere that comes slowly. After 2 T_c the contact may become as stiff as bears
    the weight by so small an overlap, fifty times, but by no more energy than its damping has taken: at e = 1 that is
    none, and k stays what it was."""
    contact = "model actm tangential off"
    settings = "restingOverlap 1e-6"
    v = 1e-3
    names = ["k", "d", "birth_overlap", "speed", "force", "step", "settling", "lost"]
    columns = " ".join(f"c_values[{n + 1}]" for n in range(len(names)))
    scene = Scene(
        [Sphere((0.0, D / 2 + 1e-7, 0.0), (0.0, -v, 0.0), diameter=D), Sphere((0.0, 1.5 * D + 2e-7, 0.0), diameter=D)],
        restitution=restitution,
        contact=contact,
        settings=settings,
        lines=[
            f"fix floor all wall/gran {contact} primitive type 1 yplane 0.0 {settings}",
            "fix weight all gravity 1e-3 vector 0 -1 0",
            "group mover id 2", "group grain id 1",
            f"fix drag mover move linear 0.0 {-v} 0.0 units box",
        ],
        integrate="fix integrate grain nve/sphere",
    )  # fmt: skip
    scene.run(tmp_path, [
        "compute values all pair/gran/local history",
        f"dump local all local 100 local.dump {columns}", "run 2000", "undump local",
    ])  # fmt: skip
    rows = [line.split() for line in (tmp_path / "local.dump").read_text().splitlines()]
    k, _, _, speed, force, _, _, lost = np.array([row for row in rows if len(row) == len(names)], dtype=float).T
    assert len(k) > 15 and speed[-1] < 3 * v and force[-1] > 0
    if restitution == 1.0:
        assert np.all(lost == 0) and np.all(k == k[0])
    else:
        assert k[-1] > 1.1 * k[0] and np.all(np.diff(k) >= 0)


WEIGHT = ["group some type 1", "group none subtract all some", "fix weight none gravity 9.81 vector 0 -1 0"]


RPM_FRICTION = "model rpm tangential haff_werner"
REACH = "range 4e-4 strength 7"


@pytest.mark.parametrize("rolls", [False, True])
def test_friction_of_rpm_at_a_wall_before_the_touch(tmp_path, rolls):
    """A sphere that slides fast within the range feels μ F_n, one that rolls feels nothing: its slip is v + n × a ω
    with the arm a to the middle of the gap."""
    gap, v = 1e-4, 0.5
    spin = -v / (D / 2 + gap / 2) if rolls else 0.0
    scene = Scene(
        [Sphere((0.0, D / 2 + gap, 0.0), (v, 0.0, 0.0), (0.0, 0.0, spin), diameter=D)],
        contact=RPM_FRICTION,
        settings=REACH,
        lines=[f"fix floor all wall/gran {RPM_FRICTION} primitive type 1 yplane 0.0 {REACH}", *WEIGHT],
    )
    along, across = scene.run(tmp_path, 1).f[0, :2]
    weight = 9.81 * scene.spheres[0].mass
    assert across == pytest.approx(7 * weight * 0.75**2, rel=1e-3)
    assert along == pytest.approx(0 if rolls else -scene.friction * across, abs=1e-3 * across)


def test_friction_of_rpm_between_spheres_before_the_touch(tmp_path):
    """Slow slip of two spheres that spin: F_t = d_t |g_t|, d_t = 2/7 m/(T + Δt), m the reduced mass, T one fluid step,
    the arms reaching to the middle of the gap. Spins of one sense slip, those of opposite sense roll.
    Bound: what one step of damping takes."""
    gap, spin = 1e-4, 0.2
    force = []
    for other in (spin, -spin):
        scene = Scene(
            [Sphere((0.0, 0.0, 0.0), spin=(0.0, 0.0, spin)), Sphere((D + gap, 0.0, 0.0), spin=(0.0, 0.0, other))],
            contact=RPM_FRICTION,
            settings=REACH,
            lines=WEIGHT,
        )
        force.append(scene.run(tmp_path / str(other), 1).f)
    mass = scene.spheres[0].mass / 2
    damping = 2 / 7 * mass / (scene.fluid_step + scene.dt)
    slip = 2 * (D / 2 + gap / 2) * spin
    found = force[0][1, 1]
    assert found == pytest.approx(damping * slip, rel=2 * scene.dt / scene.fluid_step)
    assert force[0][0, 1] == pytest.approx(-found, rel=1e-12)
    assert abs(force[1][1, 1]) < 1e-6 * found


@pytest.mark.parametrize("fixes", [1, 2])
def test_force_of_rpm(tmp_path, fixes):
    """F = ε m_p g ((S - ζ)/S)² at a gap of S/4, on both partners: m_p is the sphere's mass at a wall and at
    a held sphere, and twice the reduced mass of two that move, of whatever sizes; g is what all fixes gravity come
    to."""
    weight = WEIGHT if fixes == 1 else [*WEIGHT[:2], "fix part none gravity 4 vector 0 -1 0",
                                        "fix rest none gravity 5.81 vector 0 -1 0"]  # fmt: skip
    reach, strength, gap = 4e-4, 7.0, 1e-4
    small = 0.6 * D
    spheres = [
        Sphere((0, 0.02, 0)), Sphere((0, 0.02, (D + small) / 2 + gap), diameter=small),  # free pair
        Sphere((0.03, 0.02, 0)), Sphere((0.03, 0.02, (D + small) / 2 + gap), diameter=small),  # first held
        Sphere((0.06, D / 2 + gap, 0)),  # at the wall
    ]  # fmt: skip
    settings = f"range {reach} strength {strength}"
    wall = f"fix floor all wall/gran model rpm primitive type 1 yplane 0.0 {settings}"
    scene = Scene(
        spheres, contact="model rpm", settings=settings,
        lines=[wall, *weight, "group held id 3", "fix hold held freeze", "group free subtract all held"],
        integrate="fix integrate free nve/sphere",
    )  # fmt: skip
    force = scene.run(tmp_path, 0).f
    weights = [s.mass * 9.81 for s in spheres]
    share = strength * 0.75**2
    pair = share * 2 * weights[0] * weights[1] / (weights[0] + weights[1])
    assert force[0] == pytest.approx([0, 0, -pair], rel=1e-9)
    assert force[1] == pytest.approx([0, 0, pair], rel=1e-9)
    assert force[3] == pytest.approx([0, 0, share * weights[3]], rel=1e-9)
    assert force[4] == pytest.approx([0, share * weights[4], 0], rel=1e-9)


@pytest.mark.parametrize("share, warns", [(0.5, True), (0.05, False)])
def test_a_sphere_that_starts_inside_the_range_of_rpm_is_named(tmp_path, share, warns):
    """Let go at a depth of a share x of the range it leaves the wall at sqrt(2/3 ε g S x³): 1.5 sqrt(g D) at a half,
    0.05 sqrt(g D) at a twentieth, of which nothing is said."""
    reach = 4e-4
    strength = 1.5 * 1.5**2 * D / reach / 0.5**3
    settings = f"range {reach} strength {strength}"
    wall = f"fix floor all wall/gran model rpm primitive type 1 yplane 0.0 {settings}"
    scene = Scene([Sphere((0, D / 2 + (1 - share) * reach, 0))], contact="model rpm", settings=settings,
                  lines=[wall, *WEIGHT])  # fmt: skip
    (tmp_path / "spheres.data").write_text(scene.data_file())
    assert ("rpm: sphere 1 stands 0.0002 inside the range" in run_script(tmp_path, scene.script(5))) == warns


def test_a_sphere_is_not_thrown_off_by_its_own_image(tmp_path):
    """In a periodic box 1.01 D wide it stands inside the range of itself, which pushes it evenly from both sides."""
    settings, half = f"range 4e-4 strength {1e5}", 0.505 * D
    scene = Scene([Sphere((0, 0, 0))], contact="model rpm", settings=settings, lines=WEIGHT, boundary="p f f",
                  box=((-half, half), (-0.1, 0.1), (-0.1, 0.1)), skin=4e-4)  # fmt: skip
    (tmp_path / "spheres.data").write_text(scene.data_file())
    assert "inside the range" not in run_script(tmp_path, scene.script(5))
    assert scene.run(tmp_path, 5).f[0][0] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(("given", "steps"), [("collisionSteps 8", 8), ("", 5)])
def test_default_strength_of_rpm(tmp_path, given, steps):
    """Two equal spheres that meet at sqrt(g D) are in range of each other for collisionSteps fluid steps, five unless
    told, within the DEM step; twice the strength would take 0.79 of that."""
    u, step = np.sqrt(9.81 * D), 1e-3
    scene = Scene(
        [Sphere((0, 0, 0), (u, 0, 0)), Sphere((D + 4.3e-4, 0, 0))],
        contact="model rpm",
        settings=f"range 4e-4 {given}",
        fluid_step=step,
        lines=[*WEIGHT, "fix table all collision/table file table.csv"],
    )
    scene.run(tmp_path, 40 * scene.substeps)
    table = read_table(tmp_path / "table.csv")
    lasted = table["time_end"] - table["time_start"]
    assert lasted == pytest.approx([steps * step], abs=1.5 * scene.dt)
    assert table["rebound_speed_normal"] == pytest.approx([u], rel=1e-2)
