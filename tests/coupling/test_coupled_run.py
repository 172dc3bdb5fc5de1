"""Both real programs in one job: a small scene with collisions, on several numbers of ranks."""

import re

import h5py
import numpy as np
import pytest

from programs import BIN, SCENES, command, run
from pocket import rows

SCENE = SCENES / "pocket"
LAYOUTS = [(1, 1), (2, 1), (3, 2)]
STEPS = 300
THIRD_TOUCH = 199  # the step, of one of the grains
BOX = np.array([4.0, np.inf, 2.0])  # periods


def job(folder, *fluid_options, ranks=(1, 1), out="out", scene=SCENE):
    fluid = [str(BIN / "bedload-fluid"), str(scene / "fluid.toml"), "--out", out, *fluid_options]
    dem = [str(BIN / "bedload-dem"), "-in", str(scene / "in.liggghts"), "-var", "out", out]
    dem += ["-log", "none"]
    return run(command(fluid, dem, ranks), folder, timeout=300)


def mobile_spheres(folder):
    """Rows in ascending step and tag: step, tag, then position, velocity, spin, force, torque."""
    with h5py.File(folder / "out" / "spheres.h5") as file:
        table = {name: column[:] for name, column in file["mobile"].items()}
    order = np.lexsort((table["tag"], table["step"]))
    names = ("position", "velocity", "angular_velocity", "force", "torque")
    return (
        np.stack([table["step"][order], table["tag"][order]], axis=1),
        np.stack([table[name][order] for name in names], axis=1),
    )


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Output of the scene by rank layout."""
    found = {}
    for ranks in LAYOUTS:
        folder = tmp_path_factory.mktemp(f"ranks{ranks[0]}and{ranks[1]}")
        result = job(folder, "--steps", str(STEPS), ranks=ranks)
        assert result.status == 0, result.output
        found[ranks] = folder
    return found


def test_same_on_all_ranks(folders):
    which, reference = mobile_spheres(folders[(1, 1)])
    assert len(which) == 2 * (STEPS + 1)
    for ranks in LAYOUTS[1:]:
        other_which, other = mobile_spheres(folders[ranks])
        assert np.array_equal(which, other_which)
        apart = np.abs(other - reference)
        across = np.isfinite(BOX)
        apart[:, 0, across] = np.minimum(apart[:, 0, across],
                                         np.abs(BOX[across] - apart[:, 0, across]))
        # Sums over ranks in another order, and another plan of the transforms, round to 1e-16. Steps and a
        # collision or two let it grow some hundredfold (seen: 3e-13 in motion, 1e-12 in forces of size 1 to
        # 10, which are differences of momenta over 1/100). A grain's third and fourth touch make forty
        # times as much of it (seen: 1.1e-11 while it is in contact). A wrong term would show as 1e-3.
        motion, few_touches = apart[:, :3].max(axis=(1, 2)), which[:, 0] < THIRD_TOUCH
        assert motion[few_touches].max() < 5e-12
        assert motion[~few_touches].max() < 1e-10
        assert apart[:, 3:].max() < 1e-9


def test_the_scene_has_what_it_tests(folders):
    """Motion downstream through the periodic face, spin by the shear, collisions with the bed."""
    which, motion = mobile_spheres(folders[(1, 1)])
    for tag in (9, 10):
        path = motion[which[:, 1] == tag]
        assert path[:, 1, 0].max() > 0.9
        assert path[:, 2, 2].min() < -0.01
    path = motion[which[:, 1] == 10]
    assert path[-1, 0, 0] < path[0, 0, 0], "it should have come in again at x = 0"
    assert len(rows(folders[(1, 1)] / "out" / "collisions.csv")) >= 2


def test_momentum_sent_is_momentum_received(folders):
    for folder in folders.values():
        history = rows(folder / "out" / "history.csv")
        assert len(history) == STEPS
        # In double: sums of some 1e4 terms, over their own size.
        assert max(float(row["momentum_residual"]) for row in history) < 1e-13
        assert {int(row["mobile_spheres"]) for row in history} == {2}


def test_a_free_sphere_moves_by_the_force_on_it(folders):
    """m (v_n+1 - v_n) = (F + m g) dt, the force as spheres.h5 has it, as long as nothing is touched
    and the gap is wider than lubrication reaches (sphere 10, the first twenty steps)."""
    which, motion = mobile_spheres(folders[(1, 1)])
    path = motion[which[:, 1] == 10][:21]
    mass = 2.5 * np.pi / 6.0
    change = mass * np.diff(path[:, 1], axis=0) / 0.02
    weight = mass * np.array([0.0, -0.5, 0.0])
    np.testing.assert_allclose(change, path[1:, 3] + weight, rtol=0, atol=1e-11)
    turn = 0.1 * mass * np.diff(path[:, 2], axis=0) / 0.02
    np.testing.assert_allclose(turn, path[1:, 4], rtol=0, atol=1e-11)


@pytest.mark.parametrize(("steps", "ranks"), [(1, (1, 1)), (7, (2, 2))])
def test_exchange_once_per_step(folders, tmp_path, steps, ranks):
    """The sphere that touches nothing moves by the mean load of the stages over the whole step, in one
    exchange; its path is that of an exchange in each stage but for the delay of its motion."""
    result = job(tmp_path, "--steps", "20", "--set", 'coupling.exchange="step"',
                 "--set", f"coupling.dem_steps={steps}", ranks=ranks)  # fmt: skip
    assert result.status == 0, result.output
    which, motion = mobile_spheres(tmp_path)
    path = motion[which[:, 1] == 10]
    mass, dt = 2.5 * np.pi / 6.0, 0.02
    gain = path[1:, 3] / mass + np.array([0.0, -0.5, 0.0])  # acceleration, held for a step
    np.testing.assert_allclose(np.diff(path[:, 1], axis=0), gain * dt, rtol=0, atol=1e-12)
    way = path[:-1, 1] * dt + 0.5 * gain * dt**2
    np.testing.assert_allclose(np.diff(path[:, 0], axis=0), way, rtol=0, atol=1e-12)
    spin = path[1:, 4] * dt / (0.1 * mass)
    np.testing.assert_allclose(np.diff(path[:, 2], axis=0), spin, rtol=0, atol=1e-11)

    history = rows(tmp_path / "out" / "history.csv")
    assert max(float(row["momentum_residual"]) for row in history) < 1e-13
    line = rows(tmp_path / "out" / "timeline.csv")
    assert [row["part"] for row in line].count("grain motion") == 1
    assert "collisions 0" in result.output, "fix collision/table counts, none yet"
    _, each_stage = mobile_spheres(folders[(1, 1)])
    apart = np.abs(path - each_stage[: len(motion)][which[:, 1] == 10])[:, 1].max()
    # The fluid meets the sphere as it was at the begin of the step, a delay of a step's change of speed.
    assert 1e-6 < apart < np.abs(np.diff(path[:, 1], axis=0)).max()


def test_more_steps_of_liggghts(folders, tmp_path):
    """In 30 steps a free sphere goes where it goes in 15, its parabolas being exact, but for what the
    other one's film does to the fluid (seen: 8e-6); a step of the wrong length would show as 1e-2."""
    result = job(tmp_path, "--steps", "20", "--set", "coupling.dem_steps=30")
    assert result.status == 0, result.output
    which, finer = mobile_spheres(tmp_path)
    _, each = mobile_spheres(folders[(1, 1)])
    free = which[:, 1] == 10
    np.testing.assert_allclose(finer[free], each[: len(finer)][free], rtol=0, atol=1e-4)


def test_steps_that_no_stage_divides(tmp_path):
    result = job(tmp_path, "--steps", "1", "--set", "coupling.dem_steps=7")
    assert result.status != 0
    assert "'coupling.dem_steps' is 7, but must be a multiple of 15" in result.output


def one_step_with(folder, change, options):
    """A step of the scene with some lines more in its script, once the spheres are there."""
    script = (SCENE / "in.liggghts").read_text()
    changed = script.replace("group           bed type 1", f"{change}\ngroup bed type 1")
    assert changed != script
    (folder / "in.liggghts").write_text(changed)
    (folder / "fluid.toml").write_text((SCENE / "fluid.toml").read_text())
    return job(folder, "--steps", "1", *options, scene=folder)


@pytest.mark.parametrize(
    ("density", "options", "found"),
    [
        (0.29, (), "density 0.29, but with 'coupling.exchange' = \"stage\""),
        (0.4, ("--set", 'coupling.exchange="step"'), "or exchange in each stage"),
        (0.3, (), None),
        (0.5, ("--set", 'coupling.exchange="step"'), None),
    ],
)
def test_spheres_too_light_for_the_scheme_are_refused(tmp_path, density, options, found):
    result = one_step_with(tmp_path, f"set type 2 density {density}", options)
    assert (result.status == 0) is (found is None), result.output
    assert found is None or found in result.output


THICK = ("--set", "fluid.kinematic_viscosity=0.03")  # boundary layers of more than half a cell
ONE_STEP = (*THICK, "--set", 'coupling.exchange="step"', "--set", "coupling.dem_steps=1")


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        ("set atom 9 diameter 1.0 density 2.5\nset atom 10 diameter 1.0 density 20", ONE_STEP, "8 times the mass"),
        ("set atom 9 diameter 1.0 density 2.5\nset atom 10 diameter 1.0 density 19", ONE_STEP, None),
        ("set atom 9 diameter 1.0 density 2.5\nset atom 10 diameter 1.0 density 20", THICK, None),
        ("set atom 9 diameter 1.0 density 2.5\nset atom 10 diameter 1.0 density 160", THICK, "64 times the mass"),
        # Re = 469 and 252, D/h = 8: 0.37 and 0.504 cells.
        ("set type 2 density 20", (), "a boundary layer D/sqrt(Re) of 0.3"),
        ("set type 2 density 8", (), None),
    ],
)
def test_limits_that_no_number_alone_shows_are_warned_of(tmp_path, change, options, words):
    result = one_step_with(tmp_path, change, options)
    assert result.status == 0, result.output
    # The scene's box is two diameters wide, and its reference is of 2.5.
    others = ("both sides", "'reference.sphere_density' = 2.5")
    warnings = [line for line in result.output.splitlines()
                if "WARNING: " in line and not any(words in line for words in others)]
    assert bool(warnings) is (words is not None)
    assert words is None or words in result.output


def test_time_line_shows_both_programs(folders):
    """Grains move between the sending of their loads and the end of the wait for them."""
    line = rows(folders[(1, 1)] / "out" / "timeline.csv")
    parts = [(row["program"], row["part"]) for row in line]
    assert parts.count(("bedload-dem", "grain motion")) == 3
    assert parts.count(("bedload-fluid", "pressure")) == 3

    def times(part, edge):
        return [float(row[edge]) for row in line if row["part"] == part]

    rounding = 1e-5  # two clocks, one of them read a moment later
    for sent, began, ended, waited in zip(
        times("exchange", "start"), times("grain motion", "start"),
        times("grain motion", "end"), times("waiting for LIGGGHTS", "end"), strict=True,
    ):  # fmt: skip
        assert sent < began + rounding
        assert began <= ended < waited + rounding


def test_single_precision_follows_double(folders, tmp_path):
    result = job(tmp_path, "--steps", "20", "--set", 'accuracy.precision="single"')
    assert result.status == 0, result.output
    _, single = mobile_spheres(tmp_path)
    _, double = mobile_spheres(folders[(1, 1)])
    apart = np.abs(single - double[: len(single)])[:, :3].max()
    # Fields rounded to 6e-8: seen 3e-7 after 20 steps.
    assert 1e-12 < apart < 1e-5


def test_a_run_whose_surfaces_let_fluid_through_warns_at_its_end(tmp_path):
    """Where the reference is a hundredth of the flow's, its slip of some per cent is large."""
    for velocity, large in (("1.0", False), ("0.01", True)):
        folder = tmp_path / velocity
        folder.mkdir()
        result = job(folder, "--steps", "4", "--set", f"reference.velocity={velocity}")
        assert result.status == 0, result.output
        assert ("WARNING: the no-slip error of" in result.output) == large


def test_a_run_ends_with_its_slip_and_what_each_effect_cost(tmp_path):
    verdicts = 'accuracy.verdicts="extra forcing loops: worth it; single precision: answer +0.1 %; else: nothing"'
    result = job(tmp_path, "--steps", "60", "--set", verdicts)
    assert result.status == 0, result.output
    table = result.output.splitlines()
    why = {name: [line for line in table if line.startswith(name)] for name in ("extra forcing", "single pre")}
    assert why["extra forcing"] and all(line.endswith("is 2 (worth it)") for line in why["extra forcing"])
    assert why["single pre"] and all(line.endswith('"double" (answer +0.1 %)') for line in why["single pre"])
    assert "nothing" not in result.output
    found = re.search(r"No-slip error .*: (\S+) \(root mean square\), (\S+) \(largest\); 2 forcing",
                      result.output)
    history = rows(tmp_path / "out" / "history.csv")
    rms = np.sqrt(np.mean([float(r["slip_rms"]) ** 2 for r in history]))
    assert float(found[1]) == pytest.approx(rms, rel=6e-3)
    assert float(found[2]) == pytest.approx(max(float(r["slip_max"]) for r in history), rel=6e-3)
    # The parts of the markers' time are told apart and add up to it, but for the sums over ranks.
    share = {name: float(value) for name, value in
             re.findall(r"^(\w[\w ]*?) +on +(\d+\.\d)%", result.output, re.MULTILINE)}
    parts = ("immersed boundary", "moving boundary", "interior term", "extra forcing loops")
    assert all(share[name] > 0.0 for name in parts)
    markers = float(re.search(r"^markers .* (\d+\.\d)%", result.output, re.MULTILINE)[1])
    # A tenth more: steps of milliseconds each, two clocks inside one another. Sixty of them, as the first placing,
    # before the first step, is not in the markers' time.
    assert 0.5 * markers < sum(share[name] for name in parts) < 1.1 * markers + 0.5
    assert share["grain motion"] > 0.0


def test_fluid_alone_needs_no_liggghts(tmp_path):
    fluid = [str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--steps", "5"]
    check_sentence(run(command(fluid, None, (2, 0)), tmp_path), ["in.liggghts", "--without-grains"])
    result = run(command([*fluid, "--without-grains"], None, (2, 0)), tmp_path)
    assert result.status == 0, result.output
    out = tmp_path / "runs" / "pocket"
    assert (out / "state.h5").is_file() and not (out / "spheres.h5").exists()


FIXED = [(x + 0.5, 0.5, z + 0.5) for x in range(4) for z in range(2)]


def test_fixed_spheres_need_no_liggghts(tmp_path):
    """The fluid reads them itself: the same flow as with LIGGGHTS and a script that moves nothing."""
    scene = tmp_path / "scene"
    scene.mkdir()
    text = (SCENE / "fluid.toml").read_text()
    (scene / "fluid.toml").write_text(text.replace("[spheres]", '[spheres]\nfile = "bed.txt"'))
    lines = ["# x y z radius"] + ["{}, {} {} 0.5  # one".format(*place) for place in FIXED]
    (scene / "bed.txt").write_text("\n".join(lines) + "\n")
    fluid = [str(BIN / "bedload-fluid"), str(scene / "fluid.toml"), "--steps", "10"]
    result = run(command([*fluid, "--out", "alone"], None, (2, 0)), tmp_path)
    assert result.status == 0, result.output

    script = (SCENE / "in.liggghts").read_text().splitlines()
    (scene / "in.liggghts").write_text(
        "\n".join(line for line in script if not line.startswith(("create_atoms    2", "velocity"))))
    dem = [str(BIN / "bedload-dem"), "-in", str(scene / "in.liggghts"), "-log", "none"]
    fluid = [str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--steps", "10"]
    result = run(command([*fluid, "--out", "both"], [*dem, "-var", "out", "both"]), tmp_path)
    assert result.status == 0, result.output
    alone, both = (rows(tmp_path / out / "history.csv") for out in ("alone", "both"))
    for name in ("driving", "kinetic_energy", "slip_rms"):
        found, wanted = (np.array([float(row[name]) for row in table]) for table in (alone, both))
        # Ten steps of sums in another order; without the spheres driving and slip would be 0.
        np.testing.assert_allclose(found, wanted, rtol=1e-9)
        assert np.all(wanted != 0.0)


@pytest.mark.parametrize(
    "text, found",
    [
        ("0.5 0.5 0.5 0.5\n1 2 3\n", ["line 2", "3 numbers", "x y z radius"]),
        ("0.5 0.5 half 0.5\n", ["line 1", "'half'"]),
        ("0.5 0.5 0.5 0.1\n", ["line 1", "0.1", "4 cells"]),
        ("0.5 4.5 0.5 0.5\n", ["line 1", "y = 4.5", "0 to 3"]),
        ("# nothing\n", ["no sphere"]),
        (None, ["bed.txt", "opened"]),
    ],
    ids=["three numbers", "a word", "too small", "outside", "empty", "missing"],
)
def test_mistakes_in_a_file_of_spheres(tmp_path, text, found):
    toml = (SCENE / "fluid.toml").read_text()
    (tmp_path / "fluid.toml").write_text(toml.replace("[spheres]", '[spheres]\nfile = "bed.txt"'))
    if text is not None:
        (tmp_path / "bed.txt").write_text(text)
    check_sentence(run(command([str(BIN / "bedload-fluid"), "fluid.toml"], None), tmp_path), found)


@pytest.mark.parametrize(
    "options, found",
    [
        (("--set", "time.stepp=1"), ["time.stepp", "'time.step'"]),
        (("--set", "fluid.gravity=[0.0,-0.7,0.0]"), ["(0, -0.7, 0)", "(0, -0.5, 0)"]),
        (("--set", "time.step=0.1"), ["CFL", "'time.step'"]),
        (("--stepps", "3"), ["--stepps"]),
        (("--set", 'spheres.file="bed.txt"'), ["'spheres.file'", "bed.txt", "alone"]),
    ],
    ids=["unknown key", "gravity", "field blows up", "unknown option", "spheres twice"],
)
def test_a_mistake_ends_both_programs_with_one_sentence(tmp_path, options, found):
    check_sentence(job(tmp_path, *options, ranks=(2, 2)), found)


def test_a_folder_that_cannot_be_made(tmp_path):
    check_sentence(job(tmp_path, ranks=(2, 2), out="/proc/none"), ["/proc/none"])


def check_sentence(result, found):
    assert result.status != 0
    spoken = [line for line in result.output.splitlines() if line.startswith("bedload-fluid: ")]
    assert len(spoken) == 1, result.output
    for text in found:
        assert text in spoken[0]


def test_liggghts_follows_a_time_step_that_follows_the_flow(tmp_path):
    """With time.cfl the step changes; each free sphere still moves by F dt of its own step."""
    options = ("--steps", "20", "--set", "time.cfl=0.35", "--set", "time.step=0.04")
    result = job(tmp_path, *options)
    assert result.status == 0, result.output
    history = rows(tmp_path / "out" / "history.csv")
    step = np.array([float(row["dt"]) for row in history])
    time = np.array([float(row["time"]) for row in history])
    assert len(set(step)) >= 2
    assert step.max() < 0.04
    np.testing.assert_allclose(np.diff(time), step[1:], rtol=1e-9)
    # cfl is that of the row's step: at most what was asked for, at least a rung below; the first one began with the
    # start's speed, however long it is.
    cfl = np.array([float(row["cfl"]) for row in history])
    assert job(tmp_path, "--steps", "1", "--set", "time.step=0.005", out="short").status == 0
    short = rows(tmp_path / "short" / "history.csv")[0]
    assert cfl[0] / step[0] == pytest.approx(float(short["cfl"]) / 0.005, rel=1e-12)
    assert 0.35 / 2 ** (1 / 16) < cfl.min() <= cfl.max() < 0.35 * (1 + 1e-9)
    which, motion = mobile_spheres(tmp_path)
    path = motion[which[:, 1] == 10]
    mass = 2.5 * np.pi / 6.0
    change = mass * np.diff(path[:, 1], axis=0) / step[:, None]
    weight = mass * np.array([0.0, -0.5, 0.0])
    np.testing.assert_allclose(change, path[1:, 3] + weight, rtol=0, atol=1e-11)
    assert max(float(row["momentum_residual"]) for row in history) < 1e-13


@pytest.mark.parametrize(("every", "steps", "samples"), [(0.0, 10, 11), (0.06, 10, 4), (0.1, 15, 4), (0.101, 15, 4)])
def test_says_how_large_the_samples_become(tmp_path, every, steps, samples):
    """Before the first step, and so it is: steps of 0.02, the start among the samples, 152 B a grain. 0.3/0.1 is less
    than 3, and half a step before it is due a sample is taken. A run that goes on adds its own."""
    def check(samples, *options):
        result = job(tmp_path, "--set", f"output.spheres_every={every}", *options)
        found = re.search(r"grow by (\S+) MB: 2 mobile spheres, (\d+) samples of 0.304 kB .* moves (\S+) of reference",
                          result.output)
        assert found, result.output
        said = [float(word) for word in found.groups()]
        assert said == pytest.approx([2 * 152e-6 * samples, samples, max(every, 0.02)], rel=1e-2)
        which, _ = mobile_spheres(tmp_path)
        return len(np.unique(which[:, 0]))

    assert check(samples, "--set", f"time.end={0.02 * steps!r}") == samples
    if every == 0.1:
        assert check(3, "--set", "time.end=0.6", "--restart", "out") == samples + 3
