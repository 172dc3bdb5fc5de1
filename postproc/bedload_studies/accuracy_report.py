"""Error against price as figures and a page."""

import base64
import html
from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

PRESET_COLOUR, BEST, OTHER = "#c8553d", "#2a6f97", "#9aa5b1"


def draw_case(case: str, points, best: set[str], file: Path) -> None:
    """All points labelled; the front of best choices as a line; presets in red."""
    figure, axis = plt.subplots(figsize=(7.5, 5), layout="constrained")
    line = sorted((p for p in points if p.label in best), key=lambda p: p.core_seconds)
    axis.plot(
        [p.core_seconds for p in line], [100 * abs(p.error) for p in line], "-", color=BEST,
        label="best choices", zorder=1,
    )  # fmt: skip
    for p in points:
        colour = PRESET_COLOUR if p.knob == "preset" else BEST if p.label in best else OTHER
        axis.plot(p.core_seconds, 100 * abs(p.error), "o", color=colour, ms=6, zorder=2)
        axis.annotate(
            p.label, (p.core_seconds, 100 * abs(p.error)), xytext=(4, 3),
            textcoords="offset points", fontsize=7, color=colour,
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
    parts = [
        "<!doctype html><meta charset=utf-8><title>What accuracy costs</title>",
        "<style>body{font:15px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}"
        "table{border-collapse:collapse}td,th{padding:.15em .7em;text-align:left}"
        "td.n{text-align:right}tr.best{font-weight:600}img{max-width:100%}</style>",
        "<h1>What accuracy costs</h1><p>Bold rows: no other row has both a smaller error and fewer "
        "core-seconds.</p>",
    ]
    for case in dict.fromkeys(p.case for p in points):
        mine = [p for p in points if p.case == case]
        best = front(mine)
        file = folder / f"{case}.png"
        draw_case(case, mine, best, file)
        image = base64.b64encode(file.read_bytes()).decode()
        parts.append(f"<h2>{html.escape(case.replace('_', ' '))}</h2>")
        parts.append(f'<img src="data:image/png;base64,{image}" alt="error against core-seconds">')
        parts.append("<table><tr><th>choice<th>knob<th>error / %<th>core-seconds<th>memory / MB")
        parts += [
            f"<tr{' class=best' if p.label in best else ''}><td>{html.escape(p.label)}"
            f"<td>{html.escape(p.knob)}<td class=n>{100 * p.error:+.2f}"
            f"<td class=n>{p.core_seconds:.1f}<td class=n>{p.megabytes:.0f}"
            for p in mine
        ]
        parts.append("</table>")
    (folder / "accuracy.html").write_text("\n".join(parts), encoding="utf-8")
