"""Cases with a known answer for `./bedload study accuracy`, and the knobs that each one turns.

A case is a function (runner, label, D/h, settings) -> error of 1. In the settings, keys of fluid.toml stand
by their names; names without a dot are the case's own: `step` (length of the time step over the case's
own), `model`, `film` (what stands behind fix lubrication), `collision_steps`.
"""

import os
import resource
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from bedload_launcher import job
from bedload_launcher.accuracy import PRESETS
from bedload_launcher.memory import MemoryWatch
from bedload_launcher.scenes import INPUTS, Scene
from bedload_post.outputs import Run

from . import validation_moving, validation_steady
from .effects import without_lubrication
from .small_scenes import SmallScene
from .validation_runs import Runner, _toml


@dataclass
class PricedRunner(Runner):
    """A Runner that also notes processor time and memory; both stand in a file beside the run."""

    made: set[Path] = field(default_factory=set)  # in this study: what points share is repeated once
    core_seconds: float = 0.0
    megabytes: float = 0.0

    def __call__(self, scene, label, settings: Mapping = {}, variables: Mapping = {}):
        run = super().__call__(scene, label, settings, variables)
        self._pay(self.folder / label)
        return run

    def repeats(self, out: Path) -> bool:
        due = self.afresh and out not in self.made
        self.made.add(out)
        return due

    def _pay(self, out: Path) -> None:
        """Adds the price of the run in `out`."""
        spent, megabytes = map(float, (out / "price.csv").read_text(encoding="utf-8").split(","))
        self.core_seconds += spent
        self.megabytes = max(self.megabytes, megabytes)

    @contextmanager
    def unpaid(self) -> Iterator[None]:
        """What runs inside, a reference say, is no part of the price."""
        price = self.core_seconds, self.megabytes
        yield
        self.core_seconds, self.megabytes = price

    def _run(self, line, scene, out: Path) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with MemoryWatch(os.getpid()) as memory:
            seconds = super()._run(line, scene, out)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        megabytes = memory.bytes_of() / 1e6
        (out / "price.csv").write_text(f"{spent:.3f},{megabytes:.1f}", encoding="utf-8")
        return seconds

    def run_job(self, work: job.Job) -> Run:
        """A scene that is not of inputs/validation, priced like the others; kept where it stands."""
        if self.repeats(work.out) or not (work.out / "price.csv").is_file():
            shutil.rmtree(work.out, ignore_errors=True)
            work.out.mkdir(parents=True)
            self._run(work.command(), str(work.scene.folder), work.out)
        self._pay(work.out)
        return Run(work.out)


def keys_of(settings: Mapping) -> dict:
    """Without the case's own names."""
    return {name: value for name, value in settings.items() if "." in name}


def overrides(settings: Mapping) -> list[str]:
    return [f"{key}={_toml(value)}" for key, value in keys_of(settings).items()]


def contact_settings(settings: Mapping) -> dict[str, str]:
    """The variable of that name of in.liggghts, where the case sets it."""
    steps = settings.get("collision_steps")
    return {"contact_settings": f"collisionSteps {steps}"} if steps is not None else {}


# --- The cases --------------------------------------------------------------------------------------


def array_drag(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Drag of a dense array in Stokes flow, volume fraction 0.216 (Zick and Homsy)."""
    fraction = 0.216
    cells = round(n * validation_steady._array_edge(fraction))
    step = {}
    if "step" in settings:
        h = validation_steady._array_edge(fraction) / cells
        step = {"time.step": settings["step"] * validation_steady.DIFFUSION * h * h}
    drag, _ = validation_steady._array(runner, label, fraction, cells, **keys_of(settings), **step)
    return drag / validation_steady.ZICK_HOMSY[fraction] - 1.0


SETTLED, SETTLING_REFERENCE = 4.0, 16


def settling(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Velocity of a settling sphere (Ga 144, density ratio 1.5) at t = 4 D/u_g in a box 4 D wide, beside the
    run with sixteen cells to a diameter."""

    def velocity(name: str, cells: int, more: dict) -> float:
        step = more.get("step", 1.0) * min(0.3 / cells, 0.18 * 144.0 / cells**2)
        _, _, u = validation_moving._settle(
            runner, name, 144.0, 1.5, 1.285, cells, SETTLED, width=4.0, step=step, **keys_of(more)
        )
        return float(u[-1])

    with runner.unpaid():
        reference = velocity("settling-reference", SETTLING_REFERENCE, SINGLE)
    return velocity(label, int(n), settings) / reference - 1.0


def rebound(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """First peak after the rebound from a wall, St = 152 (Gondret et al.)."""
    more = keys_of(settings)
    variables = {"dem_steps": settings.get("coupling.dem_steps", 15), **contact_settings(settings)}
    for name in ("film", "model"):
        if name in settings:
            variables[name] = settings[name]
    step = settings.get("step", 1.0) * 1.5e-3 / n
    peak = validation_moving._rebound(
        runner, label, int(n), width=5, step=step, variables=variables, **more
    )[2]
    return peak / 0.003 / 2.489 - 1.0


CHANNEL_TIME, CHANNEL_VISCOSITY = 0.1, 0.1


def channel_exact(y: np.ndarray, time: float) -> np.ndarray:
    """Velocity between plates at y = 0 and 1 after a constant force 1 set in on fluid at rest,

        u = (y(1-y)/2 - sum_odd 4/(n pi)^3 sin(n pi y) exp(-n^2 pi^2 nu t)) / nu.
    """
    u = 0.5 * y * (1.0 - y)
    for n in range(1, 60, 2):
        k = n * np.pi
        u = u - 4.0 / k**3 * np.sin(k * y) * np.exp(-(k**2) * CHANNEL_VISCOSITY * time)
    return u / CHANNEL_VISCOSITY


def channel(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Profile between plates that a force sets into motion, beside the exact one: root mean square over
    the largest velocity. `n` cells from plate to plate."""
    cells = int(n)
    h = 1.0 / cells
    step = settings.get("step", 1.0) * 0.2 * h * h / CHANNEL_VISCOSITY
    end = CHANNEL_TIME / CHANNEL_VISCOSITY
    small = SmallScene(
        (1.0, 1.0, 1.0), cells, CHANNEL_VISCOSITY, end / round(end / step), end,
        keys={"flow.driving": '"pressure_gradient"', "flow.pressure_gradient": "1.0"},
    )  # fmt: skip
    folder = runner.folder / label
    small.write(folder)
    run = runner.run_job(job.Job(Scene(folder), None, job.Ranks(1, 1), folder / "out", overrides(settings)))
    shot = run.last_snapshot()
    y = 0.5 * (shot.y[1:] + shot.y[:-1])
    exact = channel_exact(y, shot.time)
    return float(np.sqrt(np.mean((np.mean(shot.u, axis=(0, 2)) - exact) ** 2)) / np.max(exact))


GRAINS_FROM, GRAINS_TO, GRAINS_REFERENCE = 4.0, 13.0, 10


def grains(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Mean velocity of the 125 grains of setup2_small from t = 4 to 13 D/u_b, beside the run with ten cells
    to a diameter and all else as the scene has it."""
    scene = Scene(INPUTS / "setup2_small")

    def velocity(name: str, cells: int, more: dict) -> float:
        folder = runner.folder / name
        use, model = scene, more.get("model", "actm_hw")
        if more.get("film") == "none":
            folder.mkdir(parents=True, exist_ok=True)
            use = without_lubrication(scene, model, folder)
        values = {
            "grid.cells": [26 * cells, 10 * cells, 13 * cells],
            "time.step": more.get("step", 1.0) * 0.65 / cells, "time.end": GRAINS_TO,
            "output.fields_every": 0.0,
        } | keys_of(more)  # fmt: skip
        run = runner.run_job(job.Job(use, model, job.Ranks(1, 1), folder / "out",
                                 overrides(values), variables=contact_settings(more)))  # fmt: skip
        total, rows = 0.0, 0
        for block in run.sample_blocks(since=GRAINS_FROM):
            total += float(np.sum(block.velocity[:, 0]))
            rows += len(block)
        return total / rows

    with runner.unpaid():
        reference = velocity("grains-reference", GRAINS_REFERENCE, {})
    return velocity(label, int(n), settings) / reference - 1.0


# --- The knobs ---------------------------------------------------------------------------------------

DOUBLE, SINGLE = {"accuracy.precision": "double"}, {"accuracy.precision": "single"}


def resolution(*values: int) -> list[tuple]:
    return [(f"D/h {m}", "D/h", m, {}) for m in values]


STEPS = [(f"{f:g} x dt", "CFL", 0, {"step": f}) for f in (0.5, 1.5)]
PRECISION = [("double", "precision", 0, DOUBLE)]
LOOPS = [
    *((f"{m} loops", "forcing loops", 0, {"spheres.forcing_loops": m}) for m in (2, 4)),
    ("slip 1e-3", "slip tolerance", 0, {"spheres.forcing_loops": 10, "spheres.slip_tolerance": 1e-3}),
]  # fmt: skip
MARKERS = [
    *((f"retraction {r:g} h", "marker retraction", 0, {"spheres.retraction": r}) for r in (0.0, 0.2)),
    ("no old pressure", "old pressure", 0, {"spheres.pressure_share": 0.0}),
]
IMPLICIT = [("implicit", "diffusion", 0, {"fluid.diffusion": "implicit"})]
DEM = [
    *((f"{m} DEM steps", "DEM steps", 0, {"coupling.dem_steps": m}) for m in (30, 60)),
    *((f"per step, {m} DEM", "exchange", 0,
       {"coupling.exchange": "step", "coupling.dem_steps": m}) for m in (15, 1)),
]  # fmt: skip
CONTACTS = [
    *((f"collision {m} steps", "collision time", 0, {"collision_steps": m}) for m in (5, 20)),
]
FINE_LOOPS = ("D/h 14, 2 loops", "pair", 14, {"spheres.forcing_loops": 2})


@dataclass(frozen=True)
class Case:
    """standard: cells to a diameter of the preset `standard`; knobs: (label, knob, D/h or 0, settings)."""

    error: Callable[[PricedRunner, str, float, dict], float]
    standard: int
    knobs: list[tuple]
    presets: bool = True


CASES: dict[str, Case] = {
    "array_drag": Case(
        array_drag, 10, [*resolution(6, 8, 14), *PRECISION, *LOOPS, *MARKERS, *IMPLICIT, *STEPS[:1], FINE_LOOPS]
    ),
    "channel": Case(
        channel, 20, [*resolution(10, 14, 28), *PRECISION, *IMPLICIT, *STEPS[:1],
                      ("implicit, 5 x dt", "pair", 0, {"fluid.diffusion": "implicit", "step": 5.0})],
    ),
    "settling": Case(
        settling, 10, [*resolution(6, 8, 14), *PRECISION, *LOOPS[:1], *MARKERS[:1], *IMPLICIT, *STEPS,
                       DEM[2], DEM[3]],
    ),
    "rebound": Case(
        rebound, 10, [*resolution(6, 8, 14), *PRECISION, *LOOPS, *MARKERS, *IMPLICIT, *STEPS, *DEM, *CONTACTS,
                      ("rpm", "collision model", 0, {"model": "rpm"}),
                      ("no film", "lubrication", 0, {"film": "range 1e-12"}),
                      ("published film", "lubrication", 0, {"film": " "}),
                      ("D/h 14, 0.5 x dt", "pair", 14, {"step": 0.5})],
    ),
    "grains": Case(
        grains, 6, [*resolution(8), *LOOPS[:1], *STEPS[:1], *DEM, *CONTACTS,
                    ("rpm_hw", "collision model", 0, {"model": "rpm_hw"}),
                    ("actm", "tangential model", 0, {"model": "actm"}),
                    ("no film", "lubrication", 0, {"film": "none"})],
        presets=False,
    ),
}  # fmt: skip


def choices(case: str) -> list[tuple[str, str, float, dict]]:
    """(label, knob, D/h, settings) of every point of a case; all in single precision unless told."""
    found = CASES[case]
    points = [("base", "-", found.standard, SINGLE)]
    points += [(label, knob, n or found.standard, SINGLE | more) for label, knob, n, more in found.knobs]
    for name, preset in PRESETS.items() if found.presets else ():
        settings = {"accuracy.precision": preset.precision}
        if preset.forcing_loops:
            settings["spheres.forcing_loops"] = preset.forcing_loops
        points.append((f"preset {name}", "preset", round(preset.resolution * found.standard), settings))
    return points
