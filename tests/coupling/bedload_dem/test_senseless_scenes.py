"""Numbers in a LIGGGHTS script that no machine minds and that make no sense beside the fluid: refused
with one sentence, or warned of. Those of fluid.toml alone are in tests/fluid/settings/test_bad_settings.cpp, those of
the hand-shake in test_exchange.py."""

import pytest

from pocket import changed_jobs, check_refused

GRAIN = "create_atoms    2 single 3.3 2.0 0.5 units box"
VELOCITY = "velocity        grains"
WEIGHT = "fix             weight all gravity 0.5 vector 0 -1 0"


def grain(*places):
    return (GRAIN, "\n".join(f"create_atoms 2 single {place} units box" for place in places))


# What is changed in the scene `pocket`, and words of the sentence.
REFUSED = {
    "in another grain": (grain("2.05 1.8 1.1"), ["atoms 9 and 10", "overlap by 0.888", "at most 0.5"]),
    "in the same place": (grain("1.95 1.75 1.1"), ["atoms 9 and 10", "overlap by 1, "]),
    "in another across a periodic end": (grain("3.9 2.0 0.5", "0.1 2.0 0.5"), ["overlap by 0.8"]),
    "in a fixed one": (grain("0.5 0.9 0.5"), ["overlap by 0.6"]),
    "in the upper wall": (grain("3.3 2.9 0.5"), ["atom 10", "y = 2.9", "0.4 deep in the upper wall"]),
    "moved out of the box": (
        (VELOCITY, "displace_atoms grains move 0 1.6 0 units box\n" + VELOCITY),
        ["atom 9 at (1.95, 3.35, 1.1)", "has left the box"],
    ),
    "under the floor": ((VELOCITY, "set atom 9 y -3\n" + VELOCITY), ["atom 9", "has left the box"]),
    "too small for the cells": (("diameter 1.0", "diameter 0.4"), ["3.2 cells", "at least 4"]),
    "larger than the box": (("diameter 1.0", "diameter 2.5"), ["2.5", "only 2 long along z"]),
    "lighter than the scheme carries": (("density 2.5", "density 0.2"), ["density 0.2", "from 0.3 on"]),
    "too fast": ((VELOCITY + " set 0.7", VELOCITY + " set 5000"), ["atom 9", "'time.step'"]),
    "a place that is no number": (
        (VELOCITY, "variable far atom 1e300*1e300-1e300*1e300\nset atom 9 x v_far\n" + VELOCITY),
        ["atom 9", "no finite number"],
    ),
    "an infinite place": (
        (VELOCITY, "variable far atom 1e300*1e300\nset atom 9 x v_far\n" + VELOCITY),
        ["atom 9", "no finite number"],
    ),
    "a fixed sphere without a place": (
        (VELOCITY, "variable far atom 1e300*1e300-1e300*1e300\nset atom 3 x v_far\n" + VELOCITY),
        ["atom 3", "no finite number"],
    ),
    "an infinite speed": (
        (VELOCITY, "variable far atom 1e300*1e300\nvelocity grains set v_far 0 0\n#"),
        ["atom 9", "no finite number"],
    ),
    "smallest gap above the range": (
        ("all lubrication", "all lubrication gapMin 0.6"),
        ["gapMin of 0.6 radii is a gap of 0.3", "the range 0.25"],
    ),
    "restitution above one": (("2 0.9 0.9 0.9 0.9", "2 0.9 0.9 0.9 1.1"), ["between 0.01 and 1", "1.1"]),
    "friction below zero": (("0.15 0.15 0.15 0.15", "0.15 0.15 0.15 -1"), ["coefficientFriction", "-1"]),
    "weight for the bed alone": (
        (WEIGHT, WEIGHT.replace("all", "bed")),
        ["gravity is (0, -0.5, 0)", "(0, 0, 0) in the LIGGGHTS script", "its group"],
    ),
    "weight for one grain of two": (
        (WEIGHT, "group one id 9\n" + WEIGHT.replace("all", "one")),
        ["atom 10 has another gravity"],
    ),
    "another box": (("block 0 4 0 3 0 2 units box\ncreate_box", "block 0 4 0 3.5 0 2 units box\ncreate_box"),
                    ["along y is [0, 3]", "[0, 3.5]"]),
}  # fmt: skip


NOT_MADE = {"beyond x": grain("5.3 2.0 0.5"), "beyond y": grain("3.3 3.2 0.5")}
WARNED = {
    "a fixed sphere with a speed": ((VELOCITY, "set atom 3 omegaz 2\n" + VELOCITY),
                                    ["atom 3", "is fixed and has a speed", "as a roller does"]),
    "a bed of another density": (("density 2.5", "density 3.5"),
                                 ["'reference.sphere_density' = 2.5", "the mobile spheres have 3.5"]),
}  # fmt: skip
TAKEN = {
    "a skin of overlap": grain("2.75 1.75 1.1"),  # a dense start, not a mistake
    "weight by two fixes": (WEIGHT, WEIGHT.replace("all", "bed") + "\n"
                            + WEIGHT.replace("weight all", "load grains")),
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    changes = {case: change for case, (change, _) in (REFUSED | WARNED).items()} | NOT_MADE | TAKEN
    cases = {case: (change,) for case, change in changes.items()}
    return changed_jobs(tmp_path_factory.mktemp("senseless"), cases, steps=2)


@pytest.mark.parametrize("case", REFUSED)
def test_refused(results, case):
    check_refused(results[case], REFUSED[case][1])


@pytest.mark.parametrize("case", NOT_MADE)
def test_a_grain_that_is_not_made_is_warned_of(results, case):
    """LIGGGHTS makes no atom outside the box, and says so only in its log."""
    assert results[case].status == 0, results[case].output
    assert "WARNING: a create_atoms has made no atom" in results[case].output
    assert "1 mobile spheres" in results[case].output


@pytest.mark.parametrize("case", WARNED)
def test_warned_of(results, case):
    assert results[case].status == 0, results[case].output
    for word in WARNED[case][1]:
        assert word in results[case].output


@pytest.mark.parametrize("case", TAKEN)
def test_taken(results, case):
    assert results[case].status == 0, results[case].output
