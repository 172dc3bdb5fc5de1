"""What a LIGGGHTS script may hold beside the fluid, and what it reads of it: mean loads in thermo output,
spheres that move as prescribed, no pair style."""

import h5py
import numpy as np
import pytest

from pocket import SCENE, job, numbers

MOTION = "fix             motion grains nve/sphere"
DT = 0.02


def run_script(folder, *changes, options=("--steps", "5"), ranks=(1, 1)):
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    for found, given in changes:
        assert found in text
        text = text.replace(found, given)
    folder.mkdir(exist_ok=True)
    (folder / "in.liggghts").write_text(text, encoding="utf-8")
    return job(folder / "out", *options, script=folder / "in.liggghts", ranks=ranks)


@pytest.mark.parametrize("exchange", ["stage", "step"])
def test_thermo_shows_the_mean_of_the_step(tmp_path, exchange):
    """f_fluid[1..6] against the means in spheres.h5; f_fluid[7..12] is the last stage's, another number: the sum of
    what each sphere has."""
    words = " ".join(f"${{f{n}}}" for n in range(1, 19))
    held = " ".join(f"f_couple_{name}[{n}]" for name in ("force", "torque") for n in (1, 2, 3))
    variables = "\n".join([f"compute held all reduce sum {held}"]
                          + [f"variable f{n} equal f_fluid[{n}]" for n in range(1, 13)]
                          + [f"variable f{n + 12} equal c_held[{n}]" for n in range(1, 7)])
    lines = f'{variables}\nfix loads all print 15 "{words}" file ${{out}}/loads.txt screen no title "loads"\n'
    result = run_script(tmp_path, ("thermo ", lines + "thermo "), ranks=(1, 2),
                        options=("--steps", "5", "--set", f"coupling.exchange={exchange}",
                                 "--set", f"output.spheres_every={DT}"))  # fmt: skip
    assert result.status == 0, result.output
    # The first row is printed before the first step.
    shown = np.loadtxt(tmp_path / "out" / "loads.txt", skiprows=1)[-5:]
    spheres = numbers(tmp_path / "out" / "spheres.h5")
    for n, step in enumerate(range(1, 6)):
        now = spheres["mobile/step"] == step
        wanted = np.concatenate([spheres[f"mobile/{name}"][now].sum(axis=0) for name in ("force", "torque")])
        np.testing.assert_allclose(shown[n, :6], wanted, rtol=1e-5, atol=1e-6)  # printed with 6 digits
        np.testing.assert_allclose(shown[n, 6:12], shown[n, 12:], rtol=1e-5, atol=1e-6)
        assert np.abs(shown[n, 6:9]).max() > 1e-3 and np.abs(shown[n, 9:12]).max() > 1e-4
        stage = np.abs(shown[n, 6:9] - wanted[:3]).max() / np.abs(wanted[:3]).max()
        assert bool(stage > 1e-3) is (exchange == "stage")


def test_spheres_that_move_as_prescribed(tmp_path):
    """x = x0 + v t, in the fluid as in LIGGGHTS; the fluid sees the velocity."""
    result = run_script(tmp_path, (MOTION, "fix motion grains move linear 0.5 0.0 0.0 units box"))
    assert result.status == 0, result.output
    with h5py.File(tmp_path / "out" / "spheres.h5") as file:
        mobile = {name: data[:] for name, data in file["mobile"].items()}
    for tag, start in ((9, 1.95), (10, 3.3)):
        own = mobile["tag"] == tag
        np.testing.assert_allclose(mobile["position"][own, 0], start + 0.5 * mobile["time"][own], rtol=1e-12)
        np.testing.assert_allclose(mobile["velocity"][own][1:], [[0.5, 0.0, 0.0]] * 5, atol=1e-14)
        assert (np.abs(mobile["force"][own][1:, 0]) > 1e-3).all()


@pytest.mark.parametrize("setting", ["time.step=0.01", "coupling.dem_steps=30"])
def test_prescribed_motion_goes_on_with_the_step_that_it_counts(tmp_path, setting):
    """LIGGGHTS places spheres at (steps since the move began) x (step): with another one they would jump."""
    script = (MOTION, "fix motion grains move linear 0.5 0.0 0.0 units box")
    assert run_script(tmp_path, script).status == 0
    again = {"script": tmp_path / "in.liggghts", "restart": tmp_path / "out"}
    other = job(tmp_path / "other", "--steps", "2", "--set", setting, **again)
    assert other.status != 0
    assert "fix move (motion) counts LIGGGHTS' steps, which were 0.00133333 long" in other.output
    assert job(tmp_path / "same", "--steps", "2", **again).status == 0
    with h5py.File(tmp_path / "same" / "spheres.h5") as file:
        mine = file["mobile/tag"][:] == 9
        time, x = (file[f"mobile/{name}"][:][mine] for name in ("time", "position"))
    np.testing.assert_allclose(x[:, 0], 1.95 + 0.5 * time, rtol=1e-12)


def test_a_script_that_waits_for_what_never_comes_ends(tmp_path):
    """A loop around coupled_run goes round for ever when the fluid has ended, and fills its log."""
    loop = "label again\ncoupled_run steps 2\njump SELF again\n"
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    result = run_script(tmp_path, (text[text.rindex("coupled_run"):], loop))
    assert result.status == 0, result.output
    assert "asked 10000 times for a coupled_run since the fluid has ended, and ends here" in result.output
    assert numbers(tmp_path / "out" / "spheres.h5")["mobile/step"].max() == 5


@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)])
def test_quit_behind_the_last_run_ends_a_complete_one(tmp_path, ranks):
    result = run_script(tmp_path, ("\ncoupled_run", "\ncoupled_run\nquit"), ranks=ranks)
    assert result.status == 0 and "before the fluid" not in result.output, result.output
    assert numbers(tmp_path / "out" / "spheres.h5")["mobile/step"].max() == 5


def test_an_error_behind_the_last_run_is_one(tmp_path):
    result = run_script(tmp_path, ("\ncoupled_run", "\ncoupled_run\nfix more all nonsense"))
    assert result.status != 0 and "nonsense" in result.output


def test_an_average_over_a_group_holds_the_loads(tmp_path):
    """Two grains of equal mass at equal speed stay at equal speed across."""
    grains = "velocity        grains set 0.7 -0.6 0.05 units box"
    films = "fix             lubrication all lubrication\n"
    result = run_script(tmp_path, (grains, grains.replace("0.7 -0.6", "0.5 0.0")), (films, ""),
                        ("\ncoupled_run", "\nfix even grains aveforce NULL 0 0\ncoupled_run"))  # fmt: skip
    assert result.status == 0, result.output
    found = numbers(tmp_path / "out" / "spheres.h5")
    last = found["mobile/velocity"][found["mobile/step"] == 5]
    assert abs(last[0, 1]) > 1e-3  # buoyant weight and drag act
    np.testing.assert_allclose(last[0, 1:], last[1, 1:], rtol=1e-12)


def test_buoyancy_is_not_given_twice(tmp_path):
    result = run_script(tmp_path, ("\ncoupled_run", "\nfix lift grains buoyancy density 1 level 3 dim y\ncoupled_run"))
    assert result.status == 0, result.output
    assert "fix buoyancy (id lift) gives it once more" in result.output


def test_a_grain_that_grows_is_warned_of_once(tmp_path):
    """Its diameter differs from the reference's in each step, by another number."""
    grows = "variable size equal 1-1e-4*step\nfix grow grains adapt 1 atom diameter v_size\ncoupled_run"
    result = run_script(tmp_path, ("\ncoupled_run", "\n" + grows))
    assert result.status == 0, result.output
    assert result.output.count("WARNING: " + str(SCENE / "fluid.toml") + ": 'reference.diameter' = 1") == 1


def test_an_overlap_that_a_run_comes_to_names_its_step(tmp_path):
    moved = "coupled_run steps 2\ngroup one id 10\nset group one x 2.05 y 1.8 z 1.1\ncoupled_run"
    result = run_script(tmp_path, ("\ncoupled_run", "\n" + moved))
    assert result.status != 0
    assert "step 3: of spheres that came or changed, atoms 9 and 10" in result.output


def test_no_step_has_no_slip_to_be_told(tmp_path):
    result = run_script(tmp_path, options=("--set", "time.end=0.0"))
    assert result.status == 0, result.output
    assert "fluid passes through the spheres" not in result.output


def test_a_frozen_sphere_with_a_speed_goes_on_and_is_said(tmp_path):
    stop = "coupled_run steps 2\nunfix hold\nfix stop all freeze\ncoupled_run"
    result = run_script(tmp_path, ("\ncoupled_run", "\n" + stop))
    assert result.status == 0, result.output
    assert "has a speed and a fix freeze" in result.output


def test_prescribed_motion_wants_one_time_step(tmp_path):
    """Refused before the first step, also where the limit is so wide that no step is shortened for long."""
    for limit in ("0.35", "1.6"):
        result = run_script(tmp_path / limit, (MOTION, "fix motion grains move linear 0.5 0.0 0.0 units box"),
                            options=("--steps", "20", "--set", f"time.cfl={limit}"))  # fmt: skip
        assert result.status != 0
        assert "fix move (motion) knows one time step only" in result.output
        assert not (tmp_path / limit / "out" / "history.csv").exists()


RAMP = 'variable share equal ramp(0,1)\nfix share all print 15 "${share}" file ${out}/share.txt screen no title t\n'


@pytest.mark.parametrize(
    ("runs", "options", "shares"),
    [
        ("coupled_run", (), [0.2, 0.4, 0.6, 0.8, 1.0]),
        ("coupled_run steps 2\ncoupled_run", (), [0.5, 1.0, 1 / 3, 2 / 3, 1.0]),
        ("coupled_run steps 2\nunfix share\ncoupled_run", ("--set", "time.cfl=0.35"), [0.5, 1.0]),
    ],
    ids=["time.end", "steps", "cfl"],
)
def test_a_ramp_knows_the_end(tmp_path, runs, options, shares):
    """It goes from 0 to 1 over each coupled run, also when the run is begun anew in the middle."""
    script = ("coupled_run", RAMP + runs)
    end = ("--set", f"time.end={5 * DT}", "--set", f"checkpoint.every={3 * DT}", *options)
    result = run_script(tmp_path, script, options=end)
    assert result.status == 0, result.output
    shown = np.loadtxt(tmp_path / "out" / "share.txt", skiprows=1, ndmin=1)
    shown = shown[shown > 0.0]  # 0 is printed when a run begins, or not
    np.testing.assert_allclose(shown, shares, rtol=1e-5)
    if options:
        return
    again = tmp_path / "again"
    result = job(again, restart=tmp_path / "out" / "checkpoint_00000003", script=tmp_path / "in.liggghts")
    assert result.status == 0, result.output
    shown = np.loadtxt(again / "share.txt", skiprows=1, ndmin=1)
    np.testing.assert_allclose(shown[-2:], shares[-2:], rtol=1e-5)


def test_no_pair_style_is_needed(tmp_path):
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    without = [line for line in text.splitlines()
               if not line.startswith(("pair_", "fix             lubrication", "fix             floor",
                                       "fix             table"))]  # fmt: skip
    result = run_script(tmp_path, (text, "\n".join(without) + "\n"))
    assert result.status == 0, result.output
    assert "collisions" in result.output and "no pair_style" in result.output


@pytest.mark.parametrize(
    ("modify", "warns"),
    [("delay 0", False), ("delay 0 every 100000", True), ("delay 0 every 100000 check no", True),
     ("delay 0 every 1 check no", False), ("delay 0 once yes", True)],
)  # fmt: skip
def test_lists_that_outlive_the_skin_are_told_of(tmp_path, modify, warns):
    """A grain passes half the skin, 0.275, within 10 steps of 0.03; contacts would be missed later."""
    result = run_script(tmp_path, (MOTION, "fix motion grains move linear 1.5 0.0 0.0 units box"),
                        ("delay 0", modify), options=("--steps", "14"))  # fmt: skip
    assert result.status == 0, result.output
    assert ("contacts may be missed" in result.output) is warns


def test_contacts_have_the_fluids_time(tmp_path):
    """Also where LIGGGHTS has been at work before the fluid began."""
    unsorted = ("map array", "map array sort 0 0")
    dry = ("fix             fluid", "timestep 1e-3\nrun 2000\nfix             fluid")
    lines = []
    for name, changes in (("plain", [unsorted]), ("changed", [unsorted, dry])):
        result = run_script(tmp_path / name, *changes, options=("--steps", "180"))
        assert result.status == 0, result.output
        out = tmp_path / name / "out"
        tables = [np.genfromtxt(out / table, delimiter=",", names=True) for table in
                  ("collisions.csv", "collisions_open.csv")]  # fmt: skip
        lines.append([np.atleast_1d(table[column]) for table in tables for column in table.dtype.names])
    assert len(lines[0][0]) > 1
    for plain, changed in zip(*lines):
        assert changed == pytest.approx(plain, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("change, words", [
    (("fix             fluid all couple/fluid fixed bed", "fix fluid grains couple/fluid"),
     ["atom 1 (and others perhaps) is not in its group", "the fluid goes through it"]),
    (("couple/fluid fixed bed", "couple/fluid"), ["is mobile and held by a fix freeze", "behind 'fixed'"]),
], ids=["spheres without the fluid", "mobile and frozen"])  # fmt: skip
def test_groups_that_are_hardly_meant_are_warned_of(tmp_path, change, words):
    result = run_script(tmp_path, change, options=("--steps", "2"))
    assert result.status == 0, result.output
    for word in words:
        assert word in result.output


def test_a_clock_set_back_between_two_runs_is_refused(tmp_path):
    """Contacts under way would begin anew."""
    change = ("1500\ncoupled_run", "1500\ncoupled_run steps 2\nreset_timestep 0\ncoupled_run")
    result = run_script(tmp_path, change, options=("--steps", "4"))
    assert result.status != 0
    assert "is at step 0, but the coupled_run before ended with step 30" in result.output


def test_a_sphere_moved_by_two_fixes_is_refused(tmp_path):
    result = run_script(tmp_path, (MOTION, f"{MOTION}\nfix again all nve/sphere"), options=("--steps", "2"))
    assert result.status != 0
    assert "is moved by two fixes, nve/sphere (id motion) and nve/sphere (id again)" in result.output


@pytest.mark.parametrize("substeps, warned", [(15, True), (45, False)])
def test_steps_too_long_for_a_stiff_contact_are_warned_of(tmp_path, substeps, warned):
    """T_R = pi/2 sqrt(2.5/1.923e6)/0.92553 = 1.935e-3: a step of 0.02/15 is 69 % of it, one of 0.02/45 is 23 %."""
    elastic = ("fix m3 all property/global youngsModulus peratomtype 5e6 5e6\n"
               "fix m4 all property/global poissonsRatio peratomtype 0.3 0.3\nfix             m1")  # fmt: skip
    changes = (("fix             m1", elastic), ("model actm tangential haff_werner", "model hertz tangential off"))
    result = run_script(tmp_path, *changes, options=("--steps", "1", "--set", f"coupling.dem_steps={substeps}"))
    assert result.status == 0, result.output
    sentence = "is 69 % of the shortest Rayleigh time of the spheres (0.00194)"
    assert (sentence in result.output and "'coupling.dem_steps' of fluid.toml to 45" in result.output) == warned


def test_a_warning_that_begins_in_the_next_line_arrives(tmp_path):
    """As LIGGGHTS' own of contact models that it was not compiled for."""
    lines = 'print "WARNING: "\nprint "  of this"\nprint "of nothing"\nthermo '
    result = run_script(tmp_path, ("thermo ", lines), options=("--steps", "1"))
    assert result.status == 0, result.output
    assert "bedload-dem: WARNING: of this" in result.output and "of nothing" not in result.output
