"""A user's mistake, what the system refuses, and the nearest name to offer."""

import difflib
from collections.abc import Iterable
from pathlib import Path

NEAR = 0.5  # difflib's likeness, from 0 to 1: another name from there on is taken for a slip of the fingers


class UserError(Exception):
    """One sentence that says what was found and what is allowed."""


def refused(error: OSError, place: Path | None = None) -> str:
    """The sentence for what the system refuses: file and reason; `place`: where it was, if it names no file itself."""
    names = [str(name) for name in (error.filename, error.filename2) if name is not None]
    where = " -> ".join(names) or (str(place) if place is not None else "")
    return ": ".join(filter(None, (where, error.strerror or str(error))))


def unknown(kind: str, found: str, known: Iterable[str]) -> UserError:
    """The sentence for a name that does not exist: those that do, and which of them may have been meant."""
    names = sorted(known)
    if not names:
        return UserError(f"there is no {kind} '{found}', and there are no others.")
    near = difflib.get_close_matches(found, names, n=1, cutoff=NEAR)
    if not near:
        return UserError(f"there is no {kind} '{found}'; there are: {', '.join(names)}.")
    return UserError(
        f"there is no {kind} '{found}'; the nearest is '{near[0]}' (all: {', '.join(names)})."
    )


def no_option(command: str, found: str, known: Iterable[str]) -> UserError:
    """The sentence for a word of the command line that nothing takes, with the nearest of the `known` options."""
    near = difflib.get_close_matches(found.split("=")[0], list(known), n=1, cutoff=NEAR)
    hint = f"; did you mean {near[0]}?" if near else ""
    return UserError(f"{command} has no '{found}'{hint}")
