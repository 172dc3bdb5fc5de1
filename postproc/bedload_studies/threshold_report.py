"""The report of the onset of motion: two figures, tables, and what they say of each model."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)
import numpy as np  # noqa: E402

from bedload_post import bed_motion  # noqa: E402
from bedload_post import incipient_motion as motion  # noqa: E402
from bedload_post.incipient_motion import Point, Threshold  # noqa: E402
from bedload_post.model_figures import MODELS  # noqa: E402
from bedload_post.outputs import Run  # noqa: E402


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
    shown: Sequence[tuple[str, Run]] = ()  # whose motion is drawn over x and time, one a model

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
                f"{first.moving.mean:.0%} move" + (beside if first.shields <= expected else "")
            )
        if last.moving.mean + last.moving.half_width < motion.IN_MOTION:
            return f"its threshold lies above the highest Shields number computed, {last.shields:g}"
        return (
            f"its threshold is not found among the Shields numbers computed, {first.shields:g} to "
            f"{last.shields:g}: nothing is said of it"
        )
    if found.holds(expected):
        return f"{found}: agrees with Shields' curve, {expected:.4f}, within its interval"
    side = "earlier" if found.value < expected else "later"
    factor = max(found.value / expected, expected / found.value)
    return f"{found}: begins to move {side} than Shields' curve, {expected:.4f}, by a factor {factor:.2f}"


def beside_exposed(found: Threshold) -> str:
    """The same beside the threshold of exposed grains; empty where none was found."""
    if math.isnan(found.value):
        return ""
    exposed = motion.EXPOSED_THRESHOLD
    if found.holds(exposed):
        return f"; agrees with that of exposed grains, {exposed:g}"
    return f"; {found.value / exposed:.2f} times that of exposed grains, {exposed:g}"


def draw(found: Experiment, file: Path) -> None:
    """Share of grains in motion and transport rate over the Shields number."""
    figure, (share, rate) = plt.subplots(1, 2, figsize=(9.5, 4.0), layout="constrained")
    for model in found.models:
        points = found.of(model)
        label, colour = MODELS.get(model, (model, "#555555"))[:2]
        theta = [p.shields for p in points]
        line = {"color": colour, "marker": "o", "ms": 4, "capsize": 2, "lw": 1.2, "label": label}
        share.errorbar(
            theta, [p.moving.mean for p in points], [p.moving.half_width for p in points], **line
        )
        rate.errorbar(
            theta, [p.transport.mean for p in points], [p.transport.half_width for p in points], **line
        )
    span = np.array([min(p.shields for p in found.points), max(p.shields for p in found.points)])
    share.axhline(motion.IN_MOTION, color="#999999", lw=0.8, ls="--")
    for at, what in ((found.shields_threshold, "Shields' curve"),
                     (motion.EXPOSED_THRESHOLD, "exposed grains")):  # fmt: skip
        share.axvline(at, color="#999999", lw=0.8, ls=":")
        share.text(at, 1.03, what, ha="center", va="bottom", fontsize=8, color="#666666")
    fine = np.geomspace(motion.WONG_PARKER_THRESHOLD * 1.01, max(span[1], 0.05), 60)
    rate.plot(fine, motion.wong_parker(fine), color="black", lw=1, ls="--", label="Wong & Parker 2006")
    share.set(xlabel="Shields number θ", ylabel="share of grains faster than 0.01 u_b", xscale="log",
              ylim=(0, 1.02))  # fmt: skip
    lowest = [p.transport.mean for p in found.points if p.transport.mean > 0]
    rate.set(xlabel="Shields number θ", ylabel="transport rate q*", xscale="log", yscale="log",
             ylim=(0.3 * min(lowest, default=1e-4), None))  # fmt: skip
    shown = sorted({p.shields for p in found.points})
    for axis in (share, rate):
        axis.set_xticks(shown, [f"{s:g}" for s in shown], rotation=45)
        axis.set_xticks([], minor=True)
    rate.legend(frameon=False, fontsize=8)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def as_text(found: Experiment, motion_drawn: bool = False) -> str:
    """README.md of the report; `motion_drawn`: motion.png stands beside it."""
    reynolds = found.friction_velocity * found.diameter / found.viscosity
    lines = [
        f"# Onset of motion: {found.scene}",
        "",
        f"`./bedload study threshold --scene {found.scene} --models {' '.join(found.models)} --shields "
        f"{' '.join(f'{s:g}' for s in sorted({p.shields for p in found.points}))} --cells "
        f"{found.cells_per_diameter} --throughs {found.throughs:g} --discard {found.discard:g}`",
        "",
        f"Friction velocity of the bed without mobile grains {found.friction_velocity:.5f} "
        f"({found.friction_source}), D⁺ = {reynolds:.1f}, ρp/ρf = {found.density_ratio:g}; gravity sets the "
        f"Shields number. {found.cells_per_diameter} cells to a diameter, {found.throughs:g} flow-throughs "
        f"L_x/u_b, the first {found.discard:g} left out. Intervals hold 95 %.",
        "",
        "![Share of grains in motion and transport rate](threshold.png)",
        "",
        "## Thresholds",
        "",
        "| model | 10 % of the grains in motion | q* → 0, as (θ − θc)^1.6 |",
        "|---|---|---|",
    ]
    for model in found.models:
        points = found.of(model)
        lines.append(
            f"| {model} | {motion.threshold_of_share(points)} | {motion.threshold_of_transport(points)} |"
        )
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
        lines.append(f"- {model}: {verdict(threshold, points, expected)}{beside_exposed(threshold)}.")
    lines += [
        "",
        "Shields' curve is for grains in a level bed. Grains that lie on a fixed layer, in its pockets, stand 0.82 D "
        "above the grains under them; such grains are reported to move from "
        f"θ = {motion.EXPOSED_THRESHOLD:g} on (Fenton & Abbott 1977).",
    ]
    if motion_drawn:
        lines += ["", "Where and when grains move, at the Shields number nearest to Shields' curve:", "",
                  "![Share of grains in motion over x and time](motion.png)"]  # fmt: skip
    lines += [
        "",
        "## All runs",
        "",
        "| model | θ | in motion | not resting | u_p/u_b | q* | Wong & Parker |",
        "|---|---|---|---|---|---|---|",
    ]
    for p in sorted(found.points, key=lambda p: (p.model, p.shields)):
        lines.append(
            f"| {p.model} | {p.shields:g} | {p.moving} | {p.not_resting} | {p.velocity} | "
            f"{p.transport.mean:.2e} ± {p.transport.half_width:.1e} | {motion.wong_parker(p.shields):.2e} |"
        )
    lines += ["", "## Circumstances", ""]
    lines += [f"- {name}: {value}" for name, value in found.circumstances.items()]
    return "\n".join(lines) + "\n"


def write(found: Experiment, folder: Path) -> None:
    """threshold.png, motion.png where there are many grains, README.md and numbers.json into `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    draw(found, folder / "threshold.png")
    drawn = bed_motion.compare(found.shown, folder / "motion.png")
    (folder / "README.md").write_text(as_text(found, drawn), encoding="utf-8")
    numbers = [
        {
            "model": p.model, "shields": p.shields,
            **{name: [getattr(p, name).mean, getattr(p, name).half_width]
               for name in ("moving", "not_resting", "velocity", "transport")},
        }
        for p in found.points
    ]  # fmt: skip
    (folder / "numbers.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
