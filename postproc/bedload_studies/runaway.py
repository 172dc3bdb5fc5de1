"""Whether a run that was stopped had a reason for its speeds. No study of its own.

The CFL limit stops a run whose flow is too fast for its step. That is honest where the case itself brings such
speeds: an impact squeezes the film out of a gap. A speed that grows without a cause until the limit stops it
is an instability, only caught.
"""

import math
from pathlib import Path

import numpy as np
from bedload_post.outputs import MissingOutput, Run

from .small_scenes import SmallScene
from .trajectories import Trajectories

MARGIN = 1.5  # over what explains a speed: a stream is faster between spheres than on the mean
SWING = 6  # steps of alternating sign with growing size: five in a row by chance are one in a thousand
GROWTH, ROWS = 10.0, 10  # of the flow's largest speed, without a fall in so many rows
GAP = 0.25  # D: nearer than that two spheres squeeze fluid out, faster than they are themselves


def explained_speed(scene: SmallScene) -> float:
    """The largest speed [U] that the scene itself brings: what moves at its start, with the surface's
    turning, three times the stream, a fall through the box in a vacuum."""
    moving = max((math.hypot(*b.velocity) + 0.5 * b.diameter * math.hypot(*b.spin) for b in scene.balls), default=0.0)
    keys = ("start.velocity", "flow.bulk_velocity")
    stream = max((abs(float(scene.keys[key])) for key in keys if key in scene.keys), default=0.0)
    return moving + 3.0 * stream + math.sqrt(2.0 * scene.gravity * scene.length[1])


def growing_swing(velocity: np.ndarray, least: float) -> bool:
    """Whether the last steps of any component swing to and fro, each by more than the one before, and
    by more than `least`. velocity: (m, n, 3)."""
    change = np.diff(velocity, axis=0)[-SWING:]
    if len(change) < SWING:
        return False
    turns = np.all(change[1:] * change[:-1] < 0.0, axis=0)
    grows = np.all(np.abs(change[1:]) > np.abs(change[:-1]), axis=0)
    return bool(np.any(turns & grows & (np.abs(change[-1]) > least)))


def growing_flow(largest: np.ndarray) -> bool:
    """Whether the flow's largest speed rose in each of the last rows, GROWTH times in all."""
    last = largest[-ROWS:]
    return len(last) == ROWS and bool(np.all(np.diff(last) > 0.0)) and last[-1] > GROWTH * last[0]


def without_cause(out: Path, scene: SmallScene) -> str:
    """Why the run in `out`, which was stopped, is unstable; empty where its speeds have a cause."""
    allowed = explained_speed(scene)
    try:
        history = Run(out).history()
        with np.errstate(divide="ignore", invalid="ignore"):
            flow = history["cfl"] * scene.cell / history["dt"]
    except MissingOutput:
        flow = np.zeros(0)
    try:
        t = Trajectories.of(out)
    except MissingOutput:
        return "the flow's speed grows without cause" if growing_flow(flow) else ""
    if not np.isfinite(t.velocity).all():
        return "a sphere's velocity is no number"
    if t.fastest() > MARGIN * allowed:
        return f"a sphere has {t.fastest() / allowed:.2g} times the speed that the case explains"
    if growing_swing(t.velocity, 0.05 * allowed):
        return "a sphere swings, more with each step"
    if growing_flow(flow) and t.overlaps()[-1] < -GAP:
        return "the flow's speed grows without cause"
    return ""
