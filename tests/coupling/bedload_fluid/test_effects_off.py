"""What is off is not there: nothing allocated, sent or started for it. Counts, not times, by a preloaded
library; each is shown to see the effect when it is on."""

import pytest
from programs import BIN

from bedload_launcher import bench_effects as effects
from bedload_launcher import job as launcher_job

RANKS = 2
FIELD = 8 * 96 * 48 * 64  # bytes of one number a cell


@pytest.fixture(autouse=True)
def programs(monkeypatch):
    monkeypatch.setattr(launcher_job, "BIN", BIN)


def step(line, ranks=RANKS, short=2):
    return effects.per_step(line, ranks, short)


def test_a_channel_without_grains_is_the_flow_solver_alone(tmp_path):
    """The same messages as the bare loop, not one more; one sum over ranks more, by which all agree
    on checkpoints; and what it allocates in a step are words, no fields."""
    off = step(lambda n: effects.fluid(n, tmp_path / "out"))
    never = step(lambda n: effects.plain(n))
    assert off["messages"] == never["messages"] > 0
    assert off["bytes_sent"] == never["bytes_sent"] > 0
    assert off["sums"] == never["sums"] + RANKS
    assert off["bytes"] < FIELD / 48


def test_a_channel_without_grains_allocates_no_more_than_the_solver(tmp_path):
    """Up to its last message, when the buffers of the last files are not there yet: words and small tables
    beyond the bare loop's, no field and no part of one."""
    def allocated(line):
        return effects.total(effects.counted(line, RANKS), "bytes_at_last_message")

    never = allocated(effects.plain(1))
    off = allocated(effects.fluid(1, tmp_path / "out"))
    assert not (tmp_path / "out" / "statistics.h5").exists()
    assert off - never < 0.1 * FIELD
    # Each effect would be seen: markers and scratch fields; sums over 48 planes.
    assert allocated(effects.fluid(1, tmp_path / "out", (effects.FIXED,))) > off + FIELD
    assert allocated(effects.fluid(1, tmp_path / "out", (effects.STATISTICS,))) > off + 20_000
    assert (tmp_path / "out" / "statistics.h5").exists()


def test_fixed_spheres_start_no_liggghts(tmp_path):
    started = effects.programs(effects.counted(effects.fluid(1, tmp_path / "out", (effects.FIXED,)), RANKS))
    assert started == RANKS * ["bedload-fluid"]
    never = step(lambda n: effects.plain(n, (effects.FIXED,)))
    off = step(lambda n: effects.fluid(n, tmp_path / "out", (effects.FIXED,)))
    assert off["messages"] == never["messages"] and off["bytes_sent"] == never["bytes_sent"]


def test_grains_that_never_meet_have_no_films():
    off, never = (step(lambda n, film=film: effects.grains(n, film), 1, 100) for film in (True, False))
    assert off == never

    def allocated(line):
        return effects.total(effects.counted(line, 1), "bytes")

    # Half a diameter lies between them on the mean: with that range there are films, and they are seen: their arrays
    # take half a megabyte and more, once, as they keep their length from step to step.
    never = allocated(effects.grains(100, False))
    assert allocated([*effects.grains(100, True), "-var", "range", "0.6"]) > never + 500_000
