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


def test_flux_over_fluid_is_of_the_time_of_the_statistics():
    """In a box of 4 x 3 a grain of radius 1, speed 9 before the statistics and 3 in them, and one of half the radius
    and speed 8; the fluid's flux is 3.2."""

    def blocks():
        velocity = np.array([[9.0], [8.0]] * 2 + [[3.0], [8.0]] * 8)
        yield SimpleNamespace(time=np.repeat(np.arange(10.0), 2), velocity=velocity, radius=np.array([1.0, 0.5] * 10))

    run = SimpleNamespace(diameter=9.0, box=(4.0, 9.0, 3.0), sample_blocks=blocks,
                          value={"statistics.from": 2.0}.__getitem__)  # fmt: skip
    flux = erosion.flux_over_fluid(run, statistics())
    assert flux.mean == pytest.approx(4.0 / 3.0 * np.pi * (3.0 + 8.0 / 8.0) / (4.0 * 3.0) / 3.2)
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
