"""One MPI job: the mpirun line, its environment, its signals, its status."""

import atexit
import contextlib
import csv
import ctypes
import functools
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .build import BIN
from .errors import UserError
from .machine import cores, processors
from .scenes import INPUTS, Scene
from .words import say

# Root may run (a container often has no other user); ranks are not bound, since a waiting LIGGGHTS
# rank sleeps and leaves its core to the fluid; more ranks than cores are allowed for that reason.
# Messages within a machine go off at once up to 32 kB instead of 4: where rows are divided a plane's
# messages are that long, and asking the receiver first costs a tenth of the fluid's time.
MPI_ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_btl_vader_eager_limit": "32768",
}
HOSTS = Path("/etc/hosts")
FORWARDED = (
    signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1, signal.SIGUSR2,
)  # fmt: skip
PATIENCE = 2.0  # s between SIGTERM and SIGKILL for what a command that was asked to end has left
PR_SET_PDEATHSIG = 1  # of Linux
_LIBC = ctypes.CDLL(None)


def environment() -> dict[str, str]:
    """This process's environment with what Open MPI needs; a user's own choice stands."""
    added = dict(MPI_ENVIRONMENT)
    known = HOSTS.read_text(encoding="utf-8").split() if HOSTS.is_file() else []
    if socket.gethostname() not in known:
        # mpirun asks the name server for this machine's own name; one that does not answer would
        # hold up every start by 5 s.
        added["RES_OPTIONS"] = "timeout:1 attempts:1"
    if not sys.stdout.isatty():
        # mpirun gives every rank a terminal; this says that what they print ends up in a log.
        return added | dict(os.environ) | {"TERM": "dumb"}
    return added | dict(os.environ)


def dies_with_us() -> Callable[[], None]:
    """For preexec_fn of a job: the system ends it when this process ends, be it by SIGKILL.

    To mpirun SIGTERM is the word to end its programs.
    """
    parent = os.getpid()

    def ask() -> None:
        _LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:  # which has ended in between
            os._exit(1)

    return ask


def readable(path: str) -> bool:
    """Whether a LIGGGHTS script takes the path for one word."""
    return re.search(r"[\s$\"'#&]", path) is None


@functools.cache
def script_path(path: Path, folder: Path) -> str:
    """`path` for a script that is run in `folder`: where it has blanks, a way to it that has none."""
    ways = (str(path), os.path.relpath(path, folder))
    for way in ways:
        if readable(way):
            return way
    links = tempfile.mkdtemp(prefix="bedload-")
    atexit.register(shutil.rmtree, links, ignore_errors=True)
    link = os.path.join(links, "folder")
    os.symlink(path, link)
    return link


@dataclass(frozen=True)
class Ranks:
    fluid: int
    dem: int

    @classmethod
    def parse(cls, text: str | None, scene: Scene | None = None) -> "Ranks":
        """'FLUID:DEM' or 'FLUID'; None: the fluid gets every core, LIGGGHTS one sleeping rank.

        Raises UserError for anything else, and for DEM where `scene` starts no LIGGGHTS.
        """
        if text is None:
            return cls(cores(), 1)
        parts = text.split(":")
        if len(parts) > 2 or not all(part.isdecimal() and int(part) > 0 for part in parts):
            raise UserError(f"--ranks is '{text}', but must be FLUID:DEM, for instance 4:1.")
        if len(parts) == 2 and scene is not None and not scene.moves_grains:
            raise UserError(
                f"--ranks is '{text}', but scene '{scene.name}' has no in.liggghts, so there are no ranks of LIGGGHTS; "
                f"--ranks {parts[0]} is allowed."
            )
        return cls(int(parts[0]), int(parts[1]) if len(parts) == 2 else 1)


def warn_of_crowding(ranks: Ranks) -> None:
    """Fluid ranks that share processors each wait for all others in every step; LIGGGHTS' sleep."""
    machines = os.environ.get("SLURM_JOB_NUM_NODES", "1")
    if machines != "1" or ranks.fluid <= processors():
        return
    say(
        f"bedload: WARNING: {ranks.fluid} fluid ranks on {processors()} processors take turns and wait for each other, "
        f"which is slower than {cores()} and soon many times slower; --ranks {cores()}:{ranks.dem} is the most that "
        "pays here."
    )


# Fewer grains than this on a rank of LIGGGHTS and its messages take what the division gains (811 of laminar_erosion:
# nothing gained, 9400 of bed_10000: LIGGGHTS twice as fast on two ranks).
GRAINS_WORTH_A_RANK = 2000
LONG_WAIT = 0.2  # of a run's time


def advice_on_ranks(out: Path, ranks: Ranks) -> str | None:
    """What the run in `out` says of more ranks for LIGGGHTS; None: nothing, or its tables are not whole.

    They sleep while the fluid works, so as many as there are cores cost nothing.
    """
    with contextlib.suppress(OSError, KeyError, ValueError, TypeError, IndexError, csv.Error):
        with open(out / "timing.csv", encoding="utf-8") as file:
            share = {row["part"]: float(row["share"]) for row in csv.DictReader(file)}["waiting for LIGGGHTS"]
        with open(out / "history.csv", encoding="utf-8") as file:
            grains = int(list(csv.DictReader(file))[-1]["mobile_spheres"])
        more = min(cores(), grains // GRAINS_WORTH_A_RANK)
        if share > LONG_WAIT and more > ranks.dem:
            return (
                f"waiting for LIGGGHTS took {100 * share:.0f} % of the time; with --ranks {ranks.fluid}:{more} its "
                f"ranks share the {grains} grains, and sleep while the fluid works."
            )
    return None


@dataclass(frozen=True)
class Job:
    scene: Scene
    model: str | None
    ranks: Ranks
    out: Path
    overrides: Sequence[str] = ()
    steps: int | None = None
    variables: Mapping[str, str] = field(default_factory=dict)  # of in.liggghts
    restart: Path | None = None  # a run's folder or one of its checkpoints
    fluid_options: Sequence[str] = ()
    fluid_alone: bool = False  # a scene with grains, without them

    def summary(self) -> str:
        """Scene, model and ranks in a few words."""
        model = f" with {self.model}" if self.model else ""
        dem = f" + {self.ranks.dem} (LIGGGHTS)" if self.scene.moves_grains else ""
        return f"{self.scene.name}{model} on {self.ranks.fluid} (fluid){dem} ranks"

    def command(self) -> list[str]:
        """The line that a person could type in the scene's folder."""
        fluid = [str(BIN / "bedload-fluid"), "fluid.toml", "--out", str(self.out)]
        for override in self.overrides:
            fluid += ["--set", override]
        if self.steps is not None:
            fluid += ["--steps", str(self.steps)]
        if self.restart is not None:
            fluid += ["--restart", str(self.restart)]
        fluid += self.fluid_options
        if self.fluid_alone and self.scene.moves_grains:
            fluid.append("--without-grains")
        line = ["mpirun", "--quiet", "-np", str(self.ranks.fluid), *fluid]
        if self.scene.moves_grains and not self.fluid_alone:
            script = str(self.scene.other_script or "in.liggghts")
            dem = [str(BIN / "bedload-dem"), "-in", script, "-var", "out", script_path(self.out, self.scene.folder)]
            if not readable(str(INPUTS)):  # else bedload-dem says where they are
                dem += ["-var", "inputs", script_path(INPUTS, self.scene.folder)]
            if self.model:
                dem += ["-var", "model", self.model]
            if "cell" in self.scene.variables() and "cell" not in self.variables:
                # The script's h follows the grid that this run has.
                dem += ["-var", "cell", repr(self.scene.cell_size(self.overrides))]
            for name, value in self.variables.items():
                dem += ["-var", name, value]
            dem += ["-log", str(self.out / "log.liggghts")]
            line += [":", "-np", str(self.ranks.dem), *dem]
        return line


def keep_part(out: Path) -> dict[Path, Path]:
    """Gives LIGGGHTS' log and the times of the run so far names that the next part does not write over.

    Returns the new names by the old ones.
    """
    moved = {}
    for stem, ending in (("log", "liggghts"), ("timing", "csv")):
        file = out / f"{stem}.{ending}"
        if file.is_file():
            parts = len(list(out.glob(f"{stem}.part*.{ending}")))
            moved[file] = file.rename(out / f"{stem}.part{parts + 1}.{ending}")
    return moved


def run_job(work: Job) -> int:
    return run(work.command(), work.scene.folder)


def end_group(group: int) -> None:
    """Ends what is left of a process group, what sh started behind `&`, say, which SIGINT does not reach."""
    with contextlib.suppress(ProcessLookupError):  # nothing is left
        os.killpg(group, signal.SIGTERM)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            time.sleep(0.02)
            os.killpg(group, 0)
        os.killpg(group, signal.SIGKILL)


def run(command: Sequence[str], folder: Path) -> int:
    """Runs `command` in `folder`, its output going straight to the terminal.

    Signals to the launcher are passed on; returns the exit status, 128 + n when killed by signal n.
    mpirun kills its programs a second after a signal that asks for the end; the first such signal
    goes to the programs instead, as SIGUSR2: they write a checkpoint and end. Of other commands all
    that they have started gets the signal: the shell of xvfb-run would keep it for itself.
    """
    by_mpirun = command[0] == "mpirun"
    wishes = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP} if by_mpirun else set()
    wished: list[int] = []
    ends: list[int] = []

    def pass_on(received: int, _) -> None:
        if received not in (signal.SIGUSR1, signal.SIGUSR2):
            ends.append(received)
        gently = received in wishes
        if gently:
            wished.append(received)
        if received != signal.SIGUSR1:
            wishes.clear()
        if received == signal.SIGQUIT:  # which ends mpirun and leaves its programs
            received = signal.SIGTERM
        if by_mpirun:
            child.send_signal(signal.SIGUSR2 if gently else received)
        else:
            with contextlib.suppress(ProcessLookupError):  # they have ended
                os.killpg(child.pid, received)

    # A process group of its own, so that Ctrl-C reaches mpirun once, through us: a second one
    # within seconds would make it give up the ranks without letting them finish.
    child = subprocess.Popen(
        command, cwd=folder, env=environment(), stdin=subprocess.DEVNULL, process_group=0,
        preexec_fn=dies_with_us(),
    )  # fmt: skip
    before = {number: signal.signal(number, pass_on) for number in FORWARDED}
    try:
        code = child.wait()
        if ends and not by_mpirun:
            end_group(child.pid)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if code == -signal.SIGUSR2 and wished:  # mpirun did not pass signals on yet
        code = -wished[0]
    return code if code >= 0 else 128 - code
