"""Which version of the project a result is made by."""

import subprocess

from .build import ROOT


def commit() -> str:
    """The commit of this folder, "-dirty" where files are changed; empty where git does not know."""
    return subprocess.run(
        ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=12"],
        capture_output=True, text=True, check=False,
    ).stdout.strip()  # fmt: skip
