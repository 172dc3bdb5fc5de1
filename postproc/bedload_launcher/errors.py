"""A user's mistake, and the nearest name to offer."""

import difflib
from collections.abc import Iterable


class UserError(Exception):
    """One sentence that says what was found and what is allowed."""


def unknown(kind: str, found: str, known: Iterable[str]) -> UserError:
    """The sentence for a name that does not exist, with the nearest one that does."""
    names = sorted(known)
    if not names:
        return UserError(f"there is no {kind} '{found}', and there are no others.")
    near = difflib.get_close_matches(found, names, n=1, cutoff=0.0)
    return UserError(
        f"there is no {kind} '{found}'; the nearest is '{near[0]}' (all: {', '.join(names)})."
    )
