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
# Rooms of a folder and those below that each may include; below them in turn is allowed as well.
ROOMS = {
    "fluid": {
        "kernels": [],
        "settings": ["kernels"],
        "grid": ["settings"],
        "files": ["settings"],
        "validation": ["grid"],
        "checkpoint": ["grid", "files"],
        "poisson": ["grid"],
        "immersed_boundary": ["validation", "checkpoint"],
        "channel": ["poisson", "immersed_boundary"],
        "statistics": ["channel"],
        "output": ["channel"],
    },
    "coupling": {
        "job": [],
        "exchange": ["job"],
        "bedload_fluid": ["exchange"],
        "checkpoint": ["bedload_fluid"],
        "bedload_dem": ["checkpoint"],
    },
}
MAIN = "main.cpp"  # of a program: puts the parts of all rooms together


def below(rooms, room):
    """All rooms that one may include."""
    return {room}.union(*(below(rooms, other) for other in rooms[room]))


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


@pytest.mark.parametrize("folder", ROOMS)
def test_direction_between_rooms(folder):
    rooms = ROOMS[folder]
    wrong = []
    for path, name in includes(folder):
        if path.name == MAIN:
            continue
        room = path.parts[1]
        assert room in rooms, f"{path}: a room that the test does not know"
        found = re.match(rf'"{folder}/(\w+)/', name)
        against = found and found[1] not in below(rooms, room)
        if against:
            wrong.append(f"{path} includes {name}")
    assert not wrong, "\n".join(wrong)


def test_the_fluid_knows_no_liggghts_and_no_partner():
    assert not [f"{path}: {name}" for path, name in includes("fluid") if LIGGGHTS_OWN.match(name)]
    for path in (ROOT / "fluid").rglob("*.?pp"):
        text = path.read_text(encoding="utf-8")
        assert "Intercomm" not in text and "MPI_COMM_WORLD" not in text, path
