"""Validation of packings of spheres at rest, and of free ones: what flows through their pores. No study of its own."""

import math

import numpy as np

from .random_spheres import random_spheres, write_spheres
from .sphere_theory import VOLUME
from .validation_runs import DIFFUSION, Result, Row, Runner, drag_factor, marks
from .validation_suspensions import mean_fall

LATTICES = {
    "face-centred": np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]]),
    "body-centred": np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.5]]),
}
OFF_THE_CELLS = np.array([0.26, 0.27, 0.24])  # of the edge
ALIKE = "no pore lets more through"
FIXED, HELD = "fixed all", " "  # spheres that could move, and do not


def _packing(runner: Runner, label: str, centres: np.ndarray, length: float, cells: int, kind: str,
             step: float = 1.0, loops: int = 1) -> float:  # fmt: skip
    """K of spheres of D = 1 at rest in a periodic cube in Stokes flow; `step` in that of nu dt/h^2 = DIFFUSION."""
    label += f"-{cells}-{'fixed' if kind == FIXED else 'held'}"
    if (step, loops) != (1.0, 1):
        label += f"-{step:g}-{loops}"
    file = runner.folder / f"{label}.liggghts"
    runner.folder.mkdir(parents=True, exist_ok=True)
    write_spheres(centres, file, label)
    h = length / cells
    run = runner("random_array", f"packing-{label}", {
        "grid.cells": [cells] * 3, "grid.length": [length] * 3, "fluid.kinematic_viscosity": 1.0,
        "fluid.convection": "off", "spheres.forcing_loops": loops, "time.step": step * DIFFUSION * h * h,
        "time.end": 0.15,
    }, {"length": length, "spheres": str(file), "kind": kind})  # fmt: skip
    return drag_factor(run, length) / len(centres)


def packing(runner: Runner) -> Result:
    """Flow through packings at rest: of spheres that could move, beside fixed ones; and of touching fixed spheres."""
    result = Result("Flow through packings at rest, Stokes flow", axes=("D/h", "K of held spheres over fixed ones"))

    def lattice(kind: str, fraction: float) -> tuple[np.ndarray, float]:
        places = LATTICES[kind]
        length = (len(places) * VOLUME / fraction) ** (1.0 / 3.0)
        return np.mod(places + OFF_THE_CELLS, 1.0) * length, length

    def held_over_fixed(name: str, centres: np.ndarray, length: float, cells: int, **more) -> float:
        held, fixed = (_packing(runner, name, centres, length, cells, kind, **more) for kind in (HELD, FIXED))
        return held / fixed

    # Markers beside two others keep all of their volume with this step; what is left is the ring about the contacts.
    for fraction, several in ((0.5, (10, 13, 20)), (0.6, (9, 12, 18))):
        centres, length = lattice("face-centred", fraction)
        points = []
        for cells in several:
            share, across = held_over_fixed(f"fcc-{fraction}", centres, length, cells), cells / length
            points.append((across, share))
            what = f"K of a face-centred packing of {fraction}, held spheres over fixed ones, D/h = {across:.1f}"
            result.rows.append(Row(what, share, 1.0, 0.05 if across < 10 else None, source=ALIKE))
        result.curves.append(marks(f"face-centred, {fraction}", points))
    for step, loops, words in ((0.25, 1, "a quarter of the step"), (1 / 16, 1, "a sixteenth of the step"),
                               (1.0, 4, "four loops")):  # fmt: skip
        share = held_over_fixed("fcc-0.6", *lattice("face-centred", 0.6), 9, step=step, loops=loops)
        result.rows.append(Row(f"the same of 0.6, D/h = 5.9, {words}", share, 1.0, source=ALIKE))
    length = 4.5  # the lattice that they begin from fits
    centres = random_spheres(0.45, length, 0)
    for n in (6, 8):
        share = held_over_fixed("random-0.45", centres, length, round(n * length))
        what = f"K of spheres at random places, 0.45, held over fixed ones, D/h = {n}"
        result.rows.append(Row(what, share, 1.0, 0.05, source=ALIKE))
    for kind, fraction, due in (("face-centred", math.pi / math.sqrt(18.0), 435.0),
                                ("body-centred", math.pi * math.sqrt(3.0) / 8.0, 162.9)):  # fmt: skip
        for n in (8, 12, 17):
            centres, length = lattice(kind, fraction)
            found = _packing(runner, f"touching-{kind}", centres, length, round(n * length), FIXED)
            result.rows.append(Row(f"K of fixed spheres that touch, {kind}, D/h = {n}", found, due,
                                   source="Zick & Homsy 1982, from memory"))  # fmt: skip
    speeds = {}
    for n in (6, 8, 12):
        run = runner("hindered", f"packing-free-{n}", {
            "grid.cells": [4 * n] * 3, "grid.length": [4.0] * 3, "fluid.kinematic_viscosity": 1.0,
            "time.step": DIFFUSION / n**2, "time.end": 1.5, "output.spheres_every": 0.1,
        }, {"fraction": 0.3, "length": 4.0})  # fmt: skip
        speeds[n] = float(np.mean(mean_fall(run, since=0.75)))
    for n in (6, 8):
        # Places hardly change in the time, a tenth of a diameter.
        result.rows.append(Row(f"speed of free spheres that settle, volume fraction 0.3, D/h = {n}", speeds[n],
                               speeds[12], 0.03, source="D/h = 12"))  # fmt: skip
    result.remarks.append(
        "Held spheres are mobile ones that the script freezes: their markers stand back from each other, which fixed "
        "ones' do not. At a pore, with a third surface near, they keep a share (fluid/immersed_boundary/README.md, "
        "\"Pores\"). In shorter steps and with more loops that is less, or films would be resolved too well there."
    )
    return result


CASES = {"packing": packing}
