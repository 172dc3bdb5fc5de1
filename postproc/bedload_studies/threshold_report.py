"""The report of the onset of motion: two figures, tables, and what they say of each model.

All of it but the maps of motion is made from the points, which numbers.json keeps: `rewrite` makes a kept report anew.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
import numpy as np  # noqa: E402

from bedload_post import bed_motion  # noqa: E402
from bedload_post import incipient_motion as motion  # noqa: E402
from bedload_post.batches import HIGHEST_MEMORY, Estimate  # noqa: E402
from bedload_post.incipient_motion import Point, Threshold  # noqa: E402
from bedload_post.model_figures import in_order, model_label, model_line, name_models  # noqa: E402
from bedload_post.outputs import Run  # noqa: E402
from bedload_post.paper_statements import BED_SHIELDS, CRITICAL_SHIELDS, exceeds  # noqa: E402

from .kept_numbers import kept_numbers  # noqa: E402
from .log_ticks import plain_ticks  # noqa: E402


@dataclass(frozen=True)
class Experiment:
    """Everything that the report is made from."""

    scene: str
    cells_per_diameter: int
    throughs: float
    discard: float
    friction_velocity: float  # of the bed without mobile grains [L/T]
    friction_source: str
    viscosity: float
    diameter: float
    density_ratio: float
    points: Sequence[Point]
    circumstances: dict[str, str]
    friction_half_width: float = math.nan  # of friction_velocity, 95 % [L/T]
    shown: Sequence[tuple[str, Run]] = ()  # whose motion is drawn over x and time, one a model

    @property
    def setup_2(self) -> float:
        """The Shields number computed that is nearest to that of the paper's Setup II."""
        return min((p.shields for p in self.points), key=lambda theta: abs(math.log(theta / BED_SHIELDS)))

    @property
    def models(self) -> list[str]:
        return list(dict.fromkeys(p.model for p in self.points))

    def of(self, model: str) -> list[Point]:
        return sorted((p for p in self.points if p.model == model), key=lambda p: p.shields)

    @property
    def shields_threshold(self) -> float:
        return motion.shields_threshold(self.diameter, self.friction_velocity, self.viscosity)


def verdict(found: Threshold, points: Sequence[Point], expected: float) -> str:
    """What the threshold by the share in motion says beside the one expected; ascending Shields numbers."""
    if math.isnan(found.value):
        first, last = points[0], points[-1]
        if first.moving.mean - first.moving.half_width > motion.IN_MOTION:
            beside = f": begins to move earlier than Shields' curve, {expected:.4f}"
            return (
                f"its threshold lies below the lowest Shields number computed, {first.shields:g}, where "
                f"{100 * first.moving.mean:.0f} % move" + (beside if first.shields <= expected else "")
            )
        if last.moving.mean + last.moving.half_width < motion.IN_MOTION:
            return f"its threshold lies above the highest Shields number computed, {last.shields:g}"
        return (
            f"its threshold is not found among the Shields numbers computed, {first.shields:g} to "
            f"{last.shields:g}: nothing is said of it"
        )
    if found.holds(expected):
        if found.is_open_towards(expected):
            return f"{found}: cannot be told from Shields' curve, {expected:.4f}, towards which its interval is open"
        return f"{found}: agrees with Shields' curve, {expected:.4f}, within its interval"
    side = "earlier" if found.value < expected else "later"
    factors = (found.low / expected, found.high / expected)
    if side == "earlier":
        factors = (expected / found.high, expected / found.low if found.low > 0.0 else math.inf)
    return f"{found}: begins to move {side} than Shields' curve, {expected:.4f}, by a factor of {between(*factors)}"


def between(low: float, high: float) -> str:
    """An interval of factors in words; `high` may be inf."""
    return f"{low:.2f} to {high:.2f}" if math.isfinite(high) else f"at least {low:.2f}"


def beside_exposed(found: Threshold) -> str:
    """The same beside the threshold of exposed grains; empty where none was found."""
    if math.isnan(found.value):
        return ""
    exposed = motion.EXPOSED_THRESHOLD
    if found.is_open_towards(exposed):
        return f"; cannot be told from that of exposed grains, {exposed:g}"
    if found.holds(exposed):
        return f"; agrees with that of exposed grains, {exposed:g}"
    return f"; {between(found.low / exposed, found.high / exposed)} times that of exposed grains, {exposed:g}"


def opening(found: Experiment) -> str:
    """What a reader has to know first: who begins to move where, beside Shields' curve, and what moves at the Shields
    number of the paper's Setup II."""
    expected, exposed = found.shields_threshold, motion.EXPOSED_THRESHOLD
    text = (
        f"Beside Shields' curve, {expected:.4f} (10 % of the grains in motion), {sides(found, expected, True)}. Beside "
        f"grains that lie exposed in the pockets of a fixed layer, {exposed:g} (Fenton & Abbott 1977), "
        f"{sides(found, exposed, False)}."
    )
    theta = found.setup_2
    # Below the critical number hardly any transport should occur, says the paper.
    if theta < CRITICAL_SHIELDS:
        at = [p for p in found.points if p.shields == theta]
        shares = ", ".join(
            f"{model_label(p.model)} {100 * p.moving.mean:.0f} ± {100 * p.moving.half_width:.0f} %" for p in at
        )
        answers = [exceeds(p.moving.mean, p.moving.half_width, motion.IN_MOTION) for p in at]
        verdict = "all models contradict that" if all(answers) else (
            "not all models contradict that" if any(answers) else "no model contradicts that"
        )  # fmt: skip
        text += (
            f" At θ = {theta:g} (the paper's Setup II has {BED_SHIELDS}), below the paper's critical "
            f"{CRITICAL_SHIELDS}, which is for level beds, less than 10 % should move; here {shares}: {verdict}."
        )
    return text


SIDES = {
    "earlier": "begin to move earlier", "later": "begin to move later", "agrees": "agree", "unknown": "cannot be told",
}  # fmt: skip


def sides(found: Experiment, expected: float, with_numbers: bool) -> str:
    """The models on each side of a Shields number, with their thresholds where asked for."""
    groups: dict[str, list[str]] = {}
    for model in found.models:
        points = found.of(model)
        threshold = motion.threshold_of_share(points)
        groups.setdefault(side(threshold, points, expected), []).append(
            model_label(model) + (f" {where(threshold, points)}" if with_numbers else "")
        )
    return "; ".join(f"{text}: {', '.join(groups[key])}" for key, text in SIDES.items() if key in groups)


def side(found: Threshold, points: Sequence[Point], expected: float) -> str:
    """Whether a model begins to move "earlier" or "later" than `expected`, "agrees", or it is "unknown"; ascending
    Shields numbers."""
    if not math.isnan(found.value):
        if found.is_open_towards(expected):
            return "unknown"
        return "agrees" if found.holds(expected) else "earlier" if found.value < expected else "later"
    first, last = points[0], points[-1]
    if exceeds(first.moving.mean, first.moving.half_width, motion.IN_MOTION) and first.shields <= expected:
        return "earlier"
    if exceeds(last.moving.mean, last.moving.half_width, motion.IN_MOTION) is False and last.shields >= expected:
        return "later"
    return "unknown"


def where(found: Threshold, points: Sequence[Point]) -> str:
    """The threshold, or on which side of the Shields numbers computed it lies."""
    if not math.isnan(found.value):
        return str(found)
    first, last = points[0], points[-1]
    if exceeds(first.moving.mean, first.moving.half_width, motion.IN_MOTION):
        return f"below {first.shields:g}"
    if exceeds(last.moving.mean, last.moving.half_width, motion.IN_MOTION) is False:
        return f"above {last.shields:g}"
    return "not found"


def draw(found: Experiment, file: Path) -> None:
    """Share of grains in motion and transport rate over the Shields number; models stand beside each other."""
    figure, (share, rate) = plt.subplots(1, 2, figsize=(9.5, 4.3), layout="constrained")
    for place, model in enumerate(found.models):
        points = found.of(model)
        theta = np.array([p.shields for p in points]) * (1.0 + 0.025 * (place - 0.5 * (len(found.models) - 1)))
        line = model_line(model) | {"marker": "o", "ms": 4, "capsize": 2, "lw": 1.2}
        mean, half = (np.array([getattr(p.moving, word) for p in points]) for word in ("mean", "half_width"))
        within = np.maximum([np.minimum(half, mean), np.minimum(half, 1.0 - mean)], 0.0)  # no share above 1
        share.errorbar(theta, mean, within, **line)
        rate.errorbar(
            theta, [p.transport.mean for p in points], [p.transport.half_width for p in points], **line
        )
    span = np.array([min(p.shields for p in found.points), max(p.shields for p in found.points)])
    share.axhline(motion.IN_MOTION, color="#999999", lw=0.8, ls="--")
    share.annotate(f"{100 * motion.IN_MOTION:g} %", (1.01, motion.IN_MOTION), xycoords=("axes fraction", "data"),
                   va="center", fontsize=8, color="#666666")  # fmt: skip
    for at, what in ((found.shields_threshold, "Shields' curve"),
                     (motion.EXPOSED_THRESHOLD, "exposed grains")):  # fmt: skip
        share.axvline(at, color="#999999", lw=0.8, ls=":")
        share.annotate(what, (at, 1.01), xycoords=("data", "axes fraction"), ha="center", va="bottom", fontsize=8,
                       color="#666666")  # fmt: skip
    fine = np.geomspace(motion.WONG_PARKER_THRESHOLD * 1.01, max(span[1], 0.05), 60)
    formula = motion.wong_parker(fine)
    rate.plot(fine, formula, color="black", lw=1, ls=":")
    rate.annotate("Wong & Parker\n2006", (fine[0], formula[len(fine) // 4]), xytext=(-5, 0), textcoords="offset points",
                  fontsize=8, ha="right", va="center")  # fmt: skip
    share.set(xlabel="Shields number θ", ylabel="share of grains faster than 0.01 $u_b$", xscale="log", ylim=(0, 1.02))
    lowest = [p.transport.mean for p in found.points if p.transport.mean > 0]
    rate.set(xlabel="Shields number θ", ylabel="transport rate q*", xscale="log", yscale="log",
             ylim=(0.3 * min(lowest, default=1e-4), None))  # fmt: skip
    for axis in (share, rate):
        plain_ticks(axis.xaxis)
    name_models(figure, found.models)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def as_text(found: Experiment, motion_drawn: bool = False) -> str:
    """README.md of the report; `motion_drawn`: motion.png stands beside it."""
    maps = ["", "Where and when grains move, at the Shields number nearest to Shields' curve:", "",
            "![Share of grains in motion over x and time](motion.png)"] if motion_drawn else []  # fmt: skip
    told = [f"- {name}: {value}" for name, value in found.circumstances.items()]
    lines = [*_head(found), *_thresholds(found), *maps, *_runs(found), "", "## Circumstances", "", *told]
    return "\n".join(lines) + "\n"


def narrow_sentence(found: Experiment) -> str:
    """Whose intervals of the share in motion promise too much; empty where none does, or a kept record has no
    batches."""
    throughs = found.throughs - found.discard
    known = [p for p in found.points if len(p.moving.batches)]
    narrow = [p for p in known if p.moving.too_narrow(throughs)]
    if not narrow:
        return "" if known else " This record has not kept its batches: whether it promises too much cannot be told."
    each = "; ".join(f"{model_label(p.model)} at {p.shields:g}" for p in narrow)
    return (f" It promises too much for the share in motion of {len(narrow)} of {len(known)} runs, whose batches are "
            f"shorter than a flow-through or correlated by more than {HIGHEST_MEMORY:g}: {each}.")  # fmt: skip


def commands(found: Experiment) -> str:
    """What makes the record: one command for all models that were computed at the same Shields numbers."""
    together: dict[tuple[float, ...], list[str]] = {}
    for model in found.models:
        together.setdefault(tuple(p.shields for p in found.of(model)), []).append(model)
    return "; ".join(
        f"`./bedload study threshold --scene {found.scene} --models {' '.join(models)} --shields "
        f"{' '.join(f'{s:g}' for s in numbers)} --cells {found.cells_per_diameter} "
        f"--throughs {found.throughs:g} --discard {found.discard:g}`"
        for numbers, models in together.items()
    )


def _head(found: Experiment) -> list[str]:
    """What a reader has to know, how it was made and the figure."""
    reynolds = found.friction_velocity * found.diameter / found.viscosity
    part = found.friction_half_width / found.friction_velocity
    together = "" if math.isnan(part) else (
        f" That of the friction velocity, {100 * part:.0f} %, is in none of them: it moves all Shields numbers "
        "together, by twice as much."
    )  # fmt: skip
    return [
        f"# Onset of motion: {found.scene}",
        "",
        opening(found),
        "",
        commands(found),
        "",
        f"Friction velocity of the bed without mobile grains {found.friction_velocity:.5f} "
        f"({found.friction_source}), D⁺ = {reynolds:.1f}, ρp/ρf = {found.density_ratio:g}; gravity sets the "
        f"Shields number. {found.cells_per_diameter} cells to a diameter, {found.throughs:g} flow-throughs "
        f"L_x/u_b, the first {found.discard:g} left out. ± is a 95 % confidence interval "
        "from batches, wider where these are correlated." + narrow_sentence(found) + together,
        "",
        "![Share of grains in motion and transport rate](threshold.png)",
    ]


def _thresholds(found: Experiment) -> list[str]:
    """Each model's threshold, and what it says beside those that are known."""
    lines = [
        "",
        "## Thresholds",
        "",
        "| model | 10 % of the grains in motion | q* → 0, as (θ − θc)^1.6 |",
        "|---|---|---|",
    ]
    for model in found.models:
        points = found.of(model)
        share, transport = motion.threshold_of_share(points), motion.threshold_of_transport(points)
        lines.append(f"| {model_label(model)} | {where(share, points)} | {transport} |")
    expected = found.shields_threshold
    lines += [
        "",
        f"Shields' curve (Soulsby & Whitehouse 1997) has {expected:.4f} for these grains, Wong & Parker's "
        f"formula {motion.WONG_PARKER_THRESHOLD:g}. By the share in motion:",
        "",
    ]
    for model in found.models:
        points = found.of(model)
        threshold = motion.threshold_of_share(points)
        lines.append(f"- {model_label(model)}: {verdict(threshold, points, expected)}{beside_exposed(threshold)}.")
    return [
        *lines,
        "",
        "The interval by the share in motion is from the last Shields number computed whose share, ± and all, is below "
        f"{100 * motion.IN_MOTION:g} % to the first that is above; the number in front of it is by straight lines "
        "between the points, a guess.",
        "",
        "Shields' curve is for grains in a level bed. Grains that lie on a fixed layer, in its pockets, stand 0.82 D "
        "above the grains under them; such grains are reported to move from "
        f"θ = {motion.EXPOSED_THRESHOLD:g} on (Fenton & Abbott 1977).",
    ]


def _runs(found: Experiment) -> list[str]:
    """The table of all runs."""
    lines = [
        "",
        "## All runs",
        "",
        "| model | θ | in motion | not resting | u_p/u_b | q* | Wong & Parker |",
        "|---|---|---|---|---|---|---|",
    ]
    for p in sorted(found.points, key=lambda p: in_order(p.model, p.shields)[1:] + (p.shields,)):
        lines.append(
            f"| {model_label(p.model)} | {p.shields:g} | {p.moving} | {p.not_resting} | {p.velocity} | "
            f"{p.transport.mean:.2e} ± {p.transport.half_width:.1e} | {motion.wong_parker(p.shields):.2e} |"
        )
    return lines


ESTIMATES = ("moving", "not_resting", "velocity", "transport")


def write(found: Experiment, folder: Path) -> None:
    """threshold.png, motion.png where there are many grains, README.md and numbers.json into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    write_pages(found, folder, bed_motion.compare(found.shown, folder / "motion.png"))


def write_pages(found: Experiment, folder: Path, motion_drawn: bool) -> None:
    """All but the maps of motion, which are there if `motion_drawn`."""
    draw(found, folder / "threshold.png")
    (folder / "README.md").write_text(as_text(found, motion_drawn), encoding="utf-8")
    kept = {field.name: getattr(found, field.name) for field in fields(found) if field.name not in ("points", "shown")}
    kept["points"] = [
        {"model": p.model, "shields": p.shields}
        | {name: _kept(getattr(p, name)) for name in ESTIMATES}
        for p in found.points
    ]
    (folder / "numbers.json").write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _kept(found: Estimate) -> list:
    """Mean, half width and, where they are known, the batches' means."""
    return [found.mean, found.half_width, *([found.batches.tolist()] if len(found.batches) else [])]


def _read_estimate(mean: float, half_width: float, batches: Sequence[float] = ()) -> Estimate:
    return Estimate(mean, half_width, np.array(batches))


def read(folder: Path) -> Experiment:
    """The experiment that numbers.json keeps; estimates of older records are without batches."""
    names = [field.name for field in fields(Experiment) if field.name != "shown"]
    kept = kept_numbers(folder, [name for name in names if name != "friction_half_width"])
    kept = {name: kept[name] for name in names if name in kept}
    points = [
        Point(p["model"], p["shields"], **{name: _read_estimate(*p[name]) for name in ESTIMATES})
        for p in kept.pop("points")
    ]
    return Experiment(points=points, **kept)


def rewrite(folder: Path) -> None:
    """Pages and threshold.png of a kept report anew from its numbers; motion.png stays."""
    write_pages(read(folder), folder, (folder / "motion.png").is_file())
