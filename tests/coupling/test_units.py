"""The same scene in other units has the same answer: no length, time or mass is hidden in either program.

All numbers of the scene `pocket` are scaled by powers of two (grains of a millimetre in water, about), so that the two
runs differ by what is not scaled, and by the round-off of roots."""

import csv
import re

import numpy as np
import pytest

from pocket import SCENE, numbers
from programs import BIN, command, run

LENGTH, VELOCITY, DENSITY = 2.0**-10, 2.0**-3, 2.0**10
TIME = LENGTH / VELOCITY
STEPS = 130  # the grain at the bed has hit it, and is not yet thrown out of the box by rpm

# Key or words before numbers, and the unit of these.
FLUID = {
    "length": LENGTH, "kinematic_viscosity": LENGTH * VELOCITY, "gravity": VELOCITY / TIME,
    "bulk_velocity": VELOCITY, "velocity": VELOCITY, "height": LENGTH, "diameter": LENGTH,
    "density": DENSITY, "sphere_density": DENSITY, "step": TIME, "end": TIME,
}  # fmt: skip
SCRIPT = {
    "region +box block": LENGTH, "region +layer block": LENGTH, "neighbor": LENGTH, "lattice +custom": LENGTH,
    "create_atoms +2 single": LENGTH, "diameter": LENGTH, "density": DENSITY, "velocity +grains set": VELOCITY,
    "gravity": VELOCITY / TIME,
}  # fmt: skip
NUMBER = r"-?\d+(?:\.\d+)?"


def scaled(text, words, between):
    """`text` with the numbers behind the `words` in their units."""
    for word, unit in words.items():
        numbers_there = rf"(?m)(^|(?<= ))({word}{between})((?:{NUMBER}[, ]*)+)"
        text, count = re.subn(
            numbers_there,
            lambda found, unit=unit: found[1] + found[2]
            + re.sub(NUMBER, lambda number: repr(float(number[0]) * unit), found[3]),
            text,
        )  # fmt: skip
        assert count > 0, word
    return text


def made(folder, contact, in_other_units):
    """A run of the scene: its mobile spheres, and its collisions."""
    folder.mkdir()
    fluid = (SCENE / "fluid.toml").read_text(encoding="utf-8")
    fluid = fluid.replace("[fluid]", "[fluid]\ndensity = 1.0")
    fluid = fluid.replace("[reference]", "[reference]\nvelocity = 1.0\ndiameter = 1.0")
    script = (SCENE / "in.liggghts").read_text(encoding="utf-8").replace("actm tangential haff_werner", contact)
    if in_other_units:
        fluid, script = scaled(fluid, FLUID, r" = \[?"), scaled(script, SCRIPT, " +")
    (folder / "fluid.toml").write_text(fluid, encoding="utf-8")
    (folder / "in.liggghts").write_text(script, encoding="utf-8")
    line = command([str(BIN / "bedload-fluid"), "fluid.toml", "--out", "out", "--steps", str(STEPS)],
                   [str(BIN / "bedload-dem"), "-in", "in.liggghts", "-var", "out", "out", "-log", "none"])  # fmt: skip
    result = run(line, folder)
    assert result.status == 0, result.output
    with (folder / "out" / "collisions.csv").open(newline="", encoding="utf-8") as stream:
        collisions = list(csv.DictReader(stream))
    return numbers(folder / "out" / "spheres.h5"), collisions


@pytest.mark.parametrize("contact", ["actm tangential haff_werner", "rpm tangential haff_werner"])
def test_same_answer_in_other_units(tmp_path, contact):
    ours, collisions = made(tmp_path / "ours", contact, False)
    others, their_collisions = made(tmp_path / "others", contact, True)
    assert len(collisions) == len(their_collisions) > 0
    units = {"time": TIME, "position": LENGTH, "velocity": VELOCITY, "angular_velocity": 1.0 / TIME,
             "force": DENSITY * (LENGTH * VELOCITY) ** 2}  # fmt: skip
    for name, unit in units.items():
        here, there = ours[f"mobile/{name}"], others[f"mobile/{name}"] / unit
        # A tolerance or a length that is not scaled would show in the first digits; round-off grows to 1e-14.
        assert np.max(np.abs(here - there)) < 1e-11 * np.max(np.abs(here)), name
