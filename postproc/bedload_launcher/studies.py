"""Studies by name: the modules of postproc/bedload_studies, imported only when one is run.

They need packages (numpy, matplotlib) that the launcher itself, which may still have to build, does
without.
"""

import argparse
import ast
import importlib
from collections.abc import Callable, Sequence

from .build import ROOT
from .errors import UserError, no_option, unknown

FOLDER = ROOT / "postproc" / "bedload_studies"


def all_studies() -> dict[str, str]:
    """Name and first sentence of each study; a module without `add_options` and `run` is a helper of the others."""
    found = {}
    for file in sorted(FOLDER.glob("[!_]*.py")):
        module = ast.parse(file.read_text(encoding="utf-8"))
        functions = {part.name for part in module.body if isinstance(part, ast.FunctionDef)}
        if {"add_options", "run"} <= functions:
            text = " ".join((ast.get_docstring(module) or "").split("\n\n")[0].split())
            found[file.stem] = text
    return found


def run_study(
    name: str, arguments: Sequence[str], make_parser: Callable[[str, str], argparse.ArgumentParser],
    build: Callable[[], None],
) -> int:  # fmt: skip
    """Runs study `name` with its own `arguments`; `make_parser(prog, description)` gives the parser. `build` is called
    once they are understood: help and mistakes take no build.

    Raises UserError for a mistake, and where a run lacks what the study reads.
    """
    studies = all_studies()
    if name not in studies:
        raise unknown("study", name, studies)
    module = importlib.import_module(f"bedload_studies.{name}")
    parser = make_parser(f"bedload study {name}", studies[name])
    module.add_options(parser)
    options, left_over = parser.parse_known_args(arguments)
    if left_over:
        raise no_option(parser.prog, left_over[0], parser._option_string_actions)
    build()
    from bedload_post.outputs import MissingOutput  # needs packages, as the studies do

    try:
        return module.run(options)
    except MissingOutput as missing:
        raise UserError(str(missing)) from missing
