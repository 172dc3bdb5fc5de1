"""Includes run one way: coupling -> fluid, coupling -> liggghts_styles -> LIGGGHTS. What is below knows
nothing of what is above, nor the two at the bottom of each other."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIGGGHTS_OWN = re.compile(r'"(lammps|modify|fix|atom|pair\w*|domain|update|contact_models|fix_\w+)\.h"')
FORBIDDEN = {
    "fluid": ["coupling", "liggghts_styles", "tests"],
    "liggghts_styles": ["fluid", "coupling", "tests"],
    "coupling": ["tests"],
}


def includes(folder):
    """(file, what stands behind #include) for every source of a folder."""
    for path in sorted((ROOT / folder).rglob("*")):
        if path.suffix in {".hpp", ".cpp", ".h"}:
            text = path.read_text(encoding="utf-8")
            for name in re.findall(r"^\s*#\s*include\s+(\S+)", text, re.MULTILINE):
                yield path.relative_to(ROOT), name


@pytest.mark.parametrize("folder", FORBIDDEN)
def test_direction(folder):
    found = list(includes(folder))
    assert len(found) > 10, "the folder should have sources"
    wrong = [
        f"{path} includes {name}"
        for path, name in found
        if any(name.strip('"<>').startswith(other + "/") for other in FORBIDDEN[folder])
    ]
    assert not wrong


def test_the_fluid_knows_no_liggghts_and_no_partner():
    assert not [f"{path}: {name}" for path, name in includes("fluid") if LIGGGHTS_OWN.match(name)]
    for path in (ROOT / "fluid").rglob("*.?pp"):
        text = path.read_text(encoding="utf-8")
        assert "Intercomm" not in text and "MPI_COMM_WORLD" not in text, path
