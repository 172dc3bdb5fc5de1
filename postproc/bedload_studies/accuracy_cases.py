"""Cases with a known answer for `./bedload study accuracy`, and the knobs that each one turns.

A case is a function (runner, label, D/h, settings) -> error of 1. In the settings, keys of fluid.toml stand
by their names; names without a dot are the case's own: `step` (length of the time step over the case's
own), `model`, `film` (what stands behind fix lubrication), `collision_steps`.
"""

import os
import resource
import shutil
import statistics
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from bedload_launcher import job
from bedload_launcher.presets import PRESETS
from bedload_launcher.memory import MemoryWatch
from bedload_launcher.scenes import Scene
from bedload_post.batches import Estimate
from bedload_post.outputs import Run

from . import validation_arrays, validation_falls, validation_rebounds
from .effects import without_lubrication
from .scene_answers import LEAST_SECONDS, MOST_REPEATS, difference, grain_series
from .small_scenes import Ball, SmallScene
from .validation_runs import DIFFUSION, Runner, _toml


@dataclass
class PricedRunner(Runner):
    """A Runner that also notes processor time and memory; both stand in a file beside the run. A run of less than
    LEAST_SECONDS is repeated, and its median counts."""

    interval: float = 0.0  # half width of the error, where chance takes part in it
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
        spent: list[float] = []
        with MemoryWatch(os.getpid()) as memory:
            while not spent or (sum(spent) < LEAST_SECONDS and len(spent) < MOST_REPEATS):
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                seconds = super()._run(line, scene, out)
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                spent.append((after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime))
        megabytes = memory.bytes_of() / 1e6
        (out / "price.csv").write_text(f"{statistics.median(spent):.3f},{megabytes:.1f}", encoding="utf-8")
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


def model_scales(settings: Mapping, step: float, cell: float) -> dict[str, object]:
    """Variables of in.liggghts that give the collision model its scales absolutely, the defaults' of a run with this
    `step` and `cell`: else another grid or step would be another model. A number of steps where the case sets one."""
    if (steps := settings.get("collision_steps")) is not None:
        return {"contact_settings": f"collisionSteps {steps}"}
    if str(settings.get("model", "actm")).startswith("rpm"):
        return {"repulsion_time": 5.0 * step, "repulsion_range": 2.0 * cell}
    return {"collision_time": 10.0 * step}


# --- The cases --------------------------------------------------------------------------------------


# Where the sphere stands on the grid, in cells: a coarse one meets its surface by chance.
POSITIONS = ((0.0, 0.0, 0.0), (0.33, 0.17, 0.41), (0.61, 0.50, 0.27))


def over_positions(
    runner: PricedRunner, label: str, error: Callable[[str, tuple[float, float, float]], float]
) -> float:
    """Mean of `error(label, position)`; half the range is left in the runner, the price is that of one."""
    found = [error(label, POSITIONS[0])]
    with runner.unpaid():
        found += [error(f"{label}-at-{n}", place) for n, place in enumerate(POSITIONS[1:], start=2)]
    runner.interval = 0.5 * (max(found) - min(found))
    return float(np.mean(found))


def array_drag(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Drag of a dense array in Stokes flow, volume fraction 0.216 (Zick and Homsy)."""
    fraction = 0.216
    cells = round(n * validation_arrays.array_edge(fraction))
    step = {}
    if "step" in settings:
        h = validation_arrays.array_edge(fraction) / cells
        step = {"time.step": settings["step"] * DIFFUSION * h * h}

    def error(name: str, place: tuple[float, float, float]) -> float:
        drag, _ = validation_arrays.array_drag(
            runner, name, fraction, cells, offset=place, **keys_of(settings), **step
        )
        return drag / validation_arrays.ZICK_HOMSY[fraction] - 1.0

    return over_positions(runner, label, error)


SETTLED, SETTLING_REFERENCE = 4.0, 16


def settling(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Velocity of a settling sphere (Ga 144, density ratio 1.5) at t = 4 D/u_g in a box 4 D wide, beside the
    run with sixteen cells to a diameter."""

    def velocity(name: str, cells: int, more: dict) -> float:
        step = more.get("step", 1.0) * min(0.3 / cells, 0.18 * 144.0 / cells**2)
        _, _, u = validation_falls._settle(
            runner, name, 144.0, 1.5, 1.285, cells, SETTLED, width=4.0, step=step, **keys_of(more)
        )
        return float(u[-1])

    with runner.unpaid():
        reference = velocity("settling-reference", SETTLING_REFERENCE, SINGLE)
    return velocity(label, int(n), settings) / reference - 1.0


def rebound(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """First peak after the rebound from a wall, St = 152 (Gondret et al.)."""
    more, diameter, per_cells = keys_of(settings), 0.003, 1.5e-3  # SI
    standard = CASES["rebound"].standard
    scales = model_scales(settings, per_cells / standard, diameter / standard)
    variables = {"dem_steps": settings.get("coupling.dem_steps", 15), **scales}
    for name, variable in (("film", "lubrication_settings"), ("model", "model")):
        if name in settings:
            variables[variable] = settings[name]
    step = settings.get("step", 1.0) * per_cells / n

    def error(name: str, place: tuple[float, float, float]) -> float:
        peak = validation_rebounds._rebound(
            runner, name, int(n), place, width=5, step=step, variables=variables, **more
        )[2]
        return peak / diameter / 2.489 - 1.0

    return over_positions(runner, label, error)


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


GRAINS_FROM, GRAINS_TO, GRAINS_REFERENCE = 40.0, 160.0, 10
GRAINS_CELLS = 6
GRAINS_COURANT = 0.25


def grains_scene(cells: int, step: float, model: str) -> SmallScene:
    """Four grains on a bed of twenty under a stream, in a small periodic box: after GRAINS_FROM their motion
    is steady in the mean, and GRAINS_TO is some forty passages of the box later."""
    balls = [Ball((0.5 + i, 0.5, 0.5 + k), mobile=False) for i in range(5) for k in range(4)]
    places = ((1.0, 1.0), (3.0, 1.0), (1.0, 3.0), (3.0, 3.0))
    # Above the pockets by more than the repulsion of rpm reaches on the coarsest grid.
    balls += [Ball((x, 1.6, z), density=1.3) for x, z in places]
    keys = {
        "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "0.8", "start.from": '"logarithmic"',
        "start.velocity": "1.0", "start.height": "1.0", "start.disturbance": "0.2",
        "reference.velocity": "1.0", "reference.diameter": "1.0", "reference.height": "4.0",
        "output.spheres_every": "0.2",
    }  # fmt: skip
    return SmallScene(
        (5.0, 5.0, 4.0), cells, 0.005, step * GRAINS_COURANT / cells, GRAINS_TO, balls, gravity=0.3,
        y_ends=("no_slip", "free_slip"), model=model, keys=keys,
    )  # fmt: skip


def grains(runner: PricedRunner, label: str, n: float, settings: dict) -> float:
    """Mean velocity of the grains of a small moving bed, statistically steady, beside the run with ten cells to a
    diameter; the interval of 95 % of both together is left in the runner. Each model stands beside its own."""

    def velocity(name: str, cells: int, more: dict) -> Estimate:
        folder, model = runner.folder / name, more.get("model", "actm_hw")
        grains_scene(cells, more.get("step", 1.0), model).write(folder)
        use = Scene(folder)
        if more.get("film") == "none":
            use = without_lubrication(use, model, folder)
        scales = model_scales({"model": model} | more, GRAINS_COURANT / GRAINS_CELLS, 1.0 / GRAINS_CELLS)
        variables = {key: str(value) for key, value in scales.items()}
        work = job.Job(use, model, job.Ranks(1, 1), folder / "out", overrides(more), variables=variables)
        return grain_series(runner.run_job(work))["grain velocity"].mean(GRAINS_FROM)

    model = settings.get("model", "actm_hw")
    with runner.unpaid():
        reference = velocity(f"grains-reference-{model}", GRAINS_REFERENCE, SINGLE | {"model": model})
    change, runner.interval = difference(velocity(label, int(n), settings), reference)
    return change


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
    ("1.4 times the markers", "markers", 0, {"spheres.marker_density": 1.0}),
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
                      ("no film", "lubrication", 0, {"film": "viscosity 1e-12"}),
                      ("published film", "lubrication", 0, {"film": "law published"}),
                      ("D/h 14, 0.5 x dt", "pair", 14, {"step": 0.5})],
    ),
    "grains": Case(
        grains, GRAINS_CELLS, [
            *resolution(8), *LOOPS[:1], *STEPS[:1], *DEM[::2], *CONTACTS[:1],
            *((name, "collision model", 0, {"model": name}) for name in ("rpm", "rpm_hw", "actm")),
            ("no film", "lubrication", 0, {"film": "none"}),
        ],
        presets=False,
    ),
}  # fmt: skip


Choice = tuple[str, str, float, dict]


def choices(case: str) -> list[Choice]:
    """(label, knob, D/h, settings) of every point of a case; all in single precision unless told."""
    found = CASES[case]
    points: list[Choice] = [("base", "-", found.standard, SINGLE)]
    points += [(label, knob, n or found.standard, SINGLE | more) for label, knob, n, more in found.knobs]
    for name, preset in PRESETS.items() if found.presets else ():
        settings: dict[str, object] = {"accuracy.precision": preset.precision}
        if preset.forcing_loops:
            settings["spheres.forcing_loops"] = preset.forcing_loops
        points.append((f"preset {name}", "preset", round(preset.resolution * found.standard), settings))
    return points
