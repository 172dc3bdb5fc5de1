"""The hard cases' criteria on made-up runs: the right one passes, one whose tested term is missing,
doubled or turned about does not."""

import argparse
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from bedload_launcher.errors import UserError
from bedload_launcher.words import end_of
from bedload_studies import accuracy, criteria, runaway, stability
from bedload_studies.criteria import PASS, Check, worst
from bedload_studies.hard_cases import CASES
from bedload_studies.sphere_theory import (
    film_speed,
    kicked_speed,
    spin_left,
    spun_up_torque,
    standard_drag_coefficient,
    wet_restitution,
)
from bedload_studies.small_scenes import Ball, SmallScene
from bedload_studies.trajectories import Trajectories
from synthetic import Story, write_run

DT = 0.0375  # c = 0.3 at eight cells to a diameter


def made_up(time, position, velocity, spin=0.0, radius=0.5, box=(4.0, 4.0, 4.0), bed=()):
    """A run of n spheres from arrays (m, n, 3), or (m, 3) for one; radius a number or (n)."""
    position, velocity = (np.asarray(a, float) for a in (position, velocity))
    if position.ndim == 2:
        position, velocity = position[:, None], velocity[:, None]
    shape = position.shape
    turning = np.zeros(shape)
    turning[:, :, 2] = np.reshape(spin, (-1, 1)) if np.ndim(spin) else spin
    bed = np.reshape(np.asarray(bed, float), (-1, 3))
    return Trajectories(
        np.asarray(time, float), np.arange(1, shape[1] + 1), position, velocity, turning,
        np.broadcast_to(radius, shape[:2]), np.array(box), np.array([box[0], np.inf, box[2]]),
        bed, np.full(len(bed), 0.5),
    )  # fmt: skip


def flown(time, start, velocity, **more):
    """A run from velocities (m, n, 3) and starts (n, 3): places by their sums, wrapped into the box."""
    velocity = np.asarray(velocity, float)
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)[:, None, None]
    position = np.asarray(start, float) + np.concatenate([0 * steps[:1], np.cumsum(steps, axis=0)])
    box = more.get("box", (4.0, 4.0, 4.0))
    position[..., 0] %= box[0]
    position[..., 2] %= box[2]
    return made_up(time, position, velocity, **more)


def kind(case, value, run, dt=DT):
    return CASES[case].judge(value, dt, run).kind


# --- The fluid's force and torque -------------------------------------------------------------------


def kicked_run(density, factor):
    """Drag `factor` times what lies between the two theories: 1.3 times the steady one."""
    time = np.arange(0.0, 2.0 + 1e-9, 0.005)
    speed = np.ones(len(time))
    speed[1] = criteria.share_kept(density) if factor else 1.0
    for n in range(1, len(time) - 1):
        drag = factor * 1.3 * 0.125 * math.pi * speed[n] ** 2
        drag *= standard_drag_coefficient(max(abs(speed[n]), 1e-9) / criteria.KICK_VISCOSITY)
        speed[n + 1] = speed[n] - 0.005 * drag / ((density + 0.5) * math.pi / 6)
    velocity = np.stack([speed, 0 * speed, 0 * speed], axis=1)[:, None]
    return flown(time, [[2.0, 2.0, 2.0]], velocity)


@pytest.mark.parametrize("density", [0.3, 1.0, 50.0])
def test_drag(density):
    assert kind("density_ratio", density, kicked_run(density, 1.0)) == PASS
    for wrong in (0.0, 2.0, -1.0):
        assert kind("density_ratio", density, kicked_run(density, wrong)) != PASS


@pytest.mark.parametrize("spin", [2.0, 20.0])
def test_torque(spin):
    time = np.linspace(0.0, 7.5 / spin, 101)
    left = spin_left(criteria.SPIN_DENSITY, criteria.SPIN_VISCOSITY, time)
    place = np.full((101, 3), 2.0)
    for factor, passes in ((1.0, True), (0.0, False), (2.0, False), (-1.0, False)):
        run = made_up(time, place, 0 * place, spin * left**factor)
        assert (kind("spin", spin, run) == PASS) is passes, factor


@pytest.mark.parametrize(("flow", "right", "wrong"), [("still", -0.3, -1.5), ("turbulent", 0.6, 0.0)])
def test_a_cloud_of_grains(flow, right, wrong):
    """Still: gravity without buoyancy and drag; turbulent: not taken along."""
    time = np.linspace(0.0, 3.0, 4)
    grid = np.stack(np.meshgrid(*[np.arange(8.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    start = 1.125 * grid[:500] + np.array([0.6, 3.0, 0.6])
    for speed, passes in ((right, True), (wrong, False), (-right, flow == "still")):
        velocity = np.zeros((4, 500, 3))
        velocity[..., 1 if flow == "still" else 0] = speed * (time / 3.0)[:, None]
        run = flown(time, start, velocity, box=(9.0, 14.0, 9.0))
        assert (kind("dropped", flow, run) == PASS) is passes
    assert kind("dropped", flow, flown(time, start[:499], velocity[:, :499], box=(9.0, 14.0, 9.0))) != PASS


@pytest.mark.parametrize(("case", "value", "change"), [("coarse", 6, 1.0), ("driving", -1.0, -2.0)])
def test_a_grain_in_a_stream(case, value, change):
    time = np.linspace(0.0, 4.0, 41)
    for pushed, passes in ((1.0, True), (0.0, False), (-1.0, False), (8.0, False)):
        velocity = np.zeros((41, 1, 3))
        velocity[:, 0, 0] = 0.4 * change * pushed
        run = flown(time, [[2.0, 1.3, 1.0]], velocity, box=(4.0, 5.0, 3.0))
        assert (kind(case, value, run) == PASS) is passes, pushed
    sunk = flown(time, [[2.0, 0.9, 1.0]], 0.4 * change + 0 * velocity, bed=[[2.0, 0.5, 1.0]],
                 box=(4.0, 5.0, 3.0))  # fmt: skip
    assert kind(case, value, sunk) != PASS


def corner_run(left=0.5, period=4.0):
    time = np.linspace(0.0, 1.5, 61)
    velocity = np.zeros((61, 2, 3)) + np.array([1.0, 0.3, 1.0])
    velocity[1:] *= left
    start = [[3.4, 2.0, 3.4], [2.692, 2.0, 2.692]]
    run = flown(time, start, velocity)
    run.position[run.position[..., 0] < 1.0] += 4.0 - period
    return run


def test_a_pair_through_the_corner():
    assert kind("corner", 2, corner_run()) == PASS
    assert kind("corner", 2, corner_run(left=1.0)) != PASS  # the fluid takes nothing
    assert kind("corner", 2, corner_run(period=3.9)) != PASS  # put back at the wrong place
    assert kind("corner", 2, corner_run(left=0.1)) != PASS  # never gets there
    overlapping = corner_run()
    overlapping.position[:, 1] += 0.1
    assert kind("corner", 2, overlapping) != PASS


# --- Contact force and film --------------------------------------------------------------------------


def impact_run(stokes, rebound, through=False, slow=0.0):
    """Falls from 0.8 D (or 0.2 St D), slowed down by `slow` per unit length, rebounds with `rebound`."""
    time = np.arange(0.0, 2.0, DT)
    gap, speed, y, v = min(0.8, 0.2 * stokes), -1.0, [], []
    for _ in time:
        if speed < 0.0 and gap <= 0.0 and not through:
            speed *= -rebound
        y.append(0.5 + gap)
        v.append(speed)
        speed -= slow * DT * abs(speed) * speed / max(gap, 0.05)
        gap += speed * DT
    zero = np.zeros(len(time))
    place = np.stack([zero + 1.5, y, zero + 1.5], axis=1)
    return made_up(time, place, np.stack([zero, v, zero], axis=1), box=(3.0, 4.0, 3.0))


@pytest.mark.parametrize("case", ["impact", "impact_1_step"])
def test_impact(case):
    law = wet_restitution(1000.0 * 8.5 / 8.0)
    assert kind(case, 1000.0, impact_run(1000.0, law)) == PASS
    assert kind(case, 1000.0, impact_run(1000.0, law, through=True)) != PASS  # no contact force
    assert kind(case, 1000.0, impact_run(1000.0, 1.3)) != PASS  # gains energy
    assert kind(case, 1000.0, impact_run(1000.0, 0.3)) != PASS  # contact that only damps
    assert kind(case, 1.0, impact_run(1.0, 0.0, slow=3.0)) == PASS
    assert kind(case, 1.0, impact_run(1.0, 0.97)) != PASS  # no film, no drag


def pressed_run(gap, film=1.0, contact=True):
    """W = 6 pi R^2 u film / max(gap, least), R = 1/2, until it touches; a rigid contact or none."""
    dt = 0.001
    weight = (criteria.PRESSED_DENSITY - 1.0) * criteria.PRESSED_GRAVITY * math.pi / 6.0
    time = np.arange(0.0, 3.0, dt)
    y, v = [], []
    for _ in time:
        speed = film_speed(weight, gap, criteria.PRESSED_VISCOSITY) / film if film else 0.5
        if gap <= -5e-4 and contact:
            speed = 0.0
        y.append(0.5 + gap)
        v.append(-speed)
        gap -= speed * dt
    zero = np.zeros(len(time))
    place = np.stack([zero + 1.5, y, zero + 1.5], axis=1)
    return made_up(time, place, np.stack([zero, v, zero], axis=1), box=(3.0, 3.0, 3.0))


def test_pressed():
    assert kind("pressed", 1e-2, pressed_run(1e-2)) == PASS
    assert kind("pressed", 1e-2, pressed_run(1e-2, film=0.0)) != PASS
    assert kind("pressed", 1e-2, pressed_run(1e-2, film=-1.0)) != PASS
    assert kind("pressed", 1e-3, pressed_run(1e-3, contact=False)) != PASS


def test_wedged():
    time = np.linspace(0.0, 2.0, 21)
    for opening in (0.1, 0.6):
        rest = criteria.resting_height(opening)
        for speed, end, passes in ((0.0, rest - 0.002, True), (-1.0, rest - 2.0, False),
                                   (0.0, rest + 0.1, False)):  # fmt: skip
            place = np.tile([2.0, end, 2.0], (21, 1)) - np.outer(2.0 - time, [0.0, speed, 0.0])
            run = made_up(time, place, np.tile([0.0, speed, 0.0], (21, 1)))
            assert (kind("wedged", opening, run) == PASS) is passes


def test_pinned():
    """The mover comes to rest on the grain, goes through it, throws it away, or comes back
    faster than it fell: at 2.5, 0.28 D give 0.6 g 0.28 D, speeds of up to sqrt(1 + 2 * 0.168)."""
    time = np.arange(0.0, 3.0, DT)
    for stop, thrown, kept, back, passes in (
        (1.52, 0.0, 0.8, 0.0, True), (0.9, 0.0, 0.8, 0.0, False), (1.52, 2.5, 0.8, 0.0, False),
        (1.52, 0.0, 1.0, 0.0, False), (1.52, 0.0, 0.8, 1.12, True), (1.52, 0.0, 0.8, 1.2, False),
    ):  # fmt: skip
        fall = np.maximum(1.8 - kept * time, stop)
        place = np.zeros((len(time), 2, 3)) + 1.5
        place[:, 0, 1], place[:, 1, 1] = 0.501, fall
        velocity = np.zeros_like(place)
        velocity[:, 1, 1] = np.where(fall > stop, -kept, 0.0)
        velocity[0, 1, 1] = -1.0
        velocity[-1, 0, 2], velocity[-1, 1, 1] = thrown, back
        run = made_up(time, place, velocity, box=(3.0, 4.0, 3.0))
        assert (kind("pinned", 2.5, run) == PASS) is passes


def test_cluster():
    """Two stand for thirteen: one comes in, the other is in its way."""
    time = np.arange(0.0, 1.5, DT)
    for left, through, passes in ((0.2, False, True), (0.97, False, False), (0.5, True, False)):
        velocity = np.zeros((len(time), 2, 3))
        velocity[0, 1, 0], velocity[1:, 1, 0] = -0.5, -0.5 * left
        start = [[1.0, 2.0, 2.0], [2.002, 2.0, 2.0]]
        if not through:
            velocity[1:, 1, 0] *= -1.0
        assert (kind("cluster", 0.5, flown(time, start, velocity)) == PASS) is passes
    shot = flown(time, start, 3.0 * velocity)
    shot.velocity[0] /= 3.0
    assert kind("cluster", 0.5, shot) != PASS


def test_overlap_at_the_start():
    time = np.arange(0.0, 2.0, DT)
    for speed, passes in ((0.05, True), (-0.08, False), (3.0, False)):
        velocity = np.zeros((len(time), 2, 3))
        velocity[1:, 1, 0] = speed
        run = flown(time, [[1.5, 2.0, 2.0], [2.3, 2.0, 2.0]], velocity)
        assert (kind("overlap", 0.2, run) == PASS) is passes, speed


def test_size_ratio():
    time = np.arange(0.0, 2.0, DT)
    radius = np.array([0.5, 1.0])
    for kept, stops, thrown, passes in ((0.8, True, 0.0, True), (1.0, True, 0.0, False),
                                        (0.8, False, 0.0, False), (0.8, True, 4.0, False)):  # fmt: skip
        place = np.zeros((len(time), 2, 3)) + 2.0
        place[:, 0, 1] = 0.6
        place[:, 1, 1] = 2.3 - kept * time
        if stops:
            place[:, 1, 1] = np.maximum(place[:, 1, 1], 2.1)
        velocity = np.zeros_like(place)
        velocity[:, 1, 1] = -kept
        velocity[-1, 0, 0] = thrown
        run = made_up(time, place, velocity, radius=radius, box=(7.0, 8.0, 7.0))
        assert (kind("size_ratio", 2.0, run) == PASS) is passes


# --- How verdicts are made ---------------------------------------------------------------------------


def test_the_worst_check_speaks_and_what_is_no_number_is_unstable():
    assert worst(Check("a", 0.5, 1.0), Check("b", 1.0, 1.0)).words == "b"
    assert worst(Check("a", 5.0, 1.0), Check("b", 2.0, 1.0, 1.5)).kind == "unstable"
    assert worst(Check("a", math.nan, 1.0), Check("b", 2.0, 1.0)).kind == "unstable"
    assert worst(Check("a", 5.0, 1.0), Check("b", 0.1, 1.0)).kind == "inaccurate"


def test_theories_have_their_limits():
    """Steady Stokes decay for a slow kick and long times, exp(-t 9 nu/(2 rho R^2)...); Basset only adds."""
    slow = kicked_speed(2.0, 50.0, 0.01, history=False)
    assert slow == pytest.approx(0.8 * math.exp(-18.0 * 50.0 / 2.5 * 0.01), rel=0.03)
    assert kicked_speed(2.0, 0.02, 1.0, history=True) < kicked_speed(2.0, 0.02, 1.0, history=False)
    times = np.array([0.0, 1e-3])
    # Early: w' = -15 nu/(rho R^2) (1/3) R/sqrt(pi nu t), so 1 - w = 10 sqrt(nu t/pi)/(rho R).
    early = 10.0 * math.sqrt(0.02 * 1e-3 / math.pi) / (1.2 * 0.5)
    assert 1.0 - spin_left(1.2, 0.02, times)[1] == pytest.approx(early, rel=0.1)
    assert spin_left(1.2, 0.02, times)[0] == pytest.approx(1.0, rel=1e-12)
    # Its equation, from a while after the start on: what the torque took is missing of the spin.
    time = np.linspace(0.0, 1.0, 2001) ** 2  # finer at the start, where w' is infinite
    left = spin_left(0.5, 0.25, time)  # nu/R^2 = 1
    memory = np.zeros(len(time))
    for n in range(1, len(time)):
        ages = time[n] - 0.5 * (time[1 : n + 1] + time[:n])
        ages[-1] *= 0.5  # where 1/sqrt has its mean over the last interval
        changes = np.diff(left[: n + 1])
        memory[n] = spun_up_torque(0.25, time[n]) - 1.0 + changes @ (spun_up_torque(0.25, ages) - 1.0)
    torque = left + memory
    taken = 15.0 / 0.5 * np.sum(0.5 * (torque[101:] + torque[100:-1]) * np.diff(time[100:]))
    assert left[100] - left[-1] == pytest.approx(taken, rel=2e-2) and left[100] > 0.5


def test_overlaps_see_walls_bed_and_periodic_images():
    place = [[[0.1, 2.0, 2.0], [3.3, 2.0, 2.0]]]
    still = np.zeros((1, 2, 3))
    assert made_up([0.0], place, still).deepest_overlap() == pytest.approx(0.2)
    assert made_up([0.0], [[[1.0, 0.4, 2.0]]], still[:, :1]).deepest_overlap() == pytest.approx(0.1)
    assert made_up([0.0], [[[1.0, 3.7, 2.0]]], still[:, :1]).deepest_overlap() == pytest.approx(0.2)
    over_bed = made_up([0.0], [[[1.0, 2.0, 2.0]]], still[:, :1], bed=[[1.0, 2.0, 2.7]])
    assert over_bed.deepest_overlap() == pytest.approx(0.3)
    # Where none overlap: the narrowest gap, below zero; spheres of the bed do not count among themselves.
    bed = [[2.0, 2.0, 2.0], [2.0, 2.0, 2.1]]
    assert made_up([0.0], [[[2.0, 0.7, 2.0]]], still[:, :1], bed=bed).deepest_overlap() == pytest.approx(-0.2)
    # A large sphere and a small one, with a small pair nearer to each other that overlaps less.
    apart = made_up([0.0], [[[1.0, 2.0, 1.0], [1.0, 2.0, 2.3], [1.5, 2.0, 2.3]]], np.zeros((1, 3, 3)),
                    radius=[1.2, 0.3, 0.25])  # fmt: skip
    assert apart.deepest_overlap() == pytest.approx(0.2)


# --- New cases -----------------------------------------------------------------------------------------


def stream_run(speed, deep=0.0):
    """Two grains side by side under a stream, `deep` of one in the other."""
    time = np.linspace(0.0, 4.0, 41)
    velocity = np.zeros((41, 2, 3))
    velocity[..., 0] = speed
    return flown(time, [[1.0, 2.0, 1.0], [2.0 - deep, 2.0, 1.0]], velocity)


@pytest.mark.parametrize(("case", "value"), [("light", 0.3), ("plug", 1)])
def test_grains_that_go_with_the_stream(case, value):
    for speed, deep, passes in ((0.4, 0.0, True), (0.0, 0.0, False), (-0.4, 0.0, False), (8.0, 0.0, False),
                                (0.4, 0.3, False)):  # fmt: skip
        assert (kind(case, value, stream_run(speed, deep)) == PASS) is passes, (speed, deep)


def test_a_sphere_beside_its_images():
    time = np.linspace(0.0, 2.0, 41)
    for left, across, passes in ((0.3, 0.0, True), (1.0, 0.0, False), (0.3, 0.1, False)):
        velocity = np.zeros((41, 1, 3))
        velocity[:, 0, 0], velocity[:, 0, 2] = np.linspace(1.0, left, 41), across
        run = flown(time, [[2.0, 2.0, 1.0]], velocity, box=(4.0, 4.0, 2.0))
        assert (kind("narrow", 2.0, run) == PASS) is passes


def test_a_heavy_fall():
    """Falls half a diameter under g = 100 and stays; goes through the wall; is thrown up again and again."""
    time = np.arange(0.0, 0.4, 1e-3)
    fall = np.maximum(1.0 - 50.0 * 0.9 * time**2, 0.5)
    speed = np.where(fall > 0.5, -90.0 * time, 0.0)
    for y, v, passes in ((fall, speed, True), (1.0 - 45.0 * time**2, -90.0 * time, False),
                         (fall, np.where(fall > 0.5, -90.0 * time, 6.0), False)):  # fmt: skip
        zero = np.zeros(len(time))
        place = np.stack([zero + 1.5, y, zero + 1.5], axis=1)
        run = made_up(time, place, np.stack([zero, v, zero], axis=1), box=(3.0, 4.0, 3.0))
        assert (kind("heavy_fall", 100.0, run) == PASS) is passes


def test_every_case_ends_at_one_time_whatever_its_step():
    for case in CASES.values():
        if not case.long:
            ends = {case.scene(case.values[0], dt).end for dt in (0.01, 0.02)}
            assert len(ends) == 1 or case.name == "heavy_fall", case.name


# --- A run that was stopped ---------------------------------------------------------------------------


def test_what_a_case_explains():
    ball = Ball((2.0, 2.0, 2.0), velocity=(3.0, 0.0, -4.0), spin=(0.0, 2.0, 0.0))
    scene = SmallScene((4.0, 5.0, 4.0), 8, 0.1, 0.1, 1.0, [ball], gravity=0.4, keys={"start.velocity": "-2.0"})
    assert runaway.explained_speed(scene) == pytest.approx(5.0 + 1.0 + 3.0 * 2.0 + 2.0)


def test_a_growing_swing_is_no_honest_stop():
    steps = np.arange(12)
    for growth, sign, found in ((1.5, -1.0, True), (0.7, -1.0, False), (1.5, 1.0, False)):
        velocity = np.zeros((12, 1, 3))
        velocity[:, 0, 1] = 0.01 * growth**steps * sign**steps
        assert runaway.growing_swing(velocity, 0.05) is found
    assert not runaway.growing_swing(velocity[:4], 0.0)
    flow = 2.0 ** np.arange(12)
    assert runaway.growing_flow(flow) and not runaway.growing_flow(1.0 + 0.01 * flow[:12] / flow[-1])


@pytest.mark.parametrize(("fastest", "verdict"), [(1.0, ""), (20.0, "times the speed that the case explains")])
def test_a_stopped_run_is_judged_by_its_grains(tmp_path, fastest, verdict):
    story = Story().piece(1.0, velocity=(fastest, 0.0, 0.0))
    folder = write_run(tmp_path / "run", story)
    scene = SmallScene((16.0, 9.0, 8.0), 5, 0.1, 0.1, 1.0, [Ball((1.0, 1.5, 4.0), velocity=(1.0, 0.0, 0.0))])
    why = runaway.without_cause(folder, scene)
    assert (verdict in why) if verdict else why == ""


def test_verdicts_are_counted():
    cells = [stability.Cell("a", "1", 0.1, "double", kind) for kind in ("pass", "pass", "stopped")]
    assert stability.counted(cells) == "3 runs: 2 pass, 0 inaccurate, 0 unstable, 1 stopped, 0 refused"


@pytest.mark.parametrize(
    ("line", "told"),
    [*(([name, "1"], f"{name} is for a SCENE of one's own") for name in ("--time", "--model", "--ranks", "--set")),
     *((["setup2_small", *words], f"{words[0]} is for the hard cases")
       for words in (["--case", "crowd"], ["--quick"], ["--long"], ["--again"], ["--jobs", "2"]))],
)  # fmt: skip
def test_options_of_the_other_kind_are_refused(line, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(stability, "run_cell", lambda *_: pytest.fail("a run was started"))
    monkeypatch.setattr(stability.stability_scene, "run", lambda _: pytest.fail("a run was started"))
    parser = argparse.ArgumentParser()
    stability.add_options(parser)
    with pytest.raises(UserError, match=f"{told} alone."):
        stability.run(parser.parse_args(line))


def test_warnings_are_no_ends():
    remarks = "bedload-fluid: caution: heavy\nbedload-dem: NOTE: 10 steps\nbedload-fluid: WARNING: slow\n"
    said = f"{remarks}bedload-fluid: step 3 (t = 1): the CFL"
    assert end_of(said) == "bedload-fluid: step 3 (t = 1): the CFL"
    assert end_of("nothing") == ""


def test_maps_of_a_kept_report_are_drawn_anew_from_its_table(tmp_path):
    kept = Path(__file__).resolve().parents[2] / "postproc" / "reports"
    figures = {stability: ("stability.csv", "stability.png"), accuracy: ("accuracy.csv", "channel.png")}
    for study, (table, figure) in figures.items():
        parser = argparse.ArgumentParser()
        study.add_options(parser)
        folder = tmp_path / study.__name__
        folder.mkdir()
        with pytest.raises(UserError, match=f"has no {table}"):
            study.run(parser.parse_args(["--rewrite", str(folder)]))
        shutil.copy(kept / table.removesuffix(".csv") / table, folder)
        assert study.run(parser.parse_args(["--rewrite", str(folder)])) == 0
        assert (folder / figure).stat().st_size > 20000
