"""Faults, tried for real: processes killed at chosen and at random moments, full disks, folders that
cannot be written to, partners that never come. Every job ends by itself, says once why, and leaves
what a run can go on from."""

import csv
import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import h5py
import pytest

from programs import BIN, ENVIRONMENT, LIMIT, SCENES, command, run, wait_for
from pocket import SCENE, checkpoint, checkpoints, job, line, same_numbers, spoken

# A checkpoint every fourth step; everything written in every step.
BUSY = ["--set", "checkpoint.every=0.08", "--set", "output.fields_every=0.02"]
STEPS = 12


@pytest.fixture(scope="module", params=[(1, 1), (2, 1)], ids=["1+1", "2+1"])
def runs(request, tmp_path_factory):
    """See `two_runs`, on two layouts."""
    return two_runs(tmp_path_factory, request.param)


@pytest.fixture(scope="module")
def serial_runs(tmp_path_factory):
    return two_runs(tmp_path_factory, (1, 1))


def two_runs(tmp_path_factory, ranks):
    """Folder of a run up to its first checkpoint, folder of that which goes on from there to the end
    undisturbed (both with the same algorithms of FFTW, which measures anew in each fresh run), ranks."""
    begun = tmp_path_factory.mktemp("begun") / "out"
    result = job(begun, *BUSY, "--steps", "4", ranks=ranks)
    assert result.status == 0, result.output
    whole = begun.with_name("whole")
    shutil.copytree(begun, whole)
    result = job(whole, *BUSY, "--steps", str(STEPS - 4), restart=whole, ranks=ranks)
    assert result.status == 0, result.output
    return begun, whole, ranks


def check_end(out, status, output, words=("died",)):
    """Status, one sentence with its cause and the last whole checkpoint, whole files."""
    assert status != 0, output
    said = spoken(output)
    assert len(said) == 1, output
    for word in words:
        assert word in said[0]
    steps = checkpoints(out)
    if steps:
        # Killed between the last rename and the note of it, the one before is named.
        assert any(f"--restart {checkpoint(out, step)}" in said[0] for step in steps), said[0]
    for file in out.glob("**/*.h5"):
        with h5py.File(file):
            pass
    for file in out.glob("*.csv"):
        assert file.read_text().endswith("\n"), file
        with file.open(newline="") as stream:
            rows = list(csv.reader(stream))
        assert len({len(row) for row in rows}) == 1, file


def check_going_on(out, undisturbed, ranks):
    """From the last checkpoint to the end of the undisturbed run: its numbers."""
    step = checkpoints(out)[-1]
    result = job(out, *BUSY, "--steps", str(STEPS - step), restart=out, ranks=ranks)
    assert result.status == 0, result.output
    for name in ("state.h5", "spheres.h5", "fields.h5"):
        if not (out / f"{name}.torn").exists():
            assert same_numbers(undisturbed / name, out / name, but=["run/fftw_wisdom"]), name
    assert (undisturbed / "history.csv").read_bytes() == (out / "history.csv").read_bytes()
    assert (undisturbed / "collisions.csv").read_bytes() == (out / "collisions.csv").read_bytes()
    return result


def living(out):
    """Processes of the job that writes to `out`, by what they were started with."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes()
        except OSError:  # it has just ended
            continue
        if os.fsencode(str(out)) in words and int(folder.name) != os.getpid():
            found.append(int(folder.name))
    return found


def check_gone(out, fault):
    """No process is left LIMIT seconds after the fault (a time of time.time())."""
    wait_for(lambda: not living(out), seconds=fault + LIMIT - time.time())
    assert time.time() - fault < LIMIT


def named_ranks(mpirun):
    """Process numbers of the job's programs."""
    found = subprocess.run(["ps", "-o", "pid=,comm=", "--ppid", str(mpirun.pid)],
                           capture_output=True, text=True, check=False).stdout.split()
    return [int(pid) for pid, name in zip(found[::2], found[1::2]) if name.startswith("bedload-")]


# Program, rank in the job, call, file or count: in each phase of a step, and of writing.
MOMENTS = {
    "fluid in the pressure": "bedload-fluid 0 transform 17",
    "fluid sends loads": "bedload-fluid 0 send 20",
    "grains send their motion": "bedload-dem 1 send 20",
    "fluid writes its half": "bedload-fluid 0 write checkpoint.part/fluid.h5",
    "grains write theirs": "bedload-dem 1 write checkpoint.part/grains.h5",
    "grains' half gets its name": "bedload-dem 1 rename grains.h5",
    "checkpoint gets its name": "bedload-fluid 0 rename checkpoint_00000008",
    "oldest checkpoint goes": "bedload-fluid 0 remove checkpoint.old",
    "fields are added to": "bedload-fluid 0 rename fields.xdmf",
    "inside an addition to spheres.h5": "bedload-fluid 0 write spheres.h5",
    "fluid crashes as it allocates": "bedload-fluid 0 allocate 20",
    "grains crash as they allocate": "bedload-dem 1 allocate 20",
}


@pytest.mark.parametrize("moment", MOMENTS)
def test_killed_at_a_chosen_moment(serial_runs, tmp_path, moment):
    begun, whole, ranks = serial_runs
    out = tmp_path / "out"
    shutil.copytree(begun, out)
    mark = tmp_path / "killed"
    before = ["env", f"BEDLOAD_KILL={MOMENTS[moment]}", f"BEDLOAD_KILLED={mark}",
              f"LD_PRELOAD={BIN / 'kill_at.so'}"]
    result = job(out, *BUSY, "--steps", str(STEPS - 4), restart=out, fluid_before=before,
                 dem_before=before)
    check_gone(out, mark.stat().st_mtime)
    check_end(out, result.status, result.output)
    check_going_on(out, whole, ranks)


@pytest.mark.parametrize("trial", range(3))
def test_killed_at_a_random_moment(runs, tmp_path, trial):
    begun, whole, ranks = runs
    out = tmp_path / "out"
    shutil.copytree(begun, out)
    mpirun = subprocess.Popen(
        line(out, *BUSY, ranks=ranks, restart=out), env=ENVIRONMENT, stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        wait_for(lambda: len(named_ranks(mpirun)) == sum(ranks), mpirun)
        pids = named_ranks(mpirun)
        wait_for(lambda: rows(out / "history.csv") > 4, mpirun)
        time.sleep(random.uniform(0.0, 0.1))
        fault = time.time()
        os.kill(random.choice(pids), signal.SIGABRT if trial == 1 else signal.SIGKILL)
        output, _ = mpirun.communicate(timeout=LIMIT)
        check_gone(out, fault)
    finally:
        mpirun.kill()
    check_end(out, mpirun.returncode, output)
    if checkpoints(out)[-1] < STEPS:
        check_going_on(out, whole, ranks)


def rows(table):
    return len(table.read_text().splitlines()) - 1


def test_mpirun_itself_killed(tmp_path):
    out = tmp_path / "out"
    mpirun = subprocess.Popen(line(out, *BUSY, "--set", "time.end=1e3", ranks=(2, 1)),
                              env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)  # fmt: skip
    try:
        wait_for(lambda: checkpoints(out), mpirun)
        assert len(named_ranks(mpirun)) == 3
    finally:
        fault = time.time()
        mpirun.kill()
        mpirun.wait()
    check_gone(out, fault)


# Bytes that a file of one program may have. The state of the pocket takes 0.4 MB.
@pytest.mark.parametrize(
    "limits, words",
    [
        (dict(fluid_before=["prlimit", "--fsize=1300000"]), ["fluid.h5", "File too large"]),
        (dict(dem_before=["prlimit", "--fsize=3000"]), ["grains.h5", "File too large"]),
        (dict(fluid_before=["prlimit", "--fsize=1700000"]), ["fields.h5", "cannot be written"]),
    ],
    ids=["checkpoint of the fluid", "checkpoint of the grains", "fields"],
)
@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)], ids=["1+1", "2+2"])
def test_a_file_that_may_not_grow(tmp_path, limits, words, ranks):
    out = tmp_path / "out"
    settings = BUSY if "fields.h5" in words[0] else BUSY[:2]
    result = job(out, *settings, "--steps", str(STEPS), ranks=ranks, **limits)
    check_end(out, result.status, result.output, words)
    assert result.seconds < LIMIT  # from its start
    check_gone(out, time.time())


@pytest.fixture
def small_disk(tmp_path):
    """A folder on a disk of 3 MB of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(folder)],
                          capture_output=True, text=True, check=False)
    if made.returncode != 0:
        pytest.skip(f"a disk of its own cannot be had here: {made.stderr.strip()}")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.parametrize("what", ["fields.h5", "checkpoint"])
def test_a_full_disk(small_disk, tmp_path, what):
    """Snapshots fill it; or something else does, and the next checkpoint finds no room."""
    out = small_disk / "out"
    out.mkdir()
    # For the snapshots such that the last one that fits leaves the other files the room they ask for.
    (small_disk / "other").write_bytes(bytes(1_200_000 if what == "checkpoint" else 120_000))
    settings = BUSY if what == "fields.h5" else [*BUSY[:2], "--set", "output.history_every=1000"]
    result = job(out, *settings, "--steps", "30", ranks=(2, 1))
    check_end(out, result.status, result.output, [what, "No space left on device"])
    assert result.seconds < LIMIT
    check_gone(out, time.time())
    assert checkpoints(out)


def test_a_collision_table_that_cannot_be_written(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "collisions.csv").symlink_to("/dev/full")
    result = job(out, "--steps", "2")
    assert result.status != 0
    assert len(spoken(result.output)) == 1, result.output
    assert "collisions.csv" in result.output and "No space left" in result.output


@pytest.mark.parametrize("how", ["a file in the way", "no permission"])
def test_a_folder_that_cannot_be_written(tmp_path, how):
    out = tmp_path / "closed" / "out"
    out.parent.mkdir()
    words, before = [str(out)], ()
    if how == "a file in the way":
        out.write_text("")
    else:
        out.parent.chmod(0o555)
        words.append("Permission denied")
        if os.geteuid() == 0:  # whom no mode stops
            before = ("setpriv", "--reuid=65534", "--clear-groups", "--inh-caps=-all")
    if before and subprocess.run([*before, "test", "-x", str(BIN / "bedload-fluid")],
                                 check=False).returncode != 0:  # fmt: skip
        pytest.skip("nobody may not run the programs where they are built")
    result = run([*before, *line(out, "--steps", "2")], Path("/"))
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    for word in words:
        assert word in said[0]


def test_a_partner_that_never_comes(tmp_path):
    """A program that knows nothing of MPI in the place of the other, on either side."""
    fluid = [str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml")]
    dem = [str(BIN / "bedload-dem"), "-in", str(SCENE / "in.liggghts")]
    limit = ["env", "BEDLOAD_START_LIMIT=1.5"]
    for both in (command([*limit, *fluid], ["sleep", "1000"], (2, 1)),
                 command(["sleep", "1000"], [*limit, *dem]), command([*limit, *fluid], ["true"])):
        result = run(both, tmp_path)
        assert result.status != 0
        said = spoken(result.output)
        assert len(said) == 1 and "BEDLOAD_START_LIMIT" in said[0], result.output
        assert result.seconds < LIMIT


def test_one_program_alone(tmp_path):
    """Half of a scene with grains, either half."""
    alone = run(command([str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml")], None), tmp_path)
    assert alone.status != 0 and "bedload-dem is not in the job" in spoken(alone.output)[0]
    dem = [str(BIN / "bedload-dem"), "-in", str(SCENE / "in.liggghts"), "-var", "out", "."]
    alone = run(command(None, dem), tmp_path)
    assert alone.status != 0 and alone.output.count("this job has no fluid") == 1


def test_a_partner_of_another_version(tmp_path):
    old = str(BIN / "old_partner")
    fluid = [str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml")]
    dem = [str(BIN / "bedload-dem"), "-in", str(SCENES / "free_flight.liggghts"), "-log", "none"]
    for both in (command(fluid, [old, "dem"], (2, 2)), command([old, "fluid"], dem, (2, 2))):
        result = run(both, tmp_path)
        assert result.status != 0
        said = spoken(result.output)
        assert len(said) == 1, result.output
        assert "version 0.0.1" in said[0] and "one build" in said[0]
        assert result.seconds < LIMIT
