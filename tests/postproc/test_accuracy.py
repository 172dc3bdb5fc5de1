"""The study of accuracy against price: which points are best, what the estimate quotes."""

from bedload_launcher import accuracy as presets
from bedload_studies.accuracy import CASES, Point, choices, front


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
