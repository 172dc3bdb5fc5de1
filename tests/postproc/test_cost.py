"""The estimate of a scene's cost: grids of the trials, scaling by part, memory by program, markers and cells."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from bedload_launcher import cost, job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import find_scene
from bedload_launcher.trial import Trial, allowed_step, derived_numbers, run_trial


def trial(cells, parts, fluid_bytes=0, output=0.0):
    settings = {
        "grid": {"cells": list(cells)},
        "time": {"step": 0.1, "end": 10.0},
        "output": {"fields_every": 5.0},
    }
    return Trial(settings, 10, parts, output, fluid_bytes, 7)


@pytest.mark.parametrize("cells", [(160, 90, 80), (1040, 180, 540), (512, 512, 512), (97, 97, 97)])
def test_trial_grids_keep_the_proportions_and_fit(cells):
    grids = cost.smaller_grids(cells)
    assert len(grids) == 2
    for grid in grids:
        assert math.prod(grid) <= cost.MANY_CELLS
        assert grid[0] * cells[1] == cells[0] * grid[1]
        assert grid[0] * cells[2] == cells[0] * grid[2]
    large, small = (math.prod(g) for g in grids)
    assert large / 8.1 <= small <= 0.6 * large
    # The largest that fits and is as fast to transform.
    unit = math.gcd(*cells)
    for m in range(grids[0][0] * unit // cells[0] + 1, unit + 1):
        next_up = [n * m // unit for n in cells]
        slow = cost.largest_factor(next_up) > max(7, cost.largest_factor(cells))
        assert slow or math.prod(next_up) > cost.MANY_CELLS


def test_a_small_scene_is_its_own_trial_and_nothing_is_scaled():
    assert cost.smaller_grids((160, 90, 80))[0] == (160, 90, 80)
    parts = {"markers": 2.0, "pressure": 3.0, "exchange": 0.1}
    e = cost.from_trials((160, 90, 80), [trial((160, 90, 80), parts)])
    assert e.step_seconds == pytest.approx(5.1)


def test_a_grid_without_smaller_ones_is_refused_in_one_sentence():
    with pytest.raises(UserError, match="1009 x 1013 x 1019 cells have no smaller grid"):
        cost.smaller_grids((1009, 1013, 1019))


def test_each_part_is_scaled_by_its_own_law():
    """Twice the cells per edge: volumes 8, surfaces 4, transforms 8 log(4 n^2)/log(n^2), grains 1."""
    parts = {"fluid predictor": 1.0, "markers": 1.0, "exchange": 1.0, "pressure": 1.0}
    e = cost.from_trials((128, 128, 128), [trial((64, 64, 64), parts)])
    assert e.step_seconds == pytest.approx(8 + 4 + 1 + 8 * 14 / 12)


def test_memory_has_a_part_of_the_program_one_of_markers_and_one_of_cells():
    def found(s):
        return 30e6 + 50e6 * s**2 + 200e6 * s**3

    sizes = [0.5, 0.4]
    assert cost.fluid_memory(sizes, [found(s) for s in sizes], 30e6) == pytest.approx(280e6)
    # Without a second trial, or with one that fits no such curve, the cells decide.
    assert cost.fluid_memory([0.5], [40e6], 30e6) == pytest.approx(30e6 + 8 * 10e6)
    assert cost.fluid_memory(sizes, [40e6, 39e6], 30e6) == pytest.approx(30e6 + 8 * 10e6)


def test_writing_goes_by_volume_and_by_what_writes():
    """A state and fields at the end, fields twice before, each step its rows; the start as it was."""
    trials = [
        replace(trial((40, 40, 40), {"pressure": 0.0, "markers": 1e-3}, output=0.5 + 10 * 2e-3),
                checkpoint_seconds=0.3, start_seconds=1.0),
        trial((20, 20, 20), {}),
    ]  # fmt: skip
    longer = replace(trials[0], steps=40, output_seconds=0.5 + 40 * 2e-3)
    e = cost.from_trials((80, 80, 80), trials, longer)
    assert e.dem_bytes == 7
    assert e.steps == 100
    assert e.step_seconds == pytest.approx(4e-3 + 8 * 2e-3)
    assert e.output_seconds == pytest.approx(8 * (3 * 0.5 + 0.3) + 1.0)  # t = 5, 10 and the end


def test_checkpoints_are_counted_by_time_and_by_clock():
    settings = {"time": {"end": 10.0}, "output": {"fields_every": 0.0},
                "checkpoint": {"every": 4.0, "wall_every": 600.0}}  # fmt: skip
    assert cost.writings(settings, 100, 50.0) == (1, 1 + 2)
    assert cost.writings(settings, 100, 1300.0) == (1, 1 + 2 + 2)


@pytest.mark.parametrize(("cells", "grid"), [((160, 90, 80), (32, 18, 16)), ((288, 96, 144), (48, 16, 24))])
def test_the_programs_own_memory_is_seen_on_the_smallest_grid(cells, grid):
    assert cost.smallest_grid(cells) == grid


@pytest.mark.parametrize(("cells", "factor"), [((288, 96, 144), 3), ((234, 90, 117), 13), ((97, 4, 8), 97)])
def test_the_slowest_length_to_transform(cells, factor):
    assert cost.largest_factor(cells) == factor


def test_repeats_give_the_least_time_and_the_most_memory():
    best = cost.fastest(
        [trial((8, 8, 8), {"a": 1.0, "b": 3.0}, 5), trial((8, 8, 8), {"a": 2.0, "b": 1.0}, 9)]
    )
    assert best.step_parts == {"a": 1.0, "b": 1.0}
    assert best.fluid_bytes == 9


def test_a_step_that_follows_the_flow_goes_with_the_cell():
    row = {"dt": "0.05", "cfl": "0.8"}
    assert allowed_step({"time": {"cfl": 0.0}}, row) == math.inf
    assert allowed_step({"time": {"cfl": 1.6}}, row) == pytest.approx(0.1)
    coarse = replace(trial((64, 64, 64), {}), cfl_step=0.15)
    assert cost.from_trials((64, 64, 64), [coarse]).steps == 100  # time.step is the longest
    assert cost.from_trials((128, 128, 128), [coarse]).steps == math.ceil(10 / 0.075)


def test_durations_and_memory_read_well():
    assert cost.duration(41) == "41.0 s"
    assert cost.duration(600) == "10.0 min"
    assert cost.duration(3 * 86400) == "3.0 days"
    assert cost.memory(2.5e9) == "2.50 GB"
    assert cost.memory(81e6) == "81 MB"
    assert cost.memory(23104) == "23.1 kB"


def test_cells_in_the_boundary_layer_go_with_the_grid():
    """Read from the trial's settings.toml, scaled to the scene's own cells, said with what they are good for; a
    scene without falling spheres says nothing of it."""
    numbers = {"cell": 0.2, "falling_reynolds": 400.0, "cells_per_layer": 0.3}
    text = "".join(f"# derived.{name} = {value:g}  # what it is\n" for name, value in numbers.items())
    derived = derived_numbers(text + "[grid]\ncells = [4, 4, 4]\n")
    assert derived == numbers
    coarse = replace(trial((40, 40, 40), {"pressure": 1e-3}), derived=derived)
    ranks = job.Ranks.parse("1:1")
    for cells, words in ((40, "0.3 cells"), (80, "0.6 cells"), (160, "1.2 cells"), (220, "1.6 cells")):
        e = cost.from_trials((cells,) * 3, [coarse])
        assert e.cells_per_layer == pytest.approx(0.3 * cells / 40) and e.falling_reynolds == 400.0
        said = cost.describe(e, ranks, True, 1e12)
        assert f"boundary layer {words}" in said and "Re 400" in said
        for what, which in (("fewer than were ever tried", 40), ("too few for an oblique wake", 80),
                            ("leans too little", 160), ("and an oblique wake", 220)):  # fmt: skip
            assert (what in said) == (cells == which)
    still = cost.from_trials((80, 80, 80), [trial((40, 40, 40), {"pressure": 1e-3})])
    assert "boundary layer" not in cost.describe(still, ranks, True, 1e12)


@pytest.mark.parametrize("every, samples", [(0.0, 101), (0.5, 21), (0.04, 101), (20.0, 1)])
def test_size_of_the_samples_is_said(every, samples):
    """100 steps of 0.1; a sample of the start, of each step or as often as told; 19 numbers a grain."""
    larger = replace(trial((160, 90, 80), {"markers": 1.0}), mobile_spheres=1000)
    larger.settings["output"]["spheres_every"] = every
    e = cost.from_trials((160, 90, 80), [larger])
    assert e.samples == samples
    size = cost.memory(1000 * samples * 19 * 8)
    assert f"spheres.h5     {size}: 1000 mobile spheres, {samples} samples" in cost.describe(
        e, job.Ranks(1, 1), True, 1e12
    )


def test_a_small_scene_is_tried_on_no_other_grid(monkeypatch):
    """A coarser one, on which the scene may not run, says nothing: the memory found is the scene's own."""
    tried = []

    def made_up(work):
        tried.append(work.overrides[-1])
        return trial((64, 64, 64), {"momentum": 1.0}, fluid_bytes=5e8)

    monkeypatch.setattr(cost, "run_trial", made_up)
    whole = job.Job(find_scene("setup2_small"), "rpm", job.Ranks(2, 1), Path("."))
    e = cost.estimate(whole, (64, 64, 64), print)
    assert tried == cost.REPEATS * ["grid.cells=[64, 64, 64]"]
    assert e.fluid_bytes == pytest.approx(5e8)


def test_the_reason_of_a_trial_that_fails_is_its_sentence():
    words = "LIGGGHTS\nbedload-dem: ERROR: fix lubrication: write 'neighbor 0.8 bin' or more (/a/keywords.cpp:47)\n"
    assert cost.reason(words) == "fix lubrication: write 'neighbor 0.8 bin' or more"


class NoStep(job.Job):
    """A run that is over at its start."""

    def command(self):
        files = {
            "settings.toml": "time = {end = 0.0, cfl = 0.0}",
            "timing.csv": "part,seconds_mean_over_ranks",
            "history.csv": "step,dt,cfl,mobile_spheres\n0,0.1,0.0,1",
        }
        return ["sh", "-c", "; ".join(f"printf '{text}\n' > {self.out / name}" for name, text in files.items())]


def test_a_trial_without_steps_is_refused_in_one_sentence():
    scene = find_scene("setup2_small")
    with pytest.raises(UserError, match="setup2_small has no step to measure: with 'time.end' = 0 it is over after 0"):
        run_trial(NoStep(scene, None, job.Ranks(1, 1), scene.folder))


def test_trials_are_the_run_on_smaller_grids(monkeypatch):
    """Model, ranks and variables of the script are the run's own, the grid and the number of steps the trial's."""
    tried = []

    def made_up(work):
        tried.append(work)
        return trial(json.loads(work.overrides[-1].split("=")[1]), {"momentum": 1.0})

    monkeypatch.setattr(cost, "run_trial", made_up)
    whole = job.Job(
        find_scene("setup2_small"), "rpm", job.Ranks(2, 1), Path("."), ["time.end=5"], variables={"friction": "0.3"}
    )
    cost.estimate(whole, (64, 64, 64), print, most=60**3)
    assert len(tried) == cost.REPEATS + 2
    for work in tried:
        assert (work.model, work.ranks, work.variables) == ("rpm", job.Ranks(2, 1), {"friction": "0.3"})
        assert work.overrides[0] == "time.end=5" and work.overrides[-1].startswith("grid.cells=")
        assert work.steps
    assert tried[-1].fluid_alone and not tried[0].fluid_alone
