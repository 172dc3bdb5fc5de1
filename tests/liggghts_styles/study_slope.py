"""Study: what friction laws do to grains on a slope of grains (a minute of one core).

    study_slope.py [--friction 0.5] [--angles 5 10 15 20 25 30] [MODEL ...]

Three layers of loose grains on a fixed rough bed, periodic along and across, settle on the level and are
then tilted to each angle. Prints the mean velocity along the slope over the last half of the time, in
sqrt(g D). BEDLOAD_LIGGGHTS names the program.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from liggghts_script import Scene, Sphere, dump_now

D, G = 0.01, 9.81
LONG, WIDE, LAYERS = 6, 4, 3  # grains along, pairs of rows across, loose layers
ROLLING = "fix m9 all property/global coefficientRollingFriction peratomtypepair 1 0.02"
SETTLE, TILTED, SUBSTEPS = 600, 1600, 5  # fluid steps; DEM steps in each

# Tangential model, settings, whether with the property of rolling friction.
MODELS = {
    "haff_werner": ("haff_werner", "", False),
    "haff_werner stickAfter 20": ("haff_werner", "stickAfter 20", False),
    "history": ("history", "", False),
    "haff_werner stickAfter 20, epsd2 0.02": (
        "haff_werner rolling_friction epsd2",
        "stickAfter 20 torsionTorque on",
        True,
    ),
}


def slope(tangential, settings, rolling, friction):
    """Scene of grains over a fixed bed, periodic along x and z; gravity is in its lines' hands."""
    rng = np.random.default_rng(3)
    row = np.sqrt(3) / 2 * D
    spheres = [
        Sphere(((i + 0.5 * (k % 2)) * D, 0.0, k * row), diameter=D)
        for k in range(2 * WIDE)
        for i in range(LONG)
    ]
    bed = len(spheres)
    for layer in range(LAYERS):
        for k in range(2 * WIDE):
            for i in range(LONG):
                wander = rng.uniform(-0.04, 0.04, 3) * D
                place = np.array([(i + 0.25) * D, (1.1 + 1.1 * layer) * D, (k + 0.3) * row])
                spheres.append(Sphere(tuple(place + wander), (0, -0.05, 0), diameter=0.9 * D))
    scene = Scene(
        spheres,
        box=((0.0, LONG * D), (-D, 8 * D), (0.0, 2 * WIDE * row)),
        boundary="p f p",
        substeps=SUBSTEPS,
        friction=friction,
        contact=f"model actm tangential {tangential}",
        settings=settings,
        lines=[f"group bed id 1:{bed}", f"group loose id {bed + 1}:{len(spheres)}", "fix hold bed freeze"],
        integrate="fix integrate loose nve/sphere",
        properties=[ROLLING] if rolling else [],
    )
    return scene, bed


def gravity(angle):
    """Line of a gravity that points down a slope along +x. @param angle in degrees"""
    a = np.radians(angle)
    return f"fix weight all gravity {G} vector {np.sin(a)!r} {-np.cos(a)!r} 0"


def drift(folder, model, friction, angle, tilted=TILTED):
    """Mean velocity of the loose grains along the slope over the second half, in sqrt(g D)."""
    scene, bed = slope(*MODELS[model], friction)
    half = tilted * SUBSTEPS // 2
    lines = [gravity(0), f"run {SETTLE * SUBSTEPS}", "unfix weight", gravity(angle), f"run {half}",
             *dump_now("half.dump", "id type xu yu zu"), f"run {half}",
             *dump_now("whole.dump", "id type xu yu zu")]  # fmt: skip
    scene.run(folder, lines)
    read = [np.loadtxt(Path(folder) / f"{name}.dump", skiprows=9) for name in ("half", "whole")]
    way = np.mean(read[1][bed:, 2] - read[0][bed:, 2])
    return way / (half * scene.dt) / np.sqrt(G * D)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", default=list(MODELS), metavar="MODEL")
    parser.add_argument("--friction", type=float, default=0.5)
    parser.add_argument("--angles", type=float, nargs="*", default=[5, 10, 15, 20, 25, 30])
    a = parser.parse_args()
    print("| law | " + " | ".join(f"{angle:g}°" for angle in a.angles) + " |")
    print("|---" * (len(a.angles) + 1) + "|")
    for model in a.models:
        found = []
        for angle in a.angles:
            with tempfile.TemporaryDirectory() as folder:
                found.append(f"{drift(folder, model, a.friction, angle):.1e}")
        print(f"| {model} | " + " | ".join(found) + " |", flush=True)


if __name__ == "__main__":
    main()
