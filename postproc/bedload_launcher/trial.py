"""A few steps of a scene in a folder that is thrown away: time per step by part, and peak memory."""

import math
import re
import subprocess
import tempfile
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from . import job
from .errors import UserError
from .memory import MemoryWatch
from .words import last_sentence, read_rows

NOT_A_STEP = ("output", "checkpoints", "rest")  # parts of timing.csv that are no part of the scheme


@dataclass(frozen=True)
class Trial:
    """What a trial measured.

    settings: every value in force; step_parts: seconds per step by part; output_seconds: all that the
    trial wrote but its checkpoint, the last fields included; fluid_bytes, dem_bytes: peak memory summed over the
    ranks; proportional_bytes: of all ranks at one time, pages that several processes have divided among
    them; cfl_step: length of the step that time.cfl allows the last flow on the trial's grid;
    checkpoint_seconds: of the one at its end; start_seconds: of all that is no part of timing.csv, from
    the call of mpirun to its return; wall_seconds: of everything; derived: the numbers that settings.toml works out.
    """

    settings: dict
    steps: int
    step_parts: dict[str, float]
    output_seconds: float
    fluid_bytes: int
    dem_bytes: int
    answer: Any = None  # what `read` of run_trial made of the output folder
    cfl_step: float = math.inf
    checkpoint_seconds: float = 0.0
    start_seconds: float = 0.0
    wall_seconds: float = 0.0
    proportional_bytes: int = 0
    derived: dict[str, float] = field(default_factory=dict)
    mobile_spheres: int = 0  # at the end

    @property
    def cells(self) -> tuple[int, int, int]:
        nx, ny, nz = self.settings["grid"]["cells"]
        return nx, ny, nz

    @property
    def step_seconds(self) -> float:
        return sum(self.step_parts.values())


def run_trial(
    work: job.Job, read: Callable[[Path], object] = lambda _: None, warm_up: int = 0
) -> Trial:
    """Runs `work`, whose output folder is replaced by one that is removed after `read` has seen it.

    Without a number of steps in `work` it runs to its end. The first `warm_up` steps, which the run itself
    is told to leave out, are not counted. Raises UserError with the program's own words when the run fails.
    """
    with tempfile.TemporaryDirectory(prefix="bedload-trial-") as folder:
        out = Path(folder)
        work = replace(work, out=out)
        words_file = out / "words"
        began = time.monotonic()
        with words_file.open("w") as words, subprocess.Popen(
            work.command(), cwd=work.scene.folder, env=job.environment(), stdin=subprocess.DEVNULL,
            stdout=words, stderr=subprocess.STDOUT, preexec_fn=job.dies_with_us(),
        ) as running, MemoryWatch(running.pid) as memory:  # fmt: skip
            running.wait()
            wall = time.monotonic() - began
        if running.returncode != 0:
            said = words_file.read_text(encoding="utf-8", errors="replace")
            raise UserError(
                f"a trial of {work.scene.name} ended with status {running.returncode}: {last_sentence(said)}"
            )
        text = (out / "settings.toml").read_text(encoding="utf-8")
        settings = tomllib.loads(text)
        seconds = {row["part"]: float(row["seconds_mean_over_ranks"]) for row in read_rows(out / "timing.csv")}
        last = read_rows(out / "history.csv")[-1]
        answer = read(out)
    counted = int(last["step"]) - warm_up  # fewer than asked for where the scene is over before
    if counted < 1:
        raise UserError(
            f"a trial of {work.scene.name} has no step to measure: with 'time.end' = {settings['time']['end']:g} it is "
            f"over after {last['step']} steps."
        )
    return Trial(
        settings, counted,
        {part: s / counted for part, s in seconds.items() if part not in NOT_A_STEP},
        seconds.get("output", 0.0), memory.bytes_of("bedload-fluid"),
        memory.bytes_of("bedload-dem"), answer, allowed_step(settings, last),
        seconds.get("checkpoints", 0.0), max(0.0, wall - sum(seconds.values())), wall,
        memory.proportional_bytes, derived_numbers(text), int(last["mobile_spheres"]),
    )  # fmt: skip


def derived_numbers(text: str) -> dict[str, float]:
    """Those that stand as comments in a settings.toml, by name: `# derived.cell = 0.1  # h [L]`."""
    return {name: float(value) for name, value in re.findall(r"^# derived\.(\w+) = (\S+)", text, re.MULTILINE)}


def allowed_step(settings: dict, row: dict[str, str]) -> float:
    """Length of the step with which the flow of a row of history.csv has the CFL number time.cfl."""
    wanted, found = settings["time"]["cfl"], float(row["cfl"])
    return float(row["dt"]) * wanted / found if wanted > 0.0 and found > 0.0 else math.inf
