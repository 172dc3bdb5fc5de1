"""`./bedload study models`: which runs it makes, which it leaves alone, which it goes on with."""

import argparse
import re

import numpy as np
import pytest
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import INPUTS, Scene, find_scene
from bedload_post.outputs import MissingOutput, Run
from bedload_studies import made_by, models, threshold
from synthetic import wandering_story, write_run


def options(*words):
    parser = argparse.ArgumentParser()
    models.add_options(parser)
    return parser.parse_args(list(words))


def test_setup2_has_one_run_a_model(tmp_path):
    asked = options("--out", str(tmp_path))
    runs = models.members(asked, find_scene("setup2_small"))
    assert [m.out.name for m in runs] == [
        f"setup2_small-{m}" for m in ("bed", "rpm", "rpm_hw", "actm", "actm_hw")
    ]
    assert all(m.overrides({}) == [] for m in runs)
    assert [m.variables() for m in runs] == [{"placing": "none"}, {}, {}, {}, {}]
    duct = options("--set", 'boundary.z="no_slip"')  # whose side walls leave the bed no friction velocity
    assert all(member.grains for member in models.members(duct, find_scene("setup2_small")))
    alone = models.members(options("--no-bed"), find_scene("setup2_small"))
    assert [m.model for m in alone] == ["rpm", "rpm_hw", "actm", "actm_hw"]


def test_what_is_given_twice_is_one_run():
    given = options("--no-bed", "--models", "actm", "rpm", "actm", "--densities", "1.75", "1.25", "1.750")
    runs = models.members(given, find_scene("setup1_small"))
    assert [(m.density, m.model) for m in runs] == [(1.75, "actm"), (1.75, "rpm"), (1.25, "actm"), (1.25, "rpm")]


def test_variables_reach_the_bed_without_grains():
    """Another box, say; not the keywords of a collision model, which would be another's."""
    scene = find_scene("setup2_small")
    given = {"length_x": "52", "placing": "pocket", "contact_settings": "slope 3"}
    words = [word for name, value in given.items() for word in ("--var", f"{name}={value}")]
    bed, rpm = models.members(options("--models", "rpm", *words), scene)
    assert bed.variables() == {"length_x": "52", "placing": "none"} and not bed.grains
    assert rpm.variables() == given
    with pytest.raises(UserError, match="no variable of setup2_small's in.liggghts 'lenght_x'"):
        models.members(options("--var", "lenght_x=52"), scene)


@pytest.mark.parametrize(
    ("words", "sentence"), [(["--beside", "nowhere"], "nowhere"), (["--remarks", "nothing.html"], "which is no file")]
)
def test_what_a_report_takes_in_is_looked_for_before_the_runs(monkeypatch, words, sentence):
    monkeypatch.setattr(models, "run_member", lambda *_: pytest.fail("a run was started"))
    with pytest.raises((UserError, MissingOutput), match=sentence):
        models.run(options(*words))


def test_each_model_gets_the_variables_that_its_script_reads():
    scene = find_scene("setup2_small")
    words = ("--no-bed", "--models", "rpm", "actm", "--var", "film_range=0.1", "--var", "friction=0.2")
    rpm, actm = models.members(options(*words), scene)
    assert rpm.variables() == {"friction": "0.2"}
    assert actm.variables() == {"friction": "0.2", "film_range": "0.1"}
    with pytest.raises(UserError, match="reads film_range with model rpm"):
        models.members(options("--no-bed", "--models", "rpm", "--var", "film_range=0.1"), scene)


def test_setup1_varies_the_density_alone(tmp_path):
    scene = find_scene("setup1_small")
    runs = models.members(options("--scene", "setup1_small", "--out", str(tmp_path)), scene)
    assert len(runs) == 12
    settings = models.settings_of(scene, [])
    # g D/u_b^2 of Setup II's grains and fluid: 1.1 (Re_D,II/Re_D,I)^2, Re_D = u_b D/nu.
    same = 1.1 * ((3010 / 9) / (4449 / 12)) ** 2
    assert settings["fluid"]["gravity"] == [0.0, pytest.approx(-same, rel=5e-4), 0.0]
    assert float(scene.variables()["gravity"]) == -settings["fluid"]["gravity"][1]
    for member in runs:
        assert member.overrides(settings) == [f"reference.sphere_density={member.density}"]
        assert member.variables() == {"density": repr(member.density)}
    assert {m.density for m in runs} == {1.25, 1.75, 2.25}
    light = models.members(options("--scene", "setup1_small", "--gravity", "0.66"), scene)[0]
    assert "fluid.gravity=[0.0, -0.66, 0.0]" in light.overrides(settings)
    assert light.variables()["gravity"] == "0.66"


def test_cells_refine_the_same_scene():
    """Twice the cells, half the step: 26 x 10 x 13 D."""
    scene = find_scene("setup2_small")
    asked = options("--cells", "20", "--flow-throughs", "10", "--discard", "2", "--set", "time.end=3")
    words = models.asked_settings(asked, scene)
    assert words == [
        "grid.cells=[520, 200, 260]", "time.step=0.0325", "time.end=312.0", "statistics.from=52.0",
        "time.end=3",
    ]  # fmt: skip
    assert models.asked_settings(options(), scene) == []


def test_length_and_grid_follow_the_box_that_is_set():
    """Twice as long: a flow-through takes 52 D/u_b at u_b = 1, 26 at 2; a cell of D/20 has half the step still."""
    scene = find_scene("setup2_small")
    box = "grid.length=[52.0, 10.0, 13.0]"
    asked = options("--cells", "20", "--flow-throughs", "10", "--discard", "2", "--set", box)
    assert models.asked_settings(asked, scene) == [
        "grid.cells=[1040, 200, 260]", "time.step=0.0325", "time.end=624.0", "statistics.from=104.0", box,
    ]  # fmt: skip
    fast = options("--flow-throughs", "10", "--discard", "2", "--set", box, "--set", "reference.velocity=2.0")
    assert models.asked_settings(fast, scene)[:2] == ["time.end=312.0", "statistics.from=52.0"]


def test_records_of_different_makers_are_not_mixed(tmp_path):
    made = {"commit": "a1", "programs": "p", "scene": "s", "model": "rpm"}
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        made_by.note(tmp_path / name, made)
        made_by.note(tmp_path / name, made)  # goes on
    outs = [tmp_path / "one", tmp_path / "two"]
    assert made_by.of_all(outs) == "a1"
    with pytest.raises(UserError, match="one was begun with the programs p, and this is q"):
        made_by.note(outs[0], made | {"programs": "q"})
    with pytest.raises(UserError, match="the commit a1, and this is b2.*--other-commit goes on"):
        made_by.note(outs[0], made | {"commit": "b2"}, other_commit=False)
    with pytest.raises(UserError, match="the commit a1, and this is b2.*without the folder.$"):
        made_by.note(outs[0], made | {"commit": "b2"})  # a study without that option
    made_by.note(outs[0], made | {"commit": "b2"}, other_commit=True)
    with pytest.raises(UserError, match="differ in the commit.*one: a1, b2; two: a1"):
        made_by.of_all(outs)
    assert made_by.of_all(outs, other_commit=True) == "a1, b2, a1"


def test_grains_begin_where_an_earlier_run_left_them(tmp_path, started):
    """Tags behind the bed's spheres; flow and grains of the run of the same name."""
    before, now = tmp_path / "before", tmp_path / "now"
    old = Run(write_run(before / "setup2_small-actm", wandering_story()))
    scene = find_scene("setup2_small")
    member = models.members(options("--out", str(now), "--models", "actm", "--no-bed"), scene)[0]
    ranks = job.Ranks(1, 1)
    with pytest.raises(UserError, match="setup2_small-actm has no state.h5"):
        models.run_member(member, ranks, [], before)
    (old.folder / "state.h5").touch()
    models.run_member(member, ranks, [], before)
    line = started[-1]
    assert f'start.file="{old.folder / "state.h5"}"' in line
    assert line[line.index("placing") + 1] == "placed"
    text = (now / "setup2_small-actm" / "grains.liggghts").read_text().splitlines()
    bed = len(old.fixed_spheres()[1])
    last = [*old.sample_blocks()][-1]
    assert [float(word) for word in text[1].split()[3:6]] == pytest.approx(last.position[-1], abs=1e-15)
    assert text[2].split()[:3] == ["set", "atom", str(bed + 1)]
    assert len(text) == 3


def test_floating_grains_are_refused(tmp_path):
    with pytest.raises(UserError, match="must sink"):
        models.members(options("--densities", "0.9"), find_scene("setup2_small"))


def test_the_paper_has_one_density_and_gravity_of_setup_2():
    """Its Table 2 says nothing of heavier grains."""
    assert models.setup_of("setup2_small", None) == models.setup_of("setup2_small", options()) == 2
    assert models.setup_of("setup2_small", options("--densities", "1.2")) == 2
    assert models.setup_of("setup2_small", options("--densities", "1.2", "2.0")) == 0
    assert models.setup_of("setup2", options("--gravity", "0.5")) == 0
    assert models.setup_of("setup1", options("--densities", "1.5")) == 1
    assert models.setup_of("exposed_sphere", options()) == 0


def test_set_reaches_what_follows_from_it():
    settings = models.settings_of(find_scene("setup2_small"), ["time.end=3", "fluid.density = 2.0"])
    assert settings["time"]["end"] == 3
    assert settings["fluid"]["density"] == 2.0
    assert settings["time"]["step"] > 0


LEAST = """\
[grid]
cells = [60, 20, 20]
length = [6.0, 2.0, 2.0]
[fluid]
kinematic_viscosity = 0.01
[time]
step = 0.01
end = 9.0
[statistics]
from = 3.0
[reference]
sphere_density = 1.5
"""


def scene_of(folder, text):
    (folder / "fluid.toml").write_text(text)
    return Scene(folder)


def test_what_a_scene_leaves_out_has_its_default(tmp_path):
    scene = scene_of(tmp_path, LEAST)
    settings = models.settings_of(scene, ["reference.velocity=2.0"])
    assert settings["reference"] == {"velocity": 2.0, "height": 1.0, "diameter": 1.0, "sphere_density": 1.5}
    asked = options("--cells", "20", "--flow-throughs", "2")
    assert models.asked_settings(asked, scene)[:3] == ["grid.cells=[120, 40, 40]", "time.step=0.005", "time.end=15.0"]
    heavy = models.Member(scene, "actm", 2.0, None, tmp_path, {})
    assert heavy.overrides(models.settings_of(scene, [])) == ["reference.sphere_density=2.0"]
    plan = threshold.Plan(scene, 10, 12.0, 4.0, tmp_path)
    assert plan.time_unit == 6.0 and "time.end=72.0" in plan.overrides()
    assert threshold.gravity_for(0.1, 0.2, plan.settings) == pytest.approx(0.2**2 / (0.5 * 0.1))
    bare = scene_of(tmp_path, LEAST.partition("[statistics]")[0])
    assert models.settings_of(bare, [])["reference"] == models.DEFAULTS["reference"]


def test_defaults_and_required_keys_are_those_of_the_program():
    rows = [line.split(" | ") for line in (INPUTS / "KEYS.md").read_text().splitlines() if line.startswith("| `")]
    said = {row[0].strip("| `"): (row[3], row[4].strip(" |`")) for row in rows}
    assert {key for key, (allowed, _) in said.items() if "required" in allowed} == {
        f"{table}.{key}" for table, key in models.REQUIRED
    }
    for table, values in models.DEFAULTS.items():
        assert values == {key: float(said[f"{table}.{key}"][1]) for key in values}


@pytest.mark.parametrize(
    ("line", "key"),
    [("length = [6.0, 2.0, 2.0]", "grid.length"), ("end = 9.0", "time.end"),
     ("[fluid]\nkinematic_viscosity = 0.01", "fluid.kinematic_viscosity")],
)  # fmt: skip
def test_a_key_that_is_missing_is_told(tmp_path, line, key):
    scene = scene_of(tmp_path, LEAST.replace(line, ""))
    with pytest.raises(UserError, match=f"fluid.toml: the key '{key}' is missing."):
        models.asked_settings(options(), scene)


def test_bare_words_stand_for_texts():
    given = ["accuracy.precision=single", "spheres.file = ./a-b.txt"]
    settings = models.settings_of(find_scene("setup2"), given)
    assert settings["accuracy"]["precision"] == "single"
    assert settings["spheres"]["file"] == "./a-b.txt"


@pytest.mark.parametrize("text", ["time.end", "time.end=", "time.end=2 s", "title=a b"])
def test_a_setting_that_is_none_is_told(text):
    with pytest.raises(UserError, match=f"--set {text}: .*; write it as in TOML"):
        models.settings_of(find_scene("setup2_small"), [text])


def test_a_run_is_done_when_it_has_reached_its_end(tmp_path):
    folder = write_run(tmp_path / "run", wandering_story())
    last = float((folder / "history.csv").read_text().split()[-1].split(",")[1])
    assert models.finished(folder, last)
    assert not models.finished(folder, last + 1.0)
    (folder / "timing.csv").unlink()  # was interrupted before its end
    assert not models.finished(folder, last)
    assert not models.finished(tmp_path / "nothing", last)


@pytest.mark.parametrize("name", ["setup1", "setup1_small", "setup2", "setup2_small"])
def test_the_report_leaves_out_the_start_up_that_the_scene_says(name):
    scene = find_scene(name)
    said = re.search(r"the first (\w+) are the start-up", (scene.folder / "fluid.toml").read_text())[1]
    numbers = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
    assert models.start_up(options(), scene) == pytest.approx(numbers.index(said), rel=1e-12)
    assert models.start_up(options("--discard", "0"), scene) == 0.0


def test_a_start_up_follows_what_is_set():
    # statistics.from = 39 of 26 D at u_b = 1; a scene without statistics does not say.
    scene = find_scene("setup2_small")
    assert models.start_up(options("--set", "statistics.from=39.0"), scene) == 1.5
    assert models.start_up(options(), find_scene("exposed_sphere")) == models.START_UP


@pytest.fixture
def started(monkeypatch):
    """The mpirun lines that would have been started."""
    lines = []
    monkeypatch.setattr(job, "run", lambda line, folder: lines.append(line) or 0)
    return lines


def test_runs_start_are_skipped_and_go_on(tmp_path, started):
    scene = find_scene("setup2_small")
    member = models.members(options("--out", str(tmp_path), "--models", "actm", "--no-bed"), scene)[0]
    ranks = job.Ranks(1, 1)
    models.run_member(member, ranks, ["time.end=5"])
    assert "--restart" not in started[-1]
    assert "time.end=5" in started[-1]

    write_run(member.out, wandering_story())
    assert np.all(Run_end(member.out) > 5)
    models.run_member(member, ranks, ["time.end=5"])
    assert len(started) == 1  # done: not started again
    with pytest.raises(UserError, match="holds a run without fluid.density=7.0"):
        models.run_member(member, ranks, ["time.end=5", "fluid.density=7.0"])

    (member.out / "checkpoint_00000100").mkdir()
    models.run_member(member, ranks, ["time.end=500"])
    line = started[-1]
    assert line[line.index("--restart") + 1] == str(member.out)

    # Cut off before its first checkpoint: begins anew, the cut-off output moves aside.
    (member.out / "checkpoint_00000100").rmdir()
    models.run_member(member, ranks, ["time.end=500"])
    assert "--restart" not in started[-1]
    assert (tmp_path / "setup2_small-actm.cut1" / "settings.toml").is_file()


def test_hours_are_those_of_all_parts(tmp_path):
    member = models.members(options("--out", str(tmp_path), "--models", "actm", "--no-bed"),
                            find_scene("setup2_small"))[0]  # fmt: skip
    out = write_run(member.out, wandering_story())

    def clock():
        return models.circumstances([member], job.Ranks(1, 1))["hours on the clock, all runs"]

    assert models.hours(out) == (pytest.approx(300.5 / 3600), True)
    for part in (1, 2):
        (out / "log.liggghts").touch()
        job.keep_part(out)
        assert not (out / "timing.csv").exists()
        assert clock() == "not known"
        text = "part,seconds_mean_over_ranks,seconds_max,share,calls\npressure,7200.0,7200.0,1.0,1\n"
        (out / "timing.csv").write_text(text)
        assert (out / f"log.part{part}.liggghts").is_file()
    assert clock() == "4.08"
    (out / "made_by.json").write_text('{"ranks": "3:2"}')
    told = models.circumstances([member], job.Ranks(1, 1))
    assert told["ranks of each run"] == "3 of the fluid, 2 of LIGGGHTS"
    assert told["core-hours of the fluid's ranks"] == "12.25"
    (out / "made_by.json").unlink()
    (out / "timing.part2.csv").unlink()  # of a part that was killed
    assert clock() == "more than 2.08"


def Run_end(folder):
    return Run(folder).history()["time"][-1]


@pytest.mark.parametrize("table", ["collisions.csv", "collisions_open.csv"])
def test_a_report_takes_no_run_without_its_contacts(tmp_path, table):
    """One that was killed behind the start-up: every contact under way would count as none."""
    out = write_run(tmp_path / "setup2_small-actm", wandering_story())
    (out / table).unlink()
    given = options("--report-only", "--no-bed", "--models", "actm", "--discard", "0.1", "--out", str(tmp_path))
    with pytest.raises(UserError, match=f"setup2_small-actm has no {table}"):
        models.run(given)


def test_variables_reach_the_script(tmp_path):
    work = job.Job(
        find_scene("setup1_small"), "rpm", job.Ranks(1, 1), tmp_path, variables={"density": "1.75"}
    )
    line = work.command()
    assert line[line.index("density") - 1 : line.index("density") + 2] == ["-var", "density", "1.75"]
    assert line.index("density") > line.index(":")


def test_side_walls_leave_a_bed_no_friction(tmp_path):
    folder = write_run(tmp_path / "bed", wandering_story())
    text = (folder / "settings.toml").read_text()
    text = text.replace('boundary.z = ["periodic", "periodic"]', 'boundary.z = "no_slip"')
    (folder / "settings.toml").write_text(text)
    with pytest.raises(MissingOutput, match="side walls"):
        models.measured_bed(Run(folder), 0.0)


def test_friction_of_the_bed_is_the_driving_force(tmp_path):
    """0.004 over a depth of 8 in the made-up run: u_tau^2 = 0.032, nu = 2.6578e-3; S with g' D = 0.25 x 0.99."""
    made_up = Run(write_run(tmp_path / "bed", wandering_story()))
    bed = models.measured_bed(made_up, 0.0)
    assert bed.u_tau == pytest.approx(np.sqrt(0.032), rel=1e-12)
    assert bed.reynolds == pytest.approx(np.sqrt(0.032) * 8 / 2.6578e-3, rel=1e-12)
    assert bed.shields(made_up) == pytest.approx(0.032 / (0.25 * 0.99), rel=1e-9)
    assert bed.source.endswith(f"second half {bed.reynolds:.0f}")
    assert bed.reynolds_interval == pytest.approx(0.0, abs=1e-9)  # the force is steady
    # A force of 0.003 and 0.005 by turns of a quarter of the record: batches of four, s = 0.0011547.
    history = made_up.history()
    force = np.where(np.arange(len(history["time"])) * 4 // len(history["time"]) % 2, 0.005, 0.003)
    half = 3.18245 * np.std([0.003, 0.005] * 2, ddof=1) / 2
    lines = (made_up.folder / "history.csv").read_text().splitlines()
    place = lines[0].split(",").index("driving")
    for row, value in enumerate(force, 1):
        words = lines[row].split(",")
        words[place] = repr(float(value))
        lines[row] = ",".join(words)
    (made_up.folder / "history.csv").write_text("\n".join(lines) + "\n")
    turning = models.measured_bed(Run(made_up.folder), 0.0)
    relative = half / np.mean(force)
    assert turning.reynolds_interval == pytest.approx(0.5 * relative * turning.reynolds, rel=0.05)
    found = turning.numbers(made_up)
    assert found["bed_shields_interval"] == pytest.approx(relative * found["bed_shields"], rel=0.05)
