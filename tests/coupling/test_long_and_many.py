"""A thousand coupled steps take no more memory than two hundred; several jobs on one machine leave
each other alone."""

import shutil
import subprocess
import time

import pytest

from job import ENVIRONMENT
from pocket import job, line, rows, same_numbers

from bedload_launcher.memory import MemoryWatch

HALF = 20


def last_step(out):
    table = out / "history.csv"
    return max((int(row["step"]) for row in rows(table)), default=0) if table.is_file() else 0


@pytest.mark.parametrize("ranks", [(1, 1)], ids=["1+1"])
def test_memory_does_not_grow(tmp_path, ranks):
    """Peak memory of both programs at step 1000 over that at step 200, checkpoints among them.
    Messages, markers, contacts and samples are made anew 3 times a step; what kept a hundred bytes
    of each stage would show as 0.24 MB. Bound 0.1 MB: the list of samples and the heap's own pages."""
    out = tmp_path / "out"
    words = ["--set", "time.end=1e3", "--set", "output.history_every=10", "--set",
             "output.spheres_every=1.0", "--set", "checkpoint.every=1.0"]  # fmt: skip
    mpirun = subprocess.Popen(line(out, *words, ranks=ranks), env=ENVIRONMENT,
                              stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)  # fmt: skip
    peaks = {}
    try:
        with MemoryWatch(mpirun.pid) as watch:
            for step in (200, 1000):
                while last_step(out) < step:
                    assert mpirun.poll() is None
                    time.sleep(0.02)
                peaks[step] = {name: watch.bytes_of(name) for name in ("bedload-fluid", "bedload-dem")}
    finally:
        mpirun.terminate()
        mpirun.wait(timeout=60)
    for name, first in peaks[200].items():
        assert first > 10e6
        assert peaks[1000][name] - first < 1e5, f"{name}: {first} to {peaks[1000][name]} bytes"


def test_jobs_side_by_side(tmp_path):
    """Three at once, from one checkpoint (which also settles what FFTW measures): each has the numbers
    of the one that ran alone."""
    begun = tmp_path / "begun"
    settings = ["--set", f"checkpoint.every={HALF * 0.02}"]
    result = job(begun, *settings, "--steps", str(HALF), ranks=(2, 1))
    assert result.status == 0, result.output
    outs = [tmp_path / f"out{n}" for n in range(4)]
    for out in outs:
        shutil.copytree(begun, out)
    lines = [line(out, *settings, "--steps", str(HALF), ranks=(2, 1), restart=out) for out in outs]
    alone = subprocess.run(lines[0], cwd=tmp_path, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                           capture_output=True, timeout=300, check=False)  # fmt: skip
    assert alone.returncode == 0, alone.stdout
    together = [subprocess.Popen(words, cwd=tmp_path, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                for words in lines[1:]]  # fmt: skip
    for process in together:
        _, said = process.communicate(timeout=300)
        assert process.returncode == 0, said
    for out in outs[1:]:
        for file in ("state.h5", "spheres.h5", "fields.h5"):
            assert same_numbers(outs[0] / file, out / file, but=["extra/fftw_wisdom"]), file
        for file in ("history.csv", "collisions.csv"):
            assert (outs[0] / file).read_bytes() == (out / file).read_bytes(), file
