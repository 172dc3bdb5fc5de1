"""Maps of a bed's motion: what moves is counted where it is, the surface is the highest grain's top."""

import matplotlib.image
import numpy as np
import pytest
from bedload_post import bed_motion
from bedload_post.frames import Frames


class FakeRun:
    """Two instants of four grains in a box 2 D long and 2 D wide."""

    box, diameter, bulk_velocity = np.array([2.0, 5.0, 2.0]), 1.0, 1.0

    def __init__(self, monkeypatch):
        position = np.array([[0.5, 1.0, 0.5], [0.6, 2.0, 0.4], [0.5, 1.5, 1.5], [-0.5, 3.0, 1.5]])  # the last: x = 1.5
        speed = np.array([[0.0, 0.02, 0.0, 0.0], [0.5, 0.009, 0.3, 0.3]])
        velocity = np.zeros((2, 4, 3))
        velocity[..., 2] = speed
        part = Frames(
            np.array([0.0, 1.0]), np.arange(4), np.array([position, position]), velocity, np.zeros((2, 4, 3)),
            np.full((2, 4), 0.5),
        )  # fmt: skip
        monkeypatch.setattr(bed_motion, "frames", lambda _: [part])
        monkeypatch.setattr(bed_motion, "_grains", lambda _: 4)

    def sample_blocks(self, **_):
        return iter(())

    def instants(self):
        return [(np.array([0.0, 1.0]), None)]


def test_share_in_motion_and_surface(monkeypatch):
    time, share, top = bed_motion.maps(FakeRun(monkeypatch))
    assert time.tolist() == [0.0, 1.0]
    assert share == pytest.approx(np.array([[1 / 3, 0.0], [2 / 3, 1.0]]))  # 0.009 u_b is rest
    # Over the first piece the strips' highest tops are 2.5 and 2.0; over the second one strip holds a grain.
    assert top == pytest.approx(np.array([[2.25, 3.5], [2.25, 3.5]]))


def test_several_runs_stand_side_by_side_on_one_scale(monkeypatch, tmp_path):
    named = [("rpm", FakeRun(monkeypatch)), ("actm", FakeRun(monkeypatch))]
    assert not bed_motion.compare(named, tmp_path / "motion.png")  # four grains: their paths say more
    monkeypatch.setattr(bed_motion, "_grains", lambda _: bed_motion.FEWEST)
    assert bed_motion.compare(named, tmp_path / "motion.png")
    assert (tmp_path / "motion.png").stat().st_size > 1000
    # Five runs: a row of four and one of one; the start-up's end is drawn where it is said.
    two = matplotlib.image.imread(tmp_path / "motion.png")
    assert bed_motion.compare([*named, *named, named[0]], tmp_path / "five.png")
    five = matplotlib.image.imread(tmp_path / "five.png")
    assert five.shape[0] == pytest.approx(2 * two.shape[0], abs=2)
    assert bed_motion.compare(named, tmp_path / "since.png", since=0.5)
    assert (matplotlib.image.imread(tmp_path / "since.png") != two).any()
