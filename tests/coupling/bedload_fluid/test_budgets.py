"""A thousand steps of `./bedload study budgets`: all accounts are closed. A term of the flow's energy
that is missing, doubled or turned about shows, and so does the grains' work turned about (its size does
not: slip is what remains of the forcing's work beside it)."""

from dataclasses import replace

import pytest
from programs import BIN

from bedload_launcher import job as launcher_job
from bedload_studies import budgets

STEPS = 1000


@pytest.fixture(scope="module")
def series(tmp_path_factory):
    before, launcher_job.BIN = launcher_job.BIN, BIN
    out = budgets.run_scene(budgets.scene(STEPS), tmp_path_factory.mktemp("budgets"))
    launcher_job.BIN = before
    return budgets.read_series(out)


def open_ones(series):
    return [b.what for b in budgets.account(series) if not b.closed]


def test_all_closed(series):
    assert len(series.history["step"]) == STEPS
    assert open_ones(series) == []


@pytest.mark.parametrize("factor", [0.0, 2.0, -1.0])
@pytest.mark.parametrize("term", ["driving", "viscous_work", "forcing_work", "convective_work"])
def test_a_wrong_term_of_the_flows_energy_shows(series, term, factor):
    wrong = replace(series, history=series.history | {term: factor * series.history[term]})
    assert any(what.startswith("energy: driving") for what in open_ones(wrong))


def test_a_rest_that_grows_shows_in_its_part_of_the_run(series):
    before = budgets.share_over_time(series, "rest")
    driving = series.history["driving"].copy()
    driving[-STEPS // 10 :] *= 2.0
    grown = budgets.share_over_time(replace(series, history=series.history | {"driving": driving}), "rest")
    assert grown[:-1] == before[:-1]
    assert grown[-1] > before[-1] + 0.3  # half of the driving is not found again


def test_a_wrong_term_of_the_grains_energy_shows(series):
    """Fluid's work turned about: contacts would have to give energy."""
    wrong = replace(series, to_grains=-series.to_grains, by_weight=-series.by_weight)
    assert any("contacts" in what for what in open_ones(wrong))


@pytest.mark.parametrize(
    ("column", "what"),
    [("mobile_spheres", "grains"), ("max_divergence", "mass"), ("bulk_velocity", "mass"),
     ("momentum_residual", "momentum")],
)  # fmt: skip
def test_one_bad_step_shows(series, column, what):
    values = series.history[column].copy()
    values[STEPS // 2] += 1e-3 if column != "mobile_spheres" else -1.0
    assert any(w.startswith(what) for w in open_ones(replace(series, history=series.history | {column: values})))
