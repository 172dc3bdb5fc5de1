"""Sentences of the report of models: right, wrong or open, from made-up numbers."""

import numpy as np
import pytest
from bedload_post import model_numbers, model_sentences, models_report, neighbours, paper_statements, transport
from bedload_post.collision_statistics import CollisionStatistics, collision_statistics, scales
from bedload_post.outputs import Run
from synthetic import wandering_story, write_run


def run_numbers(model, ratio=1.2, **more):
    """Numbers of one run that agree with the paper."""
    found = {
        "model": model, "density_ratio": ratio, "cells_per_diameter": 10.0,
        "mean_velocity": paper_statements.TABLE_2.get(model, 0.1), "mean_velocity_interval": 0.002,
        "flow_throughs": 30.0, "box_length": 26.0, "grains": 125,
        "mean_height": 1.5 if model.startswith("rpm") else 1.4, "mean_height_interval": 0.01,
        "spread_of_height": 0.2 if model.startswith("rpm") else 0.15, "spread_of_height_interval": 0.002,
        "low_height": 1.45 if model.startswith("rpm") else 1.33, "low_height_interval": 0.01,
        "spin_peak": -0.4 if "hw" in model else -0.1, "spin_peak_interval": 0.02, "spin_peak_height": 1.55,
        "spin_above": -0.1, "spin_above_interval": 0.02,
        "jumping_spin": 0.3 if model == "rpm" else 0.2, "jumping_spin_interval": 0.01,
        "mean_jump_height": 0.3 if model.startswith("rpm") else 0.2, "mean_jump_height_interval": 0.01,
        "creeping_slip": -0.05 if "hw" in model else -0.8, "creeping_slip_interval": 0.02,
        "share_moving": 0.05, "share_moving_interval": 0.01,
        "bed_re_tau": 219.0, "bed_re_tau_interval": 5.0, "bed_shields": 0.0241, "bed_shields_interval": 0.001,
        "re_tau": 263.0, "share_resting": 0.1, "share_resting_interval": 0.02, "share_creeping": 0.3,
        "share_creeping_interval": 0.02, "share_jumping": 0.6, "share_jumping_interval": 0.02,
    }  # fmt: skip
    return found | more


def four(**changes):
    """Numbers of the four models, those of some changed."""
    return [run_numbers(model, **changes.get(model, {})) for model in paper_statements.TABLE_2]


def not_kept(values, *names):
    """The numbers without some, as records of older versions keep them."""
    return [{name: value for name, value in v.items() if name not in names} for v in values]


def answers(setup, values, place, word=""):
    found = paper_statements.verdicts(setup, values)
    return [v.holds for v in found if v.place.startswith(place) and word in v.statement]


def test_runs_that_agree_are_right_throughout():
    found = paper_statements.verdicts(2, four())
    assert len(found) == 4 + 3 + 2 + 4 + 2 + 2 + 2 + 2 + 4 + 1
    assert all(v.holds for v in found), [v for v in found if not v.holds]
    assert paper_statements.verdicts(0, four()) == []
    assert paper_statements.far_off(2, four()) == []


def test_a_velocity_off_by_more_than_a_fifth_is_wrong():
    # 0.121 +- 20 %: 0.0968 to 0.1452
    for velocity, half, right in ((0.15, 0.002, False), (0.15, 0.01, None), (0.14, 0.002, True), (0.14, 0.02, None),
                                  (0.095, 0.001, False)):  # fmt: skip
        values = four(actm={"mean_velocity": velocity, "mean_velocity_interval": half})
        assert answers(2, values, "Table 2", "actm: mean velocity") == [right]
    values = four(actm={"mean_velocity": 0.15}, rpm={"mean_velocity": 0.37})
    assert [(v["model"], round(off, 3)) for v, off in paper_statements.far_off(2, values)] == [
        ("rpm", 0.498), ("actm", 0.24),
    ]  # fmt: skip


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


def test_grains_that_do_not_move_are_not_slowed():
    """Held, or below their threshold: nothing to compare with, and no negative interval where one goes upstream."""
    still = four(**{m: {"mean_velocity": 0.0, "mean_velocity_interval": 0.0} for m in paper_statements.TABLE_2})
    assert answers(2, still, "Table 2", "friction slows") == [None, None]
    back = four(actm_hw={"mean_velocity": -0.001, "mean_velocity_interval": 0.2})
    assert answers(2, back, "Table 2", "friction slows actm") == [None]


@pytest.mark.parametrize(
    "spread, half, expected",
    [(0.15, 0.002, True), (0.16, 0.001, True), (0.16, 0.01, None), (0.19, 0.002, False), (0.11, 0.002, False)],
)
def test_friction_leaves_the_spread(spread, half, expected):
    """actm: 0.15 +- 0.002; the same by up to 10 % means 0.135 to 0.165."""
    values = four(actm_hw={"spread_of_height": spread, "spread_of_height_interval": half})
    assert answers(2, values, "Fig. 10", "spread of y") == [True, expected]


def test_what_is_not_known_is_no_nan():
    """A still record has no spread to compare with, one too short no interval."""
    still = {"spread_of_height": 0.0, "spread_of_height_interval": 0.0}
    short = {"spread_of_height_interval": None}
    for values in (four(actm=still, actm_hw=still), four(actm=short, rpm_hw=short)):
        assert not [v.found for v in paper_statements.verdicts(2, values) if "nan" in v.found]
    found = {v.statement: v.found for v in paper_statements.verdicts(2, four(actm=still))}
    said = [text for text in found.values() if "all are at one" in text]
    assert said and said[0].startswith("0.000 to 0.")


def test_heights_and_their_spread_part_the_models():
    for height, spread, answer in ((1.4, 0.15, True), (1.495, 0.199, None), (1.6, 0.3, False)):
        values = four(actm={"mean_height": height, "spread_of_height": spread})
        assert answers(2, values, "Fig. 10", "actm's") == [answer, answer]


@pytest.mark.parametrize(
    "height, half, expected",
    [(1.45, 0.01, True), (1.36, 0.001, False), (1.37, 0.01, None), (1.56, 0.01, False), (1.53, 0.01, None),
     (1.27, 0.01, False)],
)  # fmt: skip
def test_rpm_rides_two_cells_of_the_paper_above_the_bed(height, half, expected):
    """actm's lowest grains at 1.33 D; 2h of the paper is 0.1 D, about that 0.05 D to 0.2 D."""
    values = four(rpm={"low_height": height, "low_height_interval": half}, actm={"low_height_interval": 0.0})
    assert answers(2, values, "ride", "about 2h") == [expected]
    assert answers(2, four(rpm={"low_height": None}), "ride", "about 2h") == [None]
    assert answers(2, four(actm={"low_height_interval": None}), "ride", "about 2h") == [None]  # two samples
    # 2h of Setup I is 0.143 D: 0.071 D to 0.286 D.
    values = [run_numbers("rpm", low_height=1.6), run_numbers("actm", low_height=1.33)]
    assert answers(1, values, "ride", "about 2h") == [True]


def test_rpm_is_faster_than_actm():
    for velocity, expected in ((0.247, True), (0.122, None), (0.1, False)):
        assert answers(2, four(rpm={"mean_velocity": velocity}), "ride", "faster") == [expected]


@pytest.mark.parametrize(
    "changes, expected",
    [
        ({}, True),
        ({"spin_peak": -0.11}, False),  # 1.1 times that without friction, not 1.5
        ({"spin_peak": 0.4}, True),  # of either sense
        ({"spin_peak": -0.18}, None),  # 0.15 is within the intervals, 0.02 and 1.5 times 0.02
        ({"spin_above": -0.5}, False),
        ({"spin_above": -0.38}, None),
        ({"spin_above": None}, True),  # nothing rises so high
        ({"spin_peak": None, "spin_next_to_bed": -0.4}, None),  # a record without a profile
    ],
)
def test_figure_11(changes, expected):
    assert answers(2, four(actm_hw=changes), "Fig. 11") == [True, expected]


def test_spins_of_grains_that_move_are_told_where_others_dilute_them():
    moving = {"moving_spin_peak": -0.6, "moving_spin_peak_interval": 0.02}
    found = [v.found for v in paper_statements.verdicts(2, four(actm_hw=moving)) if v.place == "Fig. 11"]
    assert "alone: -0.60 ± 0.02" in found[1]
    assert "alone" not in found[0]


def test_motion_against_shields():
    moving = four(rpm={"share_moving": 0.6}, actm={"share_moving": 0.105})
    assert answers(2, moving, "Shields") == [False, True, None, True]
    many = {"share_moving": 0.6}
    strong = four(**{m: {"bed_shields": 0.05} | many for m in paper_statements.TABLE_2})
    assert answers(2, strong, "Shields", "more than 10 %") == [True] * 4
    near = four(**{m: {"bed_shields": 0.0345} | many for m in paper_statements.TABLE_2})
    assert answers(2, near, "Shields") == [None] * 4
    assert answers(2, not_kept(near, "bed_shields_interval"), "Shields") == [None] * 4
    unsure = {"bed_shields": 0.05, "bed_shields_interval": None}
    short = four(**{m: unsure | many for m in paper_statements.TABLE_2})
    assert answers(2, short, "Shields") == [None] * 4  # of a bed's record that is too short for an interval
    assert answers(2, not_kept(short, "bed_shields_interval"), "Shields") == [True] * 4
    # Where the bed was not run: the paper's number.
    unknown = four(**{m: {"bed_shields": None, "bed_shields_interval": None} | many for m in paper_statements.TABLE_2})
    assert answers(2, unknown, "Shields", "paper's bed 0.0241") == [False] * 4


@pytest.mark.parametrize("spin, expected", [(0.3, True), (0.2, None), (0.21, None), (0.1, False), (None, None)])
def test_figure_7(spin, expected):
    values = [run_numbers("rpm", jumping_spin=spin), run_numbers("actm")]
    assert answers(1, values, "Fig. 7") == [expected]


@pytest.mark.parametrize(
    "slip, half, expected",
    [(-0.1, 0.05, True), (0.1, 0.05, True), (-0.18, 0.05, None), (-0.3, 0.05, False), (-0.4, None, False),
     (-0.25, None, None), (-0.15, None, None), (-0.05, None, True), (None, None, None)],
)  # fmt: skip
def test_creeping_grains_roll(slip, half, expected):
    values = four(actm_hw={"creeping_slip": slip, "creeping_slip_interval": half})
    old = [*values[:3], *not_kept(values[3:], "creeping_slip_interval")] if half is None else values
    assert answers(2, old, "L_slip") == [True, expected]
    found = [v.found for v in paper_statements.verdicts(2, old) if v.place.startswith("L_slip")]
    assert ("its interval was not kept" in found[1]) == (slip is not None and half is None)
    if half is None:  # of one or two phases that creep nothing is told
        assert answers(2, values, "L_slip") == [True, None]
        found = [v.found for v in paper_statements.verdicts(2, values) if v.place.startswith("L_slip")]
        assert ("too little happened for an interval" in found[1]) == (slip is not None)


@pytest.mark.parametrize("height, expected", [(0.2, True), (0.29, None), (0.4, False), (None, None)])
def test_actm_jumps_lower(height, expected):
    assert answers(2, four(actm={"mean_jump_height": height}), "jump heights", "actm jumps") == [expected]
    values = four(actm={"mean_jump_height": height, "mean_jump_height_interval": None})
    assert answers(2, values, "jump heights", "actm jumps") == [None]


def test_friction_of_the_bed():
    for reynolds, half, expected in ((219, 5, True), (255, 5, True), (255, 10, None), (280, 5, False),
                                     (225, None, True), (190, None, None)):  # fmt: skip
        bed = {"bed_re_tau": float(reynolds), "bed_re_tau_interval": half}
        values = four(**{m: bed for m in paper_statements.TABLE_2})
        old = values if half is not None else not_kept(values, "bed_re_tau_interval")
        assert answers(2, old, "Re_τ") == [expected]
        assert half is not None or answers(2, values, "Re_τ") == [None]
    # Setup I: the mean of its runs, 263 +- 20 % up to 315.6; two runs have no interval.
    for runs, expected in (((260, 270, 280), True), ((306, 308, 310), True), ((320, 322, 324), False),
                           ((300, 320, 340), None), ((263, 263), None)):  # fmt: skip
        values = [run_numbers("actm", n, re_tau=float(re)) for n, re in enumerate(runs, 2)]
        assert answers(1, values, "Re_τ") == [expected]
    assert paper_statements.mean_of_runs([1.0, 2.0, 3.0]) == pytest.approx((2.0, 4.30265 / np.sqrt(3)), rel=1e-5)


def test_setup_1():
    heavy = {"share_resting": 0.7, "share_creeping": 0.2, "share_jumping": 0.1}
    values = [run_numbers(m, 1.25) for m in ("rpm", "actm")]
    values += [run_numbers("rpm", 2.25), run_numbers("actm", 2.25, **heavy)]
    # rpm's shares stay: neither more nor less, and not twice as long on the bed.
    assert answers(1, values, "Fig. 9", "rpm: ") == [True, None, None, False]
    assert answers(1, values, "Fig. 9", "actm: ") == [True, True, True, True]
    assert answers(1, values, "Fig. 9", "the models' shares differ more") == [True]
    turned = [run_numbers("rpm", 1.25), run_numbers("actm", 1.25, **heavy)]
    turned += [run_numbers(m, 2.25) for m in ("rpm", "actm")]
    assert answers(1, turned, "Fig. 9", "the models' shares differ more") == [False]
    assert answers(1, turned, "Fig. 9", "actm: ") == [False, False, False, False]
    even = [run_numbers(m, r) for m in ("rpm", "actm") for r in (1.25, 2.25)]
    assert answers(1, even, "Fig. 9", "the models' shares differ more") == [None]
    half = [run_numbers(m, r, share_jumping=0.51) for m in ("rpm", "actm") for r in (1.25, 2.25)]
    assert answers(1, half, "Fig. 9", "most of the time") == [None, None]


@pytest.mark.parametrize("slow, expected", [(0.03, True), (0.08, False), (0.0985, None), (0.05, None)])
def test_heavy_grains_feel_the_model_more(slow, expected):
    """Light ones: 0.247 to 0.121, the slowest 51 % slower; heavy ones by 70 %, 20 %, not parted, 50 %."""
    values = [run_numbers(m, 1.25) for m in ("rpm", "actm")]
    values += [run_numbers("rpm", 2.25, mean_velocity=0.1), run_numbers("actm", 2.25, mean_velocity=slow)]
    assert answers(1, values, "heavy and light grains") == [expected]
    resting = [*values[:2], run_numbers("rpm", 2.25, mean_velocity=0.001), run_numbers("actm", 2.25, mean_velocity=0.0)]
    assert answers(1, resting, "heavy and light grains") == [None]


def test_what_contradicts_stands_first():
    """The opening names topics with their models; the table has the wrong statements above the others."""
    values = four(rpm={"share_moving": 0.6}, actm_hw={"creeping_slip": -0.4, "mean_velocity_interval": 0.05})
    found = paper_statements.verdicts(2, values)
    wrong, right, unknown = (sum(v.holds is answer for v in found) for answer in (False, True, None))
    assert (wrong, wrong + right + unknown) == (2, len(found))
    assert paper_statements.opening(found).startswith(
        f"Of {len(found)} statements of the paper 2 are wrong here: with friction creeping grains roll (actm + HW); "
        "less than 10 % of the grains move, as Shields' criterion for level beds has it (rpm). "
        f"{right} are right: mean velocity within 20 % of Table 2 (rpm, rpm + HW, actm); "
    )
    assert paper_statements.opening(found).endswith(f" {unknown} are open.")
    words = [row[2] for row in models_report.statement_rows(found)]
    assert words == ["wrong"] * wrong + ["open"] * unknown + ["right"] * right
    calm = paper_statements.opening(paper_statements.verdicts(2, four()))
    assert calm.startswith("Of 26 statements of the paper none is wrong here. 26 are right: ")
    assert "open" not in calm
    assert paper_statements.opening([]) == ""
    light = [run_numbers("rpm", 1.25, jumping_spin=0.1), run_numbers("actm", 1.25)]
    found = paper_statements.verdicts(1, light)
    assert "jumping, rpm spins more than actm (at 1.25)" in paper_statements.opening(found)
    both = [*light, *(run_numbers(m, r, creeping_slip=-0.5) for r in (1.25, 2.25) for m in ("actm_hw",))]
    both.append(run_numbers("actm", 2.25))
    found = paper_statements.verdicts(1, both)
    assert "with friction creeping grains roll (actm + HW at 1.25/2.25)" in paper_statements.opening(found)


def test_records_are_told_beside_the_paper_s():
    """30 flow-throughs of 26 D with 125 grains: 780 D/u_b, an eighth of the paper's grains times time."""
    told = model_sentences.record_sentence(2, [run_numbers("rpm"), run_numbers("actm", flow_throughs=60.0)])
    assert "780 to 1560 D/u_b long with 125 grains, the paper's more than 1560 D/u_b with 500: 0.12 to 0.25 ti" in told
    alike = model_sentences.record_sentence(2, [run_numbers("rpm"), run_numbers("actm")])
    assert "780 D/u_b long with 125 grains" in alike and ": 0.12 times as many grains times time, or less." in alike
    assert model_sentences.record_sentence(1, [run_numbers("rpm")]) == ""


def test_experiments_are_commands_of_the_study():
    for model in paper_statements.TABLE_2:
        lines = paper_statements.experiments(model, "setup2_small", "10")
        assert all(f"--models {model} " in command for _, command in lines)
        assert len({command for _, command in lines}) == len(lines) >= 4
        # No finer than the paper, no larger box than the full bed.
        asked = [what for what, _ in paper_statements.experiments(model, "setup2", "20")]
        assert len(asked) == len(lines) - 2 and not {"the box", "the resolution"} & set(asked)


def test_a_record_that_drifts_is_told():
    stepping = np.repeat([0.0, 1.0], 50) + np.tile([0.0, 0.1], 50)
    part = transport.Transport(None, 10, [np.arange(100.0)], [np.ones(100)], [stepping])
    part.share = [np.tile([[0.4, 0.3, 0.3], [0.5, 0.3, 0.2]], (50, 1))]
    found = model_numbers.drift("velocity", *part.halves("velocity"))
    assert found["velocity_halves"] == pytest.approx([0.05, 1.05])
    assert found["velocity_drifts"] is True
    still = model_numbers.drift("resting", *part.halves("share", 0))
    assert still["resting_halves"] == pytest.approx([0.45, 0.45])
    assert still["resting_drifts"] is False
    values = [found | still]
    assert "differ by more than their intervals in mean velocity of rpm" in (
        model_sentences.drift_sentence(["rpm"], values)
    )
    calm = [model_numbers.drift("velocity", *part.halves("share", 0)) | still]
    assert model_sentences.drift_sentence(["rpm"], calm).startswith("No record drifts")


def test_intervals_of_histograms():
    """Two values, one in the odd parts and one in the even: t_{0.975, 9} s/sqrt(10)."""
    part = transport.Transport(None)
    counts = part.height_parts
    low, high = 70, 80  # bins of 0.02 D: centres 1.41 and 1.61
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


def test_the_paper_s_velocities():
    """Table 2, from which the made-up runs above take theirs."""
    assert paper_statements.TABLE_2 == {"rpm": 0.247, "rpm_hw": 0.181, "actm": 0.121, "actm_hw": 0.093}


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


def test_intervals_of_neighbours():
    """Ten parts of one instant each: u_1'u_2' is 1 in eight and -1 in two, s = 0.84327; t_{0.975, 9} = 2.26216."""
    first = np.array([1.0, -1.0] * 5)
    both = np.column_stack([first, first * np.repeat([1.0, -1.0], [8, 2])])
    found = neighbours.of_series(np.full((10, 2), 9.0), both)
    assert (found.correlation, found.closest) == (pytest.approx(0.6), 9.0)
    assert found.correlation_interval == pytest.approx(2.26216 * 0.84327 / np.sqrt(10), rel=1e-4)
    assert np.isnan(found.velocity_difference_interval)  # none has another one near


@pytest.mark.filterwarnings("error")
def test_neighbours_of_two_instants():
    """Too few for an interval: the correlation, which is 1 then, is not told."""
    found = neighbours.of_series(np.full((2, 2), 9.0), np.array([[0.0, 0.0], [1.0, 1.0]]))
    assert "correlate" not in found.sentence() and "nan" not in found.sentence()
    assert found.sentence().endswith("(closest 9.00 D): too short to tell whether they feel each other")
    longer = neighbours.of_series(np.full((9, 2), 9.0), np.random.default_rng(1).normal(size=(9, 2)))
    assert "velocities of two correlate by " in longer.sentence()
