"""What each effect of a scene costs and how far it changes the scene's answer.

The scene runs as it is, then with each effect off or on in turn, for the same number of steps from
the same start. Time per step and memory stand as ratios to the scene as it is, the answer as
differences in percent: mean grain velocity, kinetic energy of the flow, driving force. A few hundred
steps show what an effect does at once, not what it does to the statistics of a long run.
"""

import argparse
import csv
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.estimate import fastest
from bedload_launcher.scenes import INPUTS, Scene, choose_model, find_scene
from bedload_launcher.trial import Trial, run_trial
from bedload_post.outputs import MissingOutput, Run
from bedload_post.summary import mean_grain_velocity


@dataclass(frozen=True)
class Variant:
    """One effect turned: values of fluid.toml, another model, or no lubrication."""

    effect: str
    state: str
    keys: tuple[str, ...] = ()
    model: str | None = None
    lubrication: bool = True


@dataclass(frozen=True)
class Answer:
    grain_velocity: float  # over u_b; not a number without grains
    flow_energy: float  # last row of history.csv
    driving: float


def read_answer(out: Path) -> Answer:
    run = Run(out)
    try:
        grains = mean_grain_velocity(run)
        if len({float(t) for time, _ in run.instants() for t in time}) < 3:
            grains = float("nan")  # a run that hardly samples its grains knows nothing of them
    except MissingOutput:
        grains = float("nan")
    history = run.history()
    driving = history["driving"]
    mean = float(np.mean(driving)) if len(driving) > 1 else float("nan")  # one row is no mean
    return Answer(grains, float(history["kinetic_energy"][-1]), mean)


def variants(scene: Scene, model: str | None, settings: dict) -> Iterator[Variant]:
    """Every effect that this scene can do with or without."""
    fluid, spheres = settings["fluid"], settings["spheres"]
    if settings["time"]["cfl"] == 0.0:  # which needs it: a limit for a flow with convection
        yield Variant("convection", "off", ('fluid.convection="off"',))
    if "diffusion" in fluid:
        yield Variant("diffusion", "explicit", ('fluid.diffusion="explicit"',))
        yield Variant("diffusion", "implicit", ('fluid.diffusion="implicit"',))
    other = "double" if settings["accuracy"]["precision"] == "single" else "single"
    yield Variant("precision", other, (f'accuracy.precision="{other}"',))
    if scene.moves_grains:
        loops = spheres["forcing_loops"]
        for other in sorted({1, 2, 3} - {loops}):
            yield Variant("forcing loops", str(other), (f"spheres.forcing_loops={other}",))
    if model:
        names = {m.stem for m in (INPUTS / "models").glob("*.liggghts")}
        if model.endswith("_hw") and model.removesuffix("_hw") in names:
            yield Variant("tangential model", "off", model=model.removesuffix("_hw"))
        elif model + "_hw" in names:
            yield Variant("tangential model", "on", model=model + "_hw")
        for other in sorted({"actm", "rpm"} - {model.removesuffix("_hw")}):
            suffix = "_hw" if model.endswith("_hw") else ""
            yield Variant("normal model", other, model=other + suffix)
    if lubrication_fixes(scene_script(scene, model)):
        yield Variant("lubrication", "off", lubrication=False)
    if "statistics" in settings:
        yield Variant("statistics", "every step", ("statistics.every=1", "statistics.from=0.0"))
    yield Variant(
        "output", "as little as can be",
        ("output.fields_every=0.0", "output.spheres_every=1e9", "output.history_every=1000000"),
    )  # fmt: skip


def scene_script(scene: Scene, model: str | None) -> tuple[list[str], list[str]]:
    """The script with all that it includes, before the first coupled_run and from there on."""
    lines = list(scene.script_lines({"model": model} if model else {}))
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


def without_lubrication(scene: Scene, model: str | None, folder: Path) -> Scene:
    """The scene with a script in `folder` that takes lubrication off before the grains move."""
    script = before, after = scene_script(scene, model)
    file = folder / "without_lubrication.liggghts"
    lines = [*before, *(f"unfix {name}" for name in lubrication_fixes(script)), *after]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Scene(scene.folder, file)


def measure(scene: Scene, model: str | None, variant: Variant, options, ranks: job.Ranks) -> Trial:
    with tempfile.TemporaryDirectory(prefix="bedload-effects-") as folder:
        if not variant.lubrication:
            scene = without_lubrication(scene, model, Path(folder))
        keys = [*options.set, "output.history_every=10", *variant.keys]
        model = variant.model or model
        work = job.Job(scene, model, ranks, Path(folder), keys, options.steps)
        return fastest([run_trial(work, read_answer) for _ in range(options.repeats)])


def percent(value: float, base: float) -> float:
    return 100.0 * (value / base - 1.0) if base else float("nan")


def compare(variant: Variant, trial: Trial, base: Trial, base_seconds: float) -> dict:
    mine, theirs = trial.answer, base.answer
    memory = trial.fluid_bytes + trial.dem_bytes
    return {
        "effect": variant.effect,
        "state": variant.state,
        "time": trial.step_seconds / base_seconds,
        "memory": memory / (base.fluid_bytes + base.dem_bytes),
        "grain velocity %": percent(mine.grain_velocity, theirs.grain_velocity),
        "flow energy %": percent(mine.flow_energy, theirs.flow_energy),
        "driving %": percent(mine.driving, theirs.driving),
    }


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", help="as for run")
    parser.add_argument("--model", help="as for run")
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")
    parser.add_argument("--steps", type=int, default=100, help="of each run (default: 100)")
    parser.add_argument(
        "--repeats", type=int, default=2, help="of each run, of which the fastest counts (default: 2)"
    )
    parser.add_argument("--out", type=Path, help="folder of the table (default: runs/effects-SCENE)")


def run(options: argparse.Namespace) -> int:
    if options.steps < 10:
        raise UserError(f"--steps is {options.steps}, but must be at least 10.")
    if options.repeats < 1:
        raise UserError(f"--repeats is {options.repeats}, but must be at least 1.")
    scene = find_scene(options.scene)
    model = choose_model(scene, options.model)
    ranks = job.Ranks.parse(options.ranks)
    out = options.out or Path("runs") / f"effects-{scene.name}"
    out.mkdir(parents=True, exist_ok=True)

    as_it_is = Variant("the scene", "as it is")
    bases = [measure(scene, model, as_it_is, options, ranks)]
    todo = list(variants(scene, model, bases[0].settings))
    trials = []
    for number, variant in enumerate(todo, start=1):
        print(f"bedload: {number}/{len(todo)} {variant.effect}: {variant.state}", file=sys.stderr)
        trials.append(measure(scene, model, variant, options, ranks))
        if number in (len(todo) // 2, len(todo)):
            bases.append(measure(scene, model, as_it_is, options, ranks))
    seconds = sorted(b.step_seconds for b in bases)
    rows = [compare(v, t, bases[0], seconds[len(seconds) // 2]) for v, t in zip(todo, trials, strict=True)]

    with (out / "effects.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    print(
        f"{scene.name}, {options.steps} steps on {ranks.fluid} fluid ranks: "
        f"{seconds[len(seconds) // 2]:.4f} s a step as it is "
        f"({seconds[0]:.4f} to {seconds[-1]:.4f} in {len(seconds)} runs)"
    )
    head = list(rows[0])
    print(f"{head[0]:18}{head[1]:22}" + "".join(f"{name:>18}" for name in head[2:]))
    for row in rows:
        print(f"{row['effect']:18}{row['state']:22}" + "".join(f"{row[n]:18.4g}" for n in head[2:]))
    print(f"Table: {out / 'effects.csv'}", file=sys.stderr)
    return 0
