"""What history.csv says that mobile grains give to y walls is what the grains do not have from the walls, and no less
or more of it: grain_stress_lower and grain_stress_upper against the spheres' momentum."""

import itertools

import h5py
import numpy as np
import pytest

from bedload_post.outputs import Run
from programs import BIN, command, run

MASS, AREA = 1.5 * np.pi / 6.0, 4.0 * 4.0  # of a sphere and of a wall of the scene below
STEPS, TIME_STEP = 12, 0.002

FLUID = f"""\
grid.cells = [32, 24, 32]
grid.length = [4.0, 3.0, 4.0]
fluid.kinematic_viscosity = 0.05
time.step = {TIME_STEP}
time.end = {STEPS * TIME_STEP}
boundary.x = "periodic"
boundary.y = "no_slip"
boundary.y_lower_velocity = [0.4, 0.0, 0.0]
boundary.z = "periodic"
output.history_every = 1
output.spheres_every = {TIME_STEP}
"""

# Sphere 1 comes at the lower wall, which slides; 2 turns and goes along the upper one, a fraction of a cell from it;
# 3 is held by both programs' rules and gives nothing to the wall that it touches.
SCRIPT = """\
units        si
atom_style   granular
atom_modify  map array
newton       off
communicate  single vel yes
boundary     p f p
region       box block 0 4 0 3 0 4 units box
create_box   2 box
neighbor     0.8 bin
neigh_modify delay 0
create_atoms 1 single {place} 2 units box
create_atoms 1 single 2.5 2.48 2 units box
create_atoms 2 single 2.5 0.5 2 units box
set          atom 1 diameter 1 density 1.5 vx -0.6 vy -0.8 vz 0
set          atom 2 diameter 1 density 1.5 vx 0.9 vy 0 vz 0 omegaz 1.5
set          atom 3 diameter 1 density 1.5
group        free type 1
group        bed type 2
fix          fluid all couple/fluid fixed bed
fix          m1 all property/global coefficientRestitution peratomtypepair 2 0.97 0.97 0.97 0.97
fix          m2 all property/global coefficientFriction peratomtypepair 2 0.3 0.3 0.3 0.3
fix          m3 all property/global youngsModulus peratomtype 5e6 5e6
fix          m4 all property/global poissonsRatio peratomtype 0.3 0.3
{model}
{lower}
fix          upper all wall/gran {contact} primitive type 1 yplane 3.0
fix          motion free nve/sphere
fix          still bed freeze
coupled_run
"""

FLAT = "fix lower all wall/gran {contact} primitive type 1 yplane 0.0 shear x 0.4"
# A slope inside the box through (2, 0.5): what acts along its normal has a part along x, where friction acts, too.
SLOPE = -0.3
TILTED = ("fix slope all mesh/surface file slope.stl type 1 surface_vel 0.4 -0.12 0\n"
          "fix lower all wall/gran {contact} mesh n_meshes 1 meshes slope")  # fmt: skip
RUBS, FILMS = "model actm tangential haff_werner", "fix film all lubrication"
CASES = {  # contact, the line of its films, wall of sphere 1 and how far from that it is
    "friction": (RUBS, "", FLAT, 0.001),
    "contact on a slope": (RUBS, "", TILTED, 0.001),
    "films": (RUBS, FILMS, FLAT, 0.005),
    "films on a slope": (RUBS, FILMS, TILTED, 0.005),
    "films that a contact model does not know": ("model hertz tangential off", "", FLAT, 0.005),
}


def place(wall, gap):
    """x and y of sphere 1 at a distance from its wall."""
    if wall == FLAT:
        return 1.0, 0.5 + gap
    foot, normal = np.array([1.2, 0.5 + SLOPE * (1.2 - 2.0)]), np.array([-SLOPE, 1.0]) / np.hypot(SLOPE, 1.0)
    return foot + (0.5 + gap) * normal


def slope_mesh():
    """Eight triangles of the slope around sphere 1, one cell of the box's length wide."""
    facets = []
    for x, z in itertools.product((0.2, 1.2), (1.0, 2.0)):
        corner = [(x + i, 0.5 + SLOPE * (x + i - 2.0), z + k) for i, k in ((0, 0), (0, 1), (1, 1), (1, 0))]
        for triangle in (corner[:3], [corner[0], *corner[2:]]):
            points = "".join("   vertex {} {} {}\n".format(*point) for point in triangle)
            facets.append(f" facet normal {-SLOPE} 1 0\n  outer loop\n{points}  endloop\n endfacet\n")
    return f"solid slope\n{''.join(facets)}endsolid slope\n"


@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)])
@pytest.mark.parametrize("case", CASES)
def test_grains_lose_what_walls_get(tmp_path, case, ranks):
    """m dv = F dt - stress area dt of each sphere by itself, over all steps: no term of it zeroed, doubled or turned
    about is within the bound. Half of the last DEM step's impulse is still to come, 1/360 of it all if it were even."""
    contact, film, wall, gap = CASES[case]
    x, y = place(wall, gap)
    script = SCRIPT.format(model=f"pair_style gran {contact}\npair_coeff * *\n{film}", contact=contact,
                           place=f"{x:.9f} {y:.9f}", lower=wall.format(contact=contact))  # fmt: skip
    (tmp_path / "in.liggghts").write_text(script, encoding="utf-8")
    (tmp_path / "slope.stl").write_text(slope_mesh(), encoding="utf-8")
    (tmp_path / "fluid.toml").write_text(FLUID, encoding="utf-8")
    fluid = [str(BIN / "bedload-fluid"), "fluid.toml", "--out", "out"]
    dem = [str(BIN / "bedload-dem"), "-in", "in.liggghts", "-log", "none"]
    result = run(command(fluid, dem, ranks), tmp_path, timeout=120)
    assert result.status == 0, result.output
    history = Run(tmp_path / "out").history()
    with h5py.File(tmp_path / "out" / "spheres.h5") as file:
        tag, velocity, force = (file["mobile"][name][:] for name in ("tag", "velocity", "force"))
    for end, sphere in (("lower", 1), ("upper", 2)):
        speed, load = velocity[tag == sphere, 0], force[tag == sphere, 0]
        assert len(speed) == STEPS + 1
        gained = MASS * (speed[-1] - speed[0])
        from_fluid = TIME_STEP * np.sum(load[1:])
        to_wall = TIME_STEP * AREA * np.sum(history[f"grain_stress_{end}"])
        assert to_wall == pytest.approx(from_fluid - gained, rel=0.01)
