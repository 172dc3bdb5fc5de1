"""Error against price as figures and a page."""

from collections.abc import Callable
from pathlib import Path

import matplotlib
from bedload_post.report import image, page, table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

PRESET_COLOUR, BEST, OTHER = "#c8553d", "#2a6f97", "#9aa5b1"


def draw_case(case: str, points, best: set[str], file: Path) -> None:
    """All points labelled; the front of best choices as a line; presets in red."""
    figure, axis = plt.subplots(figsize=(9, 7), layout="constrained")
    line = sorted((p for p in points if p.label in best), key=lambda p: p.core_seconds)
    axis.plot(
        [p.core_seconds for p in line], [100 * abs(p.error) for p in line], "-", color=BEST,
        label="best choices", zorder=1,
    )  # fmt: skip
    # Names alternate between the sides, upwards, so that neighbours do not cover each other.
    for n, p in enumerate(sorted(points, key=lambda p: abs(p.error))):
        colour = PRESET_COLOUR if p.knob == "preset" else BEST if p.label in best else OTHER
        axis.plot(p.core_seconds, 100 * abs(p.error), "o", color=colour, ms=6, zorder=2)
        axis.annotate(
            p.label, (p.core_seconds, 100 * abs(p.error)), xytext=(-5, -2) if n % 2 else (5, -2),
            ha="right" if n % 2 else "left",
            textcoords="offset points", fontsize=6.5, color=colour,
        )  # fmt: skip
    axis.set(
        xscale="log", yscale="log", xlabel="core-seconds", ylabel="|error| / %",
        title=case.replace("_", " "),
    )  # fmt: skip
    axis.legend(frameon=False, fontsize=8)
    axis.grid(alpha=0.25)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def write_report(folder: Path, points, front: Callable[[list], set[str]]) -> None:
    """CASE.png for each case and accuracy.html with all tables and figures."""
    body = [
        "<h1>What accuracy costs</h1><p>Best: no other row has both a smaller error and fewer "
        "core-seconds.</p>"
    ]
    columns = ("choice", "knob", "error / %", "core-seconds", "memory / MB", "")
    for case in dict.fromkeys(p.case for p in points):
        mine = [p for p in points if p.case == case]
        best = front(mine)
        file = folder / f"{case}.png"
        draw_case(case, mine, best, file)
        rows = (
            (
                p.label, p.knob, f"{100 * p.error:+.2f}", f"{p.core_seconds:.1f}",
                f"{p.megabytes:.0f}", "best" if p.label in best else "",
            )
            for p in mine
        )  # fmt: skip
        body.append(image(file, case.replace("_", " ")))
        body.append(table(rows, ("", "", "number", "number", "number", "note"), columns))
    (folder / "accuracy.html").write_text(page("What accuracy costs", body), encoding="utf-8")
