"""A grain in a pocket of four spheres under viscous shear: statics says when it leaves
(postproc/bedload_studies/validation_incipient.py)."""

import pytest
from programs import BIN

from bedload_launcher.job import Ranks
from bedload_studies import validation_incipient as incipient
from bedload_studies import validation_runs

CELLS, FRICTION = 8, 0.15


@pytest.fixture()
def runner(tmp_path, monkeypatch):
    monkeypatch.setattr(validation_runs, "BIN", BIN)
    return validation_runs.Runner(tmp_path, Ranks(1, 1))


def test_friction_lets_a_grain_roll_out_when_statics_says(runner):
    """actm_hw: the study finds 1.00 of statics. Without friction the threshold is 1.39 times as high, with twice the
    coefficient 0.93 times; where slip dies away in a whole time step, which viscosity outruns here, 1.18 times."""
    loads = incipient.held_loads(runner, CELLS)
    exact = loads.statics(FRICTION)
    assert loads.statics(0.0) > 1.3 * exact
    for share, goes in ((0.96, False), (1.05, True)):
        run = incipient.at_shields(runner, loads, share * exact, "actm_hw", FRICTION, CELLS, end=25.0)
        assert incipient.leaves(run) == goes, share
