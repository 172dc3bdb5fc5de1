"""Intervals of short records, at least as wide as a long one says.

The batches of a record of T flow-throughs know nothing of swings slower than T: they rise and fall together, and the
interval that they give is too narrow. The longest record of the same scene and settings, at any resolution, has
seen those swings. If its batches, as if independent, give its mean over T_l to +- L, means over T scatter about the
true one by

    L sqrt(T_l/T)

(95 %; the scatter of means that are long beside the memory falls as the root of their length). No interval of a
record of at most a quarter of the longest one's length is taken to be narrower. That the swings of a coarser grid are
those of a finer one is assumed. Records of programs that kept no L serve for the mean velocity, whose batches' memory
they have kept, and for what has intervals without it.
"""

import math
from collections.abc import Sequence

from .batches import without_memory

LONGER = 4.0  # times as long as the record whose intervals it widens
# The quantities with intervals, but for those that the width of a bin decides.
QUANTITIES = (
    "mean_velocity", "mean_height", "spread_of_height", "mean_jump_height", "share_resting", "share_creeping",
    "share_jumping", "share_moving", "jumping_spin", "spin_peak", "moving_spin_peak", "spin_above", "creeping_slip",
)  # fmt: skip
OF_SERIES = ("mean_velocity", "mean_height", "share_resting", "share_creeping", "share_jumping", "share_moving")
WIDENED = "widened"  # of a run: what its intervals are widened from
# What of a record's runs is needed.
NEEDED = ("model", "density_ratio", "flow_throughs", "cells_per_diameter", "batches", "batch_memory", *(
    f"{name}_interval{word}" for name in QUANTITIES for word in ("", "_if_independent")
))  # fmt: skip


def half_if_independent(run: dict, name: str) -> float | None:
    """L of a quantity; None where the record has kept too little for it."""
    if name not in OF_SERIES:
        return run.get(f"{name}_interval")
    if f"{name}_interval_if_independent" in run:
        return run[f"{name}_interval_if_independent"]
    half = run.get(f"{name}_interval")
    if name != "mean_velocity" or half is None or "batch_memory" not in run:
        return None
    return without_memory(half, run["batches"], run["batch_memory"])


def longest_of(run: dict, others: Sequence[dict]) -> dict | None:
    """The longest of `others` with model and density ratio of `run`; None where none is LONGER times as long."""
    same = [
        v for v in others
        if (v["model"], v["density_ratio"]) == (run["model"], run["density_ratio"])
        and half_if_independent(v, "mean_velocity") is not None
    ]  # fmt: skip
    longest = max(same, key=lambda v: v["flow_throughs"], default=None)
    if longest is None or longest["flow_throughs"] < LONGER * run["flow_throughs"]:
        return None
    return longest


def widened(run: dict, others: Sequence[dict]) -> dict:
    """`run` with intervals no narrower than the longest of `others` says (all dictionaries of model_numbers.numbers, of
    the same scene and settings); unchanged where none is long enough."""
    longest = longest_of(run, others)
    if longest is None:
        return run
    found = dict(run, interval_too_narrow=longest.get("interval_too_narrow", False))
    longer = math.sqrt(longest["flow_throughs"] / run["flow_throughs"])
    for name in QUANTITIES:
        own = run.get(f"{name}_interval")
        known = half_if_independent(longest, name)
        if own is not None and known is not None:
            found[f"{name}_interval"] = max(own, longer * known)
    found[WIDENED] = {
        "flow_throughs": longest["flow_throughs"],
        "cells_per_diameter": longest.get("cells_per_diameter"),
        "mean_velocity_interval": run["mean_velocity_interval"],
    }
    return found


def widened_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """From which length on intervals were widened and by how much that of the mean velocity was; empty for none."""
    found = [(name, v) for name, v in zip(names, values, strict=True) if WIDENED in v]
    if not found:
        return ""
    sources = sorted({(v[WIDENED]["flow_throughs"], v[WIDENED]["cells_per_diameter"]) for _, v in found})
    told = " and ".join(dict.fromkeys(
        f"{length:.3g} flow-throughs" + (f" at {cells:.3g} cells" if cells else "") for length, cells in sources
    ))  # fmt: skip
    changes = []
    for name, v in found:
        own, now = v[WIDENED]["mean_velocity_interval"], v["mean_velocity_interval"]
        changes.append(f"{name} ± {now:.3f}" + (f" in place of {own:.3f}" if now > own else ", its own"))
    return (
        f"Short records do not see slow swings. No interval here is narrower than means of this length scatter in the "
        f"longest record beside these, of {told}: mean velocity of {'; '.join(changes)}."
    )
