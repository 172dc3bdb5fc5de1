"""Sentences of the report of models: right, wrong or open, from made-up numbers."""

import numpy as np
import pytest
from bedload_post import models_report, neighbours, paper_statements, transport
from bedload_post.collision_statistics import CollisionStatistics, collision_statistics, scales
from bedload_post.outputs import Run
from synthetic import wandering_story, write_run


def run_numbers(model, ratio=1.2, **more):
    """Numbers of one run that agree with the paper."""
    found = {
        "model": model, "density_ratio": ratio, "cells_per_diameter": 10.0,
        "mean_velocity": paper_statements.TABLE_2.get(model, 0.1), "mean_velocity_interval": 0.002,
        "mean_height": 1.5 if model.startswith("rpm") else 1.4, "mean_height_interval": 0.01,
        "spread_of_height": 0.2 if model.startswith("rpm") else 0.15, "spread_of_height_interval": 0.01,
        "spin_next_to_bed": -0.4 if "hw" in model else -0.1, "spin_above": -0.1, "spin_peak_height": 1.3,
        "jumping_spin": 0.3 if model == "rpm" else 0.2, "jumping_spin_interval": 0.01,
        "mean_jump_height": 0.3 if model.startswith("rpm") else 0.2, "mean_jump_height_interval": 0.01,
        "creeping_slip": -0.05 if "hw" in model else -0.8,
        "share_moving": 0.05, "share_moving_interval": 0.01,
        "bed_re_tau": 219.0, "bed_shields": 0.0241, "re_tau": 263.0,
        "share_resting": 0.2, "share_resting_interval": 0.02, "share_creeping": 0.3,
        "share_creeping_interval": 0.02, "share_jumping": 0.5, "share_jumping_interval": 0.02,
    }  # fmt: skip
    return found | more


def four(**changes):
    """Numbers of the four models, those of some changed."""
    return [run_numbers(model, **changes.get(model, {})) for model in paper_statements.TABLE_2]


def answers(setup, values, place, word=""):
    found = paper_statements.verdicts(setup, values)
    return [v.holds for v in found if v.place.startswith(place) and word in v.statement]


def test_runs_that_agree_are_right_throughout():
    found = paper_statements.verdicts(2, four())
    assert len(found) == 4 + 3 + 2 + 4 + 2 + 2 + 2 + 4 + 1
    assert all(v.holds for v in found), [v for v in found if not v.holds]
    assert paper_statements.verdicts(0, four()) == []
    assert paper_statements.far_off(2, four()) == []


def test_a_velocity_off_by_more_than_a_fifth_is_wrong():
    # 0.121 +- 20 %: 0.0968 to 0.1452
    for velocity, half, right in ((0.15, 0.002, False), (0.15, 0.01, None), (0.14, 0.002, True),
                                  (0.095, 0.001, False)):  # fmt: skip
        values = four(actm={"mean_velocity": velocity, "mean_velocity_interval": half})
        assert answers(2, values, "Table 2", "actm: mean velocity") == [right]
    values = four(actm={"mean_velocity": 0.15}, rpm={"mean_velocity": 0.37})
    assert [(v["model"], round(off, 3)) for v, off in paper_statements.far_off(2, values)] == [
        ("rpm", 0.498), ("actm", 0.24),
    ]  # fmt: skip


def test_other_records_stand_beside_these():
    values = [run_numbers("rpm"), run_numbers("actm", mean_velocity=0.1, mean_velocity_interval=0.03)]
    faster = [run_numbers("rpm", mean_velocity=0.3),
              run_numbers("actm", mean_velocity=0.12, mean_velocity_interval=0.03)]  # fmt: skip
    comparison = models_report.Comparison("", [], 2, {}, None, "setup2_small", {"faster": faster, "alone": faster[1:]})
    these, both, alone = models_report.beside_rows(comparison, values)
    assert these == ["these", "10", "0.247 ± 0.002", "0.100 ± 0.030", ""]
    assert both[-1] == "+21 %; +20 %, not told apart"
    assert alone[2:] == ["–", "0.120 ± 0.030", "+20 %, not told apart"]


@pytest.mark.parametrize("mean, interval", [(1e-5, 1e-6), (0.02, 0.03)])
def test_a_change_from_rest_is_not_in_per_cent(mean, interval):
    values = [run_numbers("rpm", mean_velocity=mean, mean_velocity_interval=interval)]
    moving = [run_numbers("rpm", mean_velocity=0.3, mean_velocity_interval=0.01)]
    comparison = models_report.Comparison("", [], 2, {}, None, "setup2_small", {"moving": moving})
    assert models_report.beside_rows(comparison, values)[1][-1] == f"{0.3 - mean:+.3f} u_b"


def test_neighbours_in_the_order_are_open_within_their_intervals():
    close = four(actm={"mean_velocity": 0.094}, actm_hw={"mean_velocity": 0.093})
    assert answers(2, close, "Table 2", "actm is faster than actm + HW") == [None]
    turned = four(actm={"mean_velocity": 0.08}, actm_hw={"mean_velocity": 0.093})
    assert answers(2, turned, "Table 2", "actm is faster than actm + HW") == [False]


@pytest.mark.parametrize(
    "slow, half, expected",
    [(0.093, 0.002, True), (0.118, 0.002, False), (0.11, 0.02, None), (0.121, 0.02, False)],
)
def test_friction_slows_by_its_share(slow, half, expected):
    """The paper: by 1 - 0.093/0.121 = 23 %."""
    values = four(actm_hw={"mean_velocity": slow, "mean_velocity_interval": half})
    assert answers(2, values, "Table 2", "friction slows actm by 23 %") == [expected]


def test_figures_10_and_11():
    values = four(actm_hw={"spread_of_height": 0.173, "spin_next_to_bed": -0.14, "spin_above": -0.2})
    assert answers(2, values, "Fig. 10", "spread of y of actm") == [False]  # 15 % wider
    assert answers(2, values, "Fig. 10", "spread of y of rpm") == [True]
    assert answers(2, values, "Fig. 11") == [True, False]
    weak = four(actm_hw={"spin_next_to_bed": -0.14, "spin_above": -0.1})  # 1.4 times, not 1.5
    assert answers(2, weak, "Fig. 11") == [True, False]
    above_it = four(actm_hw={"spin_above": -0.5})
    assert answers(2, above_it, "Fig. 11") == [True, False]
    unknown = four(actm_hw={"spin_next_to_bed": None})
    assert answers(2, unknown, "Fig. 11") == [True, None]


def test_motion_against_shields():
    moving = four(rpm={"share_moving": 0.6}, actm={"share_moving": 0.105})
    assert answers(2, moving, "Shields") == [False, True, None, True]
    strong = four(**{m: {"bed_shields": 0.05, "share_moving": 0.6} for m in paper_statements.TABLE_2})
    assert answers(2, strong, "Shields", "more than 10 %") == [True] * 4


def test_setup_1():
    heavy = {"share_resting": 0.7, "share_jumping": 0.1}
    values = [run_numbers(m, 1.25) for m in ("rpm", "actm")]
    values += [run_numbers("rpm", 2.25), run_numbers("actm", 2.25, **heavy)]
    assert answers(1, values, "Fig. 7") == [True, True]
    # rpm's shares stay: neither more nor less.
    assert answers(1, values, "Fig. 9", "rpm: ") == [None, None]
    assert answers(1, values, "Fig. 9", "actm: ") == [True, True]
    assert answers(1, values, "Fig. 9", "the models' shares differ more") == [True]
    assert answers(1, values, "Re_τ") == [True]
    slower = [run_numbers("rpm"), run_numbers("actm", jumping_spin=0.35)]
    assert answers(1, slower, "Fig. 7") == [False]


def test_experiments_are_commands_of_the_study():
    for model in paper_statements.TABLE_2:
        lines = paper_statements.experiments(model, "setup2_small", "10")
        assert all(f"--models {model} " in command for _, command in lines)
        assert len({command for _, command in lines}) == len(lines) >= 4


def test_a_record_that_drifts_is_told():
    stepping = np.repeat([0.0, 1.0], 50) + np.tile([0.0, 0.1], 50)
    part = transport.Transport(None, 10, [np.arange(100.0)], [np.ones(100)], [stepping])
    part.share = [np.tile([[0.4, 0.3, 0.3], [0.5, 0.3, 0.2]], (50, 1))]
    found = models_report.drift("velocity", *part.halves("velocity"))
    assert found["velocity_halves"] == pytest.approx([0.05, 1.05])
    assert found["velocity_drifts"] is True
    still = models_report.drift("resting", *part.halves("share", 0))
    assert still["resting_halves"] == pytest.approx([0.45, 0.45])
    assert still["resting_drifts"] is False
    values = [found | still]
    assert "differ by more than their intervals in mean velocity of rpm" in (
        models_report.drift_sentence(["rpm"], values)
    )
    calm = [models_report.drift("velocity", *part.halves("share", 0)) | still]
    assert models_report.drift_sentence(["rpm"], calm).startswith("No record drifts")


def test_intervals_of_histograms():
    """Two values, one in the odd parts and one in the even: t_{0.975, 9} s/sqrt(10)."""
    part = transport.Transport(None)
    counts = part.height_parts
    low, high = 20, 30  # bins of 0.02 D from 1 D: centres 1.41 and 1.61
    counts[0::2, 0, low], counts[1::2, 0, high] = 100, 100
    counts[0::2, 2, low], counts[1::2, 2, high] = 30.0, 50.0
    spread, half = part.spread_of_height()
    assert spread == pytest.approx(0.1, rel=1e-9)
    assert half == pytest.approx(0.0, abs=1e-9)  # every part is 0.1 off the mean
    y, mean = part.over_height(2)
    assert y == pytest.approx([1.41, 1.61])
    assert mean == pytest.approx([0.3, 0.5])
    assert part.over_height_interval(2) == pytest.approx([0.0, 0.0], abs=1e-12)
    # Density in the first bin: 50 in five parts, 0 in five: s = 26.352.
    assert part.pdf_interval("height")[low] == pytest.approx(2.26216 * 26.352 / np.sqrt(10), rel=1e-4)


def test_collisions_are_measured_in_t_c(tmp_path):
    """St = rho_p u D/(9 mu) = 1.25 u/(9 x 2.6578e-3)."""
    run = Run(write_run(tmp_path / "run", wandering_story()))
    assert np.isnan(collision_statistics(run).duration).all()  # no T_c in a log
    head = "tag_i,tag_j,time_start,time_end,impact_speed_normal,largest_overlap\n"
    (run.folder / "collisions.csv").write_text(
        head + "1,1000,1.0,1.7,0.02,0.001\n1,1000,3.0,3.35,0.2,0.01\n1,1001,5.0,6.4,0.04,0.0\n"
    )
    (run.folder / "log.part1.liggghts").write_text("scale: normal model actm: collision time = 0.5\n")
    (run.folder / "log.liggghts").write_text(
        "scale: normal model actm: collision time = 0.35\nscale: fix lubrication: range = 0.1\n"
    )
    assert scales(run)["fix lubrication", "range"] == 0.1
    found = collision_statistics(run, since=2.0)
    unit = 1.25 / (9 * 2.6578e-3)
    assert found.stokes == pytest.approx([0.2 * unit, 0.04 * unit])
    assert found.duration == pytest.approx([1.0, 4.0])
    assert found.overlap == pytest.approx([0.01, 0.0])
    assert CollisionStatistics(np.array([0.5, 2.0, 6.0, 7.0]), *[np.zeros(4)] * 2).share_below(5) == 0.5


def test_grains_that_feel_each_other():
    """Two that move alike, two that do not; distances round the periodic ends."""
    position = np.array([[[0.5, 1.5, 0.5], [15.5, 1.5, 7.5]]])
    apart = neighbours.distances(position, np.array([16.0, np.inf, 8.0]))
    assert apart == pytest.approx(np.full((1, 2), np.sqrt(2.0)))
    numbers = np.random.default_rng(3)
    alike = np.repeat(numbers.normal(size=(2000, 1)), 2, axis=1)
    far = np.full((2000, 2), 9.0)
    found = neighbours.of_series(far, alike)
    assert found.correlation == pytest.approx(1.0, abs=1e-9)
    assert found.independent is False
    assert found.share_near == 0.0
    apart_too = neighbours.of_series(far, numbers.normal(size=(2000, 2)))
    assert abs(apart_too.correlation) < 0.1
    assert apart_too.independent is True
    slowed = numbers.normal(size=(2000, 2))
    near = np.tile(np.array([[3.0], [9.0]]), (1000, 2))
    slowed[::2] -= 1.0  # whoever has another one near
    found = neighbours.of_series(near, slowed)
    assert found.share_near == 0.5
    assert found.velocity_far - found.velocity_near == pytest.approx(1.0, abs=0.1)
    assert found.independent is False
