"""Laws of fixed spheres that the validation compares with, against their limits and numbers worked out by hand; places
at random."""

import math

import numpy as np
import pytest
from bedload_studies.random_spheres import random_spheres, smallest_distance
from bedload_studies.sphere_theory import random_array_drag, random_array_drag_tenneti
from bedload_studies.validation_sliding import _beside_wall
from bedload_studies.validation_steady import _approaching, _brenner, wall_drag_and_lift


def test_drag_and_lift_on_a_wall():
    """Without inertia O'Neill's drag and 9.22 rho (dU/dy)^2 R^4 of lift (Leighton & Acrivos), U = R dU/dy; at
    Re = 100 by hand: 0.4081 (1 + 0.104 32.06) and 3.663/10^0.88."""
    slow = 1e-4
    drag, lift = wall_drag_and_lift(slow)
    assert drag == pytest.approx(24.0 * 1.7005 / slow, rel=1e-3)
    assert lift == pytest.approx(9.22 * 0.25 / (math.pi / 8.0), rel=1e-3)
    assert wall_drag_and_lift(100.0) == (pytest.approx(1.769, rel=1e-3), pytest.approx(0.4829, rel=1e-3))


def test_spheres_that_approach():
    """Brenner's (1961) table for a wall, R cosh a away: 3.0361 at a = 1, 1.4129 at 2. Two spheres, as the film of
    R_eff = R/2 closed at 2 U where they are near, 1/(2 gap); far away as Stokes' flow of the other one, 1 + 3/(2 d)."""
    assert _brenner(math.cosh(1.0) - 1.0) == pytest.approx(3.0361, abs=1e-4)
    assert _brenner(math.cosh(2.0) - 1.0) == pytest.approx(1.4129, abs=1e-4)
    assert _approaching(0.001) == pytest.approx(500.0, rel=0.02)
    assert _approaching(148.0) == pytest.approx(1.0 + 1.5 / 150.0, abs=2e-4)


def test_spheres_beside_a_wall():
    """Goldman, Cox & Brenner's (1967) tables at gaps of 0.003202 and 0.0453 R, torques there in 8 pi mu R^3."""
    for gap, slide, mixed, turn in ((0.003202, 4.0223, 0.51326, 2.6793), (0.0453, 2.6475, None, 1.6996)):
        found = _beside_wall(gap)
        assert (found[0, 0], 0.75 * found[1, 1]) == pytest.approx((slide, turn), rel=5e-4)
        assert found[0, 1] == found[1, 0]
        assert mixed is None or found[0, 1] == pytest.approx(-mixed, rel=5e-4)


def test_drag_in_random_arrays_by_hand():
    """Alone: Stokes' drag. At 0.25: 2.5/0.5625 + 0.5625 1.75 = 5.429 without the pressure gradient, 4/3 of it
    with. With inertia, Re = 10: 0.413 10/(24 0.5625) (1.3333 + 0.5625 + 8.4 0.4539)/(1 + 5.6234/10) = 1.117 more."""
    assert random_array_drag(1e-12, 0.0) == pytest.approx(1.0, abs=1e-5)
    assert random_array_drag(0.25, 0.0) == pytest.approx(5.4288 / 0.75, rel=1e-4)
    assert random_array_drag(0.25, 10.0) == pytest.approx((5.4288 + 1.1174) / 0.75, rel=1e-3)
    # Tenneti et al.: (1 + 0.15 10^0.687 + 5.81 0.25)/0.4219 + 0.48 0.63/0.3164 + 10/64 (0.95 + 0.0169).
    assert random_array_drag_tenneti(1e-12, 0.0) == pytest.approx(1.0, abs=1e-3)
    assert random_array_drag_tenneti(0.25, 10.0) == pytest.approx(4.100 + 3.443 + 0.956 + 0.151, rel=1e-3)


def test_spheres_at_random_places_are_a_gas_of_hard_spheres():
    """Neighbours within 1.1 D of each other as Carnahan and Starling's (1969) pressure demands:
    g = (1 - phi/2)/(1 - phi)^3 = 2.48 at contact, 2.1 on the mean up to 1.1 D; 2.6 if spheres came one after the
    other, 0 on the lattice."""
    length, found = 6.0, []
    for seed in range(3):
        centres = random_spheres(0.3, length, seed, sweeps=400)
        assert len(centres) == 124
        assert smallest_distance(centres, length) >= 1.0
        apart = centres[:, None] - centres[None]
        apart -= length * np.round(apart / length)
        distances = np.linalg.norm(apart, axis=2)[np.triu_indices(len(centres), 1)]
        shell = 4.0 / 3.0 * np.pi * (1.1**3 - 1.0)
        found.append((distances < 1.1).sum() / (0.5 * len(centres) * len(centres) / length**3 * shell))
    assert np.mean(found) == pytest.approx(2.1, abs=0.25)
    assert np.array_equal(random_spheres(0.3, length, 2, sweeps=400), centres)
