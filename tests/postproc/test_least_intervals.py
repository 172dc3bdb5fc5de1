"""Short records of a signal that swings slowly: what a long record of it leaves of their intervals."""

import math

import numpy as np
import pytest
from bedload_post import least_intervals, other_records
from bedload_post.batches import batches_of, estimate
from bedload_post.model_numbers import _estimated
from bedload_post.other_records import Record
from test_paper_statements import run_numbers

MEMORY, SAMPLES = 3.0, 20  # integral time in flow-throughs, and samples in one
SHORT, LONG = 10.0, 120.0


def swinging(generator, throughs):
    """First-order autoregression of mean 0 and variance 1 that remembers MEMORY flow-throughs."""
    keeps = math.exp(-1.0 / (MEMORY * SAMPLES))
    values = np.empty(int(throughs * SAMPLES))
    values[0] = generator.standard_normal()
    push = math.sqrt(1.0 - keeps**2) * generator.standard_normal(len(values))
    for n in range(1, len(values)):
        values[n] = keeps * values[n - 1] + push[n]
    return values


def numbers_of(values, throughs, **more):
    found = _estimated("mean_velocity", estimate(values, batches_of(throughs)))
    return run_numbers("rpm", flow_throughs=throughs, **{**found, **more})


def test_widened_intervals_hold_the_mean():
    """In 95 of 100 records or a few more, for the wider of two intervals is taken; batches alone in 83. With a length
    twice or half as wide all records and 86 of 100 would hold it; the binomial scatter of 400 is 0.01."""
    generator = np.random.default_rng(2)
    held, held_alone = [], []
    for _ in range(400):
        run = numbers_of(swinging(generator, SHORT), SHORT)
        longer = numbers_of(swinging(generator, LONG), LONG)
        held_alone.append(abs(run["mean_velocity"]) < run["mean_velocity_interval"])
        wide = least_intervals.widened(run, [longer])
        held.append(abs(wide["mean_velocity"]) < wide["mean_velocity_interval"])
    assert np.mean(held_alone) < 0.87
    assert 0.90 < np.mean(held) < 0.985


def test_intervals_grow_with_the_root_of_the_length():
    """Of every quantity that both have, never below its own, from the interval without the batches' memory where there
    is one; the longest record counts, and not one of another model or of less than four times the length."""
    run = run_numbers("rpm", flow_throughs=10.0, mean_velocity_interval=0.01, mean_height_interval=0.5)
    longest = dict(
        run, flow_throughs=90.0, mean_velocity_interval=0.04, mean_velocity_interval_if_independent=0.02,
        mean_height_interval_if_independent=0.1, spin_peak_interval=0.3, cells_per_diameter=6.0,
    )  # fmt: skip
    # One of an older program that kept no memory either: it cannot say what its batches scatter by.
    older = {n: v for n, v in longest.items() if "if_independent" not in n and n != "batch_memory"}
    others = [longest, dict(longest, flow_throughs=50.0), dict(longest, model="actm", flow_throughs=1000.0),
              older | {"flow_throughs": 200.0}]  # fmt: skip
    wide = least_intervals.widened(dict(run, spin_peak_interval=0.1, interval_too_narrow=True), others)
    assert wide["mean_velocity_interval"] == pytest.approx(0.06)
    assert wide["mean_height_interval"] == 0.5
    assert wide["spin_peak_interval"] == pytest.approx(0.9)
    assert not wide["interval_too_narrow"]
    assert least_intervals.widened(dict(run, flow_throughs=25.0), others)["mean_velocity_interval"] == 0.01


def test_an_older_record_gives_back_what_its_batches_scatter_by():
    values = swinging(np.random.default_rng(5), LONG)
    kept = estimate(values, 10)
    older = {"mean_velocity_interval": kept.half_width, "batches": 10, "batch_memory": kept.memory}
    assert kept.half_width > 1.1 * kept.half_width_if_independent
    assert least_intervals.half_if_independent(older, "mean_velocity") == pytest.approx(kept.half_width_if_independent)
    assert least_intervals.half_if_independent(dict(older, mean_height_interval=1.0), "mean_height") is None


def test_the_page_says_what_was_widened():
    run = run_numbers("rpm", flow_throughs=10.0, mean_velocity_interval=0.01, cells_per_diameter=20.0)
    own = dict(run, model="actm", mean_velocity_interval=0.2)
    long = [dict(v, flow_throughs=90.0, mean_velocity_interval_if_independent=0.02, cells_per_diameter=6.0)
            for v in (run, own)]  # fmt: skip
    values, beside = other_records.with_least_intervals(
        [run, own], [Record("long", long, True), Record("experiment", [run])]
    )
    assert [v["mean_velocity_interval"] for v in values] == pytest.approx([0.06, 0.2])
    assert beside[0].runs == long
    assert beside[1].runs == [run]  # other settings may swing otherwise
    assert least_intervals.widened_sentence(["rpm", "actm"], values).endswith(
        "beside these, of 90 flow-throughs at 6 cells: mean velocity of rpm ± 0.060 in place of 0.010; "
        "actm ± 0.200, its own."
    )
    assert least_intervals.widened_sentence(["rpm"], [run]) == ""
