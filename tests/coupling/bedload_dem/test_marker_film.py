"""What markers that stand back leave of films against sliding and rolling, the coupling gives to the spheres."""

import itertools

import numpy as np
import pytest

from programs import BIN, command, run

RADIUS, CELL, VISCOSITY, SPIN = 0.5, 0.125, 0.05, 0.8  # of the scene below; dynamic viscosity
STEPS, SUBSTEPS, TIME_STEP = 2, 15, 0.002  # nu dt/h^2 = 0.0064

FLUID = """\
grid.cells = [32, 32, 32]
grid.length = [4.0, 4.0, 4.0]
fluid.kinematic_viscosity = {viscosity}
fluid.gravity = [0.0, -1e-3, 0.0]
time.step = 0.002
time.end = 1.0
boundary.x = {x}
boundary.y = {y}
boundary.z = {z}
"""

SCRIPT = """\
variable     out index .
units        si
atom_style   granular
atom_modify  map array
newton       off
communicate  single vel yes
boundary     {boundary}
region       box block 0 4 0 4 0 4 units box
create_box   2 box
neighbor     0.8 bin
neigh_modify delay 0
{spheres}
group        free type 2
group        held type 1
{wet}
fix          m1 all property/global coefficientRestitution peratomtypepair 2 0.9 0.9 0.9 0.9
fix          m2 all property/global youngsModulus peratomtype 5e6 5e6
fix          m3 all property/global poissonsRatio peratomtype 0.3 0.3
fix          weight all gravity 1e-3 vector 0 -1 0
fix          m4 all property/global characteristicVelocity scalar 1.0
{model}
fix          motion free nve/sphere
fix          still held freeze
dump         films all custom 1 ${{out}}/films.txt id omegaz f_couple_film[6] f_couple_torque[3]
dump_modify  films sort id format "%d {numbers}"
coupled_run
"""

WALL_SPEED = 0.1
ENDS = {"m": f'["no_slip", "free_slip"]\nboundary.y_lower_velocity = [{WALL_SPEED}, 0.0, 0.0]',
        "p": '"periodic"', "f": '["free_slip", "no_slip"]', "u": '["no_slip", "free_slip"]'}  # fmt: skip


def coupled(folder, script, ends="ppp", ranks=(1, 1)):
    """A run of both programs over STEPS."""
    folder.mkdir(exist_ok=True)
    (folder / "in.liggghts").write_text(script, encoding="utf-8")
    walls = {d: ENDS[end] for d, end in zip("xyz", ends, strict=True)}
    (folder / "fluid.toml").write_text(FLUID.format(viscosity=VISCOSITY, **walls), encoding="utf-8")
    fluid = [str(BIN / "bedload-fluid"), "fluid.toml", "--out", "out", "--steps", str(STEPS)]
    dem = [str(BIN / "bedload-dem"), "-in", "in.liggghts", "-var", "out", "out", "-log", "none"]
    return run(command(fluid, dem, ranks), folder, timeout=120)


def films_of(folder, script, ends="ppp", ranks=(1, 1)):
    """The dump of such a run."""
    result = coupled(folder, script, ends, ranks)
    assert result.status == 0, result.output
    return (folder / "out" / "films.txt").read_text()


def torques(folder, spheres, model, wet="fix fluid all couple/fluid", ends="ppp"):
    """Torques about z of sphere 1 in each DEM step, by what markers leave and by the fluid, over its spin."""
    script = SCRIPT.format(boundary=" ".join(ends).replace("u", "f"), spheres=spheres, wet=wet, model=model,
                           numbers="%.15g " * 3)  # fmt: skip
    rows = [row.split() for row in films_of(folder, script, ends).splitlines() if row.startswith("1 ")]
    numbers = np.array(rows, dtype=float)
    assert len(numbers) == STEPS * SUBSTEPS + 1
    return (numbers[1:, 2:] / numbers[1:, 1:2]).T


def logarithms(gap):
    """What markers leave of those of sliding and rolling in steps as short as these."""
    s, shorter = max(gap, 0.0) / CELL, np.log(0.2 * CELL**2 / (VISCOSITY * TIME_STEP))
    slide = 1.33 * np.exp(-s * (1.75 + 1.5 * s)) - 0.19 * shorter * np.exp(-s * (0.3 + 1.3 * s))
    roll = 0.583 * np.exp(-s * (1.85 + 1.55 * s)) - 0.11 * shorter * np.exp(-0.9 * s**2)
    return max(0.0, slide), max(0.0, roll)


def left(gap):
    """T/spin of a sphere that turns over another of its size, -a² (2 π μ (R/2) Λ_s + 1.2 π μ (R/2) Λ_e)."""
    slide, roll = logarithms(gap)
    return -((RADIUS + 0.5 * gap) ** 2) * np.pi * VISCOSITY * 0.5 * RADIUS * (2.0 * slide + 1.2 * roll)


def pair(gap):
    """Sphere 1 turns about z over sphere 2, which is held."""
    return (f"create_atoms 2 single 2 {2.0 + 2 * RADIUS + gap} 2 units box\n"
            "create_atoms 1 single 2 2 2 units box\n"
            f"set atom 1 diameter 1 density 1000 omegaz {SPIN}\nset atom 2 diameter 1 density 1000")  # fmt: skip


MODELS = {
    "actm": "pair_style gran model actm tangential off collisionSteps 10\npair_coeff * *",
    "rpm": "pair_style gran model rpm tangential off range 0.1 collisionTime 1\npair_coeff * *",
    "hertz": "pair_style gran model hertz tangential off\npair_coeff * *",
    "hooke": "pair_style gran model hooke tangential off\npair_coeff * *",
    "tangential off": "pair_style gran model actm tangential off\npair_coeff * *\n"
                      "fix film all lubrication tangential off range 0.01 gapMin 0.005",
}  # fmt: skip


@pytest.mark.parametrize("model, gap", itertools.product(MODELS, (0.0125, -1e-4, 0.1)))
def test_every_model_gets_it(tmp_path, model, gap):
    """In overlap that nothing pushes together, too, and whatever a film's reach and roughness. The grain is heavy and
    hardly turns slower in two steps; a coefficient left out changes the torque by a fifth and more."""
    assert torques(tmp_path, pair(gap), MODELS[model])[0] == pytest.approx(left(gap), rel=0.02)


@pytest.mark.parametrize("gap, wet", [
    (0.17, "fix fluid all couple/fluid"),  # beyond 1.25 cells
    (0.0125, "fix fluid free couple/fluid"),
])  # fmt: skip
def test_nothing_where_no_markers_stood_back(tmp_path, gap, wet):
    assert not np.any(torques(tmp_path, pair(gap), MODELS["actm"], wet)[0])


def test_images_behind_free_slip_ends(tmp_path):
    """No wall of the script stands there. The image turns against the sphere: s = 0, and e = a spin. Markers stand back
    at ends of any direction, so that the fluid's torque is the same (at an end of x it was 4 % larger where
    they did not)."""
    gap = 0.01
    roll = logarithms(2 * gap)[1]
    expected = -((RADIUS + gap) ** 2) * np.pi * VISCOSITY * 0.5 * RADIUS * 2.4 * roll
    by_fluid = []
    for ends, upper in (("fpp", False), ("pfp", False), ("upp", True)):
        place = [2.0, 2.0, 2.0]
        place[0 if upper else ends.index("f")] = 4.0 - RADIUS - gap if upper else RADIUS + gap
        spheres = (
            f"create_atoms 2 single {' '.join(map(str, place))} units box\ncreate_atoms 1 single 1.6 3.2 2 units box\n"
            f"set atom 1 diameter 1 density 1000 omegaz {SPIN}\nset atom 2 diameter 1 density 1000"
        )
        left_there, fluid = torques(tmp_path / ends, spheres, MODELS["actm"], ends=ends)
        assert left_there == pytest.approx(expected, rel=0.02)
        by_fluid.append(fluid[-1])
    assert by_fluid == pytest.approx([by_fluid[0]] * 3, rel=2e-3)


@pytest.mark.parametrize("gap, model", itertools.product((0.0125, -1e-4, 0.1), ("actm", "")))
def test_no_slip_ends(tmp_path, gap, model):
    """A sphere that slides and turns over a wall that moves: what markers leave of the way along the wall, of the
    turning and between both, with any model or none; no wall of the script need stand there."""
    speed, spin = 0.3, 0.5
    s, c, shorter = max(gap, 0.0) / CELL, 0.5 * CELL / RADIUS, np.log(0.2 * CELL**2 / (VISCOSITY * TIME_STEP))
    resolved = shorter * np.exp(-1.2 * s * (1.0 + s))
    way = max(0.0, 1.85 * np.exp(-s * (1.1 + 2.25 * s)) - 0.15 * resolved
              - 0.113 * shorter * np.exp(s * (1.4 - 2.5 * s)))  # fmt: skip
    tie = (0.39 + 11.2 * c**2) * np.exp(-s * (1.0 + 2.3 * s)) - (0.1 + 1.65 * c**2) * resolved
    tie = min(max(0.0, tie), way)
    turn = (0.485 + 170.0 * c**4) * np.exp(-s * (1.95 + 2.0 * s)) - (0.15 + 60.0 * c**4) * resolved
    turn = max(turn, 0.0, tie**2 / way if way else 0.0)
    arm, across = RADIUS + 0.5 * gap, speed - WALL_SPEED
    scale = 2.0 * np.pi * VISCOSITY * RADIUS
    spheres = (f"create_atoms 2 single 2 {RADIUS + gap} 2 units box\ncreate_atoms 1 single 2 3 2 units box\n"
               f"set atom 1 diameter 1 density 1e5 vx {speed} omegaz {spin}\nset atom 2 diameter 1 density 1000")
    script = SCRIPT.format(boundary="p f p", spheres=spheres, wet="fix fluid all couple/fluid",
                           model=MODELS[model] if model else "", numbers="%.15g " * 2)  # fmt: skip
    script = script.replace("id omegaz f_couple_film[6] f_couple_torque[3]", "id f_couple_film[1] f_couple_film[6]")
    rows = [row.split()[1:] for row in films_of(tmp_path, script, "pmp").splitlines() if row.startswith("1 ")]
    force, torque = np.array(rows, dtype=float)[1]
    assert force == pytest.approx(-scale * (way * across + tie * arm * spin), rel=0.01)
    assert torque == pytest.approx(-arm * scale * (tie * across + turn * arm * spin), rel=0.01)


DUMPED = "x y z vx vy vz omegax omegay omegaz mass radius"


@pytest.mark.parametrize("gap", [0.02, -1e-4])
def test_free_spheres_of_two_sizes_keep_momentum(tmp_path, gap):
    """Two that slide, turn and are of unequal size: no momentum, no angular momentum, energy taken, and the force of
    the formula, with s = v + n x (a w1 + b w2) and e = (chi v + n x (a w1 - b w2))/2."""
    a, b = 0.5, 0.45
    n = np.array([0.6, 0.64, 0.48])  # from sphere 2 to sphere 1
    places = np.array([2.0 + 0.5 * (a + b + gap) * n, 2.0 - 0.5 * (a + b + gap) * n])
    lines = [f"create_atoms {k} single {' '.join(f'{x:.17g}' for x in place)} units box"
             for k, place in zip((1, 2), places, strict=True)]  # fmt: skip
    lines += ["set atom 1 diameter 1 density 1000 vx 0.01 vy -0.02 vz 0.03 omegax 0.3 omegay -0.5 omegaz 0.2",
              "set atom 2 diameter 0.9 density 1000 vx -0.01 vy 0.01 omegax -0.1 omegay 0.4 omegaz 0.6"]  # fmt: skip
    columns = DUMPED + "".join(f" f_couple_film[{k}]" for k in range(1, 7))
    script = SCRIPT.format(boundary="p p p", spheres="\n".join(lines), wet="fix fluid all couple/fluid",
                           model=MODELS["actm"], numbers="%.17g " * 17)  # fmt: skip
    script = script.replace("id omegaz f_couple_film[6] f_couple_torque[3]", f"id {columns}")
    script = script.replace("free nve", "all nve").replace("fix          still held freeze\n", "")
    found = np.array(
        [row.split() for row in films_of(tmp_path, script).splitlines() if row[:2] in ("1 ", "2 ")], dtype=float
    ).reshape(-1, 2, 18)[1, :, 1:]  # of the first step
    x, v, spin, mass = found[:, 0:3], found[:, 3:6], found[:, 6:9], found[:, 9]
    force, torque = found[:, 11:14], found[:, 14:17]
    unit = np.linalg.norm(force[0])
    assert np.allclose(force.sum(0), 0.0, atol=1e-12 * unit)
    assert np.allclose((np.cross(x, force) + torque).sum(0), 0.0, atol=1e-9 * unit)
    assert np.sum(force * v) + np.sum(torque * spin) < 0.0 < np.min(mass)
    arm_1, arm_2, chi = a + 0.5 * gap, b + 0.5 * gap, (a - b) / (a + b + gap)
    across = (v[0] - v[1]) - n * (n @ (v[0] - v[1]))
    slide = across + np.cross(n, arm_1 * spin[0] + arm_2 * spin[1])
    roll = 0.5 * (chi * across + np.cross(n, arm_1 * spin[0] - arm_2 * spin[1]))
    strength, (share_slide, share_roll) = np.pi * VISCOSITY * a * b / (a + b), logarithms(gap)
    expected = -2.0 * strength * share_slide * slide - 2.4 * chi * strength * share_roll * roll
    assert force[0] == pytest.approx(expected, abs=0.01 * unit)


@pytest.mark.parametrize("ranks", [(1, 2), (1, 4), (2, 1)])
def test_the_same_on_any_ranks_and_through_seams(tmp_path, ranks):
    """A chain of three unequal spheres across two periodic seams, all of them free: in any place and on any ranks what
    it is in the middle on one."""
    radii, gaps = (0.5, 0.4, 0.45), (0.02, -1e-4)
    n = np.array([0.6, 0.64, 0.48])
    ways = np.cumsum([0.0, radii[0] + gaps[0] + radii[1], radii[1] + gaps[1] + radii[2]])
    dumps = []
    for name, start, on in (("middle", np.array([1.2, 1.2, 1.3]), (1, 1)), ("seams", np.array([3.7, 1.7, 3.3]), ranks)):
        lines = []
        for k, (way, radius) in enumerate(zip(ways, radii, strict=True), 1):
            place = (start + way * n) % 4.0
            lines += [f"create_atoms {min(k, 2)} single {' '.join(f'{x:.17g}' for x in place)} units box",
                      f"set atom {k} diameter {2 * radius} density 1000 vx {0.02 * k} omegax {0.3 - 0.2 * k} "
                      f"omegaz {0.4 * k}"]  # fmt: skip
        columns = "".join(f" f_couple_film[{k}]" for k in range(1, 7))
        script = SCRIPT.format(boundary="p p p", spheres="\n".join(lines), wet="fix fluid all couple/fluid",
                               model=MODELS["actm"], numbers="%.17g " * 6)  # fmt: skip
        script = script.replace("id omegaz f_couple_film[6] f_couple_torque[3]", f"id{columns}")
        script = script.replace("free nve", "all nve").replace("fix          still held freeze\n", "")
        rows = [row.split() for row in films_of(tmp_path / name, script, ranks=on).splitlines()]
        dumps.append(np.array([row[1:] for row in rows if len(row) == 7 and row[0] in "123"], dtype=float)[3:])
    middle, elsewhere = dumps
    assert len(middle) == 3 * STEPS * SUBSTEPS and np.abs(middle).max() > 0.0
    assert elsewhere == pytest.approx(middle, abs=1e-6 * np.abs(middle).max())


def test_loads_can_be_read_before_there_are_any(tmp_path):
    """As all properties of spheres: zero before the first step, and for spheres that come later."""
    script = SCRIPT.format(boundary="p p p", spheres=pair(0.0125), wet="fix fluid all couple/fluid",
                           model=MODELS["actm"], numbers="%.15g " * 3)  # fmt: skip
    before = "variable film atom f_couple_film[6]\nset atom 2 vx v_film\n"
    between = ("coupled_run steps 1\ncreate_atoms 2 single 1 1 1 units box\nset atom 3 diameter 1 density 1000\n"
               "set atom 3 omegaz v_film\n")  # fmt: skip
    assert "\ncoupled_run" in script
    dump = films_of(tmp_path, script.replace("\ncoupled_run", "\n" + before + between + "coupled_run"))
    spins = [float(row.split()[1]) for row in dump.splitlines() if row.startswith("3 ")]
    assert spins and max(map(abs, spins)) < 1e-6 * SPIN


def test_the_whole_film_where_the_grid_has_none(tmp_path):
    """Between a sphere in the fluid and one that is not: 6 π μ (R/2)² v/ζ; between two in the fluid less than half."""
    gap, speed = 0.04, 1e-3
    forces = {}
    for group in ("free", "all"):
        script = SCRIPT.format(
            boundary="p p p", spheres=pair(gap) + f" vy 0.0\nset atom 1 omegaz 0.0 vy {-speed}",
            wet=f"fix fluid {group} couple/fluid", numbers="%.15g " * 3,
            model=MODELS["actm"] + "\nfix film all lubrication",
        ).replace("f_couple_film[6] f_couple_torque[3]", "f_lubricationForce[2] y")  # fmt: skip
        rows = films_of(tmp_path / group, script).splitlines()
        forces[group] = float([row for row in rows if row.startswith("1 ")][1].split()[2])
    exact = 6.0 * np.pi * VISCOSITY * (0.5 * RADIUS) ** 2 * speed / gap
    assert forces["free"] == pytest.approx(exact, rel=0.01)
    assert abs(forces["all"]) < 0.5 * exact


@pytest.mark.parametrize("tangential, told", [("no_history", True), ("off", False)])
def test_a_contact_model_that_tells_nothing(tmp_path, tangential, told):
    """LIGGGHTS' own combinations that bedload does not register cannot say which spheres are close: a warning."""
    model = f"pair_style gran model hertz tangential {tangential}\npair_coeff * *"
    if tangential != "off":
        model = "fix m5 all property/global coefficientFriction peratomtypepair 2 0.1 0.1 0.1 0.1\n" + model
    script = SCRIPT.format(boundary="p p p", spheres=pair(0.0125), wet="fix fluid all couple/fluid", model=model,
                           numbers="%.15g " * 3)  # fmt: skip
    result = coupled(tmp_path, script)
    assert result.status == 0, result.output
    assert ("contact model is none that bedload knows" in result.output) == told


def test_no_contacts_no_markers_films(tmp_path):
    """Nobody tells which spheres are close: a warning."""
    script = SCRIPT.format(boundary="p p p", spheres=pair(0.0125), wet="fix fluid all couple/fluid", model="",
                           numbers="%.15g " * 3)  # fmt: skip
    result = coupled(tmp_path, script)
    assert result.status == 0, result.output
    assert "there is no pair_style, and only such a pair tells which spheres are close" in result.output
