"""Scenes anywhere: blanks in the paths of scene and output, the shipped models from any folder."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
from programs import BIN, wait_for

from bedload_launcher import job as launcher_job
from bedload_launcher.scenes import Scene
from bedload_studies.small_scenes import Ball, SmallScene


@pytest.fixture
def scene(tmp_path):
    """A sphere in a small box, in a folder with a blank and a newline in its path."""
    small = SmallScene((2.0, 2.0, 2.0), 6, 0.05, 0.02, 0.1, [Ball((1.0, 1.0, 1.0))])
    small.write(tmp_path / "my scenes\n2")
    return Scene(tmp_path / "my scenes\n2")


def test_blanks_and_the_shipped_models(scene, monkeypatch):
    monkeypatch.setattr(launcher_job, "BIN", BIN)
    for out in (scene.folder / "runs", scene.folder.parent / "out of it"):
        out.mkdir()
        work = launcher_job.Job(scene, "actm", launcher_job.Ranks(1, 1), out)
        assert launcher_job.run_job(work) == 0
        assert (out / "collisions.csv").is_file()
        assert (out / "spheres.h5").is_file()


def test_nothing_runs_on_when_the_launcher_is_killed(scene):
    """SIGKILL of the process that started mpirun ends mpirun and both programs."""
    out = scene.folder / "out"
    out.mkdir()
    code = (
        f"import sys; sys.path.insert(0, {str(Path(launcher_job.__file__).parents[1])!r})\n"
        "from pathlib import Path\n"
        "from bedload_launcher import job\n"
        "from bedload_launcher.scenes import Scene\n"
        f"job.BIN = Path({str(BIN)!r})\n"
        f"work = job.Job(Scene(Path({str(scene.folder)!r})), 'actm', job.Ranks(1, 1), Path({str(out)!r}),\n"
        "               ['time.end=1e6'])\n"
        "job.run_job(work)\n"
    )
    launcher = subprocess.Popen(["/usr/bin/python3", "-c", code], stdout=subprocess.DEVNULL)
    history = out / "history.csv"
    wait_for(lambda: history.is_file() and history.read_text().count("\n") > 3)
    running = running_in(out)
    assert len(running) == 3
    os.kill(launcher.pid, signal.SIGKILL)
    launcher.wait()
    wait_for(lambda: not running_in(out))


def running_in(out):
    """Numbers of the processes whose line names `out` or a way to it."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if words[0].endswith((b"mpirun", b"bedload-fluid", b"bedload-dem")) and os.fsencode(out) in b" ".join(words):
            found.append(int(entry.name))
    return found
