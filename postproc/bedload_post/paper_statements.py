"""What the paper says, beside the numbers of a comparison: each statement right or wrong here.

Vowinckel, Kempe, Froehlich, "Impact of collision models on particle transport in open channel flow". The
numbers are the dictionaries of models_report.numbers; nothing else is looked at, so every sentence follows
from them. A statement about runs that are not there, or within their intervals, is neither right nor wrong.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .model_figures import MODELS

CRITICAL_SHIELDS = 0.035
TABLE_2 = {model: entry[2] for model, entry in MODELS.items()}
BED_RE_TAU, BED_SHIELDS = 219.0, 0.0241  # of Setup II
RE_TAU = {1: 263.0, 2: BED_RE_TAU}
FAR = 0.2  # of the paper's value: further off asks for an experiment
SAME_SPREAD = 0.1  # by which the spread of y may change and count as unchanged
ROLLS = 0.2  # |L_slip|/L below which a grain rolls
PEAK = 1.5  # times the spin without friction


@dataclass(frozen=True)
class Verdict:
    """A statement of the paper and what the runs give."""

    place: str  # "Fig. 11", "Table 2"
    statement: str
    holds: bool | None  # None: not to be told from these runs
    found: str

    @property
    def word(self) -> str:
        return {True: "right", False: "wrong", None: "open"}[self.holds]


Runs = dict[str, dict]  # the numbers of one density ratio by model


def by_ratio(values: Sequence[dict]) -> dict[float, Runs]:
    """The numbers by density ratio and model."""
    ratios = sorted({v["density_ratio"] for v in values})
    return {r: {v["model"]: v for v in values if v["density_ratio"] == r} for r in ratios}


def _name(model: str) -> str:
    return MODELS[model][0]


def compare(a: dict, b: dict, name: str) -> int | None:
    """1 where a's value is above b's by more than both intervals, -1 below, 0 within; None unknown."""
    if any(v.get(word) is None for v in (a, b) for word in (name, f"{name}_interval")):
        return None
    half = math.hypot(a[f"{name}_interval"], b[f"{name}_interval"])
    difference = a[name] - b[name]
    if math.isnan(half) or math.isnan(difference):
        return None
    return 0 if abs(difference) <= half else (1 if difference > 0 else -1)


def above(order: int | None) -> bool | None:
    """Whether "a is above b" holds: open where the intervals do not part them."""
    return None if order is None or order == 0 else order > 0


def both(*answers: bool | None) -> bool | None:
    """Right where all are, wrong where one is, else open."""
    if any(answer is False for answer in answers):
        return False
    return None if any(answer is None for answer in answers) else True


def _pairs(runs: Runs) -> list[tuple[str, str]]:
    """Models with and without friction that are both there."""
    return [(plain, f"{plain}_hw") for plain in ("rpm", "actm") if {plain, f"{plain}_hw"} <= set(runs)]


def _with_interval(v: dict, name: str, digits: int = 3) -> str:
    return f"{v[name]:.{digits}f} ± {v[f'{name}_interval']:.{digits}f}"


def velocities(runs: Runs) -> list[Verdict]:
    """Table 2, model by model: within 20 % of the paper's value."""
    found = []
    for model, paper in TABLE_2.items():
        if model in runs:
            v = runs[model]
            off = v["mean_velocity"] / paper - 1.0
            half = v["mean_velocity_interval"] / paper
            # Off, but the interval reaches into the 20 %: open.
            holds = True if abs(off) <= FAR else False if abs(off) - half > FAR else None
            found.append(Verdict(
                "Table 2", f"{_name(model)}: mean velocity {paper} u_b (within {100 * FAR:.0f} %)",
                holds, f"{_with_interval(v, 'mean_velocity')} u_b, {100 * off:+.0f} %",
            ))  # fmt: skip
    return found


def order(runs: Runs) -> list[Verdict]:
    """rpm > rpm + HW > actm > actm + HW, neighbour by neighbour."""
    there = [model for model in MODELS if model in runs]
    found = []
    for fast, slow in zip(there, there[1:], strict=False):
        answer = above(compare(runs[fast], runs[slow], "mean_velocity"))
        found.append(Verdict(
            "Table 2", f"{_name(fast)} is faster than {_name(slow)}", answer,
            f"{_with_interval(runs[fast], 'mean_velocity')} and "
            f"{_with_interval(runs[slow], 'mean_velocity')} u_b",
        ))  # fmt: skip
    return found


def slowing(runs: Runs) -> list[Verdict]:
    """By how much friction slows: the share itself, within 20 % of a hundred."""
    found = []
    for plain, rough in _pairs(runs):
        paper = 1.0 - TABLE_2[rough] / TABLE_2[plain]
        a, b = runs[plain], runs[rough]
        here = 1.0 - b["mean_velocity"] / a["mean_velocity"]
        # Of the ratio: relative intervals add in squares.
        half = (1.0 - here) * math.hypot(
            a["mean_velocity_interval"] / a["mean_velocity"],
            b["mean_velocity_interval"] / b["mean_velocity"],
        )
        found.append(Verdict(
            "Table 2", f"friction slows {_name(plain)} by {100 * paper:.0f} %",
            told(here, half, paper),
            f"by {100 * here:.0f} ± {100 * half:.0f} %",
        ))  # fmt: skip
    return found


def told(here: float, half: float, paper: float) -> bool | None:
    """Whether an effect is the paper's: wrong where the interval leaves the paper's value out, right where
    it holds that one and not zero, open where it holds both."""
    if math.isnan(half):
        return None
    if abs(here - paper) > half:
        return False
    return True if abs(here) > half else None


def spreads(runs: Runs) -> list[Verdict]:
    """Fig. 10: rpm rides higher and spreads wider; friction leaves the spread as it is."""
    found = []
    if {"rpm", "actm"} <= set(runs):
        rpm, actm = runs["rpm"], runs["actm"]
        found.append(Verdict(
            "Fig. 10", "rpm's grains ride higher than actm's", above(compare(rpm, actm, "mean_height")),
            f"mean y {_with_interval(rpm, 'mean_height')} D and {_with_interval(actm, 'mean_height')} D",
        ))  # fmt: skip
        found.append(Verdict(
            "Fig. 10", "and their height spreads wider", above(compare(rpm, actm, "spread_of_height")),
            f"spread {rpm['spread_of_height']:.3f} D and {actm['spread_of_height']:.3f} D",
        ))  # fmt: skip
    for plain, rough in _pairs(runs):
        a, b = runs[plain]["spread_of_height"], runs[rough]["spread_of_height"]
        found.append(Verdict(
            "Fig. 10", f"friction does not change the spread of y of {_name(plain)} (by up to "
            f"{100 * SAME_SPREAD:.0f} %)", abs(b / a - 1.0) <= SAME_SPREAD, f"{a:.3f} to {b:.3f} D",
        ))  # fmt: skip
    return found


def spin_peaks(runs: Runs) -> list[Verdict]:
    """Fig. 11: with friction omega_3 has a strong peak next to the bed."""
    found = []
    for plain, rough in _pairs(runs):
        a, b = runs[plain], runs[rough]
        low, high, without = (
            b.get("spin_next_to_bed"), b.get("spin_above"), a.get("spin_next_to_bed")
        )  # fmt: skip
        answer, text = None, "too few samples"
        if low is not None and without is not None:
            strong = abs(low) > PEAK * abs(without)
            answer = strong and (high is None or abs(low) > abs(high))
            text = (
                f"largest mean ω₃ next to the bed {low:.2f} u_b/D at y = {b['spin_peak_height']:.2f} D, "
                + ("" if high is None else f"{high:.2f} above it, ") + f"{without:.2f} without friction"
            )
        found.append(Verdict("Fig. 11", f"{_name(rough)}: a peak of ω₃ next to the bed", answer, text))
    return found


def spins_in_flight(runs: Runs) -> list[Verdict]:
    """Fig. 7: without friction rpm's grains spin more while they jump than actm's."""
    if not {"rpm", "actm"} <= set(runs):
        return []
    a, b = (runs[m].get("jumping_spin") for m in ("rpm", "actm"))
    if a is None or b is None:
        return [Verdict("Fig. 7", "jumping, rpm spins more than actm", None, "too few jumps")]
    return [Verdict(
        "Fig. 7", "jumping, rpm spins more than actm (mean |ω₃|)",
        above(compare(runs["rpm"], runs["actm"], "jumping_spin")), f"{a:.3f} and {b:.3f} u_b/D",
    )]  # fmt: skip


def jumps(runs: Runs) -> list[Verdict]:
    """actm's grains jump lower than rpm's."""
    found = []
    for soft, hard in (("rpm", "actm"), ("rpm_hw", "actm_hw")):
        if {soft, hard} <= set(runs):
            a, b = runs[soft]["mean_jump_height"], runs[hard]["mean_jump_height"]
            known = a is not None and b is not None
            found.append(Verdict(
                "jump heights", f"{_name(hard)} jumps lower than {_name(soft)}",
                above(compare(runs[soft], runs[hard], "mean_jump_height")),
                f"{b:.3f} and {a:.3f} D" if known else "too few jumps",
            ))  # fmt: skip
    return found


def rolling(runs: Runs) -> list[Verdict]:
    """With friction creeping grains roll: L_slip is about zero."""
    found = []
    for _, rough in _pairs(runs):
        slip = runs[rough]["creeping_slip"]
        found.append(Verdict(
            "L_slip while creeping", f"{_name(rough)}: grains roll (|L_slip|/L up to {ROLLS})",
            None if slip is None else abs(slip) <= ROLLS,
            "nothing creeps" if slip is None else f"L_slip/L = {slip:.2f}",
        ))  # fmt: skip
    return found


def motion(runs: Runs) -> list[Verdict]:
    """Shields' criterion: below the critical number no more than a tenth of the grains moves."""
    found = []
    for model in MODELS:
        if model in runs and runs[model].get("bed_shields") is not None:
            v = runs[model]
            below = v["bed_shields"] < CRITICAL_SHIELDS
            half = v["share_moving_interval"]
            clear = abs(v["share_moving"] - 0.1) > half
            little = v["share_moving"] <= 0.1
            text = "less" if below else "more"
            found.append(Verdict(
                "Shields", f"{_name(model)}: {text} than 10 % of the grains move, as the bed's Shields number "
                f"{v['bed_shields']:.4f} demands (critical {CRITICAL_SHIELDS})",
                little == below if clear else None, f"{100 * v['share_moving']:.0f} % move, faster than 0.01 u_b",
            ))  # fmt: skip
    return found


def friction(setup: int, runs: Runs) -> list[Verdict]:
    """Re_tau of the bed, within 20 %."""
    first = next(iter(runs.values()))
    name = "bed_re_tau" if setup == 2 else "re_tau"
    if first.get(name) is None:
        return [Verdict("Re_τ", f"{RE_TAU[setup]:.0f}", None, "the bed without grains was not run")]
    off = first[name] / RE_TAU[setup] - 1.0
    return [Verdict(
        "Re_τ", f"{RE_TAU[setup]:.0f} (within {100 * FAR:.0f} %)", abs(off) <= FAR,
        f"{first[name]:.0f}, {100 * off:+.0f} %",
    )]  # fmt: skip


def density_effects(values: Sequence[dict]) -> list[Verdict]:
    """Fig. 9: light grains jump, heavy ones creep and rest; the models differ most for the heavy."""
    ratios = by_ratio(values)
    if len(ratios) < 2:
        return []
    light, heavy = ratios[min(ratios)], ratios[max(ratios)]
    found = []
    for model in MODELS:
        if model in light and model in heavy:
            for state, more in (("jumping", False), ("resting", True)):
                a, b = light[model], heavy[model]
                answer = above(compare(b, a, f"share_{state}") if more else compare(a, b, f"share_{state}"))
                word = "more" if more else "less"
                found.append(Verdict(
                    "Fig. 9", f"{_name(model)}: heavy grains are {state} {word} than light ones", answer,
                    f"{100 * a[f'share_{state}']:.0f} % at {min(ratios):g}, "
                    f"{100 * b[f'share_{state}']:.0f} % at {max(ratios):g}",
                ))  # fmt: skip
    there = [m for m in MODELS if m in light and m in heavy]
    if len(there) > 1:
        def between(runs: Runs) -> float:
            return max(
                max(runs[m][f"share_{s}"] for m in there) - min(runs[m][f"share_{s}"] for m in there)
                for s in ("resting", "creeping", "jumping")
            )

        little, much = between(light), between(heavy)
        found.append(Verdict(
            "Fig. 9", "the models' shares differ more for heavy grains than for light ones", much > little,
            f"by up to {100 * little:.0f} points at {min(ratios):g}, {100 * much:.0f} at {max(ratios):g}",
        ))  # fmt: skip
    return found


SETUP_1: tuple[Callable[[Runs], list[Verdict]], ...] = (spins_in_flight, jumps, rolling)
SETUP_2: tuple[Callable[[Runs], list[Verdict]], ...] = (
    velocities, order, slowing, spreads, spin_peaks, jumps, rolling, motion,
)  # fmt: skip


def verdicts(setup: int, values: Sequence[dict]) -> list[Verdict]:
    """All statements on `setup` (1 or 2) that its runs can be asked for; none for other scenes."""
    if setup not in (1, 2):
        return []
    found = []
    for ratio, runs in by_ratio(values).items():
        known = {model: v for model, v in runs.items() if model in MODELS}
        if not known:
            continue
        for question in SETUP_1 if setup == 1 else SETUP_2:
            at = f", ρp/ρf {ratio:g}" if setup == 1 else ""
            found += [Verdict(v.place + at, v.statement, v.holds, v.found) for v in question(known)]
    known_values = [v for v in values if v["model"] in MODELS]
    if setup == 1:
        found += density_effects(known_values)
    if known_values:
        found += friction(setup, {v["model"]: v for v in known_values})
    return found


def far_off(setup: int, values: Sequence[dict]) -> list[tuple[dict, float]]:
    """Runs whose mean velocity is further than 20 % from the paper's, with how far."""
    if setup != 2:
        return []
    found = []
    for v in values:
        if v["model"] in TABLE_2:
            off = v["mean_velocity"] / TABLE_2[v["model"]] - 1.0
            if abs(off) > FAR:
                found.append((v, off))
    return found


def experiments(model: str, scene: str, cells: str) -> list[tuple[str, str]]:
    """Commands that vary one cause of a difference at a time: (what is asked, command)."""
    line = f"./bedload study models --scene {scene} --models {model} --no-bed --cells {cells}"
    finer = f"./bedload study models --scene {scene} --models {model} --no-bed --cells"
    asked = [
        ("the resolution", f"{finer} 20 --flow-throughs 10 --out runs/fine"),
        ("the box", f"{line.replace(scene, 'setup2')} --set accuracy.precision='\"single\"' "
         "--set start.from='\"logarithmic\"' --flow-throughs 10 --discard 4 --out runs/large"),
    ]  # fmt: skip
    if model.startswith("rpm"):
        return [
            ("the range, twice the paper's", f"{line} --var repulsion_range=0.2 --out runs/range"),
            ("the strength", f"{line} --var repulsion_time=0.35 --out runs/strength"), *asked,
        ]  # fmt: skip
    return [
        ("the rule for enduring contact", f"{line} --var enduring=biegert --out runs/enduring"),
        ("the collision time", f"{line} --var collision_time=0.7 --out runs/time"),
        ("the film, the paper's on top of the grid's",
         f"{line} --var film_range=0.1 --var 'lubrication_settings=law published' --out runs/film"),
        *asked,
    ]  # fmt: skip
