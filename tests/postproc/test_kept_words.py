"""What READMEs say of kept records is what the records hold."""

import json
import re
from pathlib import Path

import pytest
from bedload_studies.accuracy import read_table
from bedload_studies.validation_runs import Result

ROOT = Path(__file__).resolve().parents[2]
REPORTS = ROOT / "postproc" / "reports"
MODELS = ("rpm", "rpm_hw", "actm", "actm_hw")


def words(file: str) -> str:
    return re.sub(r"\s+", " ", (ROOT / file).read_text(encoding="utf-8"))


def runs(report: str) -> dict:
    """Runs of a kept report by model and density ratio."""
    kept = json.loads((REPORTS / report / "numbers.json").read_text(encoding="utf-8"))
    return {(v["model"], v["density_ratio"]): v for v in kept["runs"]}


def test_which_model_to_take():
    """The sentences on onset, rebound and motion that the choice of a model hangs on."""
    text, readme = words("inputs/models/README.md"), words("README.md")
    rows = Result.load(REPORTS / "validation" / "incipient.json").rows
    for name, said in (("actm", "1.00 to 1.03"), ("rpm", "0.70 to 0.76")):
        of_statics = [row.found / row.reference for row in rows if row.what.startswith(name)]
        assert f"{min(of_statics):.2f} to {max(of_statics):.2f}" == said and said in text and said in readme
    static = [row.found / row.reference for row in rows if row.what.startswith("actm_hw_static")]
    assert {f"{value:.2f}" for value in static} == {"1.00"}
    threshold = (REPORTS / "threshold" / "README.md").read_text(encoding="utf-8")
    told = re.search(r"at a Shields number of ([\d.]+) with actm, ([\d.]+) with actm_hw, ([\d.]+) with rpm_hw", text)
    assert told is not None
    for value, name in zip(told.groups(), ("actm", "actm + HW", "rpm + HW"), strict=True):
        assert f"| {name} | {value} (" in threshold
    assert "| rpm | below 0.0025" in threshold and "below 0.0025 with rpm" in text
    moving = {model: 100 * v["share_moving"] for (model, _), v in runs("setup2_small_40").items()}
    shares = "{actm:.0f} and {actm_hw:.0f} % of the grains move with actm and actm_hw, {rpm:.0f} and {rpm_hw:.0f} %"
    assert shares.format(**moving) in text
    rpm = next(p for p in read_table(REPORTS / "accuracy" / "accuracy.csv") if (p.case, p.label) == ("rebound", "rpm"))
    assert f"rpm's is {100 * rpm.error:.0f} % too high" in text
    film = [row for row in Result.load(REPORTS / "validation" / "rebound27.json").rows if "published film" in row.what]
    assert f"rebound at St = 27 {-100 * film[0].error:.0f} % too low" in text


def test_intervals_that_do_not_decide():
    """All four models have the paper's velocity within their intervals at six cells, of the width that is told."""
    found = runs("setup2_small_40").values()
    assert all(abs(v["mean_velocity"] - v["paper_mean_velocity"]) <= v["mean_velocity_interval"] for v in found)
    half = [100 * v["mean_velocity_interval"] / v["mean_velocity"] for v in found]
    assert f"± {min(half):.0f} to {max(half):.0f} % wide" in words("inputs/models/README.md")


@pytest.mark.parametrize("report", ["setup2_small_40", "setup2_small_10_pores", "setup2_small_14_films"])
def test_velocities_of_the_scene_s_table_are_the_page_s(report):
    """As the page of the report has them, whose intervals may be wider than the record's own."""
    page = (REPORTS / report / "README.md").read_text(encoding="utf-8")
    row = re.search(r"\| mean particle velocity / u_b \| (.*) \|", page)
    assert row is not None
    line = next(text for text in (ROOT / "inputs/setup2_small/README.md").read_text(encoding="utf-8").splitlines()
                if f"reports/{report}/README.md)" in text and text.startswith("|"))  # fmt: skip
    assert line.endswith(f"| {row[1]} |")
    first, second, third, last = row[1].split(" | ")
    assert f"{first}, {second}, {third} and {last} u_b" in words("postproc/reports/README.md")


def test_statements_counted_in_the_list_of_records_are_the_pages_own():
    told = 0
    for line in (REPORTS / "README.md").read_text(encoding="utf-8").splitlines():
        counts = re.search(r"(\d+) statements of the paper wrong, (\d+) right, (\d+) open", line)
        if counts is not None:
            page = (REPORTS / line.split("`")[1] / "README.md").read_text(encoding="utf-8")
            found = re.search(r"of the paper (\d+) are wrong.*? (\d+) are right.*? (\d+) are open", page)
            assert found is not None and found.groups() == counts.groups(), line.split("`")[1]
            told += 1
    assert told >= 8
