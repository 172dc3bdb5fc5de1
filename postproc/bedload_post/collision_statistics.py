"""What the collisions of a run are like: Stokes number of the impact, duration over T_c, overlap.

    St = rho_p u_n D/(9 mu)

with the normal impact speed u_n. T_c and the other scales of the collision model are what LIGGGHTS' log says
of them; a model without T_c has durations alone.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .outputs import Run

STOKES_EDGES = np.geomspace(1e-3, 1e2, 51)
DURATION_EDGES = np.geomspace(1e-2, 1e3, 51)  # T/T_c
OVERLAP_EDGES = np.geomspace(1e-7, 1e-1, 61)  # of D
SCALE = re.compile(r"^scale: (.+?): (.+?) = (\S+)$", re.MULTILINE)
DURATION = ("normal model actm", "collision time")
STOKES_LIMITS = (1.0, 5.0)  # of Kempe & Froehlich 2012, of Biegert et al. 2017


@dataclass(frozen=True)
class CollisionStatistics:
    """One value a collision; `duration` in T_c, nan where the model has none."""

    stokes: np.ndarray
    duration: np.ndarray
    overlap: np.ndarray  # in D, nan in tables without it

    def __len__(self) -> int:
        return len(self.stokes)

    def share_below(self, stokes: float) -> float:
        """Share of the collisions with a smaller Stokes number; nan without collisions."""
        return float(np.mean(self.stokes < stokes)) if len(self) else float("nan")

    def quantiles(self, name: str, at: Sequence[float] = (0.05, 0.5, 0.95)) -> list[float]:
        """Of one of the columns; nan where there are no values."""
        values = getattr(self, name)
        values = values[np.isfinite(values)]
        return [float(q) for q in np.quantile(values, at)] if len(values) else [float("nan")] * len(at)


def scales(run: Run) -> dict[tuple[str, str], float]:
    """Ranges and durations of the collision model by (style, what), as LIGGGHTS' log has them."""
    found: dict[tuple[str, str], float] = {}
    for file in [*sorted(run.folder.glob("log.part*.liggghts")), run.folder / "log.liggghts"]:
        if file.is_file():
            text = file.read_text(encoding="utf-8", errors="replace")
            found |= {(style, what): float(value) for style, what, value in SCALE.findall(text)}
    return found


def collision_statistics(run: Run, since: float = 0.0) -> CollisionStatistics:
    """Of the collisions that begin from `since` on."""
    table = run.collision_columns("time_start", "time_end", "impact_speed_normal", "largest_overlap")
    start, end, speed, overlap = (column for column in table)
    kept = start >= since
    density = run.value("reference.sphere_density")
    viscosity = run.viscosity * run.value("fluid.density")
    stokes = density * np.maximum(speed[kept], 0.0) * run.diameter / (9.0 * viscosity)
    time = scales(run).get(DURATION, np.nan)
    return CollisionStatistics(stokes, (end - start)[kept] / time, overlap[kept] / run.diameter)
