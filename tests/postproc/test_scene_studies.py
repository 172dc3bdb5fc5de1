"""The studies of a person's own scene, on made-up answers: accuracy, effects, limits."""

import argparse
import math
from dataclasses import replace

import numpy as np
import pytest
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import find_scene
from bedload_post.outputs import Run
from bedload_studies import accuracy, accuracy_scene, effects, scene_answers, stability_scene
from bedload_studies.accuracy_scene import Choice, remaining, richardson
from bedload_studies.earlier_run import EarlierRun
from bedload_studies.scene_answers import Priced, Series
from bedload_studies.stability_scene import Knob, bisected, complaint
from synthetic import Story, even, write_run

TIME = np.linspace(0.0, 10.0, 101)


# --- Answers and prices ----------------------------------------------------------------------------------


def test_the_answers_of_a_run(tmp_path):
    story = Story(position=(3.0, 2.5, 4.0)).piece(5.0).piece(5.0, velocity=(0.4, 0.0, 0.3))
    found = scene_answers.series_of(Run(write_run(tmp_path / "run", even(story))))
    late = found["grain velocity"].mean(6.0)
    assert late.mean == pytest.approx(0.4)
    assert found["grain speed"].mean(6.0).mean == pytest.approx(0.5)
    assert found["largest grain speed"].mean(6.0).mean == pytest.approx(0.5)
    assert found["grain height"].mean(0.0).mean == pytest.approx(2.5)
    assert found["share moving"].mean(0.0).mean == pytest.approx(0.5, abs=0.01)
    assert found["driving force"].mean(0.0).mean == pytest.approx(0.004)
    assert scene_answers.chosen(found, None, 0.0) == "grain velocity"
    with pytest.raises(UserError, match="nearest is 'driving force'"):
        scene_answers.chosen(found, "driving forse", 0.0)
    with pytest.raises(UserError, match="do not move"):
        scene_answers.chosen({"flow energy": Series(TIME, 0.0 * TIME + 3.0)}, None, 0.0)


def test_an_answer_is_a_mean_over_time():
    """As long at 1 as at 3, where time.cfl has made the steps ten times shorter."""
    time = np.concatenate([np.arange(1, 101) * 0.01, 1.0 + np.arange(1, 1001) * 0.001])
    found = Series(time, np.where(np.arange(1100) < 100, 1.0, 3.0)).mean(0.0)
    assert found.mean == pytest.approx(2.0)
    assert found.batches == pytest.approx([1.0] * 5 + [3.0] * 5)


def test_a_price_is_a_number_when_it_is_long_or_agrees():
    assert Priced([4.0]).settled()
    assert not Priced([0.5, 0.5, 0.5]).settled()  # below three seconds in all
    assert Priced([1.0, 1.01, 1.0]).settled()
    assert not Priced([1.0, 1.3, 0.8]).settled()  # scatters
    assert Priced([1.0, 1.3, 0.8, 1.0, 1.2, 0.9]).settled()  # as often as it is tried
    assert Priced([1.0, 2.0, 1.1]).price == pytest.approx(1.1)  # a disturbed one does not count


def test_runs_go_in_turn_until_their_costs_are_numbers():
    order = []

    def work(name, seconds):
        def once():
            order.append(name)
            if name == "c":
                raise UserError("no")
            return Priced([seconds])

        return once

    found = scene_answers.interleaved([work("a", 2.0), work("b", 5.0), work("c", 1.0)], math.inf)
    assert "".join(order) == "abca"
    assert found[2] == "no"
    order.clear()
    scene_answers.interleaved([work("a", 0.1)], 0.0)
    assert order == ["a"]  # the time is up
    order.clear()
    found = scene_answers.interleaved([work("a", 4.0), work("b", 5.0)], math.inf, least=3)
    assert "".join(order) == "ababab"
    assert found[0].spread == 0.0
    order.clear()
    found = scene_answers.interleaved([work("a", 4.0), work("b", 5.0)], 0.0, known=[Priced([4.0])])
    assert "".join(order) == "b"


def test_no_run_begins_when_the_time_is_up(monkeypatch):
    """Within a round of repeats, too."""
    now = iter(range(100))
    monkeypatch.setattr(scene_answers.time, "monotonic", lambda: next(now))
    found = scene_answers.interleaved([lambda: Priced([4.0])] * 3, 3, least=3)
    assert [len(one.core_seconds) for one in found] == [2, 2, 1]


def test_runs_begin_where_an_earlier_one_ended(tmp_path):
    """Flow and grains; of a scene without grains the flow alone; a script that cannot place them is refused."""
    story = Story(position=(3.0, 2.5, 4.0)).piece(5.0).piece(5.0, velocity=(0.4, 0.0, 0.3))
    folder = write_run(tmp_path / "run", even(story))
    with pytest.raises(UserError, match="run has no state.h5"):
        EarlierRun.of(folder)
    (folder / "state.h5").touch()
    beginning = EarlierRun.of(folder)

    def work(name):
        out = tmp_path / name
        out.mkdir()
        return job.Job(find_scene(name), None, job.Ranks(1, 1), out, ["time.end=3"], variables={"density": "2"})

    begun = scene_answers.begun_from(beginning, work("setup2_small"))
    assert begun.overrides == ['start.from="state"', f'start.file="{folder / "state.h5"}"', "time.end=3"]
    assert begun.variables == {"density": "2", "placing": "placed"}
    assert "create_atoms 2 single" in (begun.out / "grains.liggghts").read_text()
    begun = scene_answers.begun_from(beginning, work("channel180"))
    assert begun.variables == {"density": "2"}
    assert not list(begun.out.iterdir())
    with pytest.raises(UserError, match="no line 'variable placing"):
        scene_answers.begun_from(beginning, work("exposed_sphere"))
    same = work("setup1_small")
    assert scene_answers.begun_from(None, same) is same


# --- Accuracy --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0])
def test_richardson_finds_order_and_limit(order):
    h = [1.25, 1.0, 0.8]
    limit, found = richardson(h, [5.0 + 0.3 * x**order for x in h])
    assert limit == pytest.approx(5.0, rel=1e-4)
    assert found == pytest.approx(order, abs=0.01)
    assert math.isnan(richardson(h, [5.0, 5.2, 5.1])[0])  # no trend
    assert math.isnan(richardson(h, [5.0, 5.1, 7.0])[0])  # grows


def test_what_remains():
    def run(mean, noise=0.0):
        return Priced([1.0], 1.0, {"q": Series(TIME, mean + noise * np.random.default_rng(5).normal(size=101))})

    tried = [Choice("own", h=1.0), Choice("coarse", h=1.25), Choice("fine", h=0.8), Choice("loops")]
    f = [5.0 + 0.5 * h**2 for h in (1.0, 1.25, 0.8)]
    error, half, source = remaining(tried, [*map(run, f), run(9.0)], "q", 5.0)
    assert error == pytest.approx(0.1, rel=1e-3) and half < 1e-9
    assert "order 2.0" in source
    error, half, source = remaining(tried[:3], [run(-value) for value in f], "q", 5.0)
    assert error == pytest.approx(-0.1, rel=1e-3) and "order 2.0" in source
    # The difference's interval over the share of the error that it is, 1 - 0.64.
    scattered = [run(f[0], 0.05), run(f[1]), run(f[2])]
    change, apart = scene_answers.paired(scattered[0].answers["q"], scattered[2].answers["q"], 5.0)
    error, half, source = remaining(tried[:3], scattered, "q", 5.0)
    order = float(source.split()[-1])
    assert error > 1.5 * abs(change)
    assert half / abs(error) == pytest.approx(apart / abs(change), rel=0.02) and order != 2.0
    wide = [run(f[0], 5.0), run(f[1]), run(f[2]), "ended"]
    error, half, source = remaining(tried, wide, "q", 5.0)
    assert half > 0.1 and "within the interval" in source
    # A coarser grid alone says nothing of the scene's own error, the finest grid being its own.
    for coarser in (run(f[1]), "ended"):
        error, half, source = remaining(tried, [run(5.0), coarser, "ended", run(9.0)], "q", 5.0)
        assert math.isnan(error) and math.isnan(half) and source == "no finer grid ran"


def test_the_price_is_that_of_the_whole_scene():
    """The study's runs stop short of the scene's end."""
    s = {"time": {"end": 1.0, "step": 0.1}, "grid": {"cells": [2, 2, 2]}, "accuracy": {"precision": "single"},
         "spheres": {"forcing_loops": 1}}  # fmt: skip
    taken = np.linspace(0.08, 1.0, 12)  # time.cfl has shortened some of the ten steps
    run = Priced([36.0], 1.0, {"driving force": Series(taken, taken)}, s)
    line = accuracy_scene.last_line(find_scene("channel180"), run, 0.1, 0.05, "why", "q", 10, 100.0)
    assert "3 core-seconds a step, 1 core-hours" in line
    assert "q +10.0 ± 5.0 % (why)" in line
    unknown = (math.nan, math.nan, "no finer grid ran")
    line = accuracy_scene.last_line(find_scene("channel180"), run, *unknown, "q", 10, 100.0)
    assert "q error not known (no finer grid ran), 3 core-seconds" in line and "nan" not in line


def test_the_table_stands_against_the_finest_grid():
    def run(value):
        return Priced([2.0], 50.0, {"q": Series(TIME, value + 0.001 * np.sin(7 * TIME))})

    tried = [Choice("own", h=1.0), Choice("fine", h=0.8), Choice("bad")]
    rows = accuracy_scene.rows_of(tried, [run(1.1), run(1.0), "it\nended."], "q", 5.0)
    assert rows[0].change == pytest.approx(0.1, abs=1e-3)
    assert rows[1].words == "finest" and rows[1].change == 0.0
    assert math.isnan(rows[2].price) and rows[2].words == "ended."
    assert "ended." in accuracy_scene.table_text(rows, "q")


def test_half_the_step_is_half_of_what_is_in_force():
    settings = {"time": {"step": 0.1, "cfl": 0.0}, "accuracy": {"precision": "single"}}
    for cfl, keys in ((0.0, ("time.step=0.05",)), (1.5, ("time.step=0.05", "time.cfl=0.75"))):
        settings["time"]["cfl"] = cfl
        tried = accuracy_scene.choices(find_scene("channel180"), settings)
        assert [c.keys for c in tried if c.label == "half the step"] == [keys]


def test_a_quantity_that_does_not_exist_is_found_before_the_long_runs(tmp_path, monkeypatch):
    steps = []

    def run_once(work, *_, **_more):
        steps.append(work.steps)
        return Priced([1.0], 1.0, {"flow energy": Series(TIME, TIME)}, {"time": {"step": 0.1, "end": 1.0}})

    monkeypatch.setattr(accuracy_scene, "run_once", run_once)
    parser = argparse.ArgumentParser()
    accuracy.add_options(parser)
    line = ["channel180", "--quantity", "flow enrgy", "--runs", str(tmp_path)]
    with pytest.raises(UserError, match="no quantity 'flow enrgy'; the nearest is 'flow energy'"):
        accuracy.run(parser.parse_args(line))
    assert steps == [1, 11]  # the trial alone
    with pytest.raises(UserError, match="--set grid.cells=.*this study changes grid and step itself"):
        accuracy.run(parser.parse_args([*line[:1], "--set", "grid.cells=[8,8,8]"]))
    assert steps == [1, 11]


# --- Effects ---------------------------------------------------------------------------------------------


def test_paired_differences_are_narrower_than_those_of_means():
    noise = np.random.default_rng(3).normal(size=101)
    base, mine = Series(TIME, 1.0 + 0.3 * noise), Series(TIME, 1.05 + 0.3 * noise)
    change, half = scene_answers.paired(mine, base, 5.0)
    assert change * np.mean(base.values[TIME >= 5.0]) == pytest.approx(0.05)
    assert half < 1e-9
    assert scene_answers.difference(mine.mean(5.0), base.mean(5.0))[1] > 0.05


def test_paired_differences_hold_with_other_steps():
    def wave(times, mean):
        return Series(times, mean + 0.3 * np.sin(times))

    change, half = scene_answers.paired(wave(np.linspace(0.0, 10.0, 163), 1.1), wave(TIME, 1.0), 5.0)
    late = TIME[TIME >= 5.0]
    assert change * np.mean(1.0 + 0.3 * np.sin(late)) == pytest.approx(0.1, rel=0.01)
    assert half < 1e-3
    # A run that goes on behind the other's end is compared up to it.
    long = np.linspace(0.0, 20.0, 201)
    change, half = scene_answers.paired(wave(long, 1.1), wave(TIME, 1.0), 5.0)
    assert change * np.mean(1.0 + 0.3 * np.sin(late)) == pytest.approx(0.1, rel=0.01) and half < 1e-3


@pytest.mark.parametrize(
    ("off", "change", "interval", "time", "verdict"),
    [
        (True, -0.10, 0.02, 0.9, "needed"),
        (False, 0.10, 0.02, 1.5, "worth it"),
        (True, 0.0, 0.0, 0.9, "leave it out"),  # lubrication where no pair comes near
        (False, 0.001, 0.005, 1.2, "leave it out"),
        (True, 0.001, 0.005, 0.99, "no matter"),
        (True, 0.01, 0.05, 0.8, "open"),
        (True, 0.10, 0.15, 0.8, "open"),
        (True, math.nan, math.nan, 0.8, "open"),
    ],
)
def test_verdicts(off, change, interval, time, verdict):
    assert effects.judged(off, change, interval, time) == verdict
    if verdict == "leave it out" and abs(time - 1.0) < 0.15:  # one run alone is not enough to say so
        assert effects.judged(off, change, interval, time, math.nan) == "no matter"


@pytest.mark.parametrize(("spread", "verdict"), [(0.07, "leave it out"), (0.09, "no matter")])
def test_a_time_within_two_spreads_says_nothing(spread, verdict):
    assert effects.judged(True, 0.0, 0.0, 1.0 / 1.16, spread) == verdict


def test_the_table_of_effects_keeps_its_columns_apart():
    row = effects.Compared("films against sliding and rolling", "on", 0.93, math.nan, 1.0, -0.008, 0.007, "no matter")
    other = replace(row, effect="output", state="as little as can be", spread=0.02)
    lines = effects.table_text([row, other]).split("\n")
    assert "rolling  on" in lines[1] and "nan" not in lines[1]
    assert {line.index(words) for line, words in zip(lines, ("verdict", "no matter", "no matter"), strict=True)} == {
        lines[0].index("verdict")
    }


# --- Limits ----------------------------------------------------------------------------------------------


def test_bisection_finds_the_limit_and_asks_no_value_twice():
    asked = []

    def fails(value):
        asked.append(value)
        return "too long" if value > 0.37 else ""

    limit = bisected(Knob("step", 0.1, True), fails)
    assert limit.holds <= 0.37 < limit.fails
    assert limit.fails / limit.holds < 1.05
    assert limit.distance == pytest.approx(limit.holds / 0.1)
    assert len(asked) == len(set(asked)) == 2 + stability_scene.HALVINGS
    free = bisected(Knob("density", 2.0, False), lambda _: "")
    assert math.isnan(free.fails) and free.holds == pytest.approx(2.0 / 32.0)


def test_whole_numbers_stay_whole():
    knob = Knob("steps", 60, False, whole=15)
    assert [knob.at(f) for f in (1.0, 1.4, 2.0, 32.0)] == [60, 45, 30, 15]
    limit = bisected(knob, lambda v: "few" if v < 45 else "")
    assert (limit.holds, limit.fails) == (45, 30)


def test_why_a_run_does_not_hold():
    def run(speed, energy=1.0):
        grains = Series(TIME, speed + 0 * TIME)
        return Priced([1.0], 1.0, {"largest grain speed": grains, "grain velocity": grains,
                                   "flow energy": Series(TIME, energy + 0 * TIME)})  # fmt: skip

    base = run(0.5)
    assert complaint(run(0.9), base) == ""
    assert "2.2 times" in complaint(run(1.1), base)
    assert "flow energy" in complaint(run(0.5, 2.0), base)
    assert "no number" in complaint(run(math.nan), base)
    assert complaint("mpirun\nthe CFL number is 1.8.", base) == "the CFL number is 1.8."
    swing = run(0.5)
    swing.answers["grain velocity"].values[-8:] = 0.02 * (-1.5) ** np.arange(8)
    assert "swing" in complaint(swing, base)


def test_the_step_that_is_in_force_is_turned():
    """With time.cfl, time.step is no more than the longest step: both are turned. A variable of two words is none."""
    settings = {"time": {"step": 0.1, "cfl": 0.0}, "coupling": {"exchange": "stage", "dem_steps": 15}}
    step, density = stability_scene.knobs(settings, {"density": "2.5", "gap": "1 2"})
    assert (step.name, step.keys(0.2), density.name, density.value) == ("step", ["time.step=0.2"], "density", 2.5)
    settings["time"]["cfl"] = 1.5
    follows = stability_scene.knobs(settings, {})[0]
    assert (follows.name, follows.keys(3.0)) == ("time.cfl", ["time.cfl=3.0", "time.step=0.2"])


@pytest.mark.parametrize("value", ["0", "0.0", "-1", "inf", "nan"])
def test_a_number_without_multiples_is_not_turned(value):
    """Of grains that begin in contact, say: no factor leads from there."""
    settings = {"time": {"step": 0.1}, "coupling": {"exchange": "stage", "dem_steps": 15}}
    turned = stability_scene.knobs(settings, {"density": value, "gap": value})
    assert [knob.name for knob in turned] == ["step"]
    assert "density" in stability_scene.not_turned(turned) and "gap" in stability_scene.not_turned(turned)


def test_limits_that_a_scene_offers_no_number_for_are_named():
    step, density = (Knob(name, 1.0, True) for name in ("step", "density"))
    assert stability_scene.not_turned([step, density]) == (
        "Not turned: LIGGGHTS' steps (already the fewest), gap (the script has no 'variable gap index NUMBER' above 0)."
    )
    everything = [Knob(name, 1.0, False) for name in ("step", "LIGGGHTS' steps", "density", "gap")]
    assert stability_scene.not_turned(everything) == ""
