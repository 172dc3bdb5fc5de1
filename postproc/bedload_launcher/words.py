"""Words for a person, and tables for a program."""

import csv
import sys
from pathlib import Path


def say(text: str) -> None:
    """What is being done; results go to stdout."""
    print(text, file=sys.stderr, flush=True)


def read_rows(table: Path) -> list[dict[str, str]]:
    """A CSV file with a head, by names of columns."""
    with table.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


REMARKS = ("WARNING", "NOTE", "caution")  # what a program says on the way; all else ends it


def end_of(said: str) -> str:
    """The sentence with which one of the programs ended, out of all that was said; empty where none is."""
    lines = [line.strip() for line in said.splitlines() if "bedload-" in line]
    lines = [line[line.index("bedload-") :] for line in lines]
    return next((line for line in lines if line.split(": ")[1:2] and line.split(": ")[1] not in REMARKS), "")


def last_sentence(said: str) -> str:
    """The same, or else the last line of what was said."""
    lines = said.strip().splitlines() or ["it said nothing"]
    return end_of(said) or lines[-1]


def plain(text: str) -> str:
    """Without control characters: a name that someone else chose must not command the terminal."""
    return "".join(c if c.isprintable() else "?" for c in text)
