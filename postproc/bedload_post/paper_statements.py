"""What the paper says, beside the numbers of a comparison: each statement right or wrong here.

Vowinckel, Kempe, Froehlich, "Impact of collision models on particle transport in open channel flow". The
numbers are the dictionaries of models_report.numbers; nothing else is looked at, so every sentence follows
from them. A statement is right where the whole interval agrees with it, wrong where the whole interval
contradicts it, and open in between or without the runs that it speaks of.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from .batches import half_width_of
from .incipient_motion import EXPOSED_THRESHOLD
from .model_figures import MODELS, PAPER_CELLS

CRITICAL_SHIELDS = 0.035
TABLE_2 = {model: entry[2] for model, entry in MODELS.items()}
BED_RE_TAU, BED_SHIELDS = 219.0, 0.0241  # of Setup II
RE_TAU = {1: 263.0, 2: BED_RE_TAU}
RANGE = {1: 2.0 / 14.0, 2: 2.0 / 20.0}  # 2h of the paper's grids, in D
FAR = 0.2  # of the paper's value: further off asks for an experiment
SAME_SPREAD = 0.1  # by which the spread of y may change and count as unchanged
ROLLS = 0.2  # |L_slip|/L below which a grain rolls
PEAK = 1.5  # times the spin without friction
IN_MOTION = 0.1  # share of moving grains at the threshold of motion
ABOUT = 2.0  # factor either way that counts as "about"
DRASTIC = 2.0  # times as much counts as "drastically more"


@dataclass(frozen=True)
class Verdict:
    """A statement of the paper and what the runs give."""

    place: str  # "Fig. 11", "Table 2"
    subject: str  # the model that it is about, "" for several
    claim: str
    holds: bool | None  # None: not to be told from these runs
    found: str
    topic: str = ""  # the claim in short, the same for all models; "": the claim
    at: str = ""  # the density ratio, in Setup I

    @property
    def statement(self) -> str:
        return f"{self.subject}: {self.claim}" if self.subject else self.claim

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


def told_apart(a: dict, b: dict) -> bool:
    """Whether the intervals part the mean velocities of two runs; without an interval nothing is parted."""
    return compare(a, b, "mean_velocity") in (1, -1)


def exceeds(value: float, half: float, bound: float = 0.0) -> bool | None:
    """Whether `value` +- `half` lies above `bound`: open where the interval holds it, or is not known."""
    if math.isnan(value) or math.isnan(half) or abs(value - bound) <= half:
        return None
    return value > bound


def within(value: float, half: float, bound: float) -> bool | None:
    """Whether |value| is up to `bound` over the whole interval; wrong where it is so nowhere in it."""
    if math.isnan(value) or math.isnan(half):
        return None
    if abs(value) - half > bound:
        return False
    return True if abs(value) + half <= bound else None


def both(*answers: bool | None) -> bool | None:
    """Right where all are, wrong where one is, else open."""
    if any(answer is False for answer in answers):
        return False
    return None if any(answer is None for answer in answers) else True


def _pairs(runs: Runs) -> list[tuple[str, str]]:
    """Models with and without friction that are both there."""
    return [(plain, f"{plain}_hw") for plain in ("rpm", "actm") if {plain, f"{plain}_hw"} <= set(runs)]


def _with_interval(v: dict, name: str, digits: int = 3) -> str:
    half = v.get(f"{name}_interval")
    return f"{v[name]:.{digits}f}" + ("" if half is None else f" ± {half:.{digits}f}")


def _percent(change: float, half: float, sign: str = "") -> str:
    """A relative change with its interval, where it has one."""
    return f"by {100 * change:{sign}.0f}" + ("" if math.isnan(half) else f" ± {100 * half:.0f}") + " %"


def _half(v: dict, name: str, assumed: float) -> tuple[float, str]:
    """Half width of an interval, with a remark where it has none: nan where too little happened for one (kept as
    None), what is `assumed` where an older record has kept none at all."""
    if f"{name}_interval" not in v:
        return assumed, f" (its interval was not kept: ± {assumed:.2g} assumed)"
    half = v[f"{name}_interval"]
    return (math.nan, " (too little happened for an interval)") if half is None else (half, "")


def velocities(runs: Runs) -> list[Verdict]:
    """Table 2, model by model: within 20 % of the paper's value."""
    found = []
    for model, paper in TABLE_2.items():
        if model in runs:
            v = runs[model]
            off = v["mean_velocity"] / paper - 1.0
            found.append(Verdict(
                "Table 2", _name(model), f"mean velocity {paper} u_b (within {100 * FAR:.0f} %)",
                within(off, v["mean_velocity_interval"] / paper, FAR),
                f"{_with_interval(v, 'mean_velocity')} u_b, {100 * off:+.0f} %",
                f"mean velocity within {100 * FAR:.0f} % of Table 2",
            ))  # fmt: skip
    return found


def order(runs: Runs) -> list[Verdict]:
    """rpm > rpm + HW > actm > actm + HW, neighbour by neighbour."""
    there = [model for model in MODELS if model in runs]
    found = []
    for fast, slow in zip(there, there[1:], strict=False):
        answer = above(compare(runs[fast], runs[slow], "mean_velocity"))
        found.append(Verdict(
            "Table 2", "", f"{_name(fast)} is faster than {_name(slow)}", answer,
            f"{_with_interval(runs[fast], 'mean_velocity')} and "
            f"{_with_interval(runs[slow], 'mean_velocity')} u_b",
        ))  # fmt: skip
    return found


def slowing(runs: Runs) -> list[Verdict]:
    """By how much friction slows: the share itself, within 20 % of a hundred."""
    found = []
    for plain, rough in _pairs(runs):
        paper = 1.0 - TABLE_2[rough] / TABLE_2[plain]
        change, half = relative_change(runs[plain], runs[rough], "mean_velocity")
        here = 0.0 - change
        found.append(Verdict(
            "Table 2", "", f"friction slows {_name(plain)} by {100 * paper:.0f} %",
            told(here, half, paper),
            _percent(here, half) if math.isfinite(here) else "without friction nothing moves",
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
    """Fig. 10: rpm spreads wider over the height; friction leaves the spread as it is."""
    found = []
    if {"rpm", "actm"} <= set(runs):
        rpm, actm = runs["rpm"], runs["actm"]
        found.append(Verdict(
            "Fig. 10", "", "rpm's grains ride higher than actm's", above(compare(rpm, actm, "mean_height")),
            f"mean y {_with_interval(rpm, 'mean_height')} D and {_with_interval(actm, 'mean_height')} D",
        ))  # fmt: skip
        found.append(Verdict(
            "Fig. 10", "", "rpm's height spreads wider than actm's",
            above(compare(rpm, actm, "spread_of_height")),
            f"spread {_with_interval(rpm, 'spread_of_height')} D and {_with_interval(actm, 'spread_of_height')} D",
        ))  # fmt: skip
    for plain, rough in _pairs(runs):
        a, b = runs[plain], runs[rough]
        change, half = relative_change(a, b, "spread_of_height")
        found.append(Verdict(
            "Fig. 10", _name(plain), f"friction does not change the spread of y (by up to {100 * SAME_SPREAD:.0f} %)",
            within(change, half, SAME_SPREAD),
            f"{a['spread_of_height']:.3f} to {b['spread_of_height']:.3f} D"
            + (f", {_percent(change, half, '+')}" if math.isfinite(change) else ": without friction all are at one"),
            "friction does not change the spread of y",
        ))  # fmt: skip
    return found


def relative_change(a: dict, b: dict, name: str) -> tuple[float, float]:
    """b/a - 1 of a number and the half width of its interval; relative intervals add in squares."""
    if not a[name]:
        return math.nan, math.nan
    ratio = b[name] / a[name]
    of_a, of_b = (v.get(f"{name}_interval") for v in (a, b))
    half = math.nan if of_a is None or of_b is None else math.hypot(ratio * of_a, of_b) / abs(a[name])
    return ratio - 1.0, half


def riding(setup: int, runs: Runs) -> list[Verdict]:
    """rpm's grains ride about 2h of the paper's grid above where actm's lie, and faster.

    The height is that below which the lowest twentieth lies: in the pockets, not in jumps.
    """
    if not {"rpm", "actm"} <= set(runs):
        return []
    rpm, actm = runs["rpm"], runs["actm"]
    paper = RANGE[setup]
    answer, text = None, "the record has kept no height of the lowest grains"
    if all(v.get(f"low_height{word}") is not None for v in (rpm, actm) for word in ("", "_interval")):
        gap = rpm["low_height"] - actm["low_height"]
        half = math.hypot(rpm["low_height_interval"], actm["low_height_interval"])
        # About: by a factor of two either way.
        answer = both(exceeds(gap, half, paper / ABOUT), exceeds(ABOUT * paper, half, gap))
        text = (
            f"a twentieth lies below {_with_interval(rpm, 'low_height')} D and "
            f"{_with_interval(actm, 'low_height')} D, {gap:.3f} ± {half:.3f} D apart"
        )
    return [
        Verdict("ride over the bed", "",
                f"rpm's grains ride about 2h of the paper, {paper:.2g} D, above actm's (half to twice that)",
                answer, text, "rpm's grains ride about 2h above the bed"),
        Verdict("ride over the bed", "", "rpm's grains are faster than actm's",
                above(compare(rpm, actm, "mean_velocity")),
                f"{_with_interval(rpm, 'mean_velocity')} and {_with_interval(actm, 'mean_velocity')} u_b"),
    ]  # fmt: skip


def spin_peaks(runs: Runs) -> list[Verdict]:
    """Fig. 11: with friction omega_3 of all grains at a height has a strong peak next to the bed."""
    return [
        Verdict("Fig. 11", _name(rough), "a strong peak of ω₃ next to the bed", *peak(runs[plain], runs[rough]))
        for plain, rough in _pairs(runs)
    ]


def peak(plain: dict, rough: dict) -> tuple[bool | None, str]:
    """Whether the largest mean spin next to the bed is PEAK times that without friction, and more than
    farther up; resting grains count, as in the paper's curve."""
    if any(v.get(f"spin_peak{word}") is None for v in (plain, rough) for word in ("", "_interval")):
        low, high = rough.get("spin_next_to_bed"), rough.get("spin_above")
        kept = "" if low is None or high is None else f"; largest up to y = 1.55 D {low:.2f}, above it {high:.2f} u_b/D"
        return None, f"too few samples, or the record has kept no profile{kept}"
    strong = exceeds(
        abs(rough["spin_peak"]) - PEAK * abs(plain["spin_peak"]),
        math.hypot(rough["spin_peak_interval"], PEAK * plain["spin_peak_interval"]),
    )
    text = (
        f"{_with_interval(rough, 'spin_peak', 2)} u_b/D at y = {rough['spin_peak_height']:.2f} D, "
        f"{_with_interval(plain, 'spin_peak', 2)} without friction"
    )
    moving = rough.get("moving_spin_peak")
    if moving is not None and abs(moving - rough["spin_peak"]) >= 0.005:  # resting grains dilute it
        text += f" (grains that do not rest alone: {_with_interval(rough, 'moving_spin_peak', 2)})"
    if rough.get("spin_above") is None or rough.get("spin_above_interval") is None:
        return strong, text
    lower = exceeds(
        abs(rough["spin_peak"]) - abs(rough["spin_above"]),
        math.hypot(rough["spin_peak_interval"], rough["spin_above_interval"]),
    )
    return both(strong, lower), f"{text}, {_with_interval(rough, 'spin_above', 2)} farther up"


def spins_in_flight(runs: Runs) -> list[Verdict]:
    """Fig. 7: without friction rpm's grains spin more while they jump than actm's."""
    if not {"rpm", "actm"} <= set(runs):
        return []
    a, b = runs["rpm"], runs["actm"]
    known = a.get("jumping_spin") is not None and b.get("jumping_spin") is not None
    return [Verdict(
        "Fig. 7", "", "jumping, rpm spins more than actm (mean |ω₃|)", above(compare(a, b, "jumping_spin")),
        f"{_with_interval(a, 'jumping_spin')} and {_with_interval(b, 'jumping_spin')} u_b/D"
        if known else "too few jumps",
        "jumping, rpm spins more than actm",
    )]  # fmt: skip


def jumps(runs: Runs) -> list[Verdict]:
    """actm's grains jump lower than rpm's."""
    found = []
    for soft, hard in (("rpm", "actm"), ("rpm_hw", "actm_hw")):
        if {soft, hard} <= set(runs):
            a, b = runs[soft], runs[hard]
            known = a["mean_jump_height"] is not None and b["mean_jump_height"] is not None
            kept = all(v.get("mean_jump_height_interval") is not None for v in (a, b))
            remark = "" if kept else ", without intervals"
            found.append(Verdict(
                "jump heights", "", f"{_name(hard)} jumps lower than {_name(soft)}",
                above(compare(a, b, "mean_jump_height")),
                f"{_with_interval(b, 'mean_jump_height')} and {_with_interval(a, 'mean_jump_height')} D{remark}"
                if known else "too few jumps",
            ))  # fmt: skip
    return found


def rolling(runs: Runs) -> list[Verdict]:
    """With friction creeping grains roll: L_slip is about zero."""
    found = []
    for plain, rough in _pairs(runs):
        v = runs[rough]
        answer, text = None, "nothing creeps"
        if v["creeping_slip"] is not None:
            half, remark = _half(v, "creeping_slip", 0.5 * ROLLS)
            answer = within(v["creeping_slip"], half, ROLLS)
            text = f"L_slip/L = {_with_interval(v, 'creeping_slip', 2)}{remark}"
            if runs[plain]["creeping_slip"] is not None:
                text += f", {runs[plain]['creeping_slip']:.2f} without friction"
        found.append(Verdict(
            "L_slip while creeping", _name(rough), f"grains roll (|L_slip|/L up to {ROLLS})", answer, text,
            "with friction creeping grains roll",
        ))  # fmt: skip
    return found


def motion(runs: Runs) -> list[Verdict]:
    """What the paper expects by Shields' criterion, by which it judges the models: below the critical number hardly any
    transport, here no more than a tenth of the grains. The criterion is for level beds; grains in the pockets of a
    fixed layer move earlier, which the sentences say.

    The Shields number is that of the bed without mobile grains, the paper's where that was not run.
    """
    found = []
    for model in MODELS:
        if model in runs:
            v = runs[model]
            measured = v.get("bed_shields") is not None
            number = v["bed_shields"] if measured else BED_SHIELDS
            half = _half(v, "bed_shields", 0.5 * FAR * number)[0] if measured else 0.0
            strong = exceeds(number, half, CRITICAL_SHIELDS)
            many = exceeds(v["share_moving"], v["share_moving_interval"], IN_MOTION)
            text = "more" if number > CRITICAL_SHIELDS else "less"
            whose = "the bed's Shields number" if measured else "the Shields number of the paper's bed"
            found.append(Verdict(
                "Shields", _name(model), f"{text} than {100 * IN_MOTION:.0f} % of the grains move, expected at {whose} "
                f"{number:.4f} (critical {CRITICAL_SHIELDS} for level beds, {EXPOSED_THRESHOLD:g} for exposed grains)",
                None if strong is None or many is None else many == strong,
                f"{100 * v['share_moving']:.0f} ± {100 * v['share_moving_interval']:.0f} % move, faster than 0.01 u_b",
                f"{text} than {100 * IN_MOTION:.0f} % of the grains move, as Shields' criterion for level beds has it",
            ))  # fmt: skip
    return found


def friction(setup: int, values: Sequence[dict]) -> list[Verdict]:
    """Re_tau within 20 %: of Setup II's bed without mobile grains; of Setup I, where single grains do not drag at
    the flow, the mean of all runs."""
    claim, paper = f"{RE_TAU[setup]:.0f} (within {100 * FAR:.0f} %)", RE_TAU[setup]
    if setup == 2:
        v = values[0]
        if v.get("bed_re_tau") is None:
            return [Verdict("Re_τ", "", claim, None, "the bed without grains was not run", f"Re_τ {paper:.0f}")]
        mean, (half, remark) = v["bed_re_tau"], _half(v, "bed_re_tau", 0.5 * FAR * paper)
        text = f"{mean:.0f}" + (remark or f" ± {half:.0f}")
    else:
        known = [v["re_tau"] for v in values if v["re_tau"] is not None]
        if not known:
            return [Verdict("Re_τ", "", claim, None, "no run has a friction velocity", f"Re_τ {paper:.0f}")]
        mean, half = mean_of_runs(known)
        runs = f"mean of {len(known)} run{'s' if len(known) > 1 else ''}"
        text = f"{mean:.0f}, {runs}" if math.isnan(half) else f"{mean:.0f} ± {half:.0f}, {runs}"
    off = mean / paper - 1.0
    return [Verdict(
        "Re_τ", "", claim, within(off, half / paper, FAR), f"{text}, {100 * off:+.0f} %", f"Re_τ {paper:.0f}",
    )]  # fmt: skip


def mean_of_runs(values: Sequence[float]) -> tuple[float, float]:
    """Mean of independent runs and the half width of its interval by their scatter; nan below three."""
    return math.fsum(values) / len(values), half_width_of(values)


def density_effects(values: Sequence[dict]) -> list[Verdict]:
    """Fig. 9: light grains jump, heavy ones creep and rest; the models differ most for the heavy."""
    ratios = by_ratio(values)
    if len(ratios) < 2:
        return []
    low, high = min(ratios), max(ratios)
    light, heavy = ratios[low], ratios[high]
    found = []
    for model in [m for m in MODELS if m in light and m in heavy]:
        found += density_effects_on(_name(model), light[model], heavy[model])
    there = [m for m in MODELS if m in light and m in heavy]
    if len(there) > 1:
        (little, half), (much, half_much) = (range_of_shares([r[m] for m in there]) for r in (light, heavy))
        found.append(Verdict(
            "Fig. 9", "", "the models' shares differ more for heavy grains than for light ones",
            exceeds(much - little, math.hypot(half, half_much)),
            f"by up to {100 * little:.0f} ± {100 * half:.0f} points at {low:g}, "
            f"{100 * much:.0f} ± {100 * half_much:.0f} at {high:g}",
        ))  # fmt: skip
        found.append(felt_more([light[m] for m in there], [heavy[m] for m in there]))
    return found


def density_effects_on(name: str, light: dict, heavy: dict) -> list[Verdict]:
    """What the paper's Fig. 9 says of one model's grains."""
    a, b = light["density_ratio"], heavy["density_ratio"]

    def share(v: dict, state: str) -> str:
        return f"{100 * v[f'share_{state}']:.0f} ± {100 * v[f'share_{state}_interval']:.0f} %"

    def at_both(state: str) -> str:
        return f"{share(light, state)} at {a:g}, {share(heavy, state)} at {b:g}"

    on_bed = [1.0 - v["share_jumping"] for v in (light, heavy)]
    half = math.hypot(DRASTIC * light["share_jumping_interval"], heavy["share_jumping_interval"])
    return [
        Verdict("Fig. 9", name, "light grains jump most of the time",
                exceeds(light["share_jumping"], light["share_jumping_interval"], 0.5),
                f"{share(light, 'jumping')} at {a:g}"),
        Verdict("Fig. 9", name, "heavy grains jump less than light ones",
                above(compare(light, heavy, "share_jumping")), at_both("jumping")),
        Verdict("Fig. 9", name, "heavy grains rest more than light ones",
                above(compare(heavy, light, "share_resting")), at_both("resting")),
        Verdict("Fig. 9", name, f"heavy grains creep or rest drastically more (at least {DRASTIC:g} times as long)",
                exceeds(on_bed[1] - DRASTIC * on_bed[0], half),
                f"{100 * on_bed[0]:.0f} % at {a:g}, {100 * on_bed[1]:.0f} % at {b:g}",
                "heavy grains creep or rest drastically more"),
    ]  # fmt: skip


def range_of_shares(runs: Sequence[dict]) -> tuple[float, float]:
    """Largest difference between two models in the share of a state, and the half width of its interval."""
    found = []
    for state in ("resting", "creeping", "jumping"):
        name = f"share_{state}"
        most, least = (pick(runs, key=lambda v: v[name]) for pick in (max, min))
        half = math.hypot(most[f"{name}_interval"], least[f"{name}_interval"])
        found.append((most[name] - least[name], half))
    return max(found)


def felt_more(light: Sequence[dict], heavy: Sequence[dict]) -> Verdict:
    """Heavier particles feel the model more: by how much the slowest model is slower than the fastest.

    Where heavy grains move so little that the intervals do not part the models, nothing is said.
    """
    changes, texts, apart = [], [], True
    for runs in (light, heavy):
        fast, slow = (pick(runs, key=lambda v: v["mean_velocity"]) for pick in (max, min))
        change, half = relative_change(fast, slow, "mean_velocity")
        apart = apart and told_apart(fast, slow)
        changes.append((-change, half))
        texts.append(f"by {-100 * change:.0f} ± {100 * half:.0f} % at {fast['density_ratio']:g}")
    (little, half), (much, half_much) = changes
    return Verdict(
        "heavy and light grains", "",
        "heavy grains feel the model more: the slowest is slower than the fastest by more",
        exceeds(much - little, math.hypot(half, half_much)) if apart else None,
        ", ".join(texts) + ("" if apart else "; the intervals do not part the models"),
        "heavy grains feel the model more",
    )  # fmt: skip


SETUP_1: tuple[Callable[[Runs], list[Verdict]], ...] = (
    spins_in_flight, jumps, rolling, lambda runs: riding(1, runs),
)  # fmt: skip
SETUP_2: tuple[Callable[[Runs], list[Verdict]], ...] = (
    velocities, order, slowing, spreads, lambda runs: riding(2, runs), spin_peaks, jumps, rolling, motion,
)  # fmt: skip


def verdicts(setup: int, values: Sequence[dict]) -> list[Verdict]:
    """All statements on `setup` (1 or 2) that its runs can be asked for; none for other scenes."""
    known = [v for v in values if v["model"] in MODELS]
    if setup not in (1, 2) or not known:
        return []
    found = []
    for ratio, runs in by_ratio(known).items():
        at = f"{ratio:g}" if setup == 1 else ""
        for question in SETUP_1 if setup == 1 else SETUP_2:
            found += [replace(v, at=at) for v in question(runs)]
    if setup == 1:
        found += density_effects(known)
    return found + friction(setup, known)


def opening(found: Sequence[Verdict]) -> str:
    """What a reader has to know first: where these runs contradict the paper, where they agree."""
    if not found:
        return ""
    wrong, right, unknown = ([v for v in found if v.holds is answer] for answer in (False, True, None))
    count = f"{len(found)} statement{'s' if len(found) > 1 else ''} of the paper"
    text = f"Of {count} {len(wrong)} {_are(wrong)} wrong here: {'; '.join(_topics(wrong))}." if wrong else (
        f"Of {count} none is wrong here."
    )  # fmt: skip
    if right:
        text += f" {len(right)} {_are(right)} right: {'; '.join(_topics(right))}."
    if unknown:
        text += f" {len(unknown)} {_are(unknown)} open."
    return text


def _are(found: Sequence[Verdict]) -> str:
    return "are" if len(found) > 1 else "is"


def _topics(found: Iterable[Verdict]) -> list[str]:
    """Topics with the models and densities that they are said of."""
    topics: dict[str, dict[str, list[str]]] = {}
    for v in found:
        topics.setdefault(v.topic or v.claim, {}).setdefault(v.subject, []).append(v.at)
    texts = []
    for topic, subjects in topics.items():
        named = ", ".join(
            " at ".join([subject, "/".join(ratios)] if any(ratios) else [subject]).strip()
            for subject, ratios in subjects.items()
        )
        texts.append(f"{topic} ({named})" if named else topic)
    return texts


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
    asked = [("the markers on the surface, as in the paper", f"{line} --set spheres.retraction=0 --out runs/surface")]
    if model.endswith("_hw"):
        asked.append(("the friction coefficient", f"{line} --var friction=0.5 --out runs/friction"))
    if float(cells) < PAPER_CELLS:
        asked.append(("the resolution", f"{finer} {PAPER_CELLS} --flow-throughs 10 --out runs/fine"))
    if scene != "setup2":
        asked.append((
            "the box", f"{line.replace(scene, 'setup2')} --set accuracy.precision='\"single\"' "
            "--set start.from='\"logarithmic\"' --flow-throughs 10 --discard 4 --out runs/large",
        ))  # fmt: skip
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
