"""The map of the hard cases as a picture and a page."""

import html
from pathlib import Path

import matplotlib
from bedload_post.report import image, page, table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

from .criteria import INACCURATE, PASS, REFUSED, STOPPED, UNSTABLE  # noqa: E402
from .hard_cases import CASES  # noqa: E402

COLOURS = {
    PASS: "#4c9f70", INACCURATE: "#e9c46a", UNSTABLE: "#c8553d", REFUSED: "#9aa5b1",
    STOPPED: "#6b4f8a",
}  # fmt: skip
LEGEND = 0.4  # height of the row of names over the panels [inch]


def draw_map(cells, file: Path) -> None:
    """One panel a case: knob against Courant number; a dot inside a square is the single run."""
    names = [name for name in CASES if any(c.case == name for c in cells)]
    columns = 3
    rows = -(-len(names) // columns)
    height = 2.6 * rows + LEGEND
    figure, axes = plt.subplots(
        rows, columns, figsize=(4.2 * columns, height), squeeze=False, layout="constrained"
    )
    for axis in axes.flat[len(names) :]:
        axis.set_axis_off()
    for axis, name in zip(axes.flat, names, strict=False):
        case = CASES[name]
        mine = [c for c in cells if c.case == name]
        values = [str(v) for v in case.values]
        steps = sorted({c.courant for c in mine})
        for cell in mine:
            x, y = steps.index(cell.courant), values.index(cell.value)
            if cell.precision == "double":
                axis.add_patch(
                    plt.Rectangle(
                        (x - 0.46, y - 0.46), 0.92, 0.92, color=COLOURS[cell.verdict], zorder=1
                    )
                )
            else:
                axis.plot(
                    x, y, "o", ms=9, mfc=COLOURS[cell.verdict], mec="black", mew=1.0, zorder=2
                )
        axis.set(
            xlim=(-0.5, len(steps) - 0.5), ylim=(-0.5, len(values) - 0.5), ylabel=case.knob,
            xlabel="U dt / h", title=case.question,
        )  # fmt: skip
        axis.title.set_fontsize(9)
        axis.set_xticks(range(len(steps)), [f"{s:g}" for s in steps])
        axis.set_yticks(range(len(values)), values)
        axis.spines[:].set_visible(False)
        axis.tick_params(length=0)
    handles = [plt.Rectangle((0, 0), 1, 1, color=c) for c in COLOURS.values()]
    handles.append(plt.Line2D([], [], marker="o", ls="", ms=9, mfc=COLOURS[PASS], mec="black"))
    figure.legend(handles, [*COLOURS, "dot: single precision"], ncol=6, loc="upper center", frameon=False)
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - LEGEND / height))
    figure.savefig(file, dpi=110)
    plt.close(figure)


def write_report(folder: Path, cells) -> None:
    """stability.png and stability.html in `folder`."""
    picture = folder / "stability.png"
    draw_map(cells, picture)
    body = ["<h1>Hard cases: what holds, and where the limit is</h1>", image(picture, "Map")]
    for name, case in CASES.items():
        mine = [c for c in cells if c.case == name]
        if not mine:
            continue
        criterion = " ".join((case.judge.__doc__ or "").split())
        body.append(f"<h2>{html.escape(case.question)}</h2><p>{html.escape(criterion)}</p>")
        rows = (
            (c.value, f"{c.courant:g}", c.precision, c.verdict, f"{c.number:.3g}", c.words)
            for c in mine
        )
        columns = (case.knob, "U dt/h", "precision", "verdict", "number", "")
        body.append(table(rows, ("", "", "", "", "number", "note"), columns))
    (folder / "stability.html").write_text(page("Hard cases", body), encoding="utf-8")
