"""A small bed settles: the packing asked for, no overlap, the same seed the same bed; LIGGGHTS reads the file."""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "postproc"))

from bedload_launcher import bed_options, job  # noqa: E402  (need the path above)
from bedload_studies import bed_settling  # noqa: E402
from bedload_studies.packing import Bed  # noqa: E402

BIN = Path(os.environ["BEDLOAD_BIN"])


def settle(out, *words):
    parser = argparse.ArgumentParser()
    bed_options.add_options(parser)
    bed_settling.BIN = BIN
    assert bed_settling.settle(parser.parse_args([*words, "--out", str(out)])) == 0
    rows = [line.split() for line in out.read_text().splitlines() if len(line.split()) == 7]
    table = np.array(rows, dtype=float)
    return Bed(table[:, 4:], 0.5 * table[:, 2], (5.0, 4.5)), table[:, 1]


WORDS = ("5x4.5", "--grains", "160", "--sizes", "1:0.7", "0.8:0.3", "--fixed", "0.75")


@pytest.fixture(scope="module")
def dense(tmp_path_factory):
    out = tmp_path_factory.mktemp("settle") / "bed.data"
    return out, *settle(out, *WORDS, "--packing", "0.6", "--seed", "3")


def test_packing_sizes_and_overlap(dense, capsys):
    _, bed, kinds = dense
    assert bed.packing() == pytest.approx(0.6, abs=0.005 + 1e-4)  # the tolerance that is stated, and the file's digits
    assert bed.overlap() < bed_settling.OVERLAP
    assert bed.position[:, 1].min() > 0.39  # on the floor, not in it
    assert (bed.radius == 0.4).sum() == 48
    assert 5 < (kinds == 1).sum() < 40 and set(kinds) == {1, 2}
    assert bed.position[kinds == 1, 1].max() < 0.75 < bed.position[kinds == 2, 1].min()


def test_a_thick_bed_is_at_rest_to_its_top(tmp_path):
    """Grains that lie have four to six contacts; those that are still thrown up or falling have hardly any: 1.7 in the
    upper half of such a bed, gaps below a thousandth of the diameter counted, when it was not waited for them."""
    bed, _ = settle(tmp_path / "bed.data", "4x3.5", "--grains", "160", "--seed", "3")
    position = bed.position
    upper = (position[:, 1] > 0.5 * bed.surface(0.0)) & (position[:, 1] < bed.surface(0.0) - 1.0)
    apart = position[upper, None] - position[None]
    for axis, length in ((0, 4.0), (2, 3.5)):
        apart[..., axis] -= length * np.round(apart[..., axis] / length)
    touching = np.linalg.norm(apart, axis=2) < 1.001
    assert touching.sum(axis=1).mean() - 1.0 > 3.0  # itself left out


def test_same_seed_same_bed(tmp_path):
    words = ("4x3.5", "--grains", "60")  # one fall
    for name, seed in (("first", "3"), ("again", "3"), ("other", "4")):
        settle(tmp_path / name, *words, "--seed", seed)
    first, again, other = ((tmp_path / name).read_bytes() for name in ("first", "again", "other"))
    assert first == again
    assert first.splitlines()[11:] != other.splitlines()[11:]


def test_a_script_reads_it(dense, tmp_path):
    out, bed, kinds = dense
    (tmp_path / "in.bed").write_text(f"""units si
atom_style granular
atom_modify map array sort 0 0
newton off
communicate single vel yes
boundary p f p
variable bed_file index {out}
variable density index 2.1
region box block 0 5.0 0 20 0 4.5 units box
create_box 2 box
neighbor 0.1 bin
include ${{inputs}}/beds/settled.liggghts
variable fixed equal count(bed)
variable mobile equal count(grain)
variable heavy equal mass(grain)
print "read ${{fixed}} ${{mobile}} ${{heavy}}"
""")
    done = subprocess.run(
        [BIN / "bedload-dem", "-in", "in.bed"], cwd=tmp_path, env=job.environment(), capture_output=True, text=True,
    )  # fmt: skip
    words = next(line for line in done.stdout.splitlines() if line.startswith("read")).split()
    assert [int(words[1]), int(words[2])] == [(kinds == 1).sum(), (kinds == 2).sum()]
    mobile = Bed(bed.position[kinds == 2], bed.radius[kinds == 2], bed.box)
    assert float(words[3]) == pytest.approx(2.1 * mobile.volume, rel=1e-6)
