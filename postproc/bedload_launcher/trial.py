"""A few steps of a scene in a folder that is thrown away: time per step by part, and peak memory."""

import csv
import subprocess
import tempfile
import threading
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import job
from .errors import UserError

NOT_A_STEP = ("output", "rest")  # parts of timing.csv that no step repeats
POLL = 0.02  # s between looks at the ranks' memory


@dataclass(frozen=True)
class Trial:
    """What a trial measured.

    settings: every value in force; step_parts: seconds per step by part; output_seconds: all that the
    trial wrote, the last state included; fluid_bytes, dem_bytes: peak memory summed over the ranks.
    """

    settings: dict
    steps: int
    step_parts: dict[str, float]
    output_seconds: float
    fluid_bytes: int
    dem_bytes: int
    answer: object = None  # what `read` of run_trial made of the output folder

    @property
    def cells(self) -> tuple[int, int, int]:
        return tuple(self.settings["grid"]["cells"])

    @property
    def step_seconds(self) -> float:
        return sum(self.step_parts.values())


def _descendants(parent: int) -> list[int]:
    found, todo = [], [parent]
    while todo:
        tasks = Path(f"/proc/{todo.pop()}/task")
        try:
            children = [int(c) for t in tasks.iterdir() for c in (t / "children").read_text().split()]
        except OSError:
            continue
        found += children
        todo += children
    return found


def watch_memory(parent: int, peaks: dict[int, tuple[str, int]], over: threading.Event) -> None:
    """Notes name and peak resident bytes of every process under `parent` until `over` is set."""
    while not over.is_set():
        for process in _descendants(parent):
            try:
                lines = Path(f"/proc/{process}/status").read_text(encoding="ascii").splitlines()
            except OSError:
                continue
            status = dict(line.split(":", 1) for line in lines if ":" in line)
            if "VmHWM" in status:
                peak = int(status["VmHWM"].split()[0]) * 1024
                peaks[process] = (status["Name"].strip(), peak)
        over.wait(POLL)


def run_trial(
    work: job.Job, read: Callable[[Path], object] = lambda _: None, timeout: float | None = None
) -> Trial:
    """Runs `work`, whose output folder is replaced by one that is removed after `read` has seen it.

    Raises UserError with the program's own words when the run fails.
    """
    with tempfile.TemporaryDirectory(prefix="bedload-trial-") as folder:
        out = Path(folder)
        work = job.Job(work.scene, work.model, work.ranks, out, work.overrides, work.steps)
        peaks: dict[int, tuple[str, int]] = {}
        over = threading.Event()
        words_file = out / "words"
        with words_file.open("w") as words, subprocess.Popen(
            work.command(), cwd=work.scene.folder, env=job.environment(), stdin=subprocess.DEVNULL,
            stdout=words, stderr=subprocess.STDOUT,
        ) as running:  # fmt: skip
            watch = threading.Thread(target=watch_memory, args=(running.pid, peaks, over))
            watch.start()
            try:
                running.wait(timeout)
            except subprocess.TimeoutExpired:
                running.terminate()
                raise UserError(f"a trial of {work.scene.name} took over {timeout:g} s.") from None
            finally:
                over.set()
                watch.join()
        if running.returncode != 0:
            said = words_file.read_text(encoding="utf-8", errors="replace").strip()
            raise UserError(
                f"a trial of {work.scene.name} ended with status {running.returncode}: {said}"
            )
        settings = tomllib.loads((out / "settings.toml").read_text(encoding="utf-8"))
        with (out / "timing.csv").open(newline="", encoding="utf-8") as stream:
            seconds = {
                row["part"]: float(row["seconds_mean_over_ranks"]) for row in csv.DictReader(stream)
            }
        answer = read(out)
    memory = {
        program: sum(peak for name, peak in peaks.values() if name == program[:15])
        for program in ("bedload-fluid", "bedload-dem")
    }
    return Trial(
        settings, work.steps,
        {part: s / work.steps for part, s in seconds.items() if part not in NOT_A_STEP},
        seconds.get("output", 0.0), memory["bedload-fluid"], memory["bedload-dem"],
        answer,
    )  # fmt: skip
