"""The presets of `--accuracy`: how finely any scene is computed.

A preset changes the scene's grid in proportion (so that boxes and beds stay what they are), the time
step with it at the same Courant number, the storage precision and the forcing loops. `standard` leaves
the scene as its author made it, but for the precision.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from . import verdicts
from .build import ROOT
from .errors import UserError, unknown
from .scenes import Scene
from .words import read_rows, say

MEASURED = ROOT / "postproc" / "reports" / "accuracy" / "accuracy.csv"
RESOLUTIONS = {6: "D/h 6", 8: "D/h 8", 10: "base", 14: "D/h 14"}  # labels there of cells to a diameter


@dataclass(frozen=True)
class Preset:
    """resolution: cells per length over the scene's own; forcing_loops 0: the scene's own."""

    resolution: float
    precision: str
    forcing_loops: int
    sentence: str


PRESETS = {
    "draft": Preset(0.8, "single", 1, "a coarser grid in single precision"),
    "standard": Preset(1.0, "double", 0, "the scene's own grid in double precision"),
    "fine": Preset(1.4, "double", 0, "a finer grid in double precision"),
}
AUTO = "auto"
SENTENCES = {name: preset.sentence for name, preset in PRESETS.items()} | {
    AUTO: "the scene without what `study effects SCENE` found certain to be left out"
}


def settings_of(name: str | None, scene: Scene, overrides: list[str], model: str | None = None) -> list[str]:
    """Values of fluid.toml for preset `name`; what the user sets comes after them and wins. `model`: of the run."""
    if name is None:
        return overrides
    if name == AUTO:
        return [*verdicts.settings_of(scene, overrides, model), *overrides]
    if name not in PRESETS:
        raise unknown("accuracy", name, SENTENCES)
    preset = PRESETS[name]
    own = [f'accuracy.precision="{preset.precision}"']
    if preset.forcing_loops and scene.moves_grains:
        own.append(f"spheres.forcing_loops={preset.forcing_loops}")
    if preset.resolution != 1.0:
        own += finer(scene, preset.resolution, name)
        warn_of_counted_steps(scene, model)
    return [*own, *overrides]


def warn_of_counted_steps(scene: Scene, model: str | None) -> None:
    """Where the time step is another one than the scene's."""
    if scene.counts_steps(model):
        say(f"bedload: WARNING: {scene.script} counts fluid steps (coupled_run steps): with another time step what "
            "stands behind them comes at another time.")  # fmt: skip


def finer(scene: Scene, resolution: float, name: str) -> list[str]:
    """The grid nearest to `resolution` times the scene's own that keeps its proportions."""
    cells = scene.cells()
    unit = math.gcd(*cells)
    times = max(1, round(resolution * unit))
    if times == unit:
        raise UserError(
            f"{scene.name} has {cells[0]} x {cells[1]} x {cells[2]} cells, which no grid near "
            f"{resolution:g} times as fine keeps in proportion, so --accuracy {name} cannot be had."
        )
    grid = [n * times // unit for n in cells]
    lines = [f"grid.cells={grid}"]
    step = scene.value("time", "step")
    if isinstance(step, int | float) and not isinstance(step, bool):  # about all else bedload-fluid has its sentence
        lines.append(f"time.step={step * unit / times!r}")
    return lines


def cases_like(scene: Scene, model: str | None, settings: Sequence[str] = ()) -> list[str]:
    """The cases of the kept study whose physics the scene has."""
    if not scene.has_spheres(settings):
        return ["channel"]
    if not scene.moves_grains:
        return ["array_drag"]
    # The rebound was measured with the adaptive collision time model and lubrication.
    return ["array_drag", "settling"] + (["rebound"] if (model or "").startswith("actm") else [])


def measured_errors(label: str, cases: list[str]) -> list[str]:
    """What the kept study found for one of its labels, one phrase a case; empty before it was ever run."""
    if not MEASURED.is_file():
        return []
    return [
        f"{row['case'].replace('_', ' ')} {100 * float(row['error']):+.1f} %"
        for row in read_rows(MEASURED)
        if row["label"] == label and row["case"] in cases
    ]


def errors_to_expect(scene: Scene, model: str | None, accuracy: str | None, settings: list[str]) -> str | None:
    """One line on the errors that the kept study found at the scene's own resolution, or at the nearest that it has:
    `settings` are those of the preset `accuracy` with what the user set."""
    cases = cases_like(scene, model, settings)
    diameter = scene.value("reference", "diameter", settings)
    if not scene.has_spheres(settings):
        label, where = f"preset {accuracy or 'standard'}", "with twenty cells from wall to wall before the preset"
    elif isinstance(diameter, int | float) and diameter > 0:
        own = diameter / scene.cell_size(settings)
        measured = min(RESOLUTIONS, key=lambda cells: abs(math.log(cells / own)))
        label, where = RESOLUTIONS[measured], f"with {measured} cells to a diameter"
        if abs(own / measured - 1.0) > 0.02:
            where += f", the nearest to this scene's {own:.3g} that was measured"
        if own < 0.98 * min(RESOLUTIONS):
            where += " (below 6 errors grow fast: Stokes drag +1.5 % with 5, +5.6 % with 4)"
    else:
        return None
    errors = measured_errors(label, cases)
    return f"{', '.join(errors)}, {where}" if errors else None
