"""overlap.png: both programs over one time step, what runs beside what."""

import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)

FILE = "timeline.csv"
COLOURS = {
    "fluid predictor": "#1b7fbd",
    "markers": "#e08214",
    "exchange": "#333333",
    "pressure": "#6aaed6",
    "waiting for LIGGGHTS": "#d7301f",
    "end of the step": "#bbbbbb",
    "grain motion": "#7a3b8f",
}


def read(folder: Path) -> list[tuple[str, str, float, float]]:
    """Rows of timeline.csv: program, part, start and end in seconds since the step's begin; none
    where the run was broken off."""
    if not (folder / FILE).is_file():
        return []
    with (folder / FILE).open(newline="", encoding="utf-8") as stream:
        return [(r["program"], r["part"], float(r["start"]), float(r["end"]))
                for r in csv.DictReader(stream) if r.get("end")]  # fmt: skip


def draw(folder: Path, file: Path) -> None:
    rows = read(folder)
    programs = ["bedload-dem", "bedload-fluid"]
    figure, axes = plt.subplots(figsize=(9, 2.2), layout="constrained")
    named = set()
    for program, part, start, end in rows:
        # An edge, and no smoothing: parts that follow each other have no white line between them.
        colour = COLOURS.get(part, "#dddddd")
        axes.barh(
            programs.index(program), 1e3 * (end - start), left=1e3 * start, height=0.6, color=colour, edgecolor=colour,
            linewidth=0.4, antialiased=False, label=None if part in named else part,
        )  # fmt: skip
        named.add(part)
    axes.set_yticks(range(len(programs)), programs)
    axes.set(xlabel="time since the step began [ms]", xlim=(0.0, None))
    axes.legend(ncols=4, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, 1.45))
    figure.savefig(file, dpi=120, bbox_inches="tight")
    plt.close(figure)
