"""What is checked at the start is checked always: a LIGGGHTS script that makes another scene behind its first
coupled_run, or lets a fix make one in the middle of it, meets the same rules and sentences."""

import pytest

from pocket import FLOOR, changed_jobs, check_refused

MOTION = "fix             motion grains nve/sphere"
VELOCITY = "velocity        grains set 0.7 -0.6 0.05 units box"
SMALL = """fix small all particletemplate/sphere 32452843 atom_type 2 density constant 2.5 radius constant 0.1
fix mixture all particledistribution/discrete 49979687 1 small 1
region corner block 3 3.6 2 2.6 1 1.6 units box
fix insert grains insert/pack seed 67867967 distributiontemplate mixture insert_every 15 overlapcheck yes &
 all_in yes particles_in_region 1 region corner
"""


def between(lines):
    """Two coupled runs with some lines between them."""
    return "\ncoupled_run", f"\ncoupled_run steps 1\n{lines}\ncoupled_run"


def before(lines):
    return "\ncoupled_run", f"\n{lines}\ncoupled_run"


# What is changed in the scene `pocket`, and words of the sentence.
REFUSED = {
    "change_box": (between("change_box all x final 0 5 units box"),
                   ["since the coupled_run before", "along x is [0, 4]", "[0, 5]"]),
    "other angles": (before("change_box all triclinic"), ["the fluid's box has right angles"]),
    "deform": (before("fix grow all deform 1 x scale 1.5"), ["along x is [0, 4]", "No fix may change it"]),
    "dt/reset": (before("fix reset all dt/reset 3 NULL 0.0005 0.01 units box"),
                 ["time step of LIGGGHTS is 0.0005", "makes it 0.00133333", "dt/reset"]),
    "gravity": (between("unfix weight\nfix weight all gravity 0.7 vector 0 -1 0"),
                ["since the coupled_run before", "(0, -0.5, 0)", "(0, -0.7, 0)"]),
    "gravity that a variable changes": (
        before("unfix weight\nvariable g equal 0.5+1e-3*step\nfix weight all gravity v_g vector 0 -1 0"),
        ["step 1", "gravity was (0, -0.5, 0) when the run began", "'fix gravity' may change it"]),
    "too small": (between("set atom 9 diameter 0.2"), ["atom 9", "1.6 cells across"]),
    "larger than the box": (between("set atom 10 diameter 2.1"), ["atom 10", "2.1", "only 2 long along z"]),
    "too light": (between("set atom 9 density 0.1"), ["atom 9", "density 0.1", "from 0.3 on"]),
    "created in another": (between("create_atoms 2 single 1.9 1.5 1.1 units box\n"
                                   "set group grains density 2.5"),
                           ["atoms 9 and 11", "overlap"]),
    "set into another": (between("set atom 10 x 2.0 y 1.75 z 1.1"), ["overlap", "at most 0.5"]),
    "inserted too small": (before(SMALL), ["atom 11", "1.6 cells across"]),
    "integrator gone": (between("unfix motion"), ["atom 9 is mobile and has a speed", "nve/sphere"]),
    "run between": (between("run 1"), ["'run' moves the grains without the fluid", "coupled_run"]),
    "bed moved as prescribed": (before("fix drag bed move linear 0.1 0 0 units box"),
                                ["fix move (id drag) moves atom 1,", "'fixed'", "mobile"]),
    "bed that goes on": (before("velocity bed set 0.1 0 0 units box\nfix drag bed nve/noforce"),
                         ["fix nve/noforce (id drag) moves atom 1,", "'fixed'"]),
    "bed that grows": (before("variable size equal 1-1e-5*step\nfix grow bed adapt 1 atom diameter v_size"),
                       ["step 1", "'fixed' have changed during this coupled_run", "adapt"]),
    "bed that is inserted": (before(SMALL.replace("0.1\n", "0.28\n", 1).replace("insert grains", "insert bed")),
                             ["step 1", "'fixed' have changed during this coupled_run", "insert"]),
    "bed that grew in the run before": (
        ("\ncoupled_run", "\nvariable size equal 1-1e-5*step\nfix grow bed adapt 1 atom diameter v_size\n"
                          "coupled_run steps 2\nunfix grow\ncoupled_run"),
        ["step 1", "'fixed' have changed during this coupled_run"]),
    "out through the surface": ((VELOCITY, "set atom 10 y 2.7\nvelocity grains set 0 2 0 units box"),
                                ["atom 10", "out of the box", "0.5 of its radius", "wall/gran"]),
    "coupled anew": (between("unfix fluid\nfix fluid all couple/fluid fixed bed"),
                     ["the fluid has begun with another one", "until the last coupled_run is over"]),
    "coupled by a line that stands again": (between("fix fluid all couple/fluid fixed bed"),
                                            ["the fluid has begun with another one"]),
    "clumps": (before("fix clumps grains multisphere"), ["fix multisphere (id clumps)", "spheres only"]),
    "no integrator": ((MOTION, ""), ["atom 9 is mobile and has a speed", "nve/sphere"]),
}  # fmt: skip

# Commands that initialise LIGGGHTS and make no step.
NO_STEP = "write_restart ${out}/grains\nwrite_data ${out}/grains.txt\ndelete_atoms overlap 0.1 grains bed compress no"
ANOTHER_MODEL = """unfix floor
unfix lubrication
{}
include ${{inputs}}/models/{}.liggghts
fix floor all wall/gran ${{contact}} primitive type 1 yplane 0.0 ${{contact_settings}}"""  # inputs/models/README.md
TAKEN = {
    "another model by its file": before(
        ANOTHER_MODEL.format("", "actm_hw") + "\ncoupled_run steps 1\n"
        + ANOTHER_MODEL.format("variable contact_settings delete", "rpm")),
    "commands without a step": ("\ncoupled_run", f"\ncoupled_run steps 1\n{NO_STEP}\ncoupled_run\n{NO_STEP}"),
    "gravity that a variable states": before(
        "unfix weight\nvariable g equal 0.25*2\nfix weight all gravity v_g vector 0 -1 0"),
}

WARNED = {
    "grains that nothing moves": ((f"{VELOCITY}", "velocity grains set 0 0 0 units box"), (MOTION, "")),
    "unequal grains later": (between("set atom 10 diameter 1.0 density 160"),),
    "no wall and no bed": (("couple/fluid fixed bed", "couple/fluid"), (f"fix             floor all {FLOOR}\n", "")),
    "grains held along x alone": (before("unfix motion\nfix drag grains move linear 0.5 NULL 0 units box"),),
    "grains that move as prescribed": (before("unfix motion\nfix drag grains move linear 0.5 0 0 units box"),),
    "grains that never turn": ((MOTION, MOTION.removesuffix("/sphere")),),
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    cases = {case: (change,) for case, (change, _) in REFUSED.items()} | WARNED
    cases |= {case: (change,) for case, change in TAKEN.items()}
    return changed_jobs(tmp_path_factory.mktemp("changed"), cases, steps=4)


@pytest.mark.parametrize("case", REFUSED)
def test_refused(results, case):
    check_refused(results[case], REFUSED[case][1])


@pytest.mark.parametrize("case", TAKEN)
def test_taken(results, case):
    assert results[case].status == 0, results[case].output


def test_grains_that_nothing_moves_are_warned_of(results):
    result = results["grains that nothing moves"]
    assert result.status == 0, result.output
    assert result.output.count("no fix moves it, so that it stays where it is") == 1


def test_a_warning_comes_when_the_spheres_call_for_it(results):
    """64 times the mass of the other one, from the second coupled_run on."""
    result = results["unequal grains later"]
    assert result.status == 0, result.output
    assert result.output.count("64 times the mass of the lightest") == 1


def test_grains_that_nothing_keeps_in_the_box_are_warned_of(results):
    result = results["no wall and no bed"]
    assert result.status == 0, result.output
    assert result.output.count("gravity points along y, but the script has no wall") == 1
    assert "yplane 0 " in result.output
    assert "has no wall" not in results["unequal grains later"].output  # there a floor and a bed


def test_grains_that_are_held_in_one_direction_are_warned_of(results):
    found = {case: results[f"grains {case}"] for case in ("held along x alone", "that move as prescribed")}
    for result in found.values():
        assert result.status == 0, result.output
    said = "fix move (id drag) has NULL for a direction"
    assert found["held along x alone"].output.count(said) == 1
    assert said not in found["that move as prescribed"].output


def test_grains_that_never_turn_are_warned_of(results):
    result = results["grains that never turn"]
    assert result.status == 0, result.output
    assert result.output.count("fix nve (id motion) moves spheres without turning them") == 1
    assert "without turning" not in results["unequal grains later"].output  # there nve/sphere


def test_a_box_in_which_spheres_touch_on_both_sides_is_warned_of(results):
    """That of the scene is two diameters long along z; a hundredth is for contacts that are remembered."""
    said = results["grains that never turn"].output
    assert said.count("touch through both sides at once") == 1
    assert "2 long along z" in said and "from 2.02 on they cannot" in said
