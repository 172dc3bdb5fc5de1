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
