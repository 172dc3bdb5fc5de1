"""`./bedload study models`: which runs it makes, which it leaves alone, which it goes on with."""

import argparse
import re

import numpy as np
import pytest
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import find_scene
from bedload_studies import models
from synthetic import wandering_story, write_run


def options(*words):
    parser = argparse.ArgumentParser()
    models.add_options(parser)
    return parser.parse_args(list(words))


def test_setup2_has_one_run_a_model(tmp_path):
    asked = options("--out", str(tmp_path))
    runs = models.members(asked, find_scene("setup2_small"))
    assert [m.out.name for m in runs] == [
        f"setup2_small-{m}" for m in ("rpm", "rpm_hw", "actm", "actm_hw")
    ]
    assert all(m.overrides({}) == [] and m.variables() == {} for m in runs)


def test_setup1_has_three_densities_at_one_froude_number(tmp_path):
    scene = find_scene("setup1_small")
    runs = models.members(options("--scene", "setup1_small", "--out", str(tmp_path)), scene)
    assert len(runs) == 12
    settings = models.settings_of(scene, [])
    for member in runs:
        words = dict(text.split("=") for text in member.overrides(settings))
        density = float(words["reference.sphere_density"])
        gravity = -float(words["fluid.gravity"].strip("[]").split(",")[1])
        # Fr = (rho_p - rho_f) g H/(rho_f u_b^2) with H = 12
        assert (density - 1.0) * gravity * 12.0 == pytest.approx(1.98, rel=1e-12)
        assert float(member.variables()["density"]) == density
    assert {m.density for m in runs} == {1.25, 1.75, 2.25}


def test_floating_grains_are_refused(tmp_path):
    with pytest.raises(UserError, match="must sink"):
        models.members(options("--densities", "0.9"), find_scene("setup2_small"))


def test_set_reaches_what_follows_from_it():
    settings = models.settings_of(find_scene("setup2_small"), ["time.end=3", "fluid.density = 2.0"])
    assert settings["time"]["end"] == 3
    assert settings["fluid"]["density"] == 2.0
    assert settings["time"]["step"] > 0


@pytest.mark.parametrize("text", ["accuracy.precision=single", "time.end", "time.end="])
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
    member = models.members(options("--out", str(tmp_path), "--models", "actm"), scene)[0]
    ranks = job.Ranks(1, 1)
    models.run_member(member, ranks, ["time.end=5"])
    assert "--restart" not in started[-1]
    assert "time.end=5" in started[-1]

    write_run(member.out, wandering_story())
    assert np.all(Run_end(member.out) > 5)
    models.run_member(member, ranks, ["time.end=5"])
    assert len(started) == 1  # done: not started again

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
    member = models.members(options("--out", str(tmp_path), "--models", "actm"),
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
    (out / "timing.part2.csv").unlink()  # of a part that was killed
    assert clock() == "more than 2.08"


def Run_end(folder):
    from bedload_post.outputs import Run

    return Run(folder).history()["time"][-1]


def test_variables_reach_the_script(tmp_path):
    work = job.Job(
        find_scene("setup1_small"), "rpm", job.Ranks(1, 1), tmp_path, variables={"density": "1.75"}
    )
    line = work.command()
    assert line[line.index("density") - 1 : line.index("density") + 2] == ["-var", "density", "1.75"]
    assert line.index("density") > line.index(":")
