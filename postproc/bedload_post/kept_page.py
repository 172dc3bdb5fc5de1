"""report.html of a folder of kept results: its README, tables and figures in one file."""

import csv
import html
from collections.abc import Iterator
from pathlib import Path

from .report import image, page, table

MOST_ROWS = 400  # of a table that is shown
REPORTS = Path(__file__).resolve().parents[1] / "reports"
SIGN = "<!-- made from the files of this folder by bedload show -->"


def is_kept(folder: Path) -> bool:
    """Whether the folder holds a study's results and not a run, a scene, or any tables and figures."""

    def has(*names: str) -> bool:
        return any((folder / name).is_file() for name in names)

    of_a_study = has("README.md", "numbers.json") or folder.resolve().is_relative_to(REPORTS)
    of_others = has("settings.toml", "fluid.toml", "launch.json")
    return of_a_study and not of_others and any(file.suffix in (".csv", ".png") for file in _parts(folder))


def _parts(folder: Path) -> Iterator[Path]:
    for pattern in ("README.md", "remarks.html", "*.csv", "*.png"):
        yield from sorted(folder.glob(pattern))


def _rows(file: Path) -> list[list[str]]:
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def _shown(file: Path) -> str:
    if file.suffix == ".png":
        return image(file, html.escape(file.stem.replace("_", " ")))
    if file.suffix == ".md":
        return f"<pre>{html.escape(file.read_text(encoding='utf-8'))}</pre>"
    if file.suffix == ".html":
        return file.read_text(encoding="utf-8")
    head, *rows = _rows(file) or [[]]
    whole = [row for row in rows if len(row) == len(head)][:MOST_ROWS]
    return f"<h2>{html.escape(file.stem)}</h2>" + table(whole, [""] * len(head), head)


def write(folder: Path) -> Path:
    """Writes the page and returns its path; a report.html that a study has written itself stays."""
    file = folder / "report.html"
    if file.is_file() and SIGN not in file.read_text(encoding="utf-8"):
        return file
    body = [SIGN, f"<h1>{html.escape(folder.name)}</h1>", *map(_shown, _parts(folder))]
    file.write_text(page(folder.name, body), encoding="utf-8")
    return file
