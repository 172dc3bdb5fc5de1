"""Numbers of the law of erosion from profiles that are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from bedload_studies import validation_erosion as erosion
from bedload_studies import validation_erosion_law as law
from test_erosion import statistics


def test_gravity_alone_varies_and_both_programs_have_it():
    (fluid, variables), (other, _) = law.law_run(9.0, "actm_hw"), law.law_run(5.0, "actm_hw_static")
    assert {key for key in fluid if fluid[key] != other[key]} == {"fluid.gravity"}
    assert fluid["fluid.gravity"][1] == -variables["gravity"]
    assert variables["gravity"] * (variables["density"] - 1.0) == pytest.approx(9.0**2, rel=1e-5)
    assert fluid["reference.sphere_density"] == variables["density"]
    assert fluid["grid.length"][1] == variables["length_y"] and fluid["grid.cells"][1] == 6.0 * variables["length_y"]


def test_the_flow_starts_with_the_flux_it_is_driven_with():
    fluid, _ = law.law_run(9.0, "actm_hw")
    clear = fluid["grid.length"][1] - fluid["start.height"]
    assert fluid["start.velocity"] * clear == pytest.approx(law.REYNOLDS, rel=0.02)
    assert fluid["flow.bulk_velocity"] * fluid["grid.length"][1] == pytest.approx(law.REYNOLDS)


def test_power_law_and_its_interval():
    x = np.array([0.2, 0.3, 0.4, 0.6])
    assert law.power_law(x, 1.5 * x**3) == pytest.approx((3.0, 1.5, 0.0), abs=1e-9)
    # The interval by the textbook's formula, from residuals of +-10 % with no slope of their own.
    x, off = np.exp(np.array([-1.0, 0.0, 1.0])), np.array([0.05, -0.1, 0.05])
    exponent, _, half = law.power_law(x, x**2 * np.exp(off))
    assert exponent == pytest.approx(2.0)
    assert half == pytest.approx(12.706 * np.sqrt(np.sum(off**2) / 1 / 2.0), rel=1e-3)


def test_shields_number_of_the_parabola():
    """A clear height of 2 above a packing of 0.1: halfway between planes at 1.5 and 2.5 a sixth further up."""
    run = SimpleNamespace(box=(1.0, 4.0, 1.0), diameter=0.5, viscosity=2.0, submerged_weight=6.0,
                          value={"fluid.density": 3.0}.__getitem__)  # fmt: skip
    height, shields = law.shields_of_parabola(run, statistics())
    assert height == pytest.approx((4.0 - 1.5 - 5.0 / 6.0) / 0.5)
    assert shields == pytest.approx(6.0 * 3.2 / (2.0 * 0.5**3 / 2.0) / height**2)  # Ga^2 nu = 2 x 0.5^3/2


def test_flux_below_a_height():
    s = statistics()
    s.profiles["mobile"], s.profiles["grain_u"] = np.array([0.3, 0.6, 0.0, 0.0]), np.array([0.5, 0.5, 0.0, 0.0])
    assert erosion.surface_of(s) == 1.5
    assert law.flux_below(s, 1.0) == pytest.approx(1.0 / 3.0)


def test_point_of_the_law_is_in_viscous_units_and_of_its_window():
    """Two grains of D = 2 in a box of 4 x 3, speeds 3 and 5 in the window; Ga^2 nu = 0.5 x 2^3/(4 x 0.25)."""

    def blocks():
        yield SimpleNamespace(time=np.array([1.0, 1.0, 4.0, 4.0]), velocity=np.array([[9.0], [9.0], [3.0], [5.0]]),
                              radius=np.ones(4))  # fmt: skip

    run = SimpleNamespace(
        submerged_weight=0.5, viscosity=0.25, diameter=2.0, box=(4.0, 9.0, 3.0), sample_blocks=blocks,
        value={"fluid.density": 4.0}.__getitem__,
        history=lambda: {"time": np.array([1.0, 4.0]), "wall_stress_upper": np.array([9.0, -0.03])},
    )  # fmt: skip
    shields, flux = law.law_point(run, (2.0, 5.0))
    assert shields == pytest.approx(0.03 / (0.5 * 2.0))
    assert flux == pytest.approx(np.pi / 6.0 * 2.0**3 * 8.0 / (4.0 * 3.0) / 4.0)
