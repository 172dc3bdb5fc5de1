"""Spheres that a script changes between two coupled runs: what the fluid kept of them is theirs still, or of none."""

import numpy as np
import pytest

from programs import BIN, command, run

from bedload_post.outputs import Run

STEP, BEFORE = 0.02, 10  # length; steps in the first coupled run
FLUID = """[grid]
cells = [20, 20, {cells}]
length = [2.0, 2.0, {length}]
[boundary]
y = "periodic"
[fluid]
kinematic_viscosity = 0.02
[time]
step = 0.02
end = 0.4
[reference]
diameter = 0.8
sphere_density = 2.5
"""
GRAINS = """variable out index .
units si
atom_style granular
atom_modify map array
newton off
communicate single vel yes
boundary p p p
region box block 0 2 0 2 0 {length} units box
create_box 1 box
neighbor 0.6 bin
neigh_modify delay 0
{spheres}
fix m1 all property/global coefficientRestitution peratomtypepair 1 0.9
fix fluid all couple/fluid
pair_style gran model actm
pair_coeff * *
fix motion all nve/sphere
coupled_run steps 10
{change}
coupled_run
"""
MOVING = "create_atoms 1 single 0.9 1.05 {z} units box\nset atom {tag} diameter {d} density {density} vx 1.0"
STILL = "create_atoms 1 single 0.3 0.4 {z} units box\nset atom {tag} diameter 0.5 density 2.5"


def made(folder, spheres, change, ranks=(1, 1), length=2.0, gravity="", options=()):
    """What the two coupled runs say."""
    folder.mkdir()
    fluid_toml = FLUID.format(cells=int(10 * length), length=length)
    (folder / "fluid.toml").write_text(fluid_toml.replace("[fluid]", f"[fluid]\n{gravity}"), encoding="utf-8")
    (folder / "in.liggghts").write_text(GRAINS.format(length=length, spheres=spheres, change=change), encoding="utf-8")
    fluid = [str(BIN / "bedload-fluid"), str(folder / "fluid.toml"), "--out", str(folder / "out"), *options]
    if ranks[0] > 1:
        fluid += ["--set", f"ranks.along_z={ranks[0]}"]
    dem = [str(BIN / "bedload-dem"), "-in", str(folder / "in.liggghts"), "-var", "out", str(folder), "-log", "none"]
    result = run(command(fluid, dem, ranks), folder)
    assert result.status == 0, result.output
    return result.output


def speeds(folder, spheres, change, tag=1, ranks=(1, 1), length=2.0):
    """Spins and velocities of sphere `tag` from the first step of the second coupled run on."""
    made(folder, spheres, change, ranks, length)
    samples = next(Run(folder / "out").sample_blocks())
    mine = (samples.tag == tag) & (samples.time > (BEFORE + 0.5) * STEP)
    return samples.angular_velocity[mine], samples.velocity[mine]


@pytest.mark.parametrize("exchange", ["stage", "step"])
def test_a_sphere_that_moves_from_the_start_is_no_stage_behind(tmp_path, exchange):
    """0.72 cells in a step: it goes as one that lies in fluid at rest and is set going between two coupled runs. With
    markers where the spheres start it was up to a per cent slower."""
    lies, goes = (f"{MOVING.format(z=1.0, tag=1, d=0.8, density=2.5)}\nset atom 1 vx {v}" for v in (0.0, 3.6))
    options = ("--set", f"coupling.exchange={exchange}")
    made(tmp_path / "at_once", goes, "", options=options)
    made(tmp_path / "waits", lies, "set atom 1 vx 3.6", options=options)
    at_once, waits = (next(Run(tmp_path / name / "out").sample_blocks()) for name in ("at_once", "waits"))
    first = at_once.velocity[1:6, 0]
    assert first == pytest.approx(waits.velocity[BEFORE + 1 : BEFORE + 6, 0], rel=1e-12)
    assert (first > 1.0).all() and (first < 3.0).all()  # the fluid that it pushes aside has slowed it


@pytest.mark.parametrize("density", [0.5, 1.0, 2.5])
def test_a_sphere_that_shrinks_keeps_its_speed(tmp_path, density):
    """The fluid around it goes with it. Where the smaller volume counted as lost momentum it had 0.40 to 0.57 of its
    speed one step later."""
    sphere = MOVING.format(z=1.0, tag=1, d=1.1, density=density) + "\nset atom 1 omegaz 2.0"
    plain_spin, plain = speeds(tmp_path / "plain", sphere, "")
    spin, shrunk = speeds(tmp_path / "shrunk", sphere, "set atom 1 diameter 0.8")
    assert shrunk[:, 0] == pytest.approx(plain[0, 0], rel=0.15)  # and nothing drags it forward again
    assert spin[:, 2] == pytest.approx(plain_spin[0, 2], rel=0.15)  # turned back where it counted


def test_a_sphere_put_elsewhere_starts_afresh_on_any_ranks(tmp_path):
    """The fluid there is at rest. On one rank the sphere used to pay for that at once: 0.286 in place of 0.442."""
    sphere, jump = MOVING.format(z=1.5, tag=1, d=0.8, density=2.5), "displace_atoms all move 0 0 3 units box"
    _, one = speeds(tmp_path / "one", sphere, jump, length=6.0)
    _, two = speeds(tmp_path / "two", sphere, jump, ranks=(2, 1), length=6.0)
    assert one[0, 0] == pytest.approx(0.442, abs=0.01)
    assert two == pytest.approx(one, abs=1e-9)


def test_a_sphere_with_the_number_of_another_one_begins_afresh(tmp_path):
    """A moving sphere is deleted, and one at rest made near by, which gets the number that is free or a new one."""
    new = ("group gone id {gone}\ndelete_atoms group gone compress no\ncreate_atoms 1 single 0.6 1.2 1.0 units box\n"
           "set atom {tag} diameter 0.8 density 2.5")  # fmt: skip
    still = STILL.format(z=0.3, tag="{tag}")
    moving = MOVING.format(z=1.0, tag="{tag}", d=0.8, density=2.5)
    last = f"{still.format(tag=1)}\n{moving.format(tag=2)}"
    first = f"{moving.format(tag=1)}\n{still.format(tag=2)}"
    _, again = speeds(tmp_path / "again", last, new.format(gone=2, tag=2), tag=2)
    _, fresh = speeds(tmp_path / "fresh", first, new.format(gone=1, tag=3), tag=3)
    assert again == pytest.approx(fresh, abs=1e-9)
    assert np.linalg.norm(fresh[-1]) > 0.02  # the deleted one's wake takes it along


@pytest.mark.parametrize("density, falls", [(2.5, True), (1.0, False)])
def test_a_box_that_falls_is_warned_of(tmp_path, density, falls):
    """Nothing holds what weighs in a box that is periodic everywhere; a sphere as dense as the fluid does not."""
    weight = "fix weight all gravity 1.0 vector 0 -1 0"
    sphere = MOVING.format(z=1.0, tag=1, d=0.8, density=density) + f"\n{weight}"
    said = made(tmp_path / "run", sphere, "", gravity="gravity = [0.0, -1.0, 0.0]")
    assert ("acts along y, where nothing holds the box back" in said) == falls
