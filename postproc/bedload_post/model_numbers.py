"""Every number of a model comparison for one run, as plain values: what numbers.json keeps.

The pages, the sentences and the paper's statements are made from these alone, so those of a kept record can be made
anew without its run.
"""

from dataclasses import dataclass

import numpy as np

from . import neighbours
from .batches import Estimate
from .bed_friction import bed_top, friction_velocity
from .collision_statistics import STOKES_LIMITS, CollisionStatistics, collision_statistics, scales
from .model_figures import Case
from .outputs import MissingOutput, Run
from .states import JUMPING, NAMES, RESTING
from .transport import Transport, measure

MOST_SEPARATE = 20  # grains that may be meant to be far from each other
NEXT_TO_BED, ABOVE = (0.0, 1.0), (1.0, 1.5)  # of the grains' centres over the bed's top, in D


@dataclass(frozen=True)
class Bed:
    """Friction of a bed without mobile grains."""

    u_tau: float  # over u_b
    reynolds: float  # u_tau H/nu
    source: str
    reynolds_interval: float = float("nan")

    def shields(self, run: Run) -> float:
        """u_tau^2 rho_f/((rho_p - rho_f) g D) of the grains of `run` on this bed."""
        stress = run.value("fluid.density") * (self.u_tau * run.bulk_velocity) ** 2
        return stress / (run.submerged_weight * run.diameter)

    def numbers(self, run: Run) -> dict:
        """Its numbers beside those of `run`; relative intervals double in the square of u_tau."""
        half = _known(self.reynolds_interval)
        found: dict = {"bed_re_tau": self.reynolds, "bed_re_tau_interval": half, "bed_u_tau_from": self.source}
        shields = self.shields(run) if run.submerged_weight else None
        found["bed_shields"] = shields
        found["bed_shields_interval"] = (
            None if half is None or shields is None else 2.0 * shields * half / self.reynolds
        )
        return found


def make_case(model: str, run: Run, flow_throughs: float) -> Case:
    """A run measured from `flow_throughs` L_x/u_b on."""
    since = flow_throughs * run.box[0] / run.bulk_velocity
    return Case(model, run, since, measure(run, since))


def numbers(case: Case, bed: Bed | None = None) -> dict:
    """Every number of the report for one run, as plain values; `bed`: without mobile grains."""
    run, t = case.run, case.transport
    through = run.box[0] / run.bulk_velocity
    time = np.concatenate(t.time)
    velocity = t.mean("velocity")
    phases = t.phases
    jump, jump_half = t.mean_jump_height(run.diameter)
    collisions = collision_statistics(run, case.since)
    low, low_half = t.low_height()
    slip, slip_half = t.slip_ratio()
    spread, spread_half = t.spread_of_height()
    spin, spin_half = t.mean_spin(JUMPING)
    found = {
        "model": case.model,
        "density_ratio": case.density_ratio,
        "flow_throughs": float((time[-1] - time[0]) / through),
        "discarded_flow_throughs": case.since / through,
        "grains": len(np.unique(phases.tag)),
        **_estimated("mean_velocity", velocity),
        "batches": len(velocity.batches),
        "batch_memory": velocity.memory,
        "interval_too_narrow": velocity.too_narrow((time[-1] - time[0]) / through),
        **_estimated("mean_height", t.mean("height")),
        "spread_of_height": spread,
        "spread_of_height_interval": _known(spread_half),
        "mean_spin": t.mean("spin").mean,
        "jumps": int(phases.jumps().sum()),
        "mean_jump_height": _known(jump),
        "mean_jump_height_interval": _known(jump_half),
        **_estimated("share_moving", t.mean("moving")),
        "jumping_spin": _known(spin),
        "jumping_spin_interval": _known(spin_half),
        "cells_per_diameter": run.diameter / (run.box[0] / run.value("grid.cells")[0]),
        "scales": {f"{style}: {what}": v for (style, what), v in scales(run).items()},
        "box_length": run.box[0] / run.diameter,
        "low_height": _known(low),
        "low_height_interval": _known(low_half),
        **spin_over_height(t, bed_top(run) / run.diameter),
        "profiles": profiles(t),
        **collision_numbers(collisions),
        **drift("velocity", *t.halves("velocity")),
        **drift("resting", *t.halves("share", RESTING)),
        "creeping_slip": _known(slip),
        "creeping_slip_interval": _known(slip_half),
        **friction_numbers(run, case.since),
    }
    if 1 < found["grains"] <= MOST_SEPARATE:
        near = neighbours.measure(run, case.since)
        if near is not None:
            found |= {"neighbours": near.sentence(), "share_near": near.share_near}
    if bed is not None:
        found |= bed.numbers(run)
    for state, name in enumerate(NAMES):
        found |= _estimated(f"share_{name}", t.share_of(state))
    return found


def friction_numbers(run: Run, since: float) -> dict:
    """u_tau and what follows from it, the grains' drag included; None, and why, where there is no friction velocity."""
    found: dict = dict.fromkeys(("u_tau", "re_tau", "d_plus", "shields"))
    try:
        friction, found["u_tau_from"] = friction_velocity(run, since)
    except MissingOutput as missing:
        return found | {"u_tau_from": str(missing)}
    reynolds, weight = friction * run.depth / run.viscosity, run.submerged_weight * run.diameter
    return found | {
        "u_tau": friction / run.bulk_velocity, "re_tau": reynolds, "d_plus": reynolds * run.diameter / run.depth,
        "shields": run.value("fluid.density") * friction**2 / weight if weight else None,
    }  # fmt: skip


def _estimated(name: str, found: Estimate) -> dict:
    """A mean with its interval, and the interval without the batches' memory for shorter records (least_intervals)."""
    return {
        name: found.mean,
        f"{name}_interval": found.half_width,
        f"{name}_interval_if_independent": _known(found.half_width_if_independent),
    }


def _known(value: float) -> float | None:
    """None for what JSON has no word for."""
    return float(value) if np.isfinite(value) else None


def spin_over_height(transport: Transport, top: float) -> dict:
    """Largest mean omega_3 in a slice of 0.1 D up to a diameter over the bed's top (at y/D `top`), of all grains
    and of those that do not rest, with its height, and the mean farther up; None without samples there."""
    found: dict = {"spin_peak_height": None}
    all_grains = transport.coarse_profile(1)
    near, far = ([top + height for height in reach] for reach in (NEXT_TO_BED, ABOVE))
    moving = transport.coarse_profile(1, resting=False).largest(*near)
    peak = all_grains.largest(*near)
    for name, value in (("spin_peak", peak), ("moving_spin_peak", moving), ("spin_above", all_grains.between(*far))):
        found[name], found[f"{name}_interval"] = (None, None) if value is None else value[:2]
    if peak is not None:
        found["spin_peak_height"] = peak[2]
    return found


def profiles(transport: Transport) -> dict:
    """Mean omega_3 D/u_b and u_p/u_b over the height y/D with the half widths of their intervals."""
    found: dict = {}
    for row, name in ((1, "spin"), (2, "velocity")):
        profile = transport.coarse_profile(row)
        found["height"] = [round(float(y), 3) for y in profile.height]
        found[name] = [round(float(m), 5) for m in profile.mean]
        found[f"{name}_interval"] = [round(float(h), 5) for h in profile.half]
    return found


def collision_numbers(found: CollisionStatistics) -> dict:
    """How many, how slow, how long and how deep."""
    numbers: dict = {"collisions": len(found)}
    for limit in STOKES_LIMITS:
        numbers[f"collisions_below_stokes_{limit:g}"] = _known(found.share_below(limit))
    for name in ("stokes", "duration", "overlap"):
        numbers[f"{name}_quantiles"] = [_known(q) for q in found.quantiles(name)]
    return numbers


def drift(name: str, first: Estimate, second: Estimate) -> dict:
    """Means of both halves, and whether they differ by more than their intervals."""
    half = float(np.hypot(first.half_width, second.half_width))
    return {
        f"{name}_halves": [first.mean, second.mean],
        f"{name}_halves_interval": _known(half),
        f"{name}_drifts": second.is_apart_from(first) if np.isfinite(half) else None,
    }
