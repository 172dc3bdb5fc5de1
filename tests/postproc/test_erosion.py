"""Numbers of the erosion case from profiles that are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from bedload_post.batches import Estimate
from bedload_studies import validation_erosion as erosion


def test_height_is_measured_from_the_highest_place_where_the_share_is_passed():
    y, grains = np.array([0.5, 1.5, 2.5, 3.5]), np.array([0.6, 0.2, 0.6, 0.0])
    assert erosion.height_above(y, grains, 0.3, 4.0) == pytest.approx(1.0)  # halfway between 2.5 and 3.5


def test_height_of_plane_poiseuille_flow():
    h, viscosity, gradient = 7.0, 0.5, 0.02
    flux = gradient * h**3 / (12.0 * viscosity)
    assert erosion.height_of_stress(flux, 0.5 * gradient * h, viscosity) == pytest.approx(h)


def statistics():
    """Four planes, half a packing in the lower two; the stress is that of a clear height of 2."""
    profiles = {
        "y": np.arange(4) + 0.5, "y_face": np.arange(5.0), "fluid": np.array([0.4, 0.4, 1.0, 1.0]),
        "u": np.array([0.0, 0.5, 2.0, 1.0]), "grains": np.array([0.6, 0.6, 0.0, 0.0]),
        "mobile": np.array([0.0, 0.6, 0.0, 0.0]), "grain_u": np.array([0.0, 0.5, 0.0, 0.0]),
    }  # fmt: skip
    found = SimpleNamespace(viscosity=2.0, density=1.0, wall_stress=np.array([0.0, 6.0 * 2.0 * 3.2 / 4.0]))
    found.__dict__["profiles"] = profiles
    return type("S", (), {**vars(found), "__getitem__": lambda self, name: profiles[name]})()


def test_fluxes_are_sums_of_share_velocity_and_height():
    assert erosion.fluxes(statistics()) == pytest.approx((0.4 * 0.5 + 2.0 + 1.0, 0.6 * 0.5))


def test_rows_hold_the_shields_number_of_the_height():
    rows = {row.what: row for row in erosion.rows_of(statistics(), 4.0, erosion.CASES_OF_FLUX[0], 0.5)}
    name = "Re_b 0.301: "
    assert rows[name + "Re_b of the fluid's flux"].found == pytest.approx(1.6)
    assert rows[name + "h_f/D of the flux and the upper wall's stress"].found == pytest.approx(4.0)
    shields = rows[name + "Shields number with the first of them"].found
    assert shields == pytest.approx(6.0 * 1.6 / 0.397**2 / 16.0)


def test_power_law_and_its_interval():
    x = np.array([0.2, 0.3, 0.4, 0.6])
    assert erosion.power_law(x, 1.5 * x**3) == pytest.approx((3.0, 1.5, 0.0), abs=1e-9)
    # The interval by the textbook's formula, from residuals of +-10 % with no slope of their own.
    x, off = np.exp(np.array([-1.0, 0.0, 1.0])), np.array([0.05, -0.1, 0.05])
    exponent, _, half = erosion.power_law(x, x**2 * np.exp(off))
    assert exponent == pytest.approx(2.0)
    assert half == pytest.approx(12.706 * np.sqrt(np.sum(off**2) / 1 / 2.0), rel=1e-3)


def test_larger_stress_shears_the_bed_as_far_in_as_many_steps():
    once, twice = erosion.deep(1.0, 1.0, erosion.AT_REST)[0], erosion.deep(2.0, 1.0, erosion.AT_REST)[0]
    for key in ("time.end", "time.step", "output.spheres_every", "statistics.from"):
        assert twice[key] == pytest.approx(once[key] / 2.0)
    assert twice["flow.bulk_velocity"] == pytest.approx(2.0 * once["flow.bulk_velocity"], rel=1e-4)


def test_each_friction_has_its_own_model_and_window():
    for friction in (erosion.AT_REST, erosion.DAMPER):
        fluid, variables = erosion.deep(2.0, 2.0, friction)
        assert variables["model"] == friction.model
        assert (fluid["statistics.from"], fluid["time.end"]) == pytest.approx([t / 2.0 for t in friction.window])
    assert erosion.AT_REST.label(2.0) != erosion.DAMPER.label(2.0)


def test_higher_channel_keeps_the_pull_of_the_pressure_gradient():
    """Twice the stress in twice the height, so that the gradient 2 tau/h is the same: eight times the flux."""
    once, twice = erosion.deep(1.0, 1.0, erosion.AT_REST)[0], erosion.deep(2.0, 2.0, erosion.AT_REST)[0]
    flux = [run["flow.bulk_velocity"] * run["grid.length"][1] for run in (once, twice)]
    assert flux[1] == pytest.approx(8.0 * flux[0], rel=1e-3)
    assert twice["reference.velocity"] == pytest.approx(4.0 * once["reference.velocity"], rel=1e-3)
    assert twice["grid.cells"][1] == round(6.0 * twice["grid.length"][1])
    clear = [run["grid.length"][1] - erosion.DEEP for run in (once, twice)]
    assert clear[1] == pytest.approx(2.0 * clear[0], abs=0.5)
    assert erosion.deep(2.0, 2.0, erosion.AT_REST)[1]["length_y"] == twice["grid.length"][1]


def test_shields_number_of_the_parabola():
    """A clear height of 2 above a packing of 0.1: halfway between planes at 1.5 and 2.5 a sixth further up."""
    run = SimpleNamespace(box=(1.0, 4.0, 1.0), diameter=0.5)
    height, shields = erosion.shields_of_parabola(run, statistics())
    assert height == pytest.approx((4.0 - 1.5 - 5.0 / 6.0) / 0.5)
    assert shields == pytest.approx(6.0 * 3.2 / 2.0 / 0.397**2 / height**2)


def test_flux_below_a_height():
    s = statistics()
    s.profiles["mobile"], s.profiles["grain_u"] = np.array([0.3, 0.6, 0.0, 0.0]), np.array([0.5, 0.5, 0.0, 0.0])
    assert erosion.surface_of(s) == 1.5
    assert erosion.flux_below(s, 1.0) == pytest.approx(1.0 / 3.0)


def test_point_of_the_law_is_in_viscous_units_and_of_its_window():
    """Two grains of D = 2 in a box of 4 x 3, speeds 3 and 5 in the window; Ga^2 nu = 0.5 x 2^3/(4 x 0.25)."""

    def blocks():
        yield SimpleNamespace(time=np.array([1.0, 1.0, 4.0, 4.0]), velocity=np.array([[9.0], [9.0], [3.0], [5.0]]))

    run = SimpleNamespace(
        submerged_weight=0.5, viscosity=0.25, diameter=2.0, box=(4.0, 9.0, 3.0), sample_blocks=blocks,
        value={"fluid.density": 4.0}.__getitem__,
        history=lambda: {"time": np.array([1.0, 4.0]), "wall_stress_upper": np.array([9.0, -0.03])},
    )  # fmt: skip
    shields, flux = erosion.law_point(run, (2.0, 5.0))
    assert shields == pytest.approx(0.03 / (0.5 * 2.0))
    assert flux == pytest.approx(np.pi / 6.0 * 2.0**3 * 8.0 / (4.0 * 3.0) / 4.0)


def test_flux_over_fluid_is_of_the_time_of_the_statistics():
    """One grain of D = 2 in a box of 4 x 3, speed 9 before the statistics and 3 in them; the fluid's flux is 3.2."""

    def blocks():
        yield SimpleNamespace(time=np.arange(10.0), velocity=np.array([[9.0]] * 2 + [[3.0]] * 8))

    run = SimpleNamespace(diameter=2.0, box=(4.0, 9.0, 3.0), sample_blocks=blocks,
                          value={"statistics.from": 2.0}.__getitem__)  # fmt: skip
    flux = erosion.flux_over_fluid(run, statistics())
    assert flux.mean == pytest.approx(np.pi / 6.0 * 2.0**3 * 3.0 / (4.0 * 3.0) / 3.2)
    assert flux.half_width == pytest.approx(0.0)


def test_choices_are_told_apart_where_the_difference_is_larger_than_its_interval():
    """3 and 4 add up to 5."""

    def found(mean, half_width):
        return Estimate(mean, half_width, np.array([]))

    sentences = erosion.sentences_of(
        {erosion.SHALLOW: found(10.0, 3.0), "more": found(15.1, 4.0), "less": found(4.9, 4.0),
         "near": found(14.9, 4.0), "nearer": found(5.1, 4.0)}
    )  # fmt: skip
    assert sentences == [
        "The grains' flux differs from that of the bed of 9 D with: more, less.",
        "The grains' flux is not told apart from that of the bed of 9 D with: near, nearer.",
    ]
    assert erosion.sentences_of({erosion.SHALLOW: found(10.0, 3.0)}) == []


def test_a_choice_changes_all_that_belongs_to_it():
    """The clear height stays, the flux for a unit width does, and box and cells are those of both programs."""
    for name, (fluid, variables) in erosion.CHOICES.items():
        cells, length = fluid.get("grid.cells", [48, 96, 36]), fluid.get("grid.length", [8.0, 16.0, 6.0])
        assert [n / 6.0 for n in cells] == length, name
        assert variables.get("length_x", 8.0) == length[0] and variables.get("length_y", 16.0) == length[1], name
        assert fluid.get("flow.bulk_velocity", 0.019) * length[1] == pytest.approx(0.019 * 16.0), name
        assert length[1] - fluid.get("start.height", 9.1) == pytest.approx(6.9), name


def test_fifths_are_means_over_500_time_units():
    time = np.arange(0.0, 2500.0, 100.0)
    values = np.repeat([1.0, 2.0, 4.0, 8.0, 16.0], 5)
    assert erosion.fifths_of(time, values) == [1.0, 2.0, 4.0, 8.0, 16.0]
