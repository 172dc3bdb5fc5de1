"""A long coupled run takes no more and more memory; several jobs on one machine leave each other
alone."""

import shutil
import subprocess

from programs import BIN, ENVIRONMENT, wait_for
from pocket import job, line, rows, same_numbers

HALF = 20


def last_step(out):
    table = out / "history.csv"
    return max((int(row["step"]) for row in rows(table)), default=0) if table.is_file() else 0


LOOKS = range(200, 1201, 200)  # steps between which the memory in use is compared


def test_memory_does_not_grow(tmp_path):
    """What both programs have taken from the C library and not given back, at the emptiest moment of 200
    steps, over that of the 200 steps before; checkpoints among them.

    Messages, markers, contacts and samples are made anew 3 times a step: what kept a hundred bytes of each
    stage would add 60 kB in each window. What happens once (a list that is made longer: 65 kB) is seen in
    one window of four, so that the smallest growth decides: below 5 kB, the list of samples. Bound 20 kB."""
    out = tmp_path / "out"
    words = ["--set", "time.end=1e3", "--set", "output.history_every=10", "--set",
             "output.spheres_every=1.0", "--set", "checkpoint.every=1.0"]  # fmt: skip

    def noting(program):
        return ["env", f"BEDLOAD_HEAP={tmp_path / program}", f"LD_PRELOAD={BIN / 'heap_in_use.so'}"]

    mpirun = subprocess.Popen(line(out, *words, fluid_before=noting("fluid"), dem_before=noting("dem")),
                              env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    seen = {"fluid": [], "dem": []}  # numbers noted until each of LOOKS
    try:
        for step in LOOKS:
            wait_for(lambda: last_step(out) >= step, mpirun)
            for program, notes in seen.items():
                notes.append((tmp_path / program).read_text().count("\n"))
    finally:
        mpirun.terminate()
        mpirun.wait(timeout=60)
    for program, notes in seen.items():
        in_use = [int(number) for number in (tmp_path / program).read_text().splitlines()[: notes[-1]]]
        assert max(in_use) > 1e6
        least = [min(in_use[begin:end]) for begin, end in zip(notes, notes[1:])]
        growth = [after - before for before, after in zip(least, least[1:])]
        assert min(growth) < 2e4, f"bedload-{program}: {least} bytes in windows up to steps {LOOKS[1:]}"


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
            assert same_numbers(outs[0] / file, out / file, but=["run/fftw_wisdom"]), file
        for file in ("history.csv", "collisions.csv"):
            assert (outs[0] / file).read_bytes() == (out / file).read_bytes(), file
