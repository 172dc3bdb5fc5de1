"""Restitutions from trajectories that are known."""

import numpy as np
import pytest
from bedload_studies import validation_rebounds as rebounds


def test_bounces_are_read_where_the_gap_passes_a_tenth_of_the_diameter():
    """Straight ways, D = 2: towards the wall at 3, back at 1.5, again at 1.2 and back at 0.3; too low for a third."""
    corners = np.array([(0.0, 3.0), (1.0, 0.0), (2.0, 1.5), (3.25, 0.0), (4.25, 0.3), (5.25, 0.1), (6.25, 0.15)])
    time = np.linspace(0.0, 6.25, 2501)
    first, second = rebounds._bounces(time, np.interp(time, *corners.T), 2.0)
    assert (first.speed, first.restitution) == pytest.approx((3.0, 0.5))
    assert (second.speed, second.restitution) == pytest.approx((1.2, 0.25))


def test_restitution_of_a_measured_peak_goes_as_the_root_of_the_height():
    assert rebounds.Bounce(3.0, 0.5).measured(2.0, 0.5) == rebounds.Bounce(3.0, 0.25)


def test_restitution_between_two_bounces_is_that_of_the_law_through_them():
    def law(stokes):
        return 0.9 * np.exp(-30.0 / stokes)

    ends = [(20.0, law(20.0)), (80.0, law(80.0))]
    assert rebounds._restitution_between(40.0, ends) == pytest.approx(law(40.0))
    assert rebounds._restitution_between(20.0, ends) == pytest.approx(law(20.0))


def test_stokes_numbers_of_the_experiments_are_those_of_their_names():
    assert rebounds.ST152.stokes(rebounds.ST152.speed) == pytest.approx(152.0, rel=0.01)
    assert rebounds.ST27.stokes(rebounds.ST27.speed) == pytest.approx(27.0, rel=0.01)


def test_restitution_of_a_fast_light_sphere_in_words():
    """Where it is off by more than half the scatter of experiments, resolution is missing unless the collision time
    decides."""
    of_cells = rebounds.resolution_of_restitution({10: 0.69, 20: 0.79}, 0.70, 0.89)
    assert "-0.20 at D/h = 10, -0.10 at D/h = 20" in of_cells
    assert "changes that by 5 %" in of_cells and "resolution is missing" in of_cells
    of_time = rebounds.resolution_of_restitution({10: 0.69, 20: 0.79}, 0.79, 0.89)
    assert "collision counts" in of_time and "resolution" not in of_time
    right = rebounds.resolution_of_restitution({10: 0.87, 20: 0.91}, 0.88, 0.90)
    assert right.endswith("-0.03 at D/h = 10, +0.01 at D/h = 20; half the collision time changes it by +0.01.")
