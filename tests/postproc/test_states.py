"""States, slip and jump heights of trajectories for which they are known.

u_b = 1, D = 1 (R = 0.5) throughout. Bounds: the trapezoidal sums over 400 samples per unit of time
are exact for pieces of constant speed; where a speed jumps within one sample interval, the sums are
off by at most speed x interval = 0.0025 times it.
"""

import numpy as np
import pytest
from bedload_post import path
from bedload_post.frames import time_ranges
from bedload_post.outputs import Collisions, Samples
from bedload_post.states import (
    CREEPING,
    JUMPING,
    RESTING,
    analyse,
    classify,
    timeline,
    unwrap,
)
from synthetic import Story, merge_in_time

BOX = np.array([16.0, 9.0, 8.0])
PERIODS = np.array([16.0, np.inf, 8.0])
SAMPLE = 0.0025


def analysed(*stories, block_rows=10**6, partner=-1):
    """Phases of grains 1, 2, ... that live through `stories`."""
    rows = merge_in_time(*(s.arrays(tag, BOX) for tag, s in enumerate(stories, 1)))
    contacts = [(tag, a, b) for tag, s in enumerate(stories, 1) for a, b in s.contacts]
    tag, start, end = np.array(contacts or np.empty((0, 3))).T
    collisions = Collisions(tag.astype(int), np.full(len(tag), partner), start, end)

    def blocks():
        for first in range(0, len(rows["time"]), block_rows):
            yield Samples(**{k: v[first : first + block_rows] for k, v in rows.items()})

    ranges = time_ranges((block.time, block.tag) for block in blocks())
    return analyse(collisions, ranges, blocks(), PERIODS, bulk_velocity=1.0, diameter=1.0)


@pytest.mark.parametrize(
    ("speed", "distance", "contact", "state"),
    [
        (0.0099, 0.1, False, RESTING),
        (0.0101, 0.1, False, CREEPING),
        (0.5, 0.579, False, CREEPING),
        (0.5, 0.581, False, JUMPING),
        (0.5, 0.581, True, CREEPING),  # rolls without leaving the bed
        (0.0099, 5.0, False, RESTING),  # slow for very long: rests by the paper's first rule
    ],
)
def test_thresholds_are_those_of_the_paper(speed, distance, contact, state):
    found = classify(np.array([speed]), np.array([distance]), np.array([contact]), 1.0, 1.0)
    assert found == [state]


def test_thresholds_scale_with_bulk_velocity_and_diameter():
    speed, distance = np.array([0.015]), np.array([1.0])
    no = np.array([False])
    assert classify(speed, distance, no, 2.0, 1.0) == [RESTING]
    assert classify(speed, distance, no, 1.0, 2.0) == [CREEPING]
    assert classify(speed, distance, no, 1.0, 1.0) == [JUMPING]


def test_time_is_cut_where_contacts_begin_and_end():
    start, end = np.array([5.0, 0.5, 1.0, 4.0]), np.array([6.0, 3.0, 1.5, 5.0])
    edges, contact = timeline(start, end, 0.0, 7.0)
    assert edges.tolist() == [0.0, 0.5, 1.0, 1.5, 3.0, 4.0, 5.0, 6.0, 7.0]
    assert contact.tolist() == [False, True, True, True, False, True, True, False]


def test_contacts_beyond_the_record_are_clipped():
    edges, contact = timeline(np.array([-1.0, 3.5, 8.0]), np.array([1.0, 9.0, 9.0]), 0.0, 4.0)
    assert edges.tolist() == [0.0, 1.0, 3.5, 4.0]
    assert contact.tolist() == [True, False, True]


def test_rest_ends_when_the_first_contact_of_the_pocket_is_lost():
    story = Story().touch().piece(5.0).piece(1.0, (0.3, 0, 0)).touch()
    story.contacts += [(story.contacts[0][0], 5.002), (0.0, 6.002)]
    phases = analysed(story)
    assert phases.shares() == pytest.approx([5 / 6, 1 / 6, 0.0], abs=2e-3)


def test_a_jump_has_its_height_length_and_slip():
    # Rolls at half the rolling speed while in the air: int |omega x R| = 0.4 * 0.5 * 3.
    story = Story().touch().piece(3.0, (0.5, 0, 0), spin_z=-0.4, jump_height=0.7).touch()
    phases = analysed(story)
    jump = phases.jumps()
    assert jump.sum() == 1
    assert phases.height[jump] == pytest.approx(0.7, abs=1e-6)
    assert phases.distance[jump] == pytest.approx(1.5, abs=1e-9)
    assert phases.duration[jump] == pytest.approx(3.0, abs=1e-9)
    assert phases.roll[jump] == pytest.approx(0.4 * 0.5 * 3.0, abs=0.4 * 0.5 * SAMPLE)
    # Arc length of the parabola y = 4 h f (1 - f): closed form.
    slope = 4 * 0.7 / 1.5
    arc = 1.5 * (np.hypot(1, slope) + np.arcsinh(slope) / slope) / 2
    assert phases.path[jump] == pytest.approx(arc, abs=2 * SAMPLE)
    assert phases.slip[jump] == pytest.approx(phases.roll[jump] - phases.path[jump])


@pytest.mark.parametrize(("spin", "slip"), [(-0.8, 0.0), (0.0, -0.4), (-1.6, 0.4)])
def test_rolling_without_slip_has_none(spin, slip):
    # Speed 0.4 over one unit of time; omega R = 0.4 rolls.
    story = Story().touch().piece(1.0, (0.4, 0, 0), spin_z=spin).touch()
    phases = analysed(story)
    row = phases.complete & ~phases.contact
    assert phases.state[row] == [CREEPING]
    assert phases.slip[row] == pytest.approx(slip, abs=2 * SAMPLE)


def test_rolling_follows_radius_and_both_axes_and_distance_height():
    # |omega x R| = 0.4 hypot(0.6, 0.8); the ends lie hypot(0.3, 0.55) = 0.63 D apart: a jump.
    story = Story(radius=0.4).touch().piece(1.0, (0.3, 0.55, 0), spin_z=-0.8, spin_x=0.6).touch()
    phases = analysed(story)
    row = phases.complete & ~phases.contact
    assert phases.roll[row] == pytest.approx(0.4, abs=SAMPLE)
    assert phases.distance[row] == pytest.approx(np.hypot(0.3, 0.55), abs=1e-9)
    assert phases.state[row] == [JUMPING]


def test_spin_about_the_vertical_does_not_roll():
    story = Story().touch().piece(1.0, (0.4, 0, 0)).touch()
    story.spin = [np.array([0.0, 3.0, 0.0]) for _ in story.spin]
    phases = analysed(story)
    assert phases.roll == pytest.approx(0.0, abs=1e-12)


def test_shares_of_time():
    story = Story().piece(5.0, contact=True).piece(2.0, (0.25, 0, 0)).touch(1e-3)
    story.piece(3.0, (1.0, 0, 0), jump_height=0.3).touch(1e-3).piece(10.0, contact=True)
    shares = analysed(story).shares()
    # 5 + 10 at rest, 2 creeping (0.5 D), 3 jumping, of 20; the touches are 2e-3 of rest.
    assert shares == pytest.approx([15 / 20, 2 / 20, 3 / 20], abs=5e-4)


def test_the_record_s_ends_count_in_time_but_not_as_jumps():
    story = Story().piece(2.0, (1.0, 0, 0), jump_height=0.3).touch().piece(2.0, (1.0, 0, 0))
    phases = analysed(story)
    assert phases.shares()[JUMPING] == pytest.approx(1.0, abs=1e-3)
    assert not phases.jumps().any()


def test_a_grain_that_never_collides_rests():
    phases = analysed(Story().piece(4.0))
    assert phases.shares().tolist() == [1.0, 0.0, 0.0]


def test_a_jump_through_the_periodic_corner_keeps_its_length():
    story = Story(position=(15.5, 1.5, 7.9))
    story.touch().piece(2.0, (0.6, 0, 0.3), jump_height=0.2).touch()
    phases = analysed(story)
    assert phases.distance[phases.jumps()] == pytest.approx(np.hypot(1.2, 0.6), abs=1e-9)


def test_unwrap_goes_around_both_ways_and_leaves_walls_alone():
    # Position mod the box, y beyond half the box from one sample to the next.
    true = np.array([[15.0, 0.0, 1.0], [17.0, 8.0, -1.0], [33.0, 0.0, -9.0], [34.5, 5.0, -8.0]])
    true[:, 0] = [15.0, 17.0, 22.0, 33.0 - 4.5]
    true[:, 2] = [1.0, -1.0, -3.0, -5.0]
    wrapped = np.column_stack([true[:, 0] % 16.0, true[:, 1], true[:, 2] % 8.0])
    shift = wrapped[0] - true[0]
    assert unwrap(wrapped, PERIODS) == pytest.approx(true + shift)


def test_a_thinned_path_goes_around_as_often():
    """Five units to a sample in a box of 16: of every fourth alone the way would be four backwards."""
    story = Story(position=(0.0, 1.5, 0.0)).piece(40 * SAMPLE, (5.0 / SAMPLE, 0.0, 0.0))
    one = Samples(**story.arrays(1, BOX)).rows(slice(40))
    few, way = path.thinned(one, PERIODS, 10)
    assert len(few) == 10 and np.diff(way[:, 0]) == pytest.approx(20.0)


@pytest.mark.parametrize("block_rows", [3, 7, 1000])
def test_blocks_of_any_size_give_the_same(block_rows):
    one = Story().touch().piece(1.3, (0.9, 0, 0.2), -0.5, 0.4).touch(0.1).piece(0.7, (0.3, 0, 0))
    two = Story(position=(15.8, 1.5, 0.1)).piece(0.4, contact=True)
    two.piece(1.1, (0.7, 0, -0.3), -0.9, 0.2).touch().piece(0.6, contact=True)
    for story in (one, two):
        story.time = story.time[::20] + story.time[-1:]
        for name in ("position", "velocity", "spin"):
            values = getattr(story, name)
            setattr(story, name, values[::20] + values[-1:])
    whole, pieces = analysed(one, two), analysed(one, two, block_rows=block_rows)
    assert whole.state.tolist() == pieces.state.tolist()
    for name in ("tag", "start", "end", "path", "roll", "distance", "height"):
        # Sums of the same terms in the same order: equal but for the last bits.
        assert getattr(pieces, name) == pytest.approx(getattr(whole, name), abs=1e-12)


def test_a_collision_of_two_grains_belongs_to_both():
    one, two = (
        Story().piece(1.0, (0.3, 0, 0)).piece(0.01).piece(1.0, (0.3, 0, 0)) for _ in range(2)
    )
    one.contacts = [(1.0, 1.01)]
    phases = analysed(one, two, partner=2)
    assert [(phases.tag == tag).sum() for tag in (1, 2)] == [3, 3]
