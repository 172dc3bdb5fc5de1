"""Of two spheres that overlap each is told to the fluid with its share by the masses; one that a fix moves as
prescribed has none beside one that answers to forces."""

import numpy as np
import pytest

from pocket import changed_jobs

DEPTH = 0.02
VELOCITY = "velocity        grains set 0.7 -0.6 0.05 units box"
# High over the bed, one above the other and twice as heavy.
PLACED = ("set atom 9 x 1.5 y 1.5 z 1.0 diameter 0.8\n"
          f"set atom 10 x 1.5 y {2.3 - DEPTH} z 1.0 diameter 0.8 density 5.0\n"
          "velocity grains set 0 0 0 units box")
MOTION = "fix             motion grains nve/sphere"
THERMO = "thermo          1500"
DUMP = (THERMO, f"{THERMO}\ndump shares grains custom 15 ${{out}}/shares.txt id " + " ".join(
    f"f_couple_overlap[{d}]" for d in (1, 2, 3)))  # fmt: skip


def moving(*lines):
    return ((VELOCITY, PLACED), (MOTION, "\n".join(lines)), DUMP)


PAIRS = "pair_style      gran model actm tangential haff_werner"
EACH = "pair_coeff      * *"
CASES = {
    "free": moving(MOTION),
    "free, a pair style of two": (*moving(MOTION), (PAIRS, PAIRS.replace("gran", "hybrid/overlay soft 0.1 gran")),
                                  (EACH, f"{EACH} gran\n{EACH} soft 0.0")),
    "upper held": moving("group upper id 10", "group lower id 9", MOTION.replace("grains", "lower"),
                         "fix still upper nve/noforce"),
    "both held": moving("fix still grains nve/noforce"),
    "held, in the lid": ((VELOCITY, PLACED.replace(f"y {2.3 - DEPTH} ", "y 2.8 ")),
                         *moving("fix still grains nve/noforce")[1:]),
}  # fmt: skip


@pytest.fixture(scope="module")
def overlaps(tmp_path_factory):
    """Of each case the overlaps of atoms 9 and 10, array (2, 3), as first told to the fluid."""
    folder = tmp_path_factory.mktemp("overlaps")
    found = {}
    for place, (case, result) in enumerate(changed_jobs(folder, CASES, steps=1).items()):
        assert result.status == 0, result.output
        frames = (folder / str(place) / "out" / "shares.txt").read_text().split("ITEM: ATOMS")
        lines = [line.split() for line in frames[-1].splitlines()[1:]]
        found[case] = np.array(sorted(lines, key=lambda words: int(words[0])), dtype=float)[:, 1:]
    return found


# The lower one has moved up into the upper, the upper down into the lower, along y.
@pytest.mark.parametrize(("case", "lower", "upper"), [
    ("free", 2 / 3, 1 / 3), ("free, a pair style of two", 2 / 3, 1 / 3), ("upper held", 1.0, 0.0),
])
def test_shares_of_the_overlap(overlaps, case, lower, upper):
    shares = overlaps[case]
    depth = shares[0, 1] - shares[1, 1]
    assert depth == pytest.approx(DEPTH, rel=0.2)  # the collision has begun to part them
    assert shares[:, 1] / depth == pytest.approx(np.array([lower, -upper]), abs=1e-5)  # digits of a dump
    assert np.all(np.abs(shares[:, ::2]) < 0.01 * depth)


def test_spheres_moved_as_prescribed_are_where_they_are(overlaps):
    for case in ("both held", "held, in the lid"):
        assert np.array_equal(overlaps[case], np.zeros((2, 3))), case
