"""Runs the two programs of a job from tests: one mpirun line, its output, its time."""

import os
import resource
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

BIN = Path(os.environ["BEDLOAD_BIN"])
SCENES = Path(__file__).parent / "scenes"
LAYOUTS = [(1, 1), (2, 1), (1, 2), (2, 2), (3, 2)]  # fluid ranks, LIGGGHTS ranks

# A job with a mistake or a dead rank is over two seconds later at most, start included, and all its
# processes with it; one that does not end itself hangs for ever. In between lies room for slow machines.
LIMIT = 30.0
START = 120.0  # for a job to come to where it is disturbed

# As the launcher sets it: root may run, ranks are not bound, more ranks than cores are allowed.
ENVIRONMENT = os.environ | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
}


@dataclass
class Result:
    status: int
    output: str
    seconds: float
    cpu_seconds: float

    def number(self, name: str) -> float:
        """The value that the stand-in printed as name=value."""
        for word in self.output.split():
            if word.startswith(name + "="):
                return float(word.partition("=")[2])
        raise AssertionError(f"no '{name}=' in:\n{self.output}")


def command(fluid: list[str] | None, dem: list[str] | None, ranks=(1, 1)) -> list[str]:
    parts = []
    if fluid is not None:
        parts.append(["-np", str(ranks[0]), *fluid])
    if dem is not None:
        parts.append(["-np", str(ranks[1]), *dem])
    line = ["/usr/bin/mpirun", "--quiet", *parts[0]]
    return line + ([":", *parts[1]] if len(parts) > 1 else [])


def stand_in(*options: str) -> list[str]:
    return [str(BIN / "stand_in_fluid"), *options]


def liggghts(script: str | Path, *options: str) -> list[str]:
    return [str(BIN / "bedload-dem"), "-in", str(SCENES / script), "-log", "none", *options]


def run(line: list[str], folder: Path, timeout: float = 240.0) -> Result:
    """Runs to the end; a job that hangs is a failure."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    done = subprocess.run(
        line,
        cwd=folder,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        timeout=timeout,
    )
    seconds = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Result(done.returncode, done.stdout, seconds, cpu)


def wait_for(condition, mpirun=None, seconds=START):
    """Until `condition` holds; a failure when `seconds` are over, or when the job `mpirun` has ended before."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it takes too long"
        assert mpirun is None or mpirun.poll() is None, "the job has ended too early"
        time.sleep(0.02)
