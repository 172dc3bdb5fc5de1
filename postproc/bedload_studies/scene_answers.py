"""A scene's own answers, each with its interval, and what a run of it costs. No study of its own.

An answer is the mean of a series over the second half of a run (or what --since says), with the interval of
batches.py: two settings differ where their difference is larger than both intervals together.
"""

import argparse
import math
import os
import resource
import subprocess
import tempfile
import time
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from bedload_launcher import job
from bedload_launcher.errors import UserError, unknown
from bedload_launcher.memory import MemoryWatch
from bedload_launcher.words import last_sentence
from bedload_post.batches import Estimate, estimate_over_time
from bedload_post.outputs import MissingOutput, Run
from bedload_post.states import RESTING_SPEED

from .earlier_run import EarlierRun

FEWEST = 4  # values of a series that has a mean
LEAST_SECONDS, MOST_REPEATS = 3.0, 6  # a run is repeated until it has cost that much in all
SPREAD = 0.03  # of a cost, below which it is a number


def refuse_needless(
    options: argparse.Namespace, of_a_scene: Sequence[str], of_cases: Sequence[str], cases: str
) -> None:
    """Raises UserError for an option that has no effect: one of a SCENE where none is named, one of the study's own
    `cases` where one is."""
    names, whose = (of_a_scene, "a SCENE of one's own") if options.scene is None else (of_cases, cases)
    if needless := [name for name in names if vars(options)[name]]:
        raise UserError(f"--{needless[0].replace('_', '-')} is for {whose} alone.")


@dataclass(frozen=True)
class Series:
    """One answer over time."""

    time: np.ndarray
    values: np.ndarray

    def mean(self, since: float) -> Estimate:
        """Over the time from `since` on."""
        late = self.values[self.time >= since]
        if len(late) < FEWEST or not np.isfinite(late).all():
            return Estimate(math.nan, math.nan, np.zeros(0))
        return estimate_over_time(self.time, self.values, since)


def grain_series(run: Run) -> dict[str, Series]:
    """Means over the grains at each instant: velocity along x, height, share that moves."""
    total: dict[float, np.ndarray] = {}
    fastest: dict[float, float] = {}
    scale = run.bulk_velocity or 1.0
    for block in run.sample_blocks():
        instants, rows = np.unique(block.time, return_inverse=True)
        speed = np.linalg.norm(block.velocity, axis=1)
        columns = (np.ones(len(block)), block.velocity[:, 0] / scale, block.position[:, 1] / run.diameter,
                   (speed > RESTING_SPEED * scale).astype(float), speed / scale)  # fmt: skip
        sums = np.stack([np.bincount(rows, weights=c) for c in columns], axis=1)
        highest = np.zeros(len(instants))
        np.maximum.at(highest, rows, speed / scale)
        for t, values, most in zip(instants.tolist(), sums, highest.tolist(), strict=True):
            total[t] = total.get(t, np.zeros(len(columns))) + values
            fastest[t] = max(fastest.get(t, 0.0), most)
    if not total:
        return {}
    times = np.array(sorted(total))
    table = np.array([total[t] for t in times.tolist()])
    means = table[:, 1:] / table[:, :1]
    names = ("grain velocity", "grain height", "share moving", "grain speed")
    found = {name: Series(times, means[:, n]) for n, name in enumerate(names)}
    found["largest grain speed"] = Series(times, np.array([fastest[t] for t in times.tolist()]))
    return found


def series_of(run: Run) -> dict[str, Series]:
    """Every answer that the scene has: its grains' first, then the driving force and all of history.csv."""
    try:
        found = grain_series(run)
    except MissingOutput:
        found = {}
    history = run.history()
    times = np.asarray(history["time"], dtype=float)
    named = {"driving force": "driving", "flow energy": "kinetic_energy"}
    for name, column in named.items():
        found[name] = Series(times, np.asarray(history[column], dtype=float))
    for column, values in history.items():
        if column not in ("step", "time", *named.values()):
            found[column] = Series(times, np.asarray(values, dtype=float))
    return found


def chosen(found: dict[str, Series], asked: str | None, since: float) -> str:
    """The answer that is judged: as asked, else the first that is not always the same."""
    if asked is not None:
        if asked not in found:
            raise unknown("quantity", asked, found)
        return asked
    for name in ("grain velocity", "driving force", "flow energy"):
        late = found[name].values[found[name].time >= since] if name in found else np.zeros(0)
        if len(late) >= FEWEST and np.ptp(late) > 1e-6 * max(abs(float(np.mean(late))), 1e-12):
            return name
    raise UserError("the scene's answers do not move in so short a run; give it more with --hours.")


@dataclass(frozen=True)
class Priced:
    """One run, or several of the same: what it cost and what it answered."""

    core_seconds: list[float] = field(default_factory=list)  # of each repeat
    megabytes: float = 0.0
    answers: dict[str, Series] = field(default_factory=dict)
    settings: dict = field(default_factory=dict)

    @property
    def price(self) -> float:
        return float(np.median(self.core_seconds))

    @property
    def spread(self) -> float:
        """Of the price's median: half the middle range of the repeats over it, nan of fewer than three."""
        if len(self.core_seconds) < 3:
            return math.nan
        low, high = np.percentile(self.core_seconds, [25, 75])
        return float(0.5 * (high - low) / self.price)

    def more(self, other: "Priced") -> "Priced":
        """One repeat more; the answer is that of the first."""
        return replace(
            self, core_seconds=[*self.core_seconds, *other.core_seconds],
            megabytes=max(self.megabytes, other.megabytes),
        )  # fmt: skip

    def settled(self, least: int = 1) -> bool:
        """Whether its cost is a number: long enough, or repeated, `least` times or more, until its spread is small."""
        runs = len(self.core_seconds)
        enough = runs >= least and sum(self.core_seconds) >= LEAST_SECONDS
        return runs >= MOST_REPEATS or (enough and not self.spread > SPREAD)


def begun_from(beginning: EarlierRun | None, work: job.Job) -> job.Job:
    """The same work, its flow and grains those of the end of an earlier run."""
    if beginning is None:
        return work
    grains = beginning.variables(work.scene)
    if grains:
        beginning.place(work.out)
    return replace(work, overrides=[*beginning.keys(), *work.overrides], variables=dict(work.variables) | grains)


def run_once(work: job.Job, start_seconds: float = 0.0, beginning: EarlierRun | None = None) -> Priced:
    """Runs `work` in a folder that is thrown away, as it stands or from where an earlier run ended; processor
    seconds without `start_seconds`.

    Raises UserError with the program's own words when it fails.
    """
    with tempfile.TemporaryDirectory(prefix="bedload-answer-") as folder:
        out = Path(folder)
        work = begun_from(beginning, replace(work, out=out))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with (out / "words").open("w") as words, subprocess.Popen(
            work.command(), cwd=work.scene.folder, env=job.environment(),
            stdin=subprocess.DEVNULL, stdout=words, stderr=subprocess.STDOUT,
            preexec_fn=job.dies_with_us(),
        ) as running, MemoryWatch(os.getpid()) as memory:  # fmt: skip
            running.wait()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if running.returncode != 0:
            said = (out / "words").read_text(encoding="utf-8", errors="replace")
            raise UserError(f"{work.scene.name} ended with status {running.returncode}: {last_sentence(said)}")
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        run = Run(out)
        return Priced(
            [max(spent - start_seconds, 1e-3)], memory.bytes_of() / 1e6,
            series_of(run), tomllib.loads((out / "settings.toml").read_text(encoding="utf-8")),
        )  # fmt: skip


def interleaved(
    works: Sequence[Callable[[], Priced]], until: float, say: Callable[[str], None] = lambda _: None,
    least: int = 1, known: Sequence[Priced] = (),
) -> list[Priced | str]:
    """Each work once, then round by round those whose cost is no number yet, while time.monotonic() is below
    `until`; so other work on the machine hits all alike. `least`: runs of which a cost's spread is known; `known`:
    what the first works have given already. A work that fails leaves its sentence."""
    found: list[Priced | str] = [*known]
    for number, work in enumerate(works[len(known) :], start=1 + len(known)):
        say(f"bedload: run {number} of {len(works)}")
        try:
            found.append(work())
        except UserError as error:
            found.append(str(error))
    while time.monotonic() < until:
        due = [n for n, p in enumerate(found) if isinstance(p, Priced) and not p.settled(least)]
        if not due:
            break
        for n in due:
            if time.monotonic() >= until:
                break
            one = found[n]
            assert isinstance(one, Priced)
            found[n] = one.more(works[n]())
    return found


def difference(mine: Estimate, other: Estimate) -> tuple[float, float]:
    """(mine - other)/|other| and its half width, both of 1; nan without a number."""
    if not (math.isfinite(mine.mean) and other.mean):
        return math.nan, math.nan
    half = math.hypot(mine.half_width, other.half_width)
    return (mine.mean - other.mean) / abs(other.mean), half / abs(other.mean)


def paired(mine: Series, base: Series, since: float) -> tuple[float, float]:
    """Mean of mine - base at equal times over that of |base|, and its half width, both of 1. What both have in
    common falls out; base is interpolated where the steps differ, and what comes behind its end left out."""
    both = mine.time <= base.time[-1] * (1.0 + 1e-9)
    time, values = mine.time[both], mine.values[both]
    here = Series(time, np.interp(time, base.time, base.values))
    scale = abs(here.mean(since).mean)
    apart = Series(time, values - here.values).mean(since)
    return (apart.mean / scale, apart.half_width / scale) if scale else (math.nan, math.nan)
