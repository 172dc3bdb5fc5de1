"""What each effect of a scene costs, how far it changes the scene's answer, and whether it is called for.

The scene runs as it is until its answer moves, then with each effect off or on in turn over the same time (not as
many steps: time.cfl shortens some) from the same start. Runs are interleaved and repeated until the spread of each
one's time is below 3 % or --hours are over. The change is the mean of the difference at equal times over the second
half, with its interval from batches. Verdicts, of what the scene has now:

    needed       without it the answer changes by more than the interval
    worth it     what is off changes the answer by more than the interval when it is on
    leave it out the answer stays within 2 %, certainly, and the time is less without
    no matter    the answer stays within 2 %, certainly, and the time too
    open         the interval is wider than 2 %, or another thing that the grains do (height, speed along x, speed)
                 changes by more, or the runs are too short for their time to be known: give --hours
"""

import argparse
import csv
import math
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from bedload_launcher import cost, job, verdicts
from bedload_launcher.errors import UserError
from bedload_launcher.numbers import positive, whole
from bedload_launcher.scenes import INPUTS, Scene, choose_model, find_scene
from bedload_launcher.verdicts import LEAVE_OUT, TOLERANCE
from bedload_launcher.words import last_sentence, say

from .earlier_run import EarlierRun, add_start_from
from .scene_answers import Priced, chosen, interleaved, paired, run_once

REPEATS, FEWEST_STEPS = 4, 40
SPREAD_OF = 3  # runs, the fewest whose times have a spread
FILM_SETTINGS = "lubrication_settings"  # of the scripts in inputs/models, for fix lubrication
HELD = ("hold", "1")  # of the scripts in inputs/: the grains stay where they are


@dataclass(frozen=True)
class Variant:
    """One effect turned: values of fluid.toml, another model, or no lubrication."""

    effect: str
    state: str
    keys: tuple[str, ...] = ()
    model: str | None = None
    lubrication: bool = True
    variables: tuple[tuple[str, str], ...] = ()  # of in.liggghts
    turned_off: bool = False  # the scene has the effect and this run has not; else the other way round


LARGEST_WITHOUT_CORE = 6.0  # cells across a sphere (fluid/immersed_boundary/rigid_core.hpp)


def cells_across(settings: dict) -> float:
    """Of reference.diameter."""
    return settings["reference"]["diameter"] * settings["grid"]["cells"][0] / settings["grid"]["length"][0]


def variants(scene: Scene, model: str | None, settings: dict) -> Iterator[Variant]:
    """Every effect that this scene can do with or without."""
    fluid, spheres = settings["fluid"], settings["spheres"]
    no_limit = () if settings["time"]["cfl"] == 0.0 else ("time.cfl=0.0",)  # one of convection
    yield Variant("convection", "off", ('fluid.convection="off"', *no_limit), turned_off=True)
    if "diffusion" in fluid:
        yield Variant("diffusion", "explicit", ('fluid.diffusion="explicit"',), turned_off=True)
        yield Variant("diffusion", "implicit", ('fluid.diffusion="implicit"',))
    other = "double" if settings["accuracy"]["precision"] == "single" else "single"
    yield Variant("precision", other, (f'accuracy.precision="{other}"',), turned_off=other == "single")
    if scene.moves_grains:
        loops = spheres["forcing_loops"]
        for count in sorted({1, 2, 3} - {loops}):
            yield Variant(
                "forcing loops", str(count), (f"spheres.forcing_loops={count}",), turned_off=count < loops
            )
        sub = settings["coupling"]["dem_steps"]
        yield Variant("steps of LIGGGHTS", str(2 * sub), (f"coupling.dem_steps={2 * sub}",))
        if settings["coupling"]["exchange"] == "stage":
            yield Variant("loads", "once per step", ('coupling.exchange="step"',), turned_off=True)
        if spheres["interior_term"] == "on":
            yield Variant("interior term", "off", ('spheres.interior_term="off"',), turned_off=True)
        if spheres["rigid_core"] == "on" and cells_across(settings) > LARGEST_WITHOUT_CORE:
            yield Variant("rigid core", "off", ('spheres.rigid_core="off"',), turned_off=True)
        if spheres["buoyancy"] == "on" and any(fluid["gravity"]):
            yield Variant("buoyancy", "off", ('spheres.buoyancy="off"',), turned_off=True)
        if spheres["pressure_share"] != 0.0:  # negative: as the spheres ask for
            yield Variant("old pressure", "off", ("spheres.pressure_share=0.0",), turned_off=True)
    if HELD[0] in scene.variables({"model": model} if model else {}):
        # What moving boundaries cost, and the most that letting grains fall asleep could save.
        yield Variant("moving boundary", "grains held", variables=(HELD,), turned_off=True)
    if model:
        names = {m.stem for m in (INPUTS / "models").glob("*.liggghts")}
        if model.endswith("_hw") and model.removesuffix("_hw") in names:
            yield Variant("tangential model", "off", model=model.removesuffix("_hw"), turned_off=True)
        elif model + "_hw" in names:
            yield Variant("tangential model", "on", model=model + "_hw")
        for other in sorted({"actm", "rpm"} - {model.removesuffix("_hw")}):
            suffix = "_hw" if model.endswith("_hw") else ""
            yield Variant("normal model", other, model=other + suffix)
    if lubrication_fixes(scene_script(scene, model)):
        yield Variant("lubrication", "off", lubrication=False, turned_off=True)
        settings_of_films = [line.partition("#")[0].split(maxsplit=2)[2] for line in sum(scene_script(scene, model), [])
                             if line.split()[:2] == ["variable", FILM_SETTINGS]]  # fmt: skip
        said = settings_of_films[0].replace('"', "").split()[1:] if settings_of_films else None
        for state, before in (("off", []), ("on", ["tangential", "off"])):
            if said == before:
                films = ((FILM_SETTINGS, f"tangential {state}"),)
                yield Variant("films against sliding and rolling", state, variables=films, turned_off=state == "off")
    if settings["statistics"]["every"] > 0:
        without = ("statistics.every=0", "statistics.spectra_heights=[]")
        yield Variant("statistics", "off", without, turned_off=True)
    else:
        yield Variant("statistics", "every step", ("statistics.every=1", "statistics.from=0.0"))
    yield Variant(
        "output", "as little as can be",
        ("output.fields_every=0.0", "checkpoint.wall_every=0.0"), turned_off=True,
    )  # fmt: skip


def scene_script(
    scene: Scene, model: str | None, variables: Mapping[str, str] | None = None
) -> tuple[list[str], list[str]]:
    """The script with all that it includes, before the first coupled_run and from there on; `variables`: what
    the command line sets."""
    lines = list(scene.script_lines({"model": model, **(variables or {})} if model else variables))
    for first, line in enumerate(lines):
        if line.split()[:1] == ["coupled_run"]:
            return lines[:first], lines[first:]
    return lines, []


def lubrication_fixes(script: tuple[list[str], list[str]]) -> list[str]:
    """Names of the lubrication that is on in the first coupled_run."""
    names = []
    for line in script[0]:
        match line.split():
            case ["fix", name, _, "lubrication", *_] if name not in names:
                names.append(name)
            case ["unfix", name, *_] if name in names:
                names.remove(name)
    return names


def without_lubrication(
    scene: Scene, model: str | None, folder: Path, variables: Mapping[str, str] | None = None
) -> Scene:
    """The scene with a script in `folder` that takes lubrication off before the grains move."""
    script = before, after = scene_script(scene, model, variables)
    file = folder / "without_lubrication.liggghts"
    lines = [*before, *(f"unfix {name}" for name in lubrication_fixes(script)), *after]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Scene(scene.folder, file)


CHEAPER, UNREPEATED = 0.03, 0.15  # of the time: what counts when its spread is small, or unknown
# What counts otherwise, in spreads. Half the middle range is 0.67 standard deviations, the median of three runs is
# known to 0.72: of what costs nothing, one in some thirty seems to.
SPREADS = 2.0


@dataclass(frozen=True)
class Compared:
    """One row. time, memory: over the scene as it is; spread: of the time; change, interval: of 1."""

    effect: str
    state: str
    time: float
    spread: float
    memory: float
    change: float
    interval: float
    verdict: str
    words: str = ""
    keys: str = ""  # values of fluid.toml that turned the effect, for --accuracy auto


def judged(turned_off: bool, change: float, interval: float, time: float, spread: float = 0.0) -> str:
    """The verdict on an effect that the scene has (`turned_off` in this row) or has not."""
    if not (math.isfinite(change) and math.isfinite(interval)):
        return "open"
    if abs(change) > max(interval, TOLERANCE):
        return "needed" if turned_off else "worth it"
    if abs(change) + interval > TOLERANCE:
        return "open"
    dearer = 1.0 / time if turned_off else time
    counts = max(CHEAPER, SPREADS * spread) if math.isfinite(spread) else UNREPEATED
    return LEAVE_OUT if dearer > 1.0 + counts else "no matter"


def compare(variant: Variant, run: Priced | str, base: Priced, name: str, since: float) -> Compared:
    if isinstance(run, str):
        sentence = last_sentence(run)
        nan = math.nan
        return Compared(variant.effect, variant.state, nan, nan, nan, nan, nan, "open", sentence)
    time_ratio, words = run.price / base.price, ""
    if name in run.answers:
        change, half = paired(run.answers[name], base.answers[name], since)
        verdict = judged(variant.turned_off, change, half, time_ratio, math.hypot(run.spread, base.spread))
        if verdict in (LEAVE_OUT, "no matter"):
            words = unlike(run, base, name, since)
            if not (run.settled() and base.settled()):
                words = "too short to tell its time; --hours"
            verdict = "open" if words else verdict
    else:  # grains that are held have no velocity
        change, half, verdict = math.nan, math.nan, "needed"
    return Compared(
        variant.effect, variant.state, time_ratio, run.spread, run.megabytes / base.megabytes, change, half, verdict,
        words, "; ".join(variant.keys),
    )  # fmt: skip


OF_GRAINS = ("grain velocity", "grain height", "grain speed")  # what a scene's grains do, whichever of it is judged


def unlike(run: Priced, base: Priced, judged_by: str, since: float) -> str:
    """The first of what grains do that is not certainly the same within the tolerance; else empty."""
    for name in OF_GRAINS:
        if name == judged_by or name not in run.answers or name not in base.answers:
            continue
        change, half = paired(run.answers[name], base.answers[name], since)
        if math.isfinite(change) and math.isfinite(half) and abs(change) + half > TOLERANCE:
            return f"{name} {100 * change:+.2f} ± {100 * half:.2f} %"
    return ""


def half_way(run: Priced) -> float:
    """The middle of a run's own time: its steps may be shorter than time.step."""
    times = run.answers["driving force"].time
    return float(0.5 * (times[0] + times[-1]))


def moves(run: Priced, asked: str | None, since: float) -> str | None:
    """The name of the answer that moves in this run, if any does."""
    try:
        return chosen(run.answers, asked, since)
    except UserError:
        return None


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="as for run")
    parser.add_argument("--model", help="as for run")
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")
    add_start_from(parser)
    parser.add_argument("--quantity", metavar="NAME", help="what is judged (default: the first that moves of grain "
                        "velocity, driving force, flow energy)")  # fmt: skip
    parser.add_argument("--steps", type=whole(1), help="of each run (default: as many as fit into --hours)")
    parser.add_argument("--hours", type=positive, default=0.2, help="of all runs together (default: 0.2); each variant "
                        "runs once whatever that takes")  # fmt: skip
    parser.add_argument("--out", type=Path, help="folder of the table (default: runs/effects-SCENE)")


def run(options: argparse.Namespace) -> int:
    if options.steps is not None and options.steps < 10:
        raise UserError(f"--steps is {options.steps}, but must be at least 10.")
    scene = find_scene(options.scene)
    model = choose_model(scene, options.model)
    ranks = job.Ranks.parse(options.ranks, scene)
    out = options.out or Path("runs") / f"effects-{scene.name}"
    out.mkdir(parents=True, exist_ok=True)
    beginning = EarlierRun.of(options.start_from) if options.start_from else None
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="bedload-effects-") as folder:
        placed = beginning.variables(scene) if beginning else {}
        bare = without_lubrication(scene, model, Path(folder), placed) if scene.moves_grains else scene

        def once(variant: Variant, steps: int | None, start: float = 0.0, end: float | None = None) -> Priced:
            until = [] if end is None else [f"time.end={end!r}"]
            keys = ["output.history_every=1", *options.set, *variant.keys, *until]
            used = scene if variant.lubrication else bare
            work = job.Job(used, variant.model or model, ranks, out, keys, steps, dict(variant.variables))
            return run_once(work, start, beginning)

        as_it_is = Variant("the scene", "as it is")
        start = once(as_it_is, 1)
        trial = once(as_it_is, 11, start.price)
        if options.quantity is not None:
            chosen(trial.answers, options.quantity, 0.0)  # a name that does not exist is found before the long runs
        todo = [as_it_is, *variants(scene, model, trial.settings)]
        most = math.ceil(trial.settings["time"]["end"] / trial.settings["time"]["step"])
        fitting = 3600.0 * options.hours * ranks.fluid / (REPEATS * len(todo) * trial.price / 10)
        steps = options.steps or int(min(max(fitting, FEWEST_STEPS), most))
        once_each = len(todo) * steps * trial.price / 10 / ranks.fluid
        say(f"bedload: {len(todo)} runs of {steps} steps, in turn, some {cost.duration(once_each)} once each")
        # Before the others, so that none of them runs in vain.
        base = once(as_it_is, steps, start.price)
        since, end = half_way(base), float(base.answers["driving force"].time[-1])
        name = moves(base, options.quantity, since)
        if name is None:
            raise UserError(f"no answer of {scene.name} moves within {steps} steps; give it more with --hours.")
        # All to the same end: where steps follow the flow, as many of them reach another one.
        works = [(lambda v=variant: once(v, None, start.price, end)) for variant in todo]
        runs = interleaved(works, began + 3600.0 * options.hours, say, SPREAD_OF, [base])
    base = runs[0] if isinstance(runs[0], Priced) else base  # with its repeats
    rows = [compare(v, r, base, name, since) for v, r in zip(todo[1:], runs[1:], strict=True)]
    with (out / "effects.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(Compared.__dataclass_fields__), lineterminator="\n")
        table.writeheader()
        table.writerows(vars(row) for row in rows)
    spread = f" (spread {100 * base.spread:.1f} %)" if math.isfinite(base.spread) else ""
    verdicts.note(out, scene, model, options.set)
    print(f"{scene.name}, {steps} steps on {ranks.fluid} fluid ranks, {base.price / steps:.4g} core-seconds a step as "
          f"it is{spread}; answer: {name}")  # fmt: skip
    print(table_text(rows))
    print(f"Table: {out / 'effects.csv'}", file=sys.stderr)
    return 0


def table_text(rows: list[Compared]) -> str:
    effect = max([18, *(len(r.effect) + 2 for r in rows)])
    state = max([22, *(len(r.state) + 2 for r in rows)])
    lines = [f"{'effect':{effect}}{'state':{state}}{'time':>16}{'memory':>8}{'change / %':>18}  verdict"]
    for r in rows:
        if not math.isfinite(r.time):
            lines.append(f"{r.effect:{effect}}{r.state:{state}}  {r.words}")
            continue
        cost = f"{r.time:.3f} ± {r.spread:.3f}" if math.isfinite(r.spread) else f"{r.time:.3f}        "
        change = f"{100 * r.change:+.2f} ± {100 * r.interval:.2f}" if math.isfinite(r.change) else "no such answer"
        why = f" ({r.words})" if r.words else ""
        lines.append(f"{r.effect:{effect}}{r.state:{state}}{cost:>16}{r.memory:8.2f}{change:>18}  {r.verdict}{why}")
    return "\n".join(lines)
