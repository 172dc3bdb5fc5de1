"""Configuring refuses a LIGGGHTS that was built with other switches than ours, with one sentence."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


# The switches are given to our side instead of to LIGGGHTS: what counts is that the two differ.
@pytest.mark.parametrize(
    "switches, words",
    [
        (
            "-DSUPERQUADRIC_ACTIVE_FLAG -DNONSPHERICAL_ACTIVE_FLAG",
            ["do not fit", "class SurfacesIntersectData has 400 bytes", "SUPERQUADRIC_ACTIVE_FLAG"],
        ),
        ("-DLAMMPS_BIGBIG", ["counts in other integers", "LAMMPS_SMALLBIG"]),
    ],
)
def test_a_liggghts_that_does_not_fit(tmp_path, switches, words):
    done = subprocess.run(
        [
            "cmake", "-S", str(ROOT), "-B", str(tmp_path), "-G", "Ninja", "-DBEDLOAD_TESTS=OFF",
            "-DCMAKE_C_COMPILER=clang", "-DCMAKE_CXX_COMPILER=clang++", f"-DCMAKE_CXX_FLAGS={switches}",
        ],
        text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    sentence = " ".join(done.stdout.split())
    assert all(word in sentence for word in words), done.stdout
