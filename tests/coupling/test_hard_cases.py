"""The quick ones of `./bedload study stability`: each hard case once, at a demanding time step."""

import pytest
from programs import BIN

from bedload_launcher import job as launcher_job
from bedload_studies.criteria import PASS, REFUSED
from bedload_studies.hard_cases import CASES
from bedload_studies.stability import run_cell

# Case, value of its knob, Courant number, precision. What each asks is the criterion of its case.
QUICK = [
    ("density_ratio", 0.3, 0.3, "double"),  # unstable by its spin when the torque is handed over whole
    ("density_ratio", 0.5, 0.1, "single"),
    ("density_ratio", 50.0, 0.95, "double"),
    ("spin", 2.0, 0.3, "double"),
    ("impact", 100.0, 0.3, "double"),
    ("impact", 5000.0, 0.3, "single"),
    ("impact_1_step", 1000.0, 0.3, "double"),
    ("wedged", 0.6, 0.3, "double"),
    ("pinned", 8.0, 0.3, "double"),
    ("cluster", 0.5, 0.3, "double"),
    ("crowd", 0.6, 0.3, "double"),  # goes wild with a quarter of the pressure correction in the old pressure
    ("overlap", 0.2, 0.3, "double"),
    ("corner", 4, 0.3, "double"),
    ("corner", 4, 0.6, "double"),  # refused in its first step where that forced spheres at the place of their start
    ("coarse", 6, 0.3, "double"),
    ("cfl", 1.73, 3.0, "single"),
    ("driving", -1.0, 0.3, "double"),
    ("models", "rpm", 0.3, "double"),
    ("light", 0.3, 0.3, "single"),
    ("narrow", 2.0, 0.3, "double"),
    ("plug", 4, 0.3, "double"),
    ("heavy_fall", 100.0, 0.3, "double"),
]


@pytest.mark.parametrize(("name", "value", "courant", "precision"), QUICK)
def test_holds(name, value, courant, precision, tmp_path, monkeypatch):
    monkeypatch.setattr(launcher_job, "BIN", BIN)
    cell = run_cell(CASES[name], value, courant, precision, tmp_path / "scene")
    assert cell.verdict == PASS, f"{cell.verdict}: {cell.words} ({cell.number})"


def test_what_is_too_fast_from_the_start_is_refused_with_the_step_that_is_not(tmp_path, monkeypatch):
    """A heavy sphere that is there at full speed at once, a cell a step: the fluid that it pushes aside has a CFL
    number of 1.75, and 1.73 is stable."""
    monkeypatch.setattr(launcher_job, "BIN", BIN)
    cell = run_cell(CASES["density_ratio"], 50.0, 1.0, "double", tmp_path / "scene")
    assert cell.verdict == REFUSED, f"{cell.verdict}: {cell.words} ({cell.number})"
    assert "the CFL number is 1.75" in cell.words and "set 'time.step' to at most 0.1237" in cell.words
