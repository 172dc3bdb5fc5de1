"""Shows the result of a run: pictures, numbers on the terminal, report.html."""

import argparse
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from rich.console import Console
from rich.table import Table

from . import bed_motion, flow_statistics, kept_page, overlap, path, profile_figures, report, states, summary
from .frames import time_ranges
from .outputs import MissingOutput, Run
from .summary import Line

ENTRY = Path(__file__).resolve().parents[1] / "show.py"
LEAST_WIDTH = 80  # columns: a narrower terminal breaks the lines itself, and no digit is cut off
LONGEST = 300.0  # s that picture.png may take
PICTURES = {
    "picture.png": "the scene",
    "path.png": "the grain's path, coloured by state",
    "bed_motion.png": "where and when grains of a bed move, and the bed's surface",
    "overlap.png": "both programs over the last time step",
    "profiles.png": "mean flow, fluctuations and stress over y",
}


def _or_note(console: Console, compute: Callable, otherwise):
    """The result of `compute`, or `otherwise` and one sentence where the run lacks a file."""
    try:
        return compute()
    except MissingOutput as missing:
        console.print(f"[yellow]{missing}[/]")
        return otherwise


def _print_lines(console: Console, title: str, lines: list[Line]) -> None:
    if not lines:
        return
    table = Table(title=title, title_justify="left", box=None, show_header=False, pad_edge=False)
    table.add_column(min_width=26, no_wrap=True)
    table.add_column(justify="right", no_wrap=True)
    table.add_column(style="dim")
    for line in lines:
        table.add_row(line.what, line.value, line.note)
    console.print(table)
    console.print()


def _print_times(console: Console, rows: list[tuple[str, float, float]], note: str) -> None:
    if not rows:
        return
    table = Table(title="Where the time went", title_justify="left", box=None, pad_edge=False)
    table.add_column("part", no_wrap=True)
    table.add_column("seconds", justify="right", no_wrap=True)
    table.add_column("share", justify="right", no_wrap=True)
    for part, seconds, share in rows:
        table.add_row(part, f"{seconds:.1f}", f"{100 * share:.1f} %")
    console.print(table)
    if note:
        console.print(note, style="dim")
    console.print()


def _render(console: Console, run: Run) -> None:
    """picture.png, by a process of its own under a virtual X server."""
    command = ["xvfb-run", "-a", sys.executable, "-I", "-B", str(ENTRY), str(run.folder), "--picture-only"]
    try:
        with subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
        ) as drawing:
            try:
                words = drawing.communicate(timeout=LONGEST)[1].strip().splitlines()
            except BaseException:  # it takes too long, or this process is to end: X server and all go
                os.killpg(drawing.pid, signal.SIGTERM)
                raise
        problem = "" if drawing.returncode == 0 else (words[-1] if words else f"{drawing.returncode}")
    except (OSError, subprocess.TimeoutExpired) as error:
        problem = str(error)
    if problem:
        console.print(f"[yellow]No picture.png: {problem}[/]")


def _phases(run: Run) -> states.Phases:
    return states.analyse(
        run.contacts(), time_ranges(run.instants()), run.sample_blocks(), run.periods,
        run.bulk_velocity, run.diameter,
    )  # fmt: skip


def _up_to_date(folder: Path) -> set[str]:
    """The pictures in `folder` that are not older than the run's last row."""
    history = folder / "history.csv"
    if not history.is_file():
        return set()
    last = history.stat().st_mtime_ns
    return {name for name in PICTURES if (file := folder / name).is_file() and file.stat().st_mtime_ns >= last}


def show(folder: Path, pictures: bool = True, times_shown: bool = False) -> None:
    """Writes path.png, overlap.png, picture.png and report.html into `folder` and prints the numbers.

    Pictures of an earlier show, since which the run may have gone on, are not shown again: they are removed, and
    without `pictures` left where they are. `times_shown`: the run itself has just printed its table of times.
    """
    run = Run(folder)
    console = Console(highlight=False)
    if console.width < LEAST_WIDTH:
        console = Console(highlight=False, width=LEAST_WIDTH)
    for name in PICTURES if pictures else ():
        (folder / name).unlink(missing_ok=True)
    has_grains = _or_note(console, lambda: any(len(block) for block in run.sample_blocks(rows=1)), False)
    grains: list[Line] = []
    if has_grains:
        phases = _or_note(console, lambda: _phases(run), None) if run.has_collisions else None
        grains = summary.grain_lines(run, phases)
        if pictures and summary.has_bed(run):
            if phases is not None and len(phases.tag):
                tag = path.chosen_grain(phases)
                path.draw(run, phases, run.samples_of(tag), tag, folder / "path.png")
            bed_motion.draw(run, folder / "bed_motion.png")
    if pictures:
        if (folder / flow_statistics.FILE).is_file():
            profile_figures.draw(flow_statistics.read(run), folder / "profiles.png")
        if any(program == "bedload-dem" for program, *_ in overlap.read(folder)):
            overlap.draw(folder, folder / "overlap.png")
        _render(console, run)
    flow = _or_note(console, lambda: summary.flow_lines(run), [])
    times, times_note = _or_note(console, lambda: (summary.time_rows(run), summary.times_note(run)), ([], ""))
    console.print()
    _print_lines(console, "Grains", grains)
    _print_lines(console, "Flow and checks", flow)
    if not times_shown:
        _print_times(console, times, times_note)
    shown = {name for name in PICTURES if (folder / name).is_file()} if pictures else _up_to_date(folder)
    report.write(run, shown, grains, flow, times, times_note, folder / "report.html")
    console.print(f"In {folder}:", soft_wrap=True, markup=False)
    others = {
        "report.html": "both with all numbers and settings, in one file",
        "fields.xdmf": "fields for ParaView",
        "spheres.xdmf": "spheres for ParaView",
    }
    for file, what in (PICTURES | others).items():
        if file in shown or (file in others and (folder / file).is_file()):
            console.print(f"  {file:<13} {what}")


def main() -> int:
    """What the command line asks for; 141, as of SIGPIPE, when the reader of the output has gone, 130 after Ctrl-C."""
    try:
        status = _asked()
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what Python flushes at its end
        return 128 + signal.SIGPIPE
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


def _end(received: int, _) -> NoReturn:
    sys.exit(128 + received)


def _asked() -> int:
    parser = argparse.ArgumentParser(prog="show.py", description=__doc__, allow_abbrev=False)
    parser.add_argument("folder", type=Path, metavar="OUT", help="output folder of a run")
    parser.add_argument("--no-pictures", action="store_true", help="numbers and report only")
    parser.add_argument(
        "--after-run", action="store_true", help="leave out the table of times: just printed"
    )
    parser.add_argument(
        "--picture-only", action="store_true", help="picture.png only; needs an X server"
    )
    parser.add_argument(
        "--film", type=float, metavar="SINCE", help="film.mp4 only, from this time; needs an X server"
    )
    parser.add_argument("--frames", type=int, default=250, help="of the film (default: 250)")
    options = parser.parse_args()
    if options.frames < 1:
        parser.error(f"--frames is {options.frames}, but must be at least 1")
    try:
        if options.film is not None:
            from . import film

            file = options.folder / "film.mp4"
            count = film.render(Run(options.folder), file, options.film, most=options.frames)
            print(f"{file}: {count} frames")
            return 0
        if kept_page.is_kept(options.folder):
            print(kept_page.write(options.folder))
            return 0
        if options.picture_only:
            from . import picture  # VTK takes a second to load

            picture.render(Run(options.folder), options.folder / "picture.png")
        else:
            for number in (signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, _end)  # and with us what draws the picture
            show(options.folder, not options.no_pictures, options.after_run)
    except MissingOutput as missing:
        print(missing, file=sys.stderr)
        return 1
    except BrokenPipeError:
        raise
    except OSError as error:
        print(f"{error.filename or options.folder}: {error.strerror or error}", file=sys.stderr)
        return 1
    return 0
