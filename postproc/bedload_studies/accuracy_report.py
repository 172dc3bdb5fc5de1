"""Error against price as figures and a page."""

import math
from collections.abc import Callable
from pathlib import Path

import matplotlib
from bedload_post.report import image, page, table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

from .log_ticks import plain_ticks  # noqa: E402

PRESET_COLOUR, BEST, OTHER = "#c8553d", "#2a6f97", "#9aa5b1"
NAMES = {PRESET_COLOUR: "preset of --accuracy", BEST: "no other choice is better in both", OTHER: "other choice"}
LEGEND = 0.3  # height of the row of names over a figure [inch]


def draw_case(case: str, points, best: set[str], file: Path) -> None:
    """One row a choice, the cheapest below, so that no label meets another: |error| with its interval, and
    price. Presets in red, what nothing beats in both in blue."""
    rows = sorted(points, key=lambda p: p.core_seconds)
    height = 1.3 + 0.27 * len(rows) + LEGEND
    figure, (errors, prices) = plt.subplots(1, 2, sharey=True, figsize=(9, height), layout="constrained")
    for n, p in enumerate(rows):
        if math.isnan(p.error):
            continue  # a row without marks: stopped
        colour = PRESET_COLOUR if p.knob == "preset" else BEST if p.label in best else OTHER
        errors.errorbar(100 * abs(p.error), n, xerr=100 * p.interval, fmt="o", color=colour, capsize=2)
        prices.plot(p.core_seconds, n, "s", color=colour)
    errors.set_yticks(range(len(rows)), [p.label for p in rows])
    errors.set(xscale="log", xlabel="|error| / %")
    prices.set(xscale="log", xlabel="price / core-seconds")
    for axis in (errors.xaxis, prices.xaxis):
        plain_ticks(axis)
    for axis in (errors, prices):
        axis.grid(alpha=0.25)
    title = figure.suptitle(case.replace("_", " "), fontsize=11, x=0.02, ha="left")
    handles = [plt.Line2D([], [], color=colour, marker="o", ls="none", label=name) for colour, name in NAMES.items()]
    figure.legend(handles=handles, loc="upper right", ncol=3, frameon=False, fontsize=9)
    title.set_in_layout(False)
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - LEGEND / height))
    figure.savefig(file, dpi=110)
    plt.close(figure)


def draw_cases(points, front: Callable[[list], set[str]], folder: Path) -> None:
    """CASE.png of each case of `points`."""
    for case in dict.fromkeys(p.case for p in points):
        mine = [p for p in points if p.case == case]
        draw_case(case, mine, front(mine), folder / f"{case}.png")


def error_text(point) -> str:
    """In percent, with its interval where chance takes part in it."""
    if math.isnan(point.error):
        return "stopped"
    half = f" ± {100 * point.interval:.2f}" if point.interval else ""
    return f"{100 * point.error:+.2f}{half}"


def write_report(folder: Path, points, front: Callable[[list], set[str]]) -> None:
    """CASE.png for each case and accuracy.html with all tables and figures."""
    draw_cases(points, front, folder)
    body = [
        "<h1>What accuracy costs</h1><p>Best: no other row has both a smaller error and fewer "
        "core-seconds.</p>"
    ]
    columns = ("choice", "knob", "error / %", "core-seconds", "memory / MB", "")
    for case in dict.fromkeys(p.case for p in points):
        mine = [p for p in points if p.case == case]
        best = front(mine)
        file = folder / f"{case}.png"
        rows = (
            (
                p.label, p.knob, error_text(p), f"{p.core_seconds:.1f}",
                f"{p.megabytes:.0f}", "best" if p.label in best else "",
            )
            for p in mine
        )  # fmt: skip
        body.append(image(file, case.replace("_", " ")))
        body.append(table(rows, ("", "", "number", "number", "number", "note"), columns))
    (folder / "accuracy.html").write_text(page("What accuracy costs", body), encoding="utf-8")
