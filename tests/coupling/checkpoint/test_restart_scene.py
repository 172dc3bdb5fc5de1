"""A run that goes on is the run before: its own settings, variables and groups hold, each difference is
said in a line, and what makes no sense is refused."""

import numpy as np
import pytest

from programs import BIN, command, run
from pocket import SCENE, job, numbers, spoken, two_checkpoints

SCRIPT = (SCENE / "in.liggghts").read_text()


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    return two_checkpoints(tmp_path_factory.mktemp("begun") / "out")


def told(output):
    """What was said of the differences."""
    return [text for text in output.splitlines() if "restart: " in text]


def going_on(begun, tmp_path, *options, text=SCRIPT, steps=1, **more):
    script = tmp_path / "in.liggghts"
    script.write_text(text)
    out = tmp_path / "out"
    result = job(out, "--steps", str(steps), *options, restart=begun, script=script, **more)
    return result, out


def test_nothing_is_said_of_the_same(begun, tmp_path):
    """But for what the command line of the run before said, which holds on."""
    result, _ = going_on(begun, tmp_path)
    assert result.status == 0, result.output
    assert told(result.output) == [
        "bedload-fluid: restart: --set checkpoint.every=0.04 of the run before holds."
    ]


SETTINGS = {
    "fluid.kinematic_viscosity": "0.02",
    "fluid.density": "1.1",
    "boundary.y": '["no_slip","no_slip"]',
    "flow.driving": '"none"',
    "accuracy.precision": '"single"',
    "time.step": "0.01",
    "coupling.exchange": '"step"',
    "coupling.dem_steps": "30",
    "spheres.forcing_loops": "1",
    "statistics.every": "1",
    "output.history_every": "2",
}


@pytest.mark.parametrize("key", SETTINGS)
def test_another_setting_is_said(begun, tmp_path, key):
    result, out = going_on(begun, tmp_path, "--set", f"{key}={SETTINGS[key]}")
    assert result.status == 0, result.output
    words = [text for text in told(result.output) if f"'{key}' is " in text]
    assert len(words) == 1 and ", in the run before " in words[0], result.output
    assert ("speeds jump by some per cent" in words[0]) == (key == "coupling.exchange")
    assert f"{key} = " in (out / "settings.toml").read_text()


def test_another_gravity_is_said(begun, tmp_path):
    text = SCRIPT.replace("gravity 0.5", "gravity 0.6")
    result, _ = going_on(begun, tmp_path, "--set", "fluid.gravity=[0.0,-0.6,0.0]", text=text)
    assert result.status == 0, result.output
    said = "\n".join(told(result.output))
    assert "'fluid.gravity' is " in said and "no more 'fix weight all gravity 0.5" in said


LINES = {
    "material": ("2 0.9 0.9", "2 0.8 0.9"),
    "film": ("lubrication all lubrication", "lubrication all lubrication range 0.2"),
}


@pytest.mark.parametrize("name", LINES)
def test_another_line_of_the_script_is_said(begun, tmp_path, name):
    old, new = LINES[name]
    assert old in SCRIPT
    result, _ = going_on(begun, tmp_path, text=SCRIPT.replace(old, new, 1))
    assert result.status == 0, result.output
    said = told(result.output)
    assert sum("has no more '" in text for text in said) == 1
    assert sum("which the run before had not" in text for text in said) == 1


SPHERES = {
    "one less": ("create_atoms    2 single 3.3 2.0 0.5 units box", ""),
    "one more": ("group           bed", "create_atoms 2 single 0.6 2.2 1.5 units box\nset type 2 diameter 1.0 "
                 "density 2.5\ngroup           bed"),
    "another size": ("set             group all diameter 1.0 density 2.5",
                     "set group all diameter 1.0 density 2.5\nset type 2 diameter 0.9"),
    "another density": ("set             group all diameter 1.0 density 2.5",
                        "set group all diameter 1.0 density 2.5\nset type 2 density 2.6"),
    "elsewhere": ("create_atoms    2 single 3.3 2.0 0.5", "create_atoms 2 single 3.3 2.0 0.6"),
    "another speed": ("velocity        grains set 0.7", "velocity grains set 0.6"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPHERES)
def test_other_spheres_are_refused(begun, tmp_path, name):
    old, new = SPHERES[name]
    assert old in SCRIPT
    result, _ = going_on(begun, tmp_path, text=SCRIPT.replace(old, new))
    assert result.status == 1
    assert "the run before began with 10 spheres" in result.output
    assert "take back what changes them" in result.output


def test_it_goes_on_in_an_overlap_that_no_run_may_begin_with(tmp_path):
    """Atom 10 is driven 0.27 into the bed; at most half of a radius, 0.25, is allowed at the start of a run."""
    moved = SCRIPT.replace("motion grains nve/sphere", "motion grains move linear 0.0 -2.0 0.0 units box")
    script = tmp_path / "in.liggghts"
    script.write_text(moved)
    result = job(tmp_path / "begun", "--steps", "20", script=script)
    assert result.status == 0, result.output
    result, out = going_on(tmp_path / "begun", tmp_path, text=moved, steps=2)
    assert result.status == 0, result.output
    found = numbers(out / "spheres.h5")
    place = found["mobile/position"][(found["mobile/tag"] == 10) & (found["mobile/step"] == 22)][0]
    assert place[1] == pytest.approx(2.0 - 22 * 0.04)


def test_spheres_of_a_dry_run_are_compared_by_what_it_does_not_compute(tmp_path):
    """Another friction gives other places after a dry run; that is no reason to refuse the friction."""
    dry = SCRIPT.replace("map array", "map array sort 0 0").replace(  # to be sorted they need a range
        "fix             fluid",
        "fix dry grains nve/sphere\ntimestep 0.0001\nrun 20\nunfix dry\nfix             fluid")  # fmt: skip
    first = tmp_path / "first.liggghts"
    first.write_text(dry)
    begun = two_checkpoints(tmp_path / "begun", script=first)
    (tmp_path / "speed").mkdir()
    result, _ = going_on(begun, tmp_path / "speed", text=dry.replace("grains set 0.7", "grains set 0.6"))
    assert result.status == 0, result.output
    (tmp_path / "density").mkdir()
    text = dry.replace("diameter 1.0 density 2.5", "diameter 1.0 density 2.6")
    result, _ = going_on(begun, tmp_path / "density", text=text)
    assert result.status == 1
    assert "this script makes spheres of other densities" in result.output


def test_groups_are_found_by_name(begun, tmp_path):
    """LIGGGHTS deals out its bits in the order of the groups: with one more in front, bed and grains
    would change places."""
    same, _ = going_on(begun, tmp_path, steps=2)
    assert same.status == 0, same.output
    (tmp_path / "other").mkdir()
    text = SCRIPT.replace("group           bed", "group other id 3\ngroup           bed")
    result, out = going_on(begun, tmp_path / "other", text=text, steps=2)
    assert result.status == 0, result.output
    a, b = numbers(tmp_path / "out" / "spheres.h5"), numbers(out / "spheres.h5")
    assert a.keys() == b.keys() and set(b["mobile/tag"]) == {9, 10}
    assert np.array_equal(a["mobile/position"], b["mobile/position"])
    assert any("the group 'other' is a new one" in text for text in told(result.output))


HOLD = SCRIPT.replace("group           bed type 1", "variable hold index 0\ngroup bed type 1\n"
                      'if "${hold} == 1" then "group bed type 2"')  # fmt: skip


def test_grains_that_were_held_are_let_go(tmp_path):
    """hold = 1, then hold = 0: the grains move; without a word hold = 1 goes on."""
    lines = HOLD.replace("velocity        grains", "#")
    (tmp_path / "in").write_text(lines)
    first = tmp_path / "first"
    held = ["-var", "hold", "1"]
    result = job(first, "--steps", "2", script=tmp_path / "in", dem_more=held)
    assert result.status == 0, result.output
    for name, more, mobile in (("on", [], set()), ("free", ["-var", "hold", "0"], {9, 10})):
        (tmp_path / name).mkdir()
        result, out = going_on(first, tmp_path / name, text=lines, dem_more=more)
        assert result.status == 0, result.output
        found = numbers(out / "spheres.h5")
        assert set(found.get("mobile/tag", [])) == mobile
        assert any("variable 'hold' is 0" in text for text in told(result.output)) == bool(mobile)


def test_the_runs_own_values_hold(tmp_path):
    """--set and -var of the first run need not be said again, and may be."""
    (tmp_path / "in").write_text(HOLD)
    first, second = tmp_path / "first", tmp_path / "second"
    result = job(first, "--steps", "2", "--set", "fluid.density=1.25", "--set", "output.history_every=1",
                 script=tmp_path / "in")  # fmt: skip
    assert result.status == 0, result.output
    result = job(second, "--steps", "1", "--set", "output.history_every=2", restart=first,
                 script=tmp_path / "in")  # fmt: skip
    assert result.status == 0, result.output
    settings = (second / "settings.toml").read_text()
    assert "fluid.density = 1.25 " in settings and "output.history_every = 2 " in settings
    assert "--set fluid.density=1.25 of the run before holds" in result.output
    third = tmp_path / "third"
    result = job(third, "--steps", "1", restart=second, script=tmp_path / "in")
    assert result.status == 0 and "fluid.density = 1.25 " in (third / "settings.toml").read_text()


def test_a_value_of_several_words_stays_one(tmp_path):
    """A run that goes on is given it as one word, as the first run was; several values stay several."""
    script = tmp_path / "in"
    used = "shell echo ${words} ${first} >> ${out}/said.txt\nnext first\nshell echo ${first} >> ${out}/said.txt\n"
    assert HOLD.count("coupled_run") == 1
    script.write_text(HOLD.replace("coupled_run", f"{used}coupled_run"))
    first = tmp_path / "first"
    result = job(first, "--steps", "1", script=script,
                 dem_more=("-var", "words", "law published", "-var", "first", "1", "2"))  # fmt: skip
    assert result.status == 0, result.output
    second = tmp_path / "second"
    again = job(second, "--steps", "1", restart=first, script=script)
    assert again.status == 0, again.output
    for out in (first, second):
        assert (out / "said.txt").read_text() == "law published 1\n2\n"
    assert not [text for text in told(again.output) if "words" in text or "first" in text]


def test_other_fixed_spheres_without_liggghts(tmp_path):
    (tmp_path / "fluid.toml").write_text((SCENE / "fluid.toml").read_text())
    (tmp_path / "spheres.txt").write_text("1 1 1 0.4\n3 1 1 0.3\n")

    def alone(*options):
        words = [str(BIN / "bedload-fluid"), str(tmp_path / "fluid.toml"), "--out", str(tmp_path / "out")]
        return run(command([*words, "--steps", "1", *options], None), tmp_path)

    result = alone("--set", 'spheres.file="spheres.txt"', "--set", "output.spheres_every=0.5")
    assert result.status == 0, result.output
    assert "'output.spheres_every' is set, but has no effect without mobile spheres" in result.output
    assert alone("--restart", str(tmp_path / "out")).status == 0
    (tmp_path / "spheres.txt").write_text("3 1 1 0.3\n1 1 1 0.4\n")
    result = alone("--restart", str(tmp_path / "out"))
    assert result.status == 1 and "in another order now" in result.output and len(spoken(result.output)) == 1
    (tmp_path / "spheres.txt").write_text("1 1 1 0.45\n3 1 1 0.3\n")
    result = alone("--restart", str(tmp_path / "out"))
    assert result.status == 1 and len(spoken(result.output)) == 1
    assert "fixed spheres" in result.output and "start.file" in result.output
