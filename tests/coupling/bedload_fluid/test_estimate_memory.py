"""`./bedload estimate` by real runs: the memory that it predicts from smaller grids. Its times are judged by
`./bedload study estimate`, on a quiet machine."""

import math
from dataclasses import replace

from programs import BIN

from bedload_launcher import cost, trial
from bedload_launcher import job as launcher_job
from bedload_launcher.scenes import find_scene
from bedload_studies.estimate import MEMORY_LIMIT, PART

CELLS = [112, 63, 56]


def test_memory_within_a_tenth(monkeypatch):
    """The default scene, tried on less than half of its cells."""
    monkeypatch.setattr(launcher_job, "BIN", BIN)
    monkeypatch.setattr(cost, "REPEATS", 1)
    monkeypatch.setattr(cost, "LONGER", 1)
    scene, ranks = find_scene("exposed_sphere"), launcher_job.Ranks(1, 1)
    settings = [f"grid.cells={CELLS}", "time.step=0.05"]
    whole = launcher_job.Job(scene, "actm_hw", ranks, scene.folder, settings)
    predicted_cost = cost.estimate(whole, tuple(CELLS), print, int(PART * math.prod(CELLS)))
    assert math.prod(predicted_cost.trial_cells) < PART * math.prod(CELLS)
    run = trial.run_trial(replace(whole, steps=3))
    found = run.fluid_bytes + run.dem_bytes
    predicted = predicted_cost.fluid_bytes + predicted_cost.dem_bytes
    print(predicted / found)
    assert abs(predicted / found - 1.0) < MEMORY_LIMIT
