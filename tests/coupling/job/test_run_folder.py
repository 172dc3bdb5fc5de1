"""The folder of a run: whose it is, what in it is not the program's own, what a fresh start may not take."""

import fcntl
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from programs import BIN, ENVIRONMENT, run, wait_for
from pocket import checkpoint, checkpoints, job, line, rows, spoken, two_checkpoints


@pytest.fixture(scope="module")
def begun(tmp_path_factory):
    return two_checkpoints(tmp_path_factory.mktemp("begun") / "out")


@pytest.fixture
def out(begun, tmp_path):
    shutil.copytree(begun, tmp_path / "out")
    return tmp_path / "out"


EVERY = ["--steps", "6", "--set", "checkpoint.every=0.04"]


def leave_lock_of_mpi_io(out):
    (out / "checkpoint.part").mkdir()
    (out / "checkpoint.part" / "fluid.h5.part-1.lock").touch()


def leave_file_of_nfs(out):
    (out / "checkpoint.part").mkdir()
    (out / "checkpoint.part" / ".nfs0000000000000001").touch()


def leave_note(out):
    for step in (2, 4):
        (checkpoint(out, step) / "note.txt").write_text("the good one")


def leave_all(out):
    leave_file_of_nfs(out)
    leave_note(out)
    for name in ("checkpoint.old", "checkpoint.old.left", "checkpoint.part.left"):
        (out / name).mkdir()
        (out / name / "note.txt").write_text("mine")


@pytest.mark.parametrize(
    "leave", [leave_lock_of_mpi_io, leave_file_of_nfs, leave_note, leave_all], ids=lambda f: f.__name__)
def test_tidying_up_never_ends_a_run(out, leave):
    """Whatever lies in its way, the run goes on, writes its checkpoints and keeps what is not its own."""
    leave(out)
    notes = [path.read_text() for path in out.rglob("note.txt")]
    result = job(out, *EVERY, restart=out)
    assert result.status == 0, result.output
    assert checkpoints(out) == [8, 10]
    assert sorted(path.read_text() for path in out.rglob("note.txt")) == sorted(notes)
    assert not (out / "checkpoint.part").exists()
    for step in (8, 10):
        assert job(out.parent / f"from{step}", "--steps", "1", restart=checkpoint(out, step)).status == 0


def test_two_runs_in_one_folder(out):
    """The second one ends with a sentence that says whose the folder is; the first does not notice."""
    first = subprocess.Popen(line(out, "--set", "time.end=1e3", restart=out), env=ENVIRONMENT,
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True)  # fmt: skip
    try:
        wait_for(lambda: (out / "run.lock").exists() and "process" in (out / "run.lock").read_text(), first)
        holder = dict(row.split(" = ") for row in (out / "run.lock").read_text().splitlines()[:4])
        result = job(out, "--steps", "1", restart=out)
        assert result.status == 1
        said = spoken(result.output)
        assert len(said) == 1 and "another run writes in this folder" in said[0]
        assert f"process {holder['process']} on {holder['host']}" in said[0]
        assert first.poll() is None
        first.send_signal(signal.SIGUSR2)
        words, _ = first.communicate(timeout=60)
        assert first.returncode == 3, words
    finally:
        first.kill()
    assert not (out / "run.lock").exists()


def test_a_checkpoint_that_another_run_replaces(out):
    """A run that goes on where another one writes does not come to read what is there half."""
    (checkpoint(out, 4) / "grains.h5").write_text("half")
    with (out / "run.lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        result = job(out, "--steps", "1", restart=out)
    assert result.status == 1
    said = spoken(result.output)
    assert len(said) == 1 and "another run writes in this folder" in said[0]


@pytest.mark.parametrize("machine", ["this", "another"])
def test_a_stale_lock(out, machine):
    """What a killed run has left, on this machine or on one that is switched off, is taken over."""
    (out / "run.lock").write_text(
        f"host = {machine}\nmachine = {machine}\nprocess = {os.getpid()}\nbegan = 1\njob = \n")
    assert job(out, "--steps", "1", restart=out).status == 0
    assert not (out / "run.lock").exists()


def test_a_fresh_start_leaves_checkpoints(out):
    result = job(out, "--steps", "1")
    assert result.status == 1
    said = spoken(result.output)
    assert len(said) == 1 and "--overwrite" in said[0] and f"--restart {out}" in said[0]
    assert checkpoints(out) == [2, 4]
    assert job(out, "--steps", "1", "--overwrite").status == 0
    assert checkpoints(out) == [1]


def test_going_on_in_the_folder_of_another_run(out, tmp_path):
    other = two_checkpoints(tmp_path / "other")
    result = job(out, "--steps", "1", restart=other)
    assert result.status == 1 and "another run" in result.output
    assert checkpoints(out) == [2, 4]
    result = job(out, "--steps", "1", "--overwrite", restart=other)
    assert result.status == 0, result.output
    assert checkpoints(out) == [5] and checkpoints(other) == [2, 4]
    assert [row["step"] for row in rows(out / "history.csv")] == ["5"]


def test_a_folder_by_another_name_is_not_overwritten(out):
    """--restart names the folder in one way, --out in another."""
    result = run(line(Path(out.name), "--steps", "1", "--overwrite", restart=out), out.parent)
    assert result.status == 1 and "--overwrite removes the checkpoints of" in result.output
    assert checkpoints(out) == [2, 4]


def test_a_start_that_failed_leaves_a_folder_for_the_next(tmp_path):
    out = tmp_path / "out"
    script = tmp_path / "in.liggghts"
    script.write_text("no_command\n")
    assert job(out, "--steps", "1", script=script).status == 1
    assert out.exists()
    assert job(out, "--steps", "1").status == 0


CONTAINER = ["unshare", "--pid", "--fork", "--mount-proc"]


def test_processes_of_other_containers_are_not_signalled(tmp_path):
    """Two containers of one host name and boot have process tables of their own: the number of a process
    in one means nothing in the other."""
    if os.geteuid() != 0 or subprocess.run([*CONTAINER, "true"], check=False).returncode != 0:
        pytest.skip("process tables of their own take root and unshare")
    named = run([*CONTAINER, str(BIN / "machine_identity")], tmp_path)
    here = run([str(BIN / "machine_identity")], tmp_path)
    assert named.status == here.status == 0
    assert named.output.split()[:2] == here.output.split()[:2], "the same host and boot"
    assert named.output != here.output
