"""The rheology of a suspension, and what a bed that has it carries."""

import math

import pytest
from bedload_studies import suspension_rheology as rheology


def test_friction_between_its_limits():
    """0.32 at rest, 0.7 and the fluid's part where it is fast; by hand at J = 0.005."""
    assert rheology.friction(1e-12) == pytest.approx(0.32, abs=1e-5)
    assert rheology.friction(0.005) == pytest.approx(0.32 + 0.19 + 0.005 + 1.4625 * math.sqrt(0.005))
    assert rheology.friction(1e6) == pytest.approx(1e6, rel=2e-3)  # a fluid: stress = mu gamma


@pytest.mark.parametrize("number", [1e-6, 1e-3, 0.1, 10.0])
def test_viscous_number_is_the_inverse(number):
    assert rheology.viscous_number(rheology.friction(number)) == pytest.approx(number, rel=1e-6)
    assert rheology.viscous_number(0.31) == 0.0


def test_speed_and_flux_follow_from_the_stress():
    """The bed creeps down to where 0.32 of its weight bears the stress; with twice of it both the depth that moves and
    the shear rate are about twice as large, and the flux as the cube."""
    bed, other = (rheology.moving_bed(stress, 0.05, 0.1, 9.0) for stress in (0.2, 0.4))
    assert 0.2 < bed.stress < 0.22  # where a tenth is grains
    assert math.log2(other.flux / bed.flux) == pytest.approx(3.0, abs=0.2)
    assert bed.flux < rheology.PACKED * 9.0 * bed.speed
    # Nothing moves where the stress stays below what friction at rest bears from the first layer on.
    assert rheology.moving_bed(0.0, 0.1, 0.1, 9.0).flux == 0.0


def test_flow_over_the_bed_is_that_of_its_flux():
    """Without motion both stresses are those of the parabola, 6 q/h^2; a bed that moves has less at its top, and takes
    from the wall, too: with the top at u both are 6 (q - u h/2)/h^2 -+ u/h."""
    slow = rheology.bed_under_flow(0.1, 10.0, 0.1, 9.0)
    assert slow.flux < 1e-6 and slow.wall_stress == pytest.approx(6e-3, rel=2e-3)
    flux, height = 4.565, 9.456
    found = rheology.bed_under_flow(flux, height, 0.1, 9.0)
    assert found.flux == pytest.approx(0.00924, rel=0.01)
    parabola = 6.0 * flux / height**2
    assert found.flux < rheology.moving_bed(parabola, 2.0 * parabola / height, 0.1, 9.0).flux
    speed = (parabola - found.wall_stress) * height / 2.0
    assert speed == pytest.approx(0.091, rel=0.02)
    force = 12.0 * (flux - 0.5 * speed * height) / height**3
    bed = rheology.moving_bed(0.5 * force * height - speed / height, force, 0.1, 9.0)
    assert bed.speed == pytest.approx(speed, rel=0.1)
