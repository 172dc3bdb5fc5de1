"""report.html: one file with pictures, numbers, times and settings, to keep or to send."""

import base64
import html
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from .outputs import Run
from .summary import Line

STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; color: #222; max-width: 1100px; margin: 2em auto;
       padding: 0 1em; }
img { max-width: 100%; }
table { border-collapse: collapse; margin: 0.5em 0 1.5em; }
td, th { padding: 0.2em 1em 0.2em 0; text-align: left; border-bottom: 1px solid #ddd; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
td.note { color: #777; }
pre { background: #f6f6f4; padding: 1em; overflow-x: auto; font-size: 13px; }
"""
CAPTIONS = {
    "picture.png": "The scene at the last snapshot",
    "path.png": "The grain's path",
    "bed_motion.png": "Where and when grains of the bed move, and the bed's surface",
    "profiles.png": "Flow statistics over y",
}


def image(file: Path, caption: str) -> str:
    """A heading and the picture, embedded; nothing where there is no such file."""
    if not file.is_file():
        return ""
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    return f'<h2>{caption}</h2><img alt="{caption}" src="data:image/png;base64,{data}">'


def page(title: str, body: Iterable[str]) -> str:
    """A whole HTML file."""
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}'
        f"</title><style>{STYLE}</style></head><body>" + "\n".join(body) + "</body></html>\n"
    )


def table(
    rows: Iterable[Sequence[str]], classes: Sequence[str], head: Sequence[str] = ()
) -> str:
    """Rows of text; `classes`: one of each column; `head`: their names."""
    def cells(row):
        return "".join(
            f'<td class="{name}">{html.escape(cell)}</td>'
            for name, cell in zip(classes, row, strict=True)
        )

    first = "<tr>" + "".join(f"<th>{html.escape(n)}</th>" for n in head) + "</tr>" if head else ""
    return "<table>" + first + "".join(f"<tr>{cells(row)}</tr>" for row in rows) + "</table>"


def write(
    run: Run,
    pictures: Collection[str],
    grains: list[Line],
    flow: list[Line],
    times: list[tuple[str, float, float]],
    times_note: str,
    file: Path,
) -> None:
    """Writes the report of `run` into `file`; `pictures`: those of the run's folder that are shown."""

    def numbers(title: str, lines: list[Line]) -> str:
        rows = ((line.what, line.value, line.note) for line in lines)
        return f"<h2>{title}</h2>" + table(rows, ("", "number", "note")) if lines else ""

    seconds = ((part, f"{value:.1f} s", f"{100 * share:.1f} %") for part, value, share in times)
    settings = html.escape((run.folder / "settings.toml").read_text(encoding="utf-8"))
    body = [
        f"<h1>{html.escape(run.name)}</h1>",
        *(image(run.folder / name, caption) for name, caption in CAPTIONS.items() if name in pictures),
        numbers("Grains", grains),
        numbers("Flow and checks", flow),
        "<h2>Where the time went</h2>" + table(seconds, ("", "number", "number")) + times_note if times else "",
        f"<h2>Settings in force</h2><pre>{settings}</pre>",
    ]
    try:
        file.write_text(page(run.name, body), encoding="utf-8")
    except OSError as error:  # of a write: it does not know its file
        raise OSError(error.errno, error.strerror, str(file)) from None
