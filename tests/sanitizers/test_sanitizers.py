"""Address and undefined-behaviour sanitizers over unit tests and a small coupled run.

Builds, in a folder of its own, some minutes the first time: the fluid with its output and the exchange,
and the tests of settings (fuzzed texts among them), files and contact formulas. LIGGGHTS is Debian's,
without sanitizers, and runs beside the fluid as it stands.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "coupling"))
from programs import SCENES, command, run  # noqa: E402

FOLDER = Path(os.environ["BEDLOAD_SANITIZERS"])
# MPI, HDF5 and Python's preloads leave memory behind on purpose; a report of ours ends the program.
SANITIZERS = {
    "ASAN_OPTIONS": "detect_leaks=0:exitcode=99",
    "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1:exitcode=99",
}


@pytest.fixture(scope="module", autouse=True)
def programs():
    """The built programs; nothing is done when they are up to date, as behind `./bedload test`."""
    if not (FOLDER / "build.ninja").is_file():
        made = subprocess.run(
            ["cmake", "--preset", "sanitizers", "-S", str(ROOT), "-B", str(FOLDER)],
            cwd=ROOT, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert made.returncode == 0, made.stdout + made.stderr
    made = subprocess.run(["ninja", "-C", str(FOLDER), "tested_with_sanitizers"], capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert made.returncode == 0, made.stdout[-5000:]


def check(result):
    assert result.status == 0, result.output[-6000:]
    assert "Sanitizer" not in result.output and "runtime error" not in result.output


def start(line, folder):
    return run(["env", *(f"{k}={v}" for k, v in SANITIZERS.items()), *line], folder, timeout=500)


@pytest.mark.parametrize("program", ["fluid_tests", "styles-formulas-test"])
def test_units(tmp_path, program):
    check(start([str(FOLDER / "bin" / program)], tmp_path))


@pytest.mark.parametrize("ranks", [1, 2])
def test_files(tmp_path, ranks):
    check(start(["/usr/bin/mpirun", "-np", str(ranks), str(FOLDER / "bin" / "fluid_output_tests")],
                tmp_path))


@pytest.mark.parametrize("ranks", [(1, 1), (2, 1)], ids=["1+1", "2+1"])
def test_a_coupled_run_and_its_restart(tmp_path, ranks):
    scene, out = SCENES / "pocket", tmp_path / "out"
    dem = [str(Path(os.environ["BEDLOAD_BIN"]) / "bedload-dem"), "-in", str(scene / "in.liggghts"),
           "-var", "out", str(out), "-log", "none"]  # fmt: skip
    fluid = [str(FOLDER / "bin" / "bedload-fluid"), str(scene / "fluid.toml"), "--out", str(out),
             "--steps", "5", "--set", "checkpoint.every=0.04", "--set", "statistics.every=1", "--set",
             "output.fields_every=0.04"]  # fmt: skip
    check(start(command(fluid, dem, ranks), tmp_path))
    check(start(command([*fluid, "--restart", str(out)], dem, ranks), tmp_path))


def test_spoilt_checkpoints(tmp_path):
    """The 540 of tests/coupling, read by a reader that minds each byte beyond an end."""
    spoilt = str(ROOT / "tests" / "coupling" / "checkpoint" / "test_spoilt_checkpoints.py")
    tests = [sys.executable, "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", spoilt, "-k", "refused"]
    check(start(["env", f"BEDLOAD_READER={FOLDER / 'bin' / 'open_checkpoints'}", *tests], tmp_path))
