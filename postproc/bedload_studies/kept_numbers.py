"""numbers.json of a kept report. No study of its own."""

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path

from bedload_launcher.errors import UserError


def kept_numbers(folder: Path, needed: Sequence[str]) -> dict:
    """The numbers that a report keeps; raises UserError where it lacks one of those `needed`, as other studies' do."""
    file = folder / "numbers.json"
    if not file.is_file():
        raise UserError(f"{folder} has no numbers.json, so it is no report of this study.")
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise UserError(f"{file} cannot be read: {error}.") from error
    for name in needed:
        if not isinstance(kept, dict) or name not in kept:
            raise UserError(f"{file} is of no report of this study: it has no '{name}'.")
    return kept


def refuse_others(
    options: argparse.Namespace, add_options: Callable[[argparse.ArgumentParser], None], taken: Sequence[str]
) -> None:
    """Raises UserError where the user gave an option that a report made anew from its numbers does not listen to:
    another than those `taken`."""
    parser = argparse.ArgumentParser()
    add_options(parser)
    for name, default in vars(parser.parse_args([])).items():
        if name not in taken and getattr(options, name) != default:
            option, others = name.replace("_", "-"), " and ".join(f"--{other}" for other in taken)
            raise UserError(f"--{option} changes nothing in a report made anew from its numbers; with --rewrite "
                            f"only {others} may be given.")  # fmt: skip
