"""`./bedload bench effects`: what effects cost that are off, beside a program in which they never were.

grains         a channel without grains and statistics by bedload-fluid, and by the flow solver in a bare loop
fixed spheres  spheres that do not move, without LIGGGHTS, and the same in the bare loop
lubrication    grains that never meet, with fix lubrication and without, by bedload-dem alone
statistics on  the first beside itself with statistics in each step: the measurement sees an effect

Times are medians of runs in turn. Counts come from a preloaded library (tests/performance/count_use.cpp) as
the difference of two runs of different length, so that they are exact for a step: bytes that C++ and
the fields ask for, messages to other ranks, sums over ranks; and which programs were started.
"""

import json
import re
import statistics
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import job
from .build import ROOT
from .errors import UserError
from .words import read_rows

SCENE = ROOT / "tests" / "performance" / "effects"
FIXED = 'spheres.file="spheres.txt"'
STATISTICS = "statistics.every=1"
PAIRS, STEPS, WARM_UP = 9, 24, 4  # of the timed runs
SHORT = 8  # steps of the shorter counted run; the longer has twice as many
NOT_A_STEP = ("output", "checkpoints")  # parts of timing.csv
COUNTS = ("bytes", "messages", "bytes_sent", "sums")
MPI_SETUP = ("mpirun", "orted", "orterun")


def fluid(steps: int, out: Path, settings: Sequence[str] = (), warm_up: int = 0) -> list[str]:
    """bedload-fluid on the benchmark's channel."""
    line = [str(job.BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--out", str(out)]
    line += ["--overwrite", "--steps", str(steps), "--warm-up", str(warm_up)]
    return line + [word for setting in settings for word in ("--set", setting)]


def plain(steps: int, settings: Sequence[str] = (), warm_up: int = 0) -> list[str]:
    """The bare loop on the same."""
    program = str(job.BIN / "plain_channel")
    return [program, str(SCENE / "fluid.toml"), str(steps), str(warm_up), *settings]


def grains(steps: int, film: bool) -> list[str]:
    """bedload-dem on grains that never meet."""
    script = ["-in", str(SCENE / "apart.liggghts"), "-log", "none", "-var", "steps", str(steps)]
    return [str(job.BIN / "bedload-dem"), *script, "-var", "film", "1" if film else "0"]


def run(line: Sequence[str], ranks: int, more: dict[str, str] | None = None) -> str:
    """What the program says; raises UserError with it when it fails."""
    done = subprocess.run(
        ["mpirun", "--quiet", "-np", str(ranks), *line], env=job.environment() | (more or {}),
        stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False,
    )  # fmt: skip
    if done.returncode != 0:
        raise UserError(f"{line[0]} ended with status {done.returncode}: {done.stdout}{done.stderr}")
    return done.stdout


def counted(line: Sequence[str], ranks: int) -> list[dict]:
    """The counts of every process that the job consists of."""
    with tempfile.TemporaryDirectory(prefix="bedload-counts-") as folder:
        run(line, ranks, {"LD_PRELOAD": str(job.BIN / "count_use.so"), "BEDLOAD_COUNTS": folder})
        return [json.loads(file.read_text(encoding="utf-8")) for file in Path(folder).glob("*.json")]


def programs(counts: Sequence[dict]) -> list[str]:
    """What the job started, mpirun's own processes left out, one name a process."""
    return sorted(c["program"] for c in counts if c["program"] not in MPI_SETUP)


def total(counts: Sequence[dict], name: str) -> int:
    """Summed over the ranks of our programs."""
    return sum(c[name] for c in counts if c["program"] not in MPI_SETUP)


def per_step(line: Callable[[int], list[str]], ranks: int, short: int = SHORT) -> dict[str, float]:
    """Counts of a step, by two runs of `short` and twice as many steps."""
    once, twice = counted(line(short), ranks), counted(line(2 * short), ranks)
    return {name: (total(twice, name) - total(once, name)) / short for name in COUNTS}


def fluid_seconds(settings: Sequence[str], ranks: int) -> float:
    """Seconds of a step by bedload-fluid, all but what it writes."""
    with tempfile.TemporaryDirectory(prefix="bedload-effects-") as folder:
        run(fluid(STEPS + WARM_UP, Path(folder), settings, WARM_UP), ranks)
        parts = read_rows(Path(folder) / "timing.csv")
    return sum(
        float(part["seconds_mean_over_ranks"]) for part in parts if part["part"] not in NOT_A_STEP
    ) / STEPS  # fmt: skip


def plain_seconds(settings: Sequence[str], ranks: int) -> float:
    return json.loads(run(plain(STEPS + WARM_UP, settings, WARM_UP), ranks))["seconds_per_step"]


def grains_seconds(film: bool, ranks: int) -> float:
    """Seconds of a step of LIGGGHTS, by its own clock."""
    said = run(grains(2000, film), ranks)
    found = re.search(r"Loop time of (\S+) on \d+ procs for (\d+) steps", said)
    if found is None:
        raise UserError(f"bedload-dem told no loop time: {said}")
    return float(found[1]) / int(found[2])


@dataclass(frozen=True)
class Pair:
    """An effect that is off beside a program without it: both as seconds and as lines by steps."""

    effect: str
    off: Callable[[int], float]  # seconds of a step, by ranks
    never: Callable[[int], float]
    off_line: Callable[[int, Path], list[str]]  # by steps and output folder
    never_line: Callable[[int], list[str]]
    short: int = SHORT


PAIRS_OF_PROGRAMS = (
    Pair("grains", lambda r: fluid_seconds((), r), lambda r: plain_seconds((), r),
         fluid, lambda n: plain(n)),
    Pair("fixed spheres", lambda r: fluid_seconds((FIXED,), r), lambda r: plain_seconds((FIXED,), r),
         lambda n, out: fluid(n, out, (FIXED,)), lambda n: plain(n, (FIXED,))),
    Pair("lubrication", lambda r: grains_seconds(True, 1), lambda r: grains_seconds(False, 1),
         lambda n, out: grains(n, True), lambda n: grains(n, False), 200),
)  # fmt: skip


def in_turn(off: Callable[[], float], never: Callable[[], float]) -> dict:
    """Medians of PAIRS runs each, and of the ratios of neighbours in time."""
    pairs = [(off(), never()) for _ in range(PAIRS)]
    return {
        "ratio": round(statistics.median(a / b for a, b in pairs), 4),
        "off_s": round(statistics.median(a for a, _ in pairs), 7),
        "never_s": round(statistics.median(b for _, b in pairs), 7),
        "pairs": PAIRS,
    }


def counts_of(pair: Pair, ranks: int) -> dict:
    """Counts a step, off and never, and the programs of the job that has it off."""
    with tempfile.TemporaryDirectory(prefix="bedload-effects-") as folder:
        out = Path(folder) / "out"
        off = per_step(lambda n: pair.off_line(n, out), ranks, pair.short)
        started = programs(counted(pair.off_line(1, out), ranks))
    never = per_step(pair.never_line, ranks, pair.short)
    row = {f"{name}_a_step": [off[name], never[name]] for name in COUNTS}
    return row | {"programs": started}


def rows(ranks: job.Ranks) -> Iterator[dict]:
    for pair in PAIRS_OF_PROGRAMS:
        times = in_turn(partial(pair.off, ranks.fluid), partial(pair.never, ranks.fluid))
        yield {"name": f"effects/{pair.effect}", "effect": pair.effect, "ranks": ranks.fluid,
               **times, **counts_of(pair, ranks.fluid)}  # fmt: skip
    times = in_turn(lambda: fluid_seconds((STATISTICS,), ranks.fluid), lambda: fluid_seconds((), ranks.fluid))
    yield {"name": "effects/statistics on", "effect": "statistics", "ranks": ranks.fluid,
           "ratio_on": times.pop("ratio"), "on_s": times.pop("off_s"), "off_s": times.pop("never_s"),
           **times}  # fmt: skip
