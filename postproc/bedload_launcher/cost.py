"""What a scene will cost, from trials of the same scene on grids that the machine holds easily.

With s = cells along x / cells along x of the larger trial, the time of a step is scaled part by part:

    markers                      s^2        (they lie on surfaces)
    pressure                     s^3 log    (the fast transforms: log of the cells of a plane)
    exchange, waiting            1          (the same grains)
    everything else of the fluid s^3

Memory of the fluid is a + b s^2 + c s^3: the program itself, which a trial of the smallest grid without
spheres shows, markers, fields; two trials with spheres give b and c. To the steps come what each of them
writes, by a longer trial; fields and checkpoints as often as the scene has them, s^3; and the start.

A scene of up to MANY_CELLS cells is its own only trial and nothing is scaled.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from . import job
from .errors import UserError
from .trial import Trial, run_trial
from .words import last_sentence

MANY_CELLS = 3_000_000  # a trial's largest grid: some 240 MB, far outside the caches
STEPS = 10
LONGER = 4  # times as many in one of the repeats, which tells what each step writes
REPEATS = 3  # of the larger trial: other work on the machine only ever adds time
ROW_BYTES = 152  # of a mobile sphere in a sample: 19 numbers (fluid/output/sphere_writer.hpp)
LEAST_CELLS = 16  # along each edge, of the trial that shows the program's own memory


@dataclass(frozen=True)
class Estimate:
    """What the scene needs from its start to its end."""

    cells: tuple[int, int, int]
    steps: int
    step_seconds: float
    output_seconds: float  # of all steps, fields and checkpoints, and the start
    fluid_bytes: float
    dem_bytes: float
    trial_cells: tuple[int, int, int]
    falling_reynolds: float | None = None  # of the mobile spheres, where they have weight
    cells_per_layer: float | None = None  # in their boundary layer D/sqrt(Re)
    mobile_spheres: int = 0
    samples: int = 0  # of the mobile spheres in spheres.h5

    @property
    def seconds(self) -> float:
        return self.steps * self.step_seconds + self.output_seconds


def smaller_grids(cells: tuple[int, int, int], most: int = MANY_CELLS) -> list[tuple[int, int, int]]:
    """The two trial grids, the larger first: the scene's proportions, whole numbers of cells.

    The larger has at most `most` cells, the smaller between an eighth and 0.6 of the larger: as many as
    possible, since a scene may not bear fewer cells to a sphere. Both are no slower to transform than the
    scene's own grid, where there are such.
    """
    unit = math.gcd(*cells)
    volume = math.prod(cells)
    slowest = max(7, largest_factor(cells))  # FFTW is fast for factors up to 7

    def sizes(limit: float) -> list[int]:
        fitting = [m for m in range(1, unit + 1) if volume * (m / unit) ** 3 <= limit]
        fast = [m for m in fitting if largest_factor([n * m // unit for n in cells]) <= slowest]
        return fast or fitting

    large = sizes(most)
    if not large:
        raise UserError(
            f"{cells[0]} x {cells[1]} x {cells[2]} cells have no smaller grid of the same "
            "proportions to try; choose cells with a common divisor."
        )
    first = large[-1]
    small = [m for m in sizes(0.6 * volume * (first / unit) ** 3) if m >= first / 2]
    # A grid that no smaller one matches is tried alone: all its memory but the program's goes as s^3.
    return [shrunk(cells, m, unit) for m in [first, *small[-1:]]]


def shrunk(cells: tuple[int, int, int], m: int, unit: int) -> tuple[int, int, int]:
    """`cells` times m / unit."""
    return cells[0] * m // unit, cells[1] * m // unit, cells[2] * m // unit


def largest_factor(cells: Sequence[int]) -> int:
    """Largest prime factor of the numbers of cells along x and z, which are transformed."""
    left, factor = cells[0] * cells[2], 2
    while factor * factor <= left:
        if left % factor == 0:
            left //= factor
        else:
            factor += 1
    return left


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
        checkpoint_seconds=min(t.checkpoint_seconds for t in trials),
        start_seconds=min(t.start_seconds for t in trials),
        fluid_bytes=max(t.fluid_bytes for t in trials),
        dem_bytes=max(t.dem_bytes for t in trials),
    )


def fluid_memory(sizes: list[float], found: list[float], program: float) -> float:
    """a + b s^2 + c s^3 at s = 1, with a = `program`, from what was found at `sizes` (one or two).

    One trial, or two that lie on no such curve with b and c above 0: all but the program goes as s^3.
    """
    cells = [size**3 for size in sizes]
    above = [bytes_ - program for bytes_ in found]
    if len(sizes) == 2:
        # above / s^2 = b + c s
        high, low = (a / size**2 for a, size in zip(above, sizes, strict=True))
        c = (high - low) / (sizes[0] - sizes[1])
        b = high - c * sizes[0]
        if b > 0.0 and c > 0.0:
            return program + b + c
    return program + above[0] / cells[0]


def writings(settings: dict, steps: int, seconds: float) -> tuple[float, float]:
    """How often fields and checkpoints are written, both once more at the end."""
    end, every = settings["time"]["end"], settings["output"]["fields_every"]
    keep = settings.get("checkpoint", {})
    by_time, by_clock = keep.get("every", 0.0), keep.get("wall_every", 0.0)
    fields = 1 + (math.floor(end / every) if every > 0 else 0)
    checkpoints = 1 + (math.floor(end / by_time) if by_time > 0 else 0)
    return fields, checkpoints + (math.floor(seconds / by_clock) if by_clock > 0 else 0)


def from_trials(
    cells: tuple[int, int, int], trials: list[Trial], longer: Trial | None = None,
    program_bytes: float = 0.0,
) -> Estimate:  # fmt: skip
    """The estimate for a grid of `cells`.

    trials: the larger grid first; longer: the larger one over more steps; program_bytes: memory of the
    fluid's program without a grid to speak of.
    """
    larger = trials[0]
    sizes = [t.cells[0] / cells[0] for t in trials]
    volume = 1.0 / sizes[0] ** 3
    time = larger.settings["time"]
    # The step that time.cfl allows goes with the cell.
    step = min(time["step"], larger.cfl_step * sizes[0])
    steps = math.ceil(time["end"] / step - 1e-6)
    step_seconds = sum(s * scale(part, cells, larger.cells) for part, s in larger.step_parts.items())
    each = 0.0
    if longer and longer.steps > larger.steps:
        each = max(0.0, longer.output_seconds - larger.output_seconds) / (longer.steps - larger.steps)
    once = max(0.0, larger.output_seconds - each * larger.steps)
    fields, checkpoints = writings(larger.settings, steps, steps * step_seconds)
    return Estimate(
        cells,
        steps,
        step_seconds + each * volume,
        (fields * once + checkpoints * larger.checkpoint_seconds) * volume + larger.start_seconds,
        fluid_memory(sizes, [t.fluid_bytes for t in trials], program_bytes),
        larger.dem_bytes,
        larger.cells,
        larger.derived.get("falling_reynolds"),
        layer_on(cells, larger),
        larger.mobile_spheres,
        samples_of(larger.settings, steps),
    )


def samples_of(settings: dict, steps: int) -> int:
    """Instants of which spheres.h5 holds the mobile spheres: the start, and each output.spheres_every."""
    every = settings["output"].get("spheres_every", 0.0)
    return 1 + (min(steps, math.floor(settings["time"]["end"] / every + 1e-6)) if every > 0.0 else steps)


def layer_on(cells: tuple[int, int, int], trial: Trial) -> float | None:
    """Cells in the boundary layer of a freely falling sphere on the grid `cells`."""
    found = trial.derived.get("cells_per_layer")
    return None if found is None else found * cells[0] / trial.cells[0]


def smallest_grid(cells: tuple[int, int, int]) -> tuple[int, int, int]:
    """The scene's proportions with at least LEAST_CELLS along each edge."""
    unit = math.gcd(*cells)
    m = min(unit, math.ceil(LEAST_CELLS * unit / min(cells)))
    return shrunk(cells, m, unit)


def on_grid(overrides: Sequence[str], grid: tuple[int, int, int]) -> list[str]:
    return [*overrides, f"grid.cells=[{grid[0]}, {grid[1]}, {grid[2]}]"]


def estimate(
    whole: job.Job, cells: tuple[int, int, int], say: Callable[[str], None], most: int = MANY_CELLS
) -> Estimate:
    """Runs the trials of `whole`, whose grid has `cells`, on at most `most` cells, and scales them."""
    trials: list[Trial] = []
    longer = None
    grids = smaller_grids(cells, most)
    if grids[0] == cells:
        del grids[1:]  # nothing is scaled, so its memory needs no parts
    for grid in grids:
        say(f"bedload: trying {STEPS} steps on {grid[0]} x {grid[1]} x {grid[2]} cells")
        work = replace(whole, overrides=on_grid(whole.overrides, grid), steps=STEPS)
        if not trials:
            longer = run_trial(replace(work, steps=LONGER * STEPS))
            trials.append(fastest([*(run_trial(work) for _ in range(REPEATS - 1)), longer]))
            continue
        try:
            trials.append(run_trial(work))
        except UserError as error:
            say(f"bedload: the scene does not run on that one ({reason(str(error))}); the other's memory is "
                "scaled by cells")  # fmt: skip
    program = program_memory(whole, cells) if grids[0] != cells else 0.0
    return from_trials(cells, trials, longer, program)


def reason(words: str) -> str:
    """The program's own sentence out of all that a trial has said, without the source line that LIGGGHTS adds."""
    sentence = last_sentence(words).split(": ", 1)[-1].removeprefix("ERROR: ")
    return re.sub(r" \([^()\s]+\.[ch]pp:\d+\)$", "", sentence).rstrip(".")


def program_memory(whole: job.Job, cells: tuple[int, int, int]) -> float:
    """Peak memory of the fluid's ranks without spheres on the smallest grid; 0 where that does not run."""
    line = on_grid([*whole.overrides, 'spheres.file=""'], smallest_grid(cells))
    work = replace(whole, overrides=line, steps=2, fluid_alone=True)
    try:
        return run_trial(work).fluid_bytes
    except UserError:
        return 0.0


def duration(seconds: float) -> str:
    """Seconds as a person says them: 41 s, 12 min, 3.4 h, 2.6 days."""
    for size, unit in ((86400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.1f} s"


def memory(bytes_: float) -> str:
    """Bytes as a person says them: 2.31 GB, 240 MB, 23.1 kB."""
    if bytes_ >= 1e9:
        return f"{bytes_ / 1e9:.2f} GB"
    return f"{bytes_ / 1e6:.0f} MB" if bytes_ >= 1e6 else f"{bytes_ / 1e3:.1f} kB"


def layer_verdict(cells: float) -> str:
    """What fluid/immersed_boundary/README.md has found with so many cells in the layer, under "Limits"."""
    if cells < 0.5:
        return ": fewer than were ever tried; a run warns"
    if cells < 0.9:
        return ": right for a steady fall, too few for an oblique wake"
    if cells < 1.5:
        return ": right for a steady fall; an oblique wake leans too little"
    return ": right for a steady fall and an oblique wake"


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
    if e.falling_reynolds is not None and e.cells_per_layer is not None:
        lines.append(
            f"boundary layer {e.cells_per_layer:.2g} cells (D/sqrt(Re) of a grain that falls freely, Re "
            f"{e.falling_reynolds:.3g}){layer_verdict(e.cells_per_layer)}"
        )
    if e.mobile_spheres > 0:
        lines.append(
            f"spheres.h5     {memory(ROW_BYTES * e.mobile_spheres * e.samples)}: {e.mobile_spheres} mobile "
            f"spheres, {e.samples} samples (output.spheres_every)"
        )
    if e.trial_cells != e.cells:
        lines.append("scaled from    " + " x ".join(map(str, e.trial_cells)) + " cells")
    if total > available:
        lines.append("It does not fit into this machine's memory.")
    return "\n".join(lines)
