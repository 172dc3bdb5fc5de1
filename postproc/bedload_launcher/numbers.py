"""Numbers of the command line with a range, and paths: types for argparse, which puts the option's name before their
sentence."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path


def whole(least: int) -> Callable[[str], int]:
    """Whole numbers from `least` on; 1e8 is one, too."""

    def read(text: str) -> int:
        try:
            number = int(text)
        except ValueError:
            if not float(text).is_integer():
                raise
            number = int(float(text))
        if number < least:
            raise argparse.ArgumentTypeError(f"is {text}, but must be at least {least}")
        return number

    read.__name__ = "int"  # in argparse's sentence for what is no number
    return read


def finite(text: str) -> float:
    """A number that is neither inf nor nan."""
    if not math.isfinite(number := float(text)):
        raise argparse.ArgumentTypeError(f"is {text}, but must be a finite number")
    return number


finite.__name__ = "float"


def positive(text: str) -> float:
    """A finite number above 0."""
    if not (number := finite(text)) > 0.0:
        raise argparse.ArgumentTypeError(f"is {text}, but must be more than 0")
    return number


positive.__name__ = "float"


def named(text: str) -> Path:
    """A path; empty text, which Path takes for the current folder, is none."""
    if not text:
        raise argparse.ArgumentTypeError("is empty, but must be a path")
    return Path(text)
