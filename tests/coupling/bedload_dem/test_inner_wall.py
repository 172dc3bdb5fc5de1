"""A wall of LIGGGHTS inside the box, through which the fluid goes: its grid resolves nothing of the film there."""

import numpy as np
import pytest

from pocket import FLOOR, SCENE, job

HEIGHT, RADIUS, VISCOSITY = 1.2, 0.5, 0.05  # of the wall; of the spheres; dynamic
CELL, TIME_STEP, LOOPS = 0.125, 0.02, 2  # as in its fluid.toml
STEPS, SUBSTEPS = 2, 15
DUMP = ("dump films all custom 1 ${out}/films.txt id y vy f_lubricationForce[2]\n"
        "dump_modify films sort id format \"%d %.15g %.15g %.15g\"\ncoupled_run")  # fmt: skip


@pytest.mark.parametrize("height, whole", [(HEIGHT, True), (0.0, False)], ids=["inside", "end of the box"])
def test_the_film_is_whole_where_the_fluid_has_no_wall(tmp_path, height, whole):
    """F = 6 π μ R² v/ζ at a wall inside; at the end of the box what the grid lacks of it, S = exp(-a s - 0.8 s²) with
    s = ζ/h and a = 1.8 - 0.23 ln(λ/0.05), λ that of two loops."""
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    for found, given in (
        (FLOOR, FLOOR.replace("yplane 0.0", f"yplane {height}")),
        ("create_atoms    1 region layer", f"create_atoms 1 single 1.0 {2.5 if height == 0.0 else 0.5} 1.6 units box"),
        ("1.95 1.75 1.1", f"1.95 {height + RADIUS + 0.1} 1.1"),
        ("set 0.7 -0.6 0.05", "set 0.0 -0.3 0.0"),
        ("\ncoupled_run", "\n" + DUMP),
    ):
        assert found in text
        text = text.replace(found, given)
    script = tmp_path / "in.liggghts"
    script.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    result = job(out, "--steps", str(STEPS), "--set", f"fluid.kinematic_viscosity={VISCOSITY}", script=script)
    assert result.status == 0, result.output
    rows = [line.split() for line in (out / "films.txt").read_text().splitlines() if line.startswith("2 ")]
    y, v, force = np.array(rows, dtype=float).T[1:]
    assert len(y) == STEPS * SUBSTEPS + 1
    gap = y - RADIUS - height
    share = force * gap / (6 * np.pi * VISCOSITY * RADIUS**2 * -v)
    # Force of the step before, at a gap that is up to half a per cent longer.
    s, number = gap / CELL, VISCOSITY * TIME_STEP / CELL**2 / LOOPS**1.3
    lacks = np.exp(-(1.8 - 0.23 * np.log(number / 0.05)) * s - 0.8 * s**2)
    expected = np.ones(len(gap)) if whole else lacks
    assert share[2:] == pytest.approx(expected[2:], rel=0.01)
