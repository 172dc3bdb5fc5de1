"""The page of the validation says first what misses its bound, and every number has its place."""

import shutil
from pathlib import Path

import pytest
from bedload_launcher.job import Ranks, readable
from bedload_studies import validation_runs
from bedload_studies.validation import CASES, page_of, rewrite
from bedload_studies.validation_figures import PANELS, draw, in_symbols, is_reference, panels
from bedload_studies.validation_runs import Curve, Result, Row, Runner, marks

REPORTS = Path(__file__).resolve().parents[2] / "postproc" / "reports"

DRAG = Result("Drag, D/h = 8", rows=[
    Row("K", 2.02, 2.0, 0.02, source="theory"), Row("order", 1.3),
])  # fmt: skip
SPIN = Result("Spin", rows=[Row("torque", 1.2, 1.0, 0.1, source="exact"), Row("moment", 0.95, 1.0, 0.1)])


def test_missed_bounds_come_first():
    lines = page_of({"drag": DRAG, "spin": SPIN}).splitlines()
    head = lines[: lines.index("## drag: Drag, D/h = 8")]
    assert "**1 of 3 numbers miss their bounds:**" in head
    assert [line for line in head if line.startswith("- ")] == [
        "- `spin`: torque: 1.2, should be 1 (exact), +20.00 %, bound 10 %"
    ]
    assert "| [drag](#drag-drag-dh--8) | Drag, D/h = 8 | 1 of 1 |" in head
    assert "| [spin](#spin-spin) | Spin | **1 of 2** |" in head


def test_all_numbers_stand_there():
    page = page_of({"drag": DRAG})
    assert "**0 of 1 numbers miss their bounds.**" in page
    assert "| K | 2.02 | 2 (theory) | +1.00 % | 2 % | kept |" in page
    assert "| order | 1.3 |  |  |  |  |" in page


def test_a_result_says_of_which_commits_its_runs_are(tmp_path, monkeypatch):
    def run(runner, line, scene, out):
        out.mkdir()
        return 1.0

    monkeypatch.setattr(Runner, "_run", run)
    monkeypatch.setattr(validation_runs, "Run", lambda out: out)
    monkeypatch.setattr(validation_runs, "commit", lambda: "a1")
    Runner(tmp_path, Ranks(1, 1))("scene", "first")
    monkeypatch.setattr(validation_runs, "commit", lambda: "b2")
    runner = Runner(tmp_path, Ranks(1, 1))
    for label in ("first", "second", "third"):  # the first one stands there
        runner("scene", label)
    day = runner.made_by[0].split()[0]
    assert runner.made_by == [f"{day} by commit a1", f"{day} by commit b2"]
    page = page_of({"drag": Result("Drag", rows=DRAG.rows, costs=runner.costs, made_by=runner.made_by)})
    assert f"Runs: 3 s in all, made {day} by commit a1 and {day} by commit b2." in page


def test_blanks_in_a_folder_do_not_reach_the_scripts(tmp_path, monkeypatch):
    lines = []

    def run(runner, line, scene, out):
        lines.append(list(line))
        out.mkdir(parents=True, exist_ok=True)
        return 1.0

    monkeypatch.setattr(Runner, "_run", run)
    monkeypatch.setattr(validation_runs, "Run", lambda out: out)
    monkeypatch.setattr(validation_runs, "INPUTS", tmp_path / "my checkout" / "inputs")
    for _ in range(2):  # the second time it stands there
        Runner(tmp_path / "my runs", Ranks(1, 1))("kissing", "first")
    (line,) = lines
    assert line[line.index("--out") + 1] == str(tmp_path / "my runs" / "first")
    for name in ("out", "inputs"):
        assert readable(line[line.index(name) + 1])


@pytest.mark.parametrize("file", sorted((REPORTS / "validation").glob("*.json")), ids=lambda file: file.stem)
def test_a_figure_shows_every_curve_and_no_panel_is_crowded(file):
    curves = Result.load(file).curves
    shown = [[c for c in curves if panel.holds(c)] for panel in panels(file.stem)]
    assert all(any(curve in own for own in shown) for curve in curves)
    for own in shown:
        ours = [c for c in own if not is_reference(c)]
        assert own
        assert len([c for c in ours if not c.points]) <= 4 and len([c for c in ours if c.points]) <= 4


def test_panels_belong_to_cases_and_their_curves_are_there(tmp_path):
    assert set(PANELS) <= set(CASES)
    result = Result("Spin", curves=[Curve("D/h = 8", [0, 1], [1, 2]), marks("measured", [(0, 1)])], axes=("t", "u_g"))
    draw("no such case", result, tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 5000
    assert in_symbols("t nu / D^2, u_g") == "t ν / D$^{2}$, $u_g$"


def test_a_kept_report_is_made_anew_without_runs(tmp_path):
    for name in ("spin", "offsets"):
        shutil.copy(REPORTS / "validation" / f"{name}.json", tmp_path)
    rewrite(tmp_path)
    assert sorted(file.name for file in tmp_path.glob("*.png")) == ["offsets.png", "spin.png"]
    assert "## offsets: " in (tmp_path / "README.md").read_text(encoding="utf-8")
