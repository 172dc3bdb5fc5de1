"""The study of accuracy against price: which points are best, what the estimate quotes."""

import argparse

import pytest
from bedload_launcher import cost, job, presets
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import find_scene
from bedload_launcher.words import last_sentence
from bedload_studies import accuracy, accuracy_cases, accuracy_report
from bedload_studies.accuracy import CASES, Point, choices, front
from bedload_studies.accuracy_cases import Case
from bedload_studies.validation_runs import Runner


def point(label, error, core_seconds):
    return Point("case", label, "-", error, core_seconds, 1.0)


def test_the_front_holds_what_nothing_beats_in_both():
    points = [
        point("cheap", -0.10, 1.0), point("good", 0.01, 10.0), point("beaten", 0.02, 20.0),
        point("lost", float("nan"), 0.1), point("between", 0.05, 5.0),
    ]  # fmt: skip
    assert front(points) == {"cheap", "between", "good"}


def test_every_case_measures_every_preset_and_names_no_point_twice():
    for case in CASES:
        labels = [label for label, *_ in choices(case)]
        assert len(labels) == len(set(labels))
        if CASES[case].presets:
            assert {f"preset {name}" for name in presets.PRESETS} <= set(labels)


def test_the_estimate_quotes_the_kept_study(tmp_path, monkeypatch):
    kept = tmp_path / "accuracy.csv"
    monkeypatch.setattr(presets, "MEASURED", kept)
    assert presets.measured_errors("preset draft", ["rebound"]) == []
    kept.write_text("case,label,error\narray_drag,preset draft,-0.0123\nrebound,preset fine,0.5\n")
    assert presets.measured_errors("preset draft", ["array_drag", "rebound"]) == ["array drag -1.2 %"]
    assert presets.measured_errors("preset fine", ["array_drag"]) == []


def test_only_errors_of_the_scene_s_own_physics_are_quoted():
    assert presets.cases_like(find_scene("channel180"), None) == ["channel"]
    assert "rebound" in presets.cases_like(find_scene("setup2_small"), "actm_hw")
    assert "rebound" not in presets.cases_like(find_scene("setup2_small"), "rpm")


def test_a_trial_that_does_not_run_says_why():
    words = (
        "a trial of bed ended with status 1: bedload-fluid: WARNING: slow.\n[..] 3 %\n"
        "bedload-fluid: a sphere has 1.6 cells to its radius; at least 2.\n"
    )
    assert cost.reason(words) == "a sphere has 1.6 cells to its radius; at least 2"
    assert cost.reason("a trial ended\nkilled.") == "killed"
    assert last_sentence(words) == "bedload-fluid: a sphere has 1.6 cells to its radius; at least 2."
    assert last_sentence("a trial ended\nkilled.\n") == "killed."
    assert last_sentence("") == "it said nothing"


def test_a_choice_that_the_programs_stop_is_a_row(tmp_path, monkeypatch, capsys):
    def stops(*_):
        raise UserError("the step is too long.")

    monkeypatch.setitem(CASES, "case", Case(stops, 10, []))
    options = argparse.Namespace(runs=tmp_path, again=False)
    row = accuracy.measure("case", "1.5 x dt", "CFL", 0, {}, options, set())
    assert accuracy_report.error_text(row) == "stopped"
    assert "the step is too long." in capsys.readouterr().out


def test_again_runs_everything_again_and_what_points_share_once(tmp_path, monkeypatch):
    """Two points, each with a run by its scene, one by its job, and a reference in common."""
    started = []

    def start(self, line, scene, out):
        started.append(out.name)
        out.mkdir(parents=True, exist_ok=True)
        (out / "settings.toml").touch()
        return 1.0

    def error(runner, label, n, settings):
        with runner.unpaid():
            runner("settling", "reference")
        runner("settling", label)
        scene, out = find_scene("exposed_sphere"), runner.folder / f"{label}-job"
        runner.run_job(job.Job(scene, None, job.Ranks(1, 1), out))
        return 0.1

    monkeypatch.setattr(Runner, "_run", start)
    monkeypatch.setattr(accuracy_cases, "LEAST_SECONDS", 0.0)
    monkeypatch.setattr(accuracy, "write_report", lambda *_: None)
    monkeypatch.setitem(CASES, "fake", Case(error, 10, [("other", "knob", 0, {})], presets=False))

    def study(*words):
        started.clear()
        parser = argparse.ArgumentParser()
        accuracy.add_options(parser)
        line = ["--case", "fake", "--runs", str(tmp_path), *words]
        assert accuracy.run(parser.parse_args(line)) == 0
        return sorted(started)

    every = ["fake-base", "fake-base-job", "fake-other", "fake-other-job", "reference"]
    assert study() == every
    assert study() == []
    assert study("--again") == every
    (tmp_path / "report" / "accuracy.csv").unlink()  # the runs are kept, the table is made anew
    assert study() == []


def test_a_cost_of_less_than_seconds_is_repeated(tmp_path, monkeypatch):
    """A run that takes no time is made as often as allowed, and its median stands beside it."""
    runs = []
    monkeypatch.setattr(Runner, "_run", lambda self, line, scene, out: runs.append(out) or 0.1)
    (tmp_path / "a").mkdir()
    accuracy_cases.PricedRunner(tmp_path, job.Ranks(1, 1))._run([], "scene", tmp_path / "a")
    assert len(runs) == accuracy_cases.MOST_REPEATS
    assert float((tmp_path / "a" / "price.csv").read_text().split(",")[0]) < 0.5


def test_the_figure_has_a_row_for_every_choice_and_intervals_are_told(tmp_path):
    points = [point(f"choice {n}", 0.01 * n + 0.01, 1.0 + n) for n in range(20)]
    accuracy_report.draw_case("case", points, {"choice 0"}, tmp_path / "case.png")
    assert (tmp_path / "case.png").stat().st_size > 5000
    assert accuracy_report.error_text(points[1]) == "+2.00"
    assert accuracy_report.error_text(Point("c", "l", "k", -0.1, 1.0, 1.0, 0.03)) == "-10.00 ± 3.00"


def test_scatter_with_the_place_on_the_grid_is_averaged_and_told(tmp_path):
    runner = accuracy_cases.PricedRunner(tmp_path, job.Ranks(1, 1))
    asked = []

    def error(name, place):
        asked.append((name, place))
        runner.core_seconds += 2.0
        return (0.01, 0.05, -0.03)[len(asked) - 1]

    assert abs(accuracy_cases.over_positions(runner, "base", error) - 0.01) < 1e-12
    assert abs(runner.interval - 0.04) < 1e-12
    assert runner.core_seconds == 2.0
    assert len(set(asked)) == 3


@pytest.mark.parametrize(
    ("line", "told"),
    [(["--hours", "1"], "--hours is for a SCENE"), (["--start-from", "x"], "--start-from is for a SCENE"),
     (["setup2_small", "--again"], "--again is for the known cases")],
)  # fmt: skip
def test_options_of_the_other_kind_are_refused(line, told):
    parser = argparse.ArgumentParser()
    accuracy.add_options(parser)
    with pytest.raises(UserError, match=told):
        accuracy.run(parser.parse_args(line))


def test_a_case_keeps_the_scales_of_its_collision_model_on_every_grid():
    """Lengths and times, those of the standard grid's defaults; steps only where the case asks for them."""
    assert accuracy_cases.model_scales({}, 0.1, 0.2) == {"collision_time": pytest.approx(1.0)}
    rpm = accuracy_cases.model_scales({"model": "rpm_hw"}, 0.1, 0.2)
    assert rpm == {"repulsion_time": pytest.approx(0.5), "repulsion_range": pytest.approx(0.4)}
    assert accuracy_cases.model_scales({"collision_steps": 5}, 0.1, 0.2) == {"contact_settings": "collisionSteps 5"}
    given = []

    def runs(*_, variables, **__):
        given.append(variables["collision_time"])
        return 0.0, 0.0, 0.003 * 2.489, None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accuracy_cases.validation_rebounds, "_rebound", runs)
        patch.setattr(accuracy_cases, "over_positions", lambda _, label, error: error(label, (0.0, 0.0, 0.0)))
        for n, settings in ((8, {}), (14, {}), (10, {"step": 0.5})):
            assert accuracy_cases.rebound(None, "trial", n, settings) == pytest.approx(0.0)
    assert given == [pytest.approx(1.5e-3)] * 3


@pytest.mark.parametrize("cells, words", [
    (6, "settling -2.4 %, with 6 cells to a diameter"),
    (9, "with 10 cells to a diameter, the nearest to this scene's 9"),  # 10/9 < 9/8
    (4, "with 6 cells to a diameter, the nearest to this scene's 4 that was measured (below 6 errors grow fast"),
    (20, "with 14 cells to a diameter, the nearest to this scene's 20 that was measured"),
])  # fmt: skip
def test_errors_to_expect_are_those_of_the_scene_s_own_grid(cells, words):
    scene = find_scene("setup2_small")
    settings = [f"grid.cells=[{26 * cells}, 10, 10]"]
    assert scene.cell_size(settings) == pytest.approx(1.0 / cells)
    said = presets.errors_to_expect(scene, "rpm", None, settings)
    assert words in said and "rebound" not in said
    assert ("grow fast" in said) == (cells < 6)


def test_errors_to_expect_follow_what_the_command_line_sets():
    """A diameter, the file of the spheres and the grid, in each of the ways in which --set may be written."""
    scene = find_scene("setup2_small")
    own = scene.value("reference", "diameter") / scene.cell_size()
    finest = f"with 14 cells to a diameter, the nearest to this scene's {14 * 2:.3g}"
    for line in (f"reference.diameter={28 / own}", f"reference = {{diameter = {28 / own}}}"):
        assert finest in presets.errors_to_expect(scene, "rpm", None, [line]), line
    assert scene.cells(["grid = {cells = [8, 8, 4]}", "grid.length=[1.0, 1.0, 0.5]"]) == (8, 8, 4)
    channel = find_scene("channel180")
    spheres = ["spheres.file=spheres.csv", "reference.diameter=1.0"]
    assert presets.cases_like(channel, None, spheres) == ["array_drag"]
    assert "settling" not in presets.errors_to_expect(channel, None, None, spheres)
    assert "cells to a diameter" in presets.errors_to_expect(channel, None, None, spheres)
    with pytest.raises(UserError, match="--set grid.cells=7: grid.cells must be three numbers above 0"):
        scene.cells(["grid.cells=[8, 8, 8]", "grid.cells=7"])
