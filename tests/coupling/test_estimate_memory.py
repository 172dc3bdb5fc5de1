"""`./bedload estimate` by real runs: the memory that it predicts from smaller grids. Its times are judged by
`./bedload study estimate`, on a quiet machine."""

import math

from job import BIN

from bedload_launcher import estimate, trial
from bedload_launcher import job as launcher_job
from bedload_launcher.scenes import find_scene
from bedload_studies.estimate import MEMORY_LIMIT, PART

CELLS = [112, 63, 56]


def test_memory_within_a_tenth(monkeypatch):
    """The default scene, tried on less than half of its cells."""
    monkeypatch.setattr(launcher_job, "BIN", BIN)
    monkeypatch.setattr(estimate, "REPEATS", 1)
    monkeypatch.setattr(estimate, "LONGER", 1)
    scene, ranks = find_scene("exposed_sphere"), launcher_job.Ranks(1, 1)
    settings = [f"grid.cells={CELLS}", "time.step=0.05"]
    cost = estimate.estimate(scene, "actm_hw", ranks, settings, tuple(CELLS), print, int(PART * math.prod(CELLS)))
    assert math.prod(cost.trial_cells) < PART * math.prod(CELLS)
    run = trial.run_trial(launcher_job.Job(scene, "actm_hw", ranks, scene.folder, settings, 3))
    found = run.fluid_bytes + run.dem_bytes
    predicted = cost.fluid_bytes + cost.dem_bytes
    print(predicted / found)
    assert abs(predicted / found - 1.0) < MEMORY_LIMIT
