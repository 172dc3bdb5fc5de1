"""`./bedload study stability SCENE`: how far a person's own scene is from its limits, each found by bisection.

The scene runs as it is for a short time, then with one number turned further and further until a run no longer
holds: the step longer, LIGGGHTS' steps fewer, the grains lighter, the gap narrower. All runs end at the same
physical time. A run holds when it comes to its end, its grains are not faster than FASTER times those of the
scene as it is, its flow has not more than ENERGY times the energy, and its markers do not slip SLIP times as much.
"""

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from bedload_launcher import job, presets
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import choose_model, find_scene
from bedload_launcher.words import last_sentence, say

from .runaway import growing_swing
from .scene_answers import Priced, Series, run_once

FASTER, ENERGY, SLIP = 2.0, 1.5, 5.0
FURTHEST = 32.0  # times the scene's own number, either way
HALVINGS = 4  # of the interval, which then is 4 % wide where it began with a factor of two
STEPS = 60  # of the scene as it is


@dataclass(frozen=True)
class Knob:
    """A number of the scene. up: the danger lies above; keys(value), variables(value): what sets it;
    whole: it comes in multiples of that (0: any number)."""

    name: str
    value: float
    up: bool
    keys: Callable[[float], list[str]] = lambda _: []
    variables: Callable[[float], dict[str, str]] = lambda _: {}
    whole: int = 0

    def at(self, factor: float) -> float:
        """The value `factor` times nearer to danger."""
        value = self.value * factor if self.up else self.value / factor
        return max(self.whole, self.whole * round(value / self.whole)) if self.whole else value


def largest(found: dict[str, Series], name: str) -> float:
    """Of a series' absolute values; 0 where there is none."""
    return float(np.max(np.abs(found[name].values), initial=0.0)) if name in found else 0.0


def complaint(run: Priced | str, base: Priced) -> str:
    """Why a run does not hold; empty where it does."""
    if isinstance(run, str):
        return last_sentence(run)
    for name, limit in (("largest grain speed", FASTER), ("flow energy", ENERGY), ("slip_rms", SLIP)):
        mine, theirs = largest(run.answers, name), largest(base.answers, name)
        if not math.isfinite(mine):
            return f"{name} is no number"
        if theirs > 0.0 and mine > limit * theirs:
            return f"{name} is {mine / theirs:.2g} times that of the scene as it is"
    if "grain velocity" in run.answers:
        speed = run.answers["grain velocity"].values[:, None, None]
        if growing_swing(speed, 0.05 * max(largest(base.answers, "largest grain speed"), 1e-12)):
            return "the grains swing, more with each step"
    return ""


@dataclass(frozen=True)
class Limit:
    """holds: furthest value that held; fails: nearest that did not, nan where none was found."""

    knob: str
    value: float
    holds: float
    fails: float
    why: str

    @property
    def distance(self) -> float:
        """Factor between the scene's own value and the limit."""
        return max(self.holds / self.value, self.value / self.holds)


def bisected(knob: Knob, fails_with: Callable[[float], str]) -> Limit:
    """The limit between the last value that held and the first that did not; `fails_with(value)` runs
    the scene and says why it does not hold."""
    good, bad, why = 1.0, math.inf, ""
    tried: dict[float, str] = {knob.value: ""}

    def ask(factor: float) -> str:
        value = knob.at(factor)
        if value not in tried:
            tried[value] = fails_with(value)
        return tried[value]

    factor = 2.0
    while factor <= FURTHEST:
        if words := ask(factor):
            bad, why = factor, words
            break
        good, factor = factor, 2.0 * factor
    if math.isinf(bad):
        return Limit(knob.name, knob.value, knob.at(good), math.nan, "holds as far as was tried")
    for _ in range(HALVINGS):
        middle = math.sqrt(good * bad)
        if words := ask(middle):
            bad, why = middle, words
        else:
            good = middle
    return Limit(knob.name, knob.value, knob.at(good), knob.at(bad), why)


def sub_steps(value: float) -> list[str]:
    return [f"coupling.dem_steps={int(value)}"]


def one_variable(name: str, value: float) -> dict[str, str]:
    return {name: repr(value)}


def knobs(settings: dict, declared: dict[str, str]) -> list[Knob]:
    """What the scene can be turned at: the density of its grains and a gap where its script has such
    variables and they are above 0, of which there are multiples."""
    step, cfl = settings["time"]["step"], settings["time"].get("cfl", 0.0)
    found = [Knob("step", step, True, keys=lambda v: [f"time.step={v!r}"])]
    if cfl > 0.0:  # the step follows the flow: time.step alone would be no more than its upper end
        found = [Knob("time.cfl", cfl, True, keys=lambda v: [f"time.cfl={v!r}", f"time.step={step * (v / cfl)!r}"])]
    if declared:
        multiple = 15 if settings["coupling"]["exchange"] == "stage" else 1
        sub = settings["coupling"]["dem_steps"]
        if sub > multiple:
            found.append(Knob("LIGGGHTS' steps", sub, False, keys=sub_steps, whole=multiple))
    for name in ("density", "gap"):
        value = number(declared.get(name, ""))
        if value is not None and math.isfinite(value) and value > 0.0:
            found.append(Knob(name, value, False, variables=partial(one_variable, name)))
    return found


def number(text: str) -> float | None:
    """The number that a variable of the script is; None for several words, or none."""
    try:
        return float(text)
    except ValueError:
        return None


def not_turned(turned: list[Knob]) -> str:
    """A sentence on what the scene offers no number for; empty where it offers all."""
    names = {knob.name for knob in turned}
    wanted = [name for name in ("density", "gap") if name not in names]
    missing = [f"{name} (the script has no 'variable {name} index NUMBER' above 0)" for name in wanted]
    if "LIGGGHTS' steps" not in names:
        missing.insert(0, "LIGGGHTS' steps (already the fewest)")
    return f"Not turned: {', '.join(missing)}." if missing else ""


def run(options) -> int:
    scene = find_scene(options.scene)
    model = choose_model(scene, options.model)
    ranks = job.Ranks.parse(options.ranks, scene)
    declared = scene.variables({"model": model} if model else {})
    options.out.mkdir(parents=True, exist_ok=True)
    dense = ["output.history_every=1", "output.fields_every=0.0", "output.spheres_every=0.0", *options.set]

    def once(keys: list[str], variables: dict[str, str], steps: int | None = None) -> Priced:
        return run_once(job.Job(scene, model, ranks, options.out, [*dense, *keys], steps, variables))

    presets.warn_of_counted_steps(scene, model)
    say(f"bedload: {scene.name} as it is")
    settings = once([], {}, 1).settings
    end = options.time or STEPS * settings["time"]["step"]
    until = [f"time.end={end!r}"]
    base = once(until, {})
    limits = []
    turned = knobs(settings, declared)
    for knob in turned:

        def fails_with(value: float, knob: Knob = knob) -> str:
            say(f"bedload: {knob.name} = {value:g}")
            try:
                return complaint(once([*until, *knob.keys(value)], knob.variables(value)), base)
            except UserError as error:
                return complaint(str(error), base)

        limits.append(bisected(knob, fails_with))
    write(options.out / "limits.csv", limits)
    print(f"{scene.name} to t = {end:g}: furthest value that holds\n"
          f"{'':18}{'the scene has':>14}{'holds':>12}{'fails':>12}{'distance':>10}")  # fmt: skip
    for limit in limits:
        fails = f"{limit.fails:.4g}" if math.isfinite(limit.fails) else "-"
        print(f"{limit.knob:18}{limit.value:14.4g}{limit.holds:12.4g}{fails:>12}{limit.distance:9.2f}x  {limit.why}")
    if declared and (words := not_turned(turned)):
        print(words)
    return 0


def write(file, limits: list[Limit]) -> None:
    with file.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(Limit.__dataclass_fields__), lineterminator="\n")
        table.writeheader()
        table.writerows(vars(limit) for limit in limits)
