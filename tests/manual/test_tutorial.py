"""The tutorial, done as it says: its files written, its commands run, in an empty folder."""

import os
import re
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

import tables

TUTORIAL = tables.ROOT / "inputs" / "TUTORIAL.md"
BUILD = tables.ROOT / "build" / "release"
BIN = Path(os.environ["BEDLOAD_BIN"])
RUNS = ("flow", "one", "one-rpm", "six", "six-soft")

# The launcher builds and runs the release preset, whatever this test belongs to.
pytestmark = pytest.mark.skipif(BIN != BUILD / "bin", reason="the tutorial runs the release build")


def steps():
    """(kind, file or "", text) of every block, in order."""
    text = TUTORIAL.read_text(encoding="utf-8")
    return re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def follow(folder: Path) -> str:
    """All of it; returns what was printed."""
    environment = os.environ | {"BEDLOAD": str(tables.ROOT), "TERM": "dumb"}
    here, printed = folder, ""
    for kind, name, text in steps():
        if name:
            (here / name).parent.mkdir(exist_ok=True)
            (here / name).write_text(text, encoding="utf-8")
            continue
        assert kind == "sh"
        done = subprocess.run(
            ["bash", "-e", "-c", text], cwd=here, env=environment, text=True, timeout=900,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        assert done.returncode == 0, text + done.stdout[-4000:]
        printed += done.stdout
        here = folder / "my_scene"
    return printed


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tutorial")
    return follow(folder), folder / "my_scene"


def test_it_leaves_what_it_promises(done):
    printed, scene = done
    for run in RUNS:
        names = ["report.html", "picture.png"] + ["path.png"] * (run != "flow")
        assert all((scene / "runs" / run / name).stat().st_size > 1000 for name in names), run
    assert (scene / "height.png").stat().st_size > 1000
    assert "columns of history.csv: " in printed


def test_the_grain_rolls_and_the_flow_is_a_channel(done):
    printed, _ = done
    samples, speed = re.search(r"grain \d+: (\d+) samples, mean speed (\S+) u_b", printed).groups()
    assert int(samples) == 171  # every 0.1 until 17: the restart went on in the same file
    assert 0.02 < float(speed) < 0.5
    surface, bed = map(float, re.search(r"surface (\S+), just above the bed (\S+) u_b", printed).groups())
    assert 1.3 < surface < 1.7  # a parabola's is 1.5 u_b
    assert 0 < bed < 0.5


def test_six_grains_each_with_its_model(done):
    _, scene = done
    ends = []
    for run in ("six", "six-soft"):
        with h5py.File(scene / "runs" / run / "spheres.h5") as file:
            ends.append(file["mobile/position"][-6:])
            assert len(set(file["mobile/tag"][:])) == 6
    # On the bed, neither in it nor lifted off; a model without film is not the one with it.
    assert all((1.1 < end[:, 1]).all() and (end[:, 1] < 1.8).all() for end in ends)
    assert np.abs(ends[0] - ends[1]).max() > 1e-3


def test_the_readme_s_way_to_read_a_run(done):
    _, scene = done
    readme = (tables.ROOT / "README.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"^```python\n(.*?)^```$", readme, re.MULTILINE | re.DOTALL)
    printed = subprocess.run(
        ["/usr/bin/python3", "-", "runs/one"], cwd=scene, input=script, text=True, timeout=60,
        stdout=subprocess.PIPE, check=True,
    ).stdout  # fmt: skip
    assert "last 17.0" in printed and "largest CFL number 0.6" in printed


def test_the_batch_job_starts_and_goes_on(done):
    _, scene = done
    for end in (0.5, 1.0):
        batch = ["bash", str(tables.ROOT / "inputs" / "job.slurm"), "--set", f"time.end={end}"]
        subprocess.run(
            batch, cwd=scene, check=True, timeout=300, stdout=subprocess.DEVNULL,
            env=os.environ | {
                "PATH": f"{BIN}:/usr/bin:/bin", "SLURM_NTASKS": "1", "SLURM_JOB_NAME": "mine",
                "MODEL": "actm", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            },
        )  # fmt: skip
    history = np.genfromtxt(scene / "runs" / "mine-actm" / "history.csv", delimiter=",", names=True)
    assert history["time"][-1] == pytest.approx(1.0)
    assert list(history["step"]) == sorted(set(history["step"]))  # one record, no row twice
