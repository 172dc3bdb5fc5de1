"""What a scene will cost, from trials of the same scene on grids that the machine holds easily.

Two trials at different numbers of cells give the memory as a line in the number of cells. The time
of a step is taken part by part from the larger one and scaled to the scene's own grid with
s = cells along x / cells along x of the trial:

    markers                      s^2        (they lie on surfaces)
    pressure                     s^3 log    (the fast transforms: log of the cells of a plane)
    exchange, waiting            1          (the same grains)
    everything else of the fluid s^3

A scene of up to MANY_CELLS cells is its own larger trial and nothing is scaled.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from . import job
from .errors import UserError
from .scenes import Scene
from .trial import Trial, run_trial

MANY_CELLS = 3_000_000  # a trial's largest grid: some 240 MB, far outside the caches
STEPS = 10
REPEATS = 3  # of the larger trial: other work on the machine only ever adds time


@dataclass(frozen=True)
class Estimate:
    """What the scene needs from its start to its end."""

    cells: tuple[int, int, int]
    steps: int
    step_seconds: float
    output_seconds: float
    fluid_bytes: float
    dem_bytes: float
    trial_cells: tuple[int, int, int]

    @property
    def seconds(self) -> float:
        return self.steps * self.step_seconds + self.output_seconds


def smaller_grids(cells: tuple[int, int, int], most: int = MANY_CELLS) -> list[tuple[int, int, int]]:
    """The two trial grids, the larger first: the scene's proportions, whole numbers of cells.

    The larger has at most `most` cells, the smaller between an eighth and 0.6 of the larger: as many as
    possible, since a scene may not bear fewer cells to a sphere.
    """
    unit = math.gcd(*cells)
    volume = math.prod(cells)

    def sizes(limit: float) -> list[int]:
        return [m for m in range(1, unit + 1) if volume * (m / unit) ** 3 <= limit]

    large = sizes(most)
    if not large:
        raise UserError(
            f"{cells[0]} x {cells[1]} x {cells[2]} cells have no smaller grid of the same "
            "proportions to try; choose cells with a common divisor."
        )
    first = large[-1]
    small = [m for m in sizes(0.6 * volume * (first / unit) ** 3) if m >= first / 2]
    # A grid that no smaller one matches is tried once: its memory is taken as proportional.
    chosen = [first] + small[-1:]
    return [tuple(n * m // unit for n in cells) for m in chosen]


def scale(part: str, cells: tuple[int, int, int], trial: tuple[int, int, int]) -> float:
    """How many times dearer `part` is on `cells` than on `trial` (the module's table)."""
    s = cells[0] / trial[0]
    if part == "markers":
        return s**2
    if part in ("exchange", "waiting for LIGGGHTS"):
        return 1.0
    if "pressure" in part:
        return s**3 * math.log(cells[0] * cells[2]) / math.log(trial[0] * trial[2])
    return s**3


def fastest(trials: list[Trial]) -> Trial:
    """The same trial repeated: each part's smallest time, the largest memory."""
    return replace(
        trials[0],
        step_parts={
            part: min(t.step_parts[part] for t in trials) for part in trials[0].step_parts
        },
        output_seconds=min(t.output_seconds for t in trials),
        fluid_bytes=max(t.fluid_bytes for t in trials),
        dem_bytes=max(t.dem_bytes for t in trials),
    )


def line_through(x: list[float], y: list[float], at: float) -> float:
    """The line through two points at `at`; one point: proportional."""
    if len(x) == 1:
        return y[0] * at / x[0]
    slope = (y[0] - y[1]) / (x[0] - x[1])
    return y[0] + slope * (at - x[0])


def from_trials(cells: tuple[int, int, int], trials: list[Trial]) -> Estimate:
    """The estimate for a grid of `cells`; the larger trial comes first."""
    settings = trials[0].settings
    volumes = [float(math.prod(t.cells)) for t in trials]
    volume = float(math.prod(cells))
    time = settings["time"]
    every = settings["output"]["fields_every"]
    writings = 1 + (math.floor(time["end"] / every) if every > 0 else 0)
    larger = trials[0]
    # The step that time.cfl allows goes with the cell.
    step = min(time["step"], larger.cfl_step * larger.cells[0] / cells[0])
    return Estimate(
        cells,
        math.ceil(time["end"] / step - 1e-6),
        sum(s * scale(part, cells, larger.cells) for part, s in larger.step_parts.items()),
        writings * larger.output_seconds * volume / volumes[0],
        line_through(volumes, [t.fluid_bytes for t in trials], volume),
        larger.dem_bytes,
        larger.cells,
    )


def estimate(
    scene: Scene, model: str | None, ranks: job.Ranks, overrides: list[str],
    cells: tuple[int, int, int], say: Callable[[str], None],
) -> Estimate:  # fmt: skip
    """Runs the trials of `scene`, whose own grid has `cells`, and scales them."""
    trials = []
    for grid in smaller_grids(cells):
        say(f"bedload: trying {STEPS} steps on {grid[0]} x {grid[1]} x {grid[2]} cells")
        line = [*overrides, f"grid.cells=[{grid[0]}, {grid[1]}, {grid[2]}]"]
        work = job.Job(scene, model, ranks, scene.folder, line, STEPS)
        if not trials:
            trials.append(fastest([run_trial(work) for _ in range(REPEATS)]))
            continue
        try:
            trials.append(run_trial(work))
        except UserError:
            say("bedload: the scene does not run on that one; its memory is taken as proportional")
    return from_trials(cells, trials)


def duration(seconds: float) -> str:
    """Seconds as a person says them: 41 s, 12 min, 3.4 h, 2.6 days."""
    for size, unit in ((86400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def memory(bytes_: float) -> str:
    return f"{bytes_ / 1e9:.2f} GB" if bytes_ >= 1e9 else f"{bytes_ / 1e6:.0f} MB"


def describe(e: Estimate, ranks: job.Ranks, moves_grains: bool, available: float) -> str:
    """The estimate as lines for the terminal."""
    nx, ny, nz = e.cells
    total = e.fluid_bytes + e.dem_bytes
    share = f" (fluid {memory(e.fluid_bytes)}, LIGGGHTS {memory(e.dem_bytes)})" if moves_grains else ""
    lines = [
        f"cells          {nx} x {ny} x {nz} = {math.prod(e.cells) / 1e6:.3g} million",
        f"memory         {memory(total)}{share}; free here: {memory(available)}",
        f"time of a step {e.step_seconds:.3g} s on {ranks.fluid} fluid ranks",
        f"to the end     {e.steps} steps, {duration(e.seconds)}"
        f" = {e.seconds * ranks.fluid / 3600:.3g} core-hours",
    ]
    if e.trial_cells != e.cells:
        lines.append("scaled from    " + " x ".join(map(str, e.trial_cells)) + " cells")
    if total > available:
        lines.append("It does not fit into this machine's memory.")
    return "\n".join(lines)
