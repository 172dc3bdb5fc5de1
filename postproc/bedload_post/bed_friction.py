"""Friction velocity over a bed of grains."""

import math

from . import flow_statistics
from .batches import batches_of, estimate_over_time, mean_over_time
from .flow_statistics import FlowStatistics
from .outputs import MissingOutput, Run

MOST_BEFORE = 0.1  # of the statistics' time
NEAR = 0.05  # the top of a bed of grains is known no better


def two_walls(run: Run) -> bool:
    """Whether the flow is between two no-slip walls, y = 0 and the upper end of the box."""
    ends = run.settings.get("boundary", {}).get("y", "periodic")
    return set([ends] if isinstance(ends, str) else ends) == {"no_slip"}


def side_walls(settings: dict) -> bool:
    """Whether a no-slip wall along z takes a part of what drives the flow."""
    ends = settings.get("boundary", {}).get("z", "periodic")
    return "no_slip" in ([ends] if isinstance(ends, str) else ends)


def driven_height(run: Run) -> float:
    """Height [L] over which a driving force is borne by one wall or the bed on it: reference.height, between two
    no-slip walls half of the distance that the flow has there (Settings::driven_height of the fluid)."""
    if not two_walls(run):
        return run.depth
    clear = float(run.box[1]) - run.settings.get("start", {}).get("height", 0.0)
    return run.depth if abs(2.0 * run.depth - clear) <= NEAR * clear else 0.5 * run.depth


def without_stress(run: Run) -> float:
    """y [L] where in the mean no stress is: the free surface, or the middle between the bed's top and an upper wall."""
    return float(run.box[1]) - (driven_height(run) if two_walls(run) else 0.0)


def bed_top(run: Run) -> float:
    """y [L] of the top of the bed, or of the floor."""
    return without_stress(run) - driven_height(run)


def bed_stress(statistics: FlowStatistics, top: float, clear: float, without: float | None = None) -> float:
    """tau [M/(L T^2)] at the bed's `top`, extrapolated from above `clear`, where no sphere takes part in it.

    There the balance is tau = f (without - y) with f the driving force and `without` the height where no stress is,
    of its own accord the upper end of the box; f by least squares.
    """
    face = statistics["y_face"]
    without = float(face[-1]) if without is None else without
    depth = without - face
    rows = face >= clear
    if rows.sum() < 3:
        raise MissingOutput("statistics.h5 has no heights above the grains.")
    force = (statistics.total_stress[rows] * depth[rows]).sum() / (depth[rows] ** 2).sum()
    return float(force * (without - top))


def driving_friction(run: Run, since: float) -> float:
    """u_tau = sqrt(|f| H/rho) [L/T] of the driving force f, mean over the time from `since` on, H = driven_height; nan
    without rows."""
    history = run.history()
    mean = abs(mean_over_time(history["time"], history["driving"], since))
    return math.sqrt(mean * driven_height(run) / run.value("fluid.density"))


def driving_friction_interval(run: Run, since: float) -> float:
    """Half width of the 95 % interval of driving_friction [L/T], half of the force's in relation; nan where the record
    is too short."""
    history = run.history()
    rows = history["time"] >= since
    if rows.sum() < 2:
        return math.nan
    throughs = (history["time"][rows][-1] - since) * run.bulk_velocity / run.box[0]
    force = estimate_over_time(history["time"], history["driving"], since, batches_of(throughs))
    return driving_friction(run, since) * 0.5 * force.half_width / abs(force.mean) if force.mean else math.nan


def friction_velocity(run: Run, since: float) -> tuple[float, str]:
    """u_tau [L/T] and where it is from: total stress at the bed's top, else the driving force.

    In the mean both are the same number: the driving force times the depth is what the bed with its
    grains takes up. Statistics over less than half of the time from `since` on are not used, nor those of which more
    than MOST_BEFORE is earlier: they hold the start-up.
    """
    if side_walls(run.settings):
        raise MissingOutput(f"the side walls of {run.folder} bear a part of the driving force: no friction velocity.")
    without, top = without_stress(run), bed_top(run)
    density = run.value("fluid.density")
    history = run.history()
    try:
        statistics = flow_statistics.read(run)
        covered = statistics.end - max(statistics.begin, since)
        late = covered >= (1.0 - MOST_BEFORE) * (statistics.end - statistics.begin)
        stress = bed_stress(statistics, top, top + 0.4 * run.depth, without)
        if stress > 0 and late and covered >= 0.5 * (history["time"][-1] - since):
            return math.sqrt(stress / density), "total stress extrapolated to the bed's top"
    except MissingOutput:
        pass
    friction = driving_friction(run, since)
    if not friction > 0:
        raise MissingOutput(f"history.csv of {run.folder} has no driving force after t = {since:g}.")
    return friction, "driving force times depth"
