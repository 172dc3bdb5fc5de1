"""Laws of suspensions that the validation compares with, against their limits and numbers worked out by hand."""

import numpy as np
import pytest
from bedload_post.outputs import Samples
from bedload_studies import validation_suspensions as suspensions
from bedload_studies.validation_suspensions import (
    eilers_viscosity,
    richardson_zaki_exponent,
    settling_reynolds,
    slower_by_images,
    structure_factor,
    zarraga_viscosity,
)


@pytest.mark.parametrize("law, einstein", [(eilers_viscosity, 2.5), (zarraga_viscosity, 2.5)])
def test_few_spheres_add_what_einstein_found(law, einstein):
    few = 1e-6
    assert law(few) - 1.0 == pytest.approx(einstein * few, rel=1e-3)


def test_viscosity_by_hand():
    assert eilers_viscosity(0.3) == pytest.approx((1.0 + 0.375 / 0.5) ** 2)  # 3.06
    assert zarraga_viscosity(0.31) == pytest.approx(8.0 * np.exp(-2.34 * 0.31))  # 3.87


def test_exponent_between_its_limits():
    """5.1 where viscosity rules, 2.7 where inertia does, in the middle at 10^(10/9)."""
    assert richardson_zaki_exponent(1e-9) == pytest.approx(5.1, abs=1e-6)
    assert richardson_zaki_exponent(1e12) == pytest.approx(2.7, abs=1e-6)
    assert richardson_zaki_exponent(10.0 ** (10.0 / 9.0)) == pytest.approx(3.9)


def test_a_sphere_alone():
    """Stokes: u = (rho_p/rho_f - 1) g D^2/(18 nu), Re = Ga^2/18."""
    assert settling_reynolds(0.01) == pytest.approx(1e-4 / 18.0, rel=1e-3)
    assert settling_reynolds(10.0) == pytest.approx(4.0, rel=2e-3)  # 24 (1 + 0.15 4^0.687) 4 = 133 = 4/3 100


def test_what_images_take():
    """One sphere in a wide box: Hasimoto's 2.8373 R/L; many: as the width, by S(0) = 1 - 8 phi of few."""
    share = np.pi / 6.0 / 40.0**3
    assert slower_by_images(share, 1.0) == pytest.approx(2.8373 * 0.5 / 40.0, rel=1e-3)
    assert structure_factor(1e-4) == pytest.approx(1.0 - 8e-4, abs=1e-6)
    assert structure_factor(0.3) == pytest.approx(0.7**4 / (1.6**2 - 0.027 * 3.7))
    assert slower_by_images(0.1, 800.0) == pytest.approx(0.5 * slower_by_images(0.1, 100.0))


class MadeUp:
    """Two instants of two spheres that fall along -x, at 1 and 2, then at 3 and 5."""

    def sample_blocks(self, since):
        time, tag, zero = np.array([0.0, 0.0, 1.0, 1.0]), np.array([1, 2, 1, 2]), np.zeros((4, 3))
        velocity = zero - np.array([1.0, 2.0, 3.0, 5.0])[:, None] * [1, 0, 0]
        return [Samples(time, tag, zero, velocity, zero, np.full(4, 0.5))]


def test_mean_fall_of_a_run():
    assert suspensions.mean_fall(MadeUp(), 0.0).tolist() == [1.5, 4.0]
