"""Study: a heap of 500 grains comes to rest and stays (two minutes of one core per model).

    study_heap.py [--grains 500] [--settle 200000] [--steps 1000000] [MODEL ...]

Prints kinetic energy (translation and spin) over that of the impact while the heap settles and over the
steps that follow, with the largest way and the largest overlap; fails where a heap that has to rest has
more than 1e-10 of the impact's energy. BEDLOAD_LIGGGHTS names the program.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from liggghts_script import dump_now, kinetic_energy, read_dump
from test_resting import FALL, RESTING_OVERLAP, ROLLING, STATIC, D, heap, overlaps

# Model: tangential model, settings, whether it has to rest.
MODELS = {
    # Its springs have little damping: a spin or two goes on at some 1e-9 of the impact's energy.
    "history": (*STATIC.values(), False),
    "haff_werner stickAfter": (
        "haff_werner rolling_friction epsd2",
        f"{STATIC['settings']} stickAfter 20",
        True,
    ),
    "haff_werner": ("haff_werner", "", False),
}
PIECES = 5


def spin_energy(spheres, state):
    """[J]"""
    return 0.5 * np.sum(np.array([s.inertia for s in spheres]) * np.sum(state.spin**2, 1))


def study(model, grains, settle, steps):
    """Runs one heap, prints its table, returns whether it holds what it should."""
    tangential, settings, rests = MODELS[model]
    layers = int(np.ceil(grains / 64))
    scene = heap(0.5, tangential, layers=layers, width=8, settings=settings)
    scene.spheres = scene.spheres[:grains]
    scene.properties.append(ROLLING)
    pieces = [settle] + [steps // PIECES] * PIECES
    lines = []
    for n, piece in enumerate(pieces):
        lines += [f"run {piece}", *dump_now(f"at{n}.dump")]
    with tempfile.TemporaryDirectory() as folder:
        scene.run(folder, lines, timeout=None)
        states = [read_dump(Path(folder) / f"at{n}.dump") for n in range(len(pieces))]
    impact = grains * 0.5 * scene.spheres[0].mass * FALL**2
    ok = True
    for done, state in zip(np.cumsum(pieces), states):
        spin = spin_energy(scene.spheres, state) / impact
        energy = kinetic_energy(scene.spheres, state) / impact - spin
        way = np.max(np.abs(state.x - states[0].x)) / D
        depth = np.max(overlaps(state.x)) / (RESTING_OVERLAP * D / 2)
        print(f"{model:24} {done:9d} steps: energy {energy:8.1e} (spins {spin:8.1e}) of the "
              f"impact's, largest way since the first row {way:8.1e} D, largest overlap {depth:5.2f} "
              "of restingOverlap", flush=True)
        # No contact bears more than four columns of grains as high as the heap, with a stiffness down to
        # a quarter of the bearing one (that of the impact, which a contact may have to keep: it
        # stiffens only with energy that it has dissipated).
        ok &= depth < (4 * 4 * layers) ** (2 / 3) and (energy + spin < 1e-10 or not rests)
    return ok


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", default=list(MODELS), metavar="MODEL")
    parser.add_argument("--grains", type=int, default=500)
    parser.add_argument("--settle", type=int, default=200000)
    parser.add_argument("--steps", type=int, default=1000000)
    a = parser.parse_args()
    return 0 if all([study(m, a.grains, a.settle, a.steps) for m in a.models]) else 1


if __name__ == "__main__":
    sys.exit(main())
