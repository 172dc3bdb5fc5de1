"""Friction velocity over a bed of grains."""

import math

import numpy as np

from . import flow_statistics
from .batches import batches_of, estimate
from .flow_statistics import FlowStatistics
from .outputs import MissingOutput, Run

MOST_BEFORE = 0.1  # of the statistics' time


def bed_stress(statistics: FlowStatistics, bed_top: float, clear: float) -> float:
    """tau [M/(L T^2)] at `bed_top`, extrapolated from above `clear`, where no sphere takes part in it.

    There the balance is tau = f (top - y) with f the driving force; f by least squares.
    """
    face = statistics["y_face"]
    depth = face[-1] - face
    rows = face >= clear
    if rows.sum() < 3:
        raise MissingOutput("statistics.h5 has no heights above the grains.")
    force = (statistics.total_stress[rows] * depth[rows]).sum() / (depth[rows] ** 2).sum()
    return float(force * (face[-1] - bed_top))


def driving_friction(run: Run, since: float) -> float:
    """u_tau = sqrt(|f| H/rho) [L/T] of the mean driving force f from `since` on; nan without rows."""
    history = run.history()
    driving = history["driving"][history["time"] >= since]
    mean = abs(np.mean(driving)) if len(driving) else math.nan
    return math.sqrt(mean * run.depth / run.value("fluid.density"))


def driving_friction_interval(run: Run, since: float) -> float:
    """Half width of the 95 % interval of driving_friction [L/T], half of the force's in relation; nan where the record
    is too short."""
    history = run.history()
    rows = history["time"] >= since
    if rows.sum() < 2:
        return math.nan
    throughs = (history["time"][rows][-1] - since) * run.bulk_velocity / run.box[0]
    force = estimate(history["driving"][rows], batches_of(throughs))
    return driving_friction(run, since) * 0.5 * force.half_width / abs(force.mean) if force.mean else math.nan


def friction_velocity(run: Run, since: float) -> tuple[float, str]:
    """u_tau [L/T] and where it is from: total stress at the bed's top, else the driving force.

    In the mean both are the same number: the driving force times the depth is what the bed with its
    grains takes up. Statistics over less than half of the time from `since` on are not used, nor those of which more
    than MOST_BEFORE is earlier: they hold the start-up.
    """
    bed_top = run.box[1] - run.depth
    density = run.value("fluid.density")
    history = run.history()
    try:
        statistics = flow_statistics.read(run)
        covered = statistics.end - max(statistics.begin, since)
        late = covered >= (1.0 - MOST_BEFORE) * (statistics.end - statistics.begin)
        stress = bed_stress(statistics, bed_top, bed_top + 0.4 * run.depth)
        if stress > 0 and late and covered >= 0.5 * (history["time"][-1] - since):
            return math.sqrt(stress / density), "total stress extrapolated to the bed's top"
    except MissingOutput:
        pass
    friction = driving_friction(run, since)
    if not friction > 0:
        raise MissingOutput(f"history.csv of {run.folder} has no driving force after t = {since:g}.")
    return friction, "driving force times depth"
