"""Checkpoints of both programs and --restart: a run that goes on from one is the run itself."""

import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

from programs import ENVIRONMENT, run, wait_for
from pocket import SCENE, checkpoint, job, line, numbers, same_numbers, spoken, two_checkpoints

HALF = 60  # steps up to the first checkpoint: sphere 9 is in contact then
WHOLE = ["--steps", str(2 * HALF), "--set", f"checkpoint.every={HALF * 0.02}"]
REST = ["--steps", str(HALF), "--set", f"checkpoint.every={HALF * 0.02}"]


@pytest.fixture(scope="module", params=[(1, 1), (3, 2)], ids=["1+1", "3+2"])
def whole(request, tmp_path_factory):
    """A run with a checkpoint in its middle and one at its end, and its ranks."""
    out = tmp_path_factory.mktemp("whole") / "out"
    result = job(out, *WHOLE, ranks=request.param)
    assert result.status == 0, result.output
    return out, request.param


def half_of(whole, folder):
    """As the run would have been left by a crash behind its first checkpoint."""
    shutil.copytree(whole, folder)
    shutil.rmtree(checkpoint(folder, 2 * HALF))
    return folder


def test_bit_for_bit_on_the_same_ranks(whole, tmp_path):
    """Fields, pressure, spheres in collision, collision table, history: the same files."""
    out, ranks = whole
    again = half_of(out, tmp_path / "again")
    result = job(again, *REST, ranks=ranks, restart=again)
    assert result.status == 0, result.output
    for name in ("state.h5", "fields.h5", "spheres.h5"):
        assert same_numbers(out / name, again / name), name
    for name in ("history.csv", "collisions.csv"):
        assert (out / name).read_bytes() == (again / name).read_bytes(), name
    assert len((out / "collisions.csv").read_text().splitlines()) > 2
    table = numbers(out / "spheres.h5")
    assert len(np.unique(table["mobile/step"])) == 2 * HALF + 1


def test_to_round_off_on_other_ranks(whole, tmp_path):
    """From any ranks to any others. Round-off of 1e-16 grows over sixty steps and one collision to
    1e-13; what is forgotten (a contact's history, a load, the old pressure) shows as 1e-6."""
    out, ranks = whole
    other = (2, 2) if ranks == (1, 1) else (1, 1)
    there = tmp_path / "there"
    result = job(there, *REST, ranks=other, restart=checkpoint(out, HALF))
    assert result.status == 0, result.output
    a, b = numbers(out / "spheres.h5"), numbers(there / "spheres.h5")
    behind = a["mobile/step"] > HALF
    assert np.array_equal(a["mobile/step"][behind], b["mobile/step"])
    for name in ("position", "velocity", "angular_velocity", "force"):
        apart = np.abs(a[f"mobile/{name}"][behind] - b[f"mobile/{name}"])
        apart = np.minimum(apart, np.abs(apart - 4.0)) if name == "position" else apart
        assert apart.max() < 1e-10, name
    a, b = numbers(out / "state.h5"), numbers(there / "state.h5")
    for name in "uvw":
        assert np.abs(a[name] - b[name]).max() < 1e-11


def test_the_clock_of_a_run_that_goes_on_with_another_step(tmp_path):
    """Four steps of 0.02 and four of 0.01, by LIGGGHTS' own time."""
    text = (SCENE / "in.liggghts").read_text()
    clock = 'variable now equal time\nfix clock all print 15 "${now}" file ${out}/clock.txt screen no\n'
    script = tmp_path / "in.liggghts"
    script.write_text(text.replace("thermo ", clock + "thermo "))
    first, second = tmp_path / "first", tmp_path / "second"
    result = job(first, "--steps", "4", "--set", "checkpoint.every=0.08", script=script)
    assert result.status == 0, result.output
    result = job(second, "--steps", "4", "--set", "time.step=0.01", restart=first, script=script)
    assert result.status == 0, result.output
    times = [float(line) for line in (second / "clock.txt").read_text().split("\n")[1:] if line]
    assert times[-4:] == pytest.approx([0.09, 0.1, 0.11, 0.12], rel=1e-9)


def test_two_checkpoints_are_kept(tmp_path):
    out = tmp_path / "out"
    result = job(out, "--steps", "8", "--set", "checkpoint.every=0.04")
    assert result.status == 0, result.output
    assert sorted(p.name for p in out.glob("checkpoint*")) == [
        "checkpoint_00000006", "checkpoint_00000008",
    ]  # fmt: skip


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    return two_checkpoints(tmp_path_factory.mktemp("short") / "out")


@pytest.mark.parametrize(
    "options, dem, found",
    [
        (["--set", "grid.cells=[64,48,32]"], [], ["grid.cells", "64, 48, 32", "start.file"]),
        (["--set", "grid.length=[8.0,6.0,4.0]"], [], ["grid.length", "8"]),
        (["--set", "grid.y_stretching=0.5"], [], ["grid.y_stretching", "other heights"]),
        ([], ["another"], ["another LIGGGHTS script or model", "history_floor"]),
    ],
    ids=["grid", "box", "heights", "script"],
)
def test_a_checkpoint_of_another_scene(short, tmp_path, options, dem, found):
    words = line(tmp_path / "out", "--steps", "1", *options, restart=checkpoint(short, 4))
    if dem:
        script = (SCENE / "in.liggghts").read_text().replace(" tangential haff_werner", "")
        (tmp_path / "in.liggghts").write_text(script)
        words[words.index("-in") + 1] = str(tmp_path / "in.liggghts")
    result = run(words, tmp_path, timeout=120)
    assert result.status != 0
    for text in found:
        assert text in result.output


def test_nothing_to_go_on_from(tmp_path):
    result = job(tmp_path / "out", restart=tmp_path)
    assert result.status != 0
    assert "neither a checkpoint nor a folder of a run" in result.output


@pytest.mark.parametrize("sent", [signal.SIGUSR1, signal.SIGUSR2])
def test_signals(tmp_path, sent):
    """SIGUSR1: a checkpoint, and on; SIGUSR2 (and SIGTERM where nobody kills a second later): a
    checkpoint, and the end, from which a run goes on."""
    out = tmp_path / "out"
    child = subprocess.Popen(
        line(out, "--set", "time.end=1e3", ranks=(2, 1)), env=ENVIRONMENT,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        table = out / "history.csv"
        wait_for(lambda: table.exists() and len(table.read_text()) >= 1000, child)
        child.send_signal(sent)
        if sent == signal.SIGUSR1:
            wait_for(lambda: list(out.glob("checkpoint_*")), child)
            time.sleep(0.5)
            assert child.poll() is None
            child.send_signal(signal.SIGUSR2)
        said, _ = child.communicate(timeout=60)
    finally:
        child.kill()
    assert child.returncode == 3, said
    last = sorted(out.glob("checkpoint_*"))[-1]
    sentences = spoken(said)
    assert len(sentences) == 1 and str(last) in sentences[0] and "signal" in sentences[0]
    assert job(out, "--steps", "1", restart=out).status == 0


def test_the_time_limit(tmp_path):
    out = tmp_path / "out"
    result = job(out, "--set", "time.end=1e3", "--set", "time.wall_limit=1.0")
    assert result.status == 3
    assert "time.wall_limit" in result.output and str(out / "checkpoint_") in result.output
