"""`./bedload study models` from the command to the report, on a coarse grid and for a few steps."""

import argparse
import json
import os
import shutil
import signal
import threading
from pathlib import Path

import numpy as np
import pytest
from bedload_launcher import job
from bedload_post.outputs import MissingOutput, Run
from bedload_studies import models

SHORT = [
    "--set", "grid.cells=[130, 50, 65]", "--set", "time.step=0.1", "--set", "time.end=0.6",
    "--set", "output.spheres_every=0.0", "--set", "output.history_every=1",
    "--set", "start.from=\"logarithmic\"", "--set", "start.velocity=1.0",
]  # fmt: skip


@pytest.fixture
def study(monkeypatch, tmp_path):
    """Runs the study with the programs just built; returns (status, mpirun lines that were started)."""
    monkeypatch.setattr(job, "BIN", Path(os.environ["BEDLOAD_BIN"]))
    started, real_run = [], job.run
    monkeypatch.setattr(job, "run", lambda line, folder: started.append(line) or real_run(line, folder))

    def run(*words):
        parser = argparse.ArgumentParser()
        models.add_options(parser)
        line = ["--models", "rpm", "actm_hw", "--ranks", "1:1", "--discard", "0", "--no-bed"]
        options = parser.parse_args([*line, "--out", str(tmp_path), *words])
        return models.run(options), started

    return run


def test_two_models_then_the_report_and_nothing_twice(study, tmp_path):
    status, started = study(*SHORT)
    assert status == 0
    assert len(started) == 2
    report = tmp_path / "report-setup2_small"
    kept = json.loads((report / "numbers.json").read_text())
    assert [run["model"] for run in kept["runs"]] == ["rpm", "actm_hw"]
    assert all(run["grains"] == 125 for run in kept["runs"])
    # 0.6 D/u_b of 26 D/u_b; the first sample is the start.
    assert kept["runs"][0]["flow_throughs"] == pytest.approx(0.6 / 26, rel=1e-9)
    assert kept["circumstances"]["ranks of each run"].startswith("1 of the fluid")
    assert "data:image/png;base64" in (report / "report.html").read_text()

    shutil.rmtree(report)
    assert study(*SHORT)[0] == 0
    assert len(started) == 2  # both were done: only the report was written anew
    assert (report / "report.html").is_file()


def interrupt_after_three_steps(out: Path, over: threading.Event) -> None:
    """Ctrl-C as soon as the run in `out` has written three steps."""
    while not over.wait(0.02):
        try:
            if len(Run(out).history()["step"]) < 3:
                continue
        except (MissingOutput, OSError, ValueError):
            continue
        os.kill(os.getpid(), signal.SIGINT)
        return


def test_an_interrupted_run_goes_on_and_gives_the_same(study, tmp_path):
    one = [*SHORT, "--set", "time.end=2.0", "--set", 'accuracy.precision="double"']
    one += ["--models", "actm_hw"]
    out = tmp_path / "setup2_small-actm_hw"
    assert study(*one)[0] == 0
    out.rename(tmp_path / "at once")

    over = threading.Event()
    threading.Thread(target=interrupt_after_three_steps, args=(out, over)).start()
    try:
        assert study(*one)[0] != 0
    finally:
        over.set()
    assert 3 <= Run(out).history()["step"][-1] < 20

    status, started = study(*one)
    assert status == 0
    assert "--restart" in started[-1]
    assert (out / "log.part1.liggghts").is_file()
    whole, parts = Run(tmp_path / "at once"), Run(out)
    assert list(parts.history()["step"]) == list(whole.history()["step"])
    # Two runs measure FFTW's plans each for itself, so they differ by round-off (6e-15 after
    # 20 steps); a step too many or too few would show as 1e-2.
    for a, b in zip(whole.sample_blocks(), parts.sample_blocks(), strict=True):
        assert np.array_equal(a.time, b.time)
        assert np.array_equal(a.tag, b.tag)
        assert b.position == pytest.approx(a.position, abs=1e-12)
        assert b.velocity == pytest.approx(a.velocity, abs=1e-12)
        assert b.angular_velocity == pytest.approx(a.angular_velocity, abs=1e-12)
