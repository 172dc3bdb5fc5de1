"""The study of accuracy against price: which points are best, what the estimate quotes."""

import argparse

from bedload_launcher import accuracy as presets
from bedload_launcher import job
from bedload_launcher.scenes import find_scene
from bedload_studies import accuracy
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
    assert presets.measured_errors("draft") == []
    kept.write_text("case,label,error\narray_drag,preset draft,-0.0123\nrebound,preset fine,0.5\n")
    assert presets.measured_errors("draft") == ["array drag -1.2 %"]


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
