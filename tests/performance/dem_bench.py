"""Speed of the contact models on a dense bed of 20 000 grains: one line of JSON per measurement.

    dem_bench.py PROGRAM [--grains 20000] [--steps 1000] [--repeat 3]

PROGRAM is a LIGGGHTS with bedload's styles (bedload-dem or liggghts-with-styles). LIGGGHTS' own
`hertz tangential history` is measured with Debian's `liggghts` if it is there, else with PROGRAM.
Processor time of the steps counts: that of a run less that of one without steps. The runs of the
models alternate and the fastest of the repeats is taken, so that a busy machine disturbs least.
"""

import argparse
import json
import os
import re
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path

D = 0.01
DT = 1e-5
PROPERTIES = """
fix m1 all property/global coefficientRestitution peratomtypepair 1 0.8
fix m2 all property/global coefficientFriction peratomtypepair 1 0.3
fix m3 all property/global fluidTimeStep scalar 1.5e-4
fix m4 all property/global youngsModulus peratomtype 5e6
fix m5 all property/global poissonsRatio peratomtype 0.3
"""
FILM = "fix film all lubrication viscosity 1e-3 range 1e-3"
GRID = f"fix h all property/global fluidCellSize scalar 5e-4\n{FILM}"
# name: (contact model, spacing of the grains in diameters, further lines, plain LIGGGHTS will do)
CASES = {
    "hertz history": ("model hertz tangential history", 0.9997, "", True),
    "actm haff_werner": ("model actm tangential haff_werner", 0.9997, "", False),
    "actm haff_werner, films": ("model actm tangential haff_werner", 0.9997, FILM, False),
    "rpm haff_werner": ("model rpm tangential haff_werner", 1.0999, "", False),
    # Gaps of 0.4 h: all twelve neighbours of a grain have films.
    "near, films": ("model actm tangential haff_werner", 1.02, GRID, False),
    # Gaps of half a diameter, and of just more than the range of the film.
    "far apart": ("model actm tangential haff_werner", 1.5, "", False),
    "far apart, films": ("model actm tangential haff_werner", 1.5, FILM, False),
    "beyond range": ("model actm tangential haff_werner", 1.11, "", False),
    "beyond range, films": ("model actm tangential haff_werner", 1.11, FILM, False),
}


def script(case, grains, steps):
    contact, spacing, lines, _ = CASES[case]
    settings = "range 1e-3" if "rpm" in contact else ""
    # Face-centred cubic, square layers; a quarter as high as wide.
    side = round((grains * 2) ** (1 / 3))
    layers = max(1, round(grains / (side * side) / 2))
    cell = 2**0.5 * spacing * D
    wide = cell * round(side / 2**0.5)
    high = cell * layers
    return f"""
atom_style granular
atom_modify map array
boundary p f p
newton off
communicate single vel yes
units si
region box block 0 {wide!r} {-0.1 * D!r} {high + 2 * D!r} 0 {wide!r} units box
create_box 1 box
neighbor 2e-3 bin
neigh_modify delay 0
pair_style gran {contact} {settings}
pair_coeff * *
{PROPERTIES}
lattice fcc {cell!r} origin 0.25 0.3537 0.25
region bed block 0 {wide - 1e-9!r} 0 {high!r} 0 {wide - 1e-9!r} units box
create_atoms 1 region bed
set group all diameter {D} density 2500
displace_atoms all random {5e-5 * D} {5e-5 * D} {5e-5 * D} 15485863 units box
fix weight all gravity 9.81 vector 0 -1 0
fix floor all wall/gran {contact} primitive type 1 yplane 0.0 {settings}
{lines}
fix integrate all nve/sphere
timestep {DT}
thermo 100000
run {steps}
"""


def measure(program, case, grains, steps):
    """Processor seconds of the run, and the number of grains."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in.liggghts").write_text(script(case, grains, steps))
        environment = {
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "RES_OPTIONS": "timeout:1 attempts:1",
            **os.environ,
        }
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        said = subprocess.run(
            [program, "-in", "in.liggghts", "-log", "none"],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            errors="replace",
            check=False,
        ).stdout
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    loops = re.findall(r"Loop time of \S+ on \d+ procs for \d+ steps with (\d+) atoms", said)
    if not loops:
        raise SystemExit(f"dem_bench: the run of '{case}' failed:\n{said[-2000:]}")
    return used, int(loops[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="LIGGGHTS with bedload's styles")
    parser.add_argument("--grains", type=int, default=20000)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--repeat", type=int, default=3)
    a = parser.parse_args()
    program = str(Path(a.program).resolve())
    best, count = {}, {}
    for _ in range(a.repeat):
        for case, (_, _, _, plain) in CASES.items():
            used = (plain and shutil.which("liggghts")) or program
            empty, _ = measure(used, case, a.grains, 0)
            whole, count[case] = measure(used, case, a.grains, a.steps)
            best[case] = min(whole - empty, best.get(case, whole))
    for case, seconds in best.items():
        base = case.removesuffix(", films") if case[0] in "fb" else "hertz history"
        record = {
            "bench": "dem",
            "case": case,
            "grains": count[case],
            "ranks": 1,
            "steps_per_processor_second": round(a.steps / seconds, 2),
            "time_over_reference": round(seconds / best[base], 3),
            "reference": base,
        }
        print(json.dumps(record), flush=True)


if __name__ == "__main__":
    main()
