"""`./bedload study accuracy SCENE`: what each choice of accuracy costs and changes in a person's own scene.

The scene runs as it is and with one choice turned at a time: three resolutions, two steps, both precisions,
forcing loops, LIGGGHTS' steps, loads once per step. Beside the core-seconds stands the change of the
scene's own answer against the finest grid, with its interval, and Richardson's estimate of what remains:

    f(h) = f_0 + C h^p    from three grids;  the scene's own error is f(h) - f_0

and, of what the answer differs by from that of the finest grid h', the multiple

    (f(h) - f_0)/(f(h) - f(h')) = 1/(1 - (h'/h)^p),

by which the difference's interval is wider, too (at the order that was found).
"""

import csv
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from bedload_launcher import job, presets
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import Scene, choose_model, find_scene
from bedload_launcher.words import last_sentence, say

from .earlier_run import EarlierRun
from .log_ticks import plain_ticks
from .scene_answers import Priced, chosen, interleaved, paired, run_once

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

COARSER, FINER = 0.8, 1.25
TRIAL_STEPS, FEWEST_STEPS = 10, 60
HOURS = 0.1  # of all runs together, unless told
AS_IT_IS = "as it is"


@dataclass(frozen=True)
class Choice:
    """One setting of the scene. work: its steps and cells over the scene's own, to share out the time."""

    label: str
    keys: tuple[str, ...] = ()
    h: float = 0.0  # cell over the scene's own, of the grids only
    work: float = 1.0


def grids(scene: Scene) -> Iterator[Choice]:
    """A coarser and a finer grid in the scene's proportions, the step with the cell."""
    for factor in (COARSER, FINER):
        try:
            keys = presets.finer(scene, factor, f"of {factor:g} times the cells")
        except UserError:
            continue
        cells = Scene(scene.folder).cells(keys)
        ratio = cells[0] / scene.cells()[0]
        yield Choice(f"{cells[0]} x {cells[1]} x {cells[2]} cells", tuple(keys), 1.0 / ratio, ratio**4)


def choices(scene: Scene, settings: dict) -> list[Choice]:
    """All that is tried, the scene as it is first."""
    found = [Choice(AS_IT_IS, h=1.0), *grids(scene)]
    step, cfl = settings["time"]["step"], settings["time"].get("cfl", 0.0)
    follows = (f"time.cfl={0.5 * cfl!r}",) if cfl > 0.0 else ()  # time.step is its upper end there
    found.append(Choice("half the step", (f"time.step={0.5 * step!r}", *follows), work=2.0))
    other = "double" if settings["accuracy"]["precision"] == "single" else "single"
    found.append(Choice(f"{other} precision", (f'accuracy.precision="{other}"',), work=1.2))
    if scene.has_spheres():
        loops = settings["spheres"]["forcing_loops"]
        found += [
            Choice(f"{n} forcing loop{'s' * (n > 1)}", (f"spheres.forcing_loops={n}",), work=1.1)
            for n in sorted({1, 2, 3} - {loops})
        ]
    if scene.moves_grains:
        sub = settings["coupling"]["dem_steps"]
        found.append(Choice(f"{2 * sub} steps of LIGGGHTS", (f"coupling.dem_steps={2 * sub}",)))
        exchange = settings["coupling"]["exchange"]
        if exchange == "stage":
            found.append(Choice("loads once per step", ('coupling.exchange="step"',)))
    return found


def richardson(h: list[float], f: list[float]) -> tuple[float, float]:
    """(f_0, p) of f = f_0 + C h^p through three grids, p between 0.5 and 4; nan where they show no trend."""
    (h1, f1), (h2, f2), (h3, f3) = sorted(zip(h, f, strict=True), reverse=True)
    if (f1 - f2) * (f2 - f3) <= 0.0:
        return math.nan, math.nan
    ratio = (f1 - f2) / (f2 - f3)
    orders = np.linspace(0.5, 4.0, 701)
    rises = (h1**orders - h2**orders) / (h2**orders - h3**orders)
    if not rises[0] <= ratio <= rises[-1]:
        return math.nan, math.nan
    p = float(np.interp(ratio, rises, orders))
    return f3 - (f2 - f3) * h3**p / (h2**p - h3**p), p


@dataclass(frozen=True)
class Row:
    """One line of the table; change and interval of 1."""

    choice: str
    price: float
    repeats: int
    megabytes: float
    answer: float
    answer_interval: float
    change: float
    interval: float
    words: str = ""


def finest(tried: list[Choice], runs: list[Priced | str]) -> tuple[int, Priced]:
    """Which of the grids that ran is the finest, and its run."""
    ran = {n: run for n, run in enumerate(runs) if isinstance(run, Priced)}
    number = min((choice.h, n) for n, choice in enumerate(tried) if choice.h and n in ran)[1]
    return number, ran[number]


def rows_of(tried: list[Choice], runs: list[Priced | str], name: str, since: float) -> list[Row]:
    """The table against the finest grid that ran."""
    fine, best = finest(tried, runs)
    rows = []
    for choice, run in zip(tried, runs, strict=True):
        if not isinstance(run, Priced):
            sentence = last_sentence(str(run))
            rows.append(Row(choice.label, math.nan, 0, math.nan, math.nan, math.nan, math.nan, math.nan, sentence))
            continue
        mean = run.answers[name].mean(since)
        change, half = (
            paired(run.answers[name], best.answers[name], since) if choice is not tried[fine] else (0.0, 0.0)
        )
        rows.append(Row(choice.label, run.price, len(run.core_seconds), run.megabytes, mean.mean,
                        mean.half_width, change, half, "finest" if choice is tried[fine] else ""))  # fmt: skip
    return rows


def remaining(
    tried: list[Choice], runs: list[Priced | str], name: str, since: float
) -> tuple[float, float, str]:
    """The scene's own error of 1 and its interval, and what it is from; nan, and why, where no finer grid ran: a
    coarser one alone says nothing of it."""
    own = runs[0]
    grids_ = [(c.h, r.answers[name]) for c, r in zip(tried, runs, strict=True) if c.h and isinstance(r, Priced)]
    if not isinstance(own, Priced):
        return math.nan, math.nan, "it did not run"
    number, best = finest(tried, runs)
    if number == 0:
        return math.nan, math.nan, "no finer grid ran"
    change, half = paired(own.answers[name], best.answers[name], since)
    if len(grids_) == 3 and abs(change) > half:
        # Of the finest grid's answer: 1 with its sign, and what the others differ by at equal times.
        sign = math.copysign(1.0, best.answers[name].mean(since).mean)
        f = [sign + paired(answer, best.answers[name], since)[0] for _, answer in grids_]
        f_0, p = richardson([h for h, _ in grids_], f)
        if math.isfinite(f_0) and f_0:
            wider = 1.0 / (1.0 - tried[number].h ** p) / abs(f_0)
            return (f[0] - f_0) / abs(f_0), half * wider, f"Richardson's estimate, order {p:.1f}"
    why = "within the interval" if not abs(change) > half else "the grids show no trend"
    return change, half, f"against the finest grid; {why}"


def last_line(
    scene: Scene, run: Priced, error: float, half: float, source: str, name: str, steps: int, end: float
) -> str:
    """This setting, this error, this price; `end`: of the scene, which the run stopped short of after `steps` times
    time.step, in more steps where time.cfl shortened them."""
    s = run.settings
    whole = run.price / steps * math.ceil(end / s["time"]["step"])
    taken = len(run.answers["driving force"].time)
    count = s["spheres"]["forcing_loops"]
    loops = f", {count} forcing loop{'s' * (count > 1)}" if scene.has_spheres() else ""
    cells = " x ".join(map(str, s["grid"]["cells"]))
    known = f"{100 * error:+.1f} ± {100 * half:.1f} %" if math.isfinite(error) else "error not known"
    return (
        f"This setting ({cells} cells, step {s['time']['step']:g}, {s['accuracy']['precision']} precision{loops}): "
        f"{name} {known} ({source}), "
        f"{run.price / taken:.3g} core-seconds a step, {whole / 3600:.2g} core-hours to the scene's end."
    )


def draw(rows: list[Row], name: str, file: Path) -> None:
    """One row a choice, so that no label meets another: change with its interval, and price."""
    shown = [row for row in rows if math.isfinite(row.price)]
    figure, (left, right) = plt.subplots(
        1, 2, sharey=True, figsize=(9.0, 1.2 + 0.36 * len(shown)), layout="constrained"
    )
    place = np.arange(len(shown))[::-1]
    left.errorbar([100 * r.change for r in shown], place, xerr=[100 * r.interval for r in shown], fmt="o",
                  color="#2a6f97", capsize=3)  # fmt: skip
    left.axvline(0.0, color="#9aa5b1", lw=0.8)
    left.set(xlabel=f"change of the {name} against the finest grid / %")
    left.set_yticks(place, [r.choice for r in shown])
    right.plot([r.price for r in shown], place, "s", color="#c8553d")
    right.set(xlabel="price / core-seconds", xscale="log")
    plain_ticks(right.xaxis)
    for axis in (left, right):
        axis.grid(alpha=0.25)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def shared_steps(hours: float, work: float, step_seconds: float, most: int) -> int:
    """Steps of the scene as it is, so that all runs together take `hours` on the clock."""
    return int(min(max(3600.0 * hours / (work * step_seconds), FEWEST_STEPS), most))


def run(options) -> int:
    scene = find_scene(options.scene)
    model = choose_model(scene, options.model)
    ranks = job.Ranks.parse(options.ranks, scene)
    if fixed := [text for text in options.set if text.startswith(("grid.", "time.step", "time.cfl"))]:
        raise UserError(f"--set {fixed[0]}: this study changes grid and step itself; write it into a scene of its own.")
    hours = options.hours or HOURS
    out = options.report or options.runs / scene.name
    out.mkdir(parents=True, exist_ok=True)

    beginning = EarlierRun.of(options.start_from) if options.start_from else None

    def work(steps: int | None, *keys: str) -> job.Job:
        dense = ("output.history_every=1", "output.fields_every=0.0", "output.spheres_every=0.0")
        return job.Job(scene, model, ranks, out, [*dense, *options.set, *keys], steps)

    presets.warn_of_counted_steps(scene, model)
    say(f"bedload: trying {TRIAL_STEPS} steps")
    began = time.monotonic()
    start = run_once(work(1), beginning=beginning)
    trial = run_once(work(1 + TRIAL_STEPS), start.price, beginning)
    if options.quantity is not None:
        chosen(trial.answers, options.quantity, 0.0)  # a name that does not exist is found before the long runs
    step_seconds = trial.price / TRIAL_STEPS / ranks.fluid
    tried = choices(scene, trial.settings)
    step, end = trial.settings["time"]["step"], trial.settings["time"]["end"]
    steps = shared_steps(hours, 1.5 * sum(c.work for c in tried), step_seconds, math.ceil(end / step))
    until = f"time.end={steps * step!r}"
    say(f"bedload: {len(tried)} choices over {steps} of the scene's steps, t = {steps * step:g}")
    works = [
        (lambda keys=choice.keys: run_once(work(None, until, *keys), start.price, beginning)) for choice in tried
    ]
    runs = interleaved(works, began + 3600.0 * hours, say)
    if not isinstance(runs[0], Priced):
        raise UserError(runs[0])
    since = 0.5 * steps * step
    name = chosen(runs[0].answers, options.quantity, since)
    rows = rows_of(tried, runs, name, since)
    write(out, scene, rows, name)
    print(table_text(rows, name))
    line = last_line(scene, runs[0], *remaining(tried, runs, name, since), name, steps, end)
    (out / "line.txt").write_text(line + "\n", encoding="utf-8")
    print(line)
    say(f"Table and figure: {out}")
    return 0


def table_text(rows: list[Row], name: str) -> str:
    lines = [f"{'choice':26}{'core-s':>9}{'runs':>5}{'MB':>7}  {name:>24}  {'change / %':>16}"]
    for r in rows:
        if not math.isfinite(r.price):
            lines.append(f"{r.choice:26}  {r.words}")
            continue
        lines.append(
            f"{r.choice:26}{r.price:9.2f}{r.repeats:5}{r.megabytes:7.0f}  "
            f"{f'{r.answer:.5g} ± {r.answer_interval:.2g}':>24}  "
            f"{f'{100 * r.change:+.2f} ± {100 * r.interval:.2f}':>16}  {r.words}"
        )
    return "\n".join(lines)


def write(out: Path, scene: Scene, rows: list[Row], name: str) -> None:
    with (out / "accuracy.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(Row.__dataclass_fields__), lineterminator="\n")
        table.writeheader()
        table.writerows(vars(row) for row in rows)
    draw(rows, name, out / "accuracy.png")
