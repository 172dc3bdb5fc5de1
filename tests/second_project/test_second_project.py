"""bedload installed to a prefix, and a project of one's own that uses library and plug-ins of it."""

import math
import os
import re
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
BUILD = Path(os.environ["BEDLOAD_BUILD"])
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "RES_OPTIONS": "timeout:1 attempts:1",
}


def _cached(name):
    cache = (BUILD / "CMakeCache.txt").read_text(encoding="utf-8")
    return re.search(rf"^{name}:\w+=(.*)$", cache, re.MULTILINE)[1]


def say(*words, folder=None, status=0):
    """What the command prints; fails with all of it when its status is another."""
    done = subprocess.run(
        [str(word) for word in words], cwd=folder, env=ENVIRONMENT, text=True, errors="replace",
        timeout=900, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
    )  # fmt: skip
    assert (done.returncode == 0) == (status == 0), done.stdout
    return done.stdout


@pytest.fixture(scope="session")
def prefix(tmp_path_factory):
    where = tmp_path_factory.mktemp("installed")
    say("cmake", "--install", BUILD, "--prefix", where)
    return where


@pytest.fixture(scope="session")
def project(prefix, tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    sanitizers = _cached("BEDLOAD_SANITIZE")
    flags = f"-fsanitize={sanitizers}" if sanitizers else ""
    say(
        "cmake", "-S", HERE, "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
        f"-DCMAKE_CXX_COMPILER={_cached('CMAKE_CXX_COMPILER')}", f"-DCMAKE_CXX_FLAGS={flags}",
        "-DCMAKE_BUILD_TYPE=Debug",
    )  # fmt: skip
    say("cmake", "--build", folder)
    return folder


def test_flow_solver_as_a_library(project):
    out = say("mpirun", "--oversubscribe", "--bind-to", "none", "-np", 2, project / "channel")
    found = re.search(r"steps (\d+) bulk (\S+) exact (\S+)", out)
    assert int(found[1]) == 500
    # The scheme's own parabola carries 2 (h/H)^2 more than the exact one, on 32 cells 2e-3.
    assert float(found[2]) == pytest.approx(float(found[3]), rel=2e-3)


@pytest.mark.parametrize("damping", [0.0, 0.1])
def test_collision_model_of_ones_own(prefix, project, tmp_path, damping):
    program = prefix / "bin" / "bedload-dem"
    out = say(
        program, "-in", HERE / "in.rebound", "-var", "plugin", project / "soft.so",
        "-var", "damping", damping, folder=tmp_path,
    )  # fmt: skip
    left, right = map(float, re.search(r"speeds (\S+) (\S+)", out).groups())
    ratio = damping / (2 * math.sqrt(100 * 0.5e-3))
    restitution = math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2))
    # 700 steps in a contact; LIGGGHTS' half-step velocities in the damper cost 1 in 700.
    assert right == pytest.approx(0.1 * restitution, rel=3e-3)
    assert left == pytest.approx(-right, rel=1e-9)


def test_keywords_of_ones_own_are_checked(prefix, project, tmp_path):
    out = say(
        prefix / "bin" / "bedload-dem", "-in", HERE / "in.rebound", "-var", "plugin",
        project / "soft.so", "-var", "damping", "much", folder=tmp_path, status=1,
    )  # fmt: skip
    assert "damping needs a number, found 'much'" in out


@pytest.mark.parametrize(
    "what, words",
    [
        ("nowhere.so", ["plugin: there is no file", "nowhere.so"]),
        ("text.so", ["plugin:", "text.so"]),
        (_cached("LIGGGHTS_LIBRARY"), ["is no plug-in of bedload"]),
    ],
)
def test_what_is_no_plugin(prefix, tmp_path, what, words):
    (tmp_path / "text.so").write_text("no library")
    out = say(
        prefix / "bin" / "bedload-dem", "-in", HERE / "in.rebound", "-var", "plugin", what,
        folder=tmp_path, status=1,
    )  # fmt: skip
    for word in words:
        assert word in out


def test_installed_program_runs_without_its_build_folder(prefix, tmp_path):
    assert "time.step" in say(prefix / "bin" / "bedload-fluid", "--help-keys", folder=tmp_path)
    assert "--help-styles" in say(prefix / "bin" / "bedload-dem", "--help", folder=tmp_path)
    assert "plugin load FILE" in say(prefix / "bin" / "bedload-dem", "--help-styles", folder=tmp_path)
