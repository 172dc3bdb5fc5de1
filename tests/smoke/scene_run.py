"""A shipped scene, run for some steps with the programs just built, as the launcher starts it."""

import os
import subprocess
from pathlib import Path

from bedload_launcher import job, scenes  # conftest.py shows the way


def run_scene(name, model, out, settings, steps, variables=None):
    """On 1 + 1 ranks, into the folder `out`, which is made."""
    out.mkdir(exist_ok=True)
    scene = scenes.find_scene(name)
    work = job.Job(scene, model, job.Ranks(1, 1), out, settings, steps, variables or {})
    programs = Path(os.environ["BEDLOAD_BIN"])
    line = [
        str(programs / Path(word).name) if Path(word).parent == job.BIN else word
        for word in work.command()
    ]
    done = subprocess.run(
        line, cwd=scene.folder, env=job.environment(), stdin=subprocess.DEVNULL,
        capture_output=True, text=True, timeout=280,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
