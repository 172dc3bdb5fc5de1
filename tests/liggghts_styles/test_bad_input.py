"""Bad input ends the run with one clear sentence and an exit code that is not 0."""

import pytest

from liggghts_script import Scene, Sphere, launch

PAIR = [Sphere((0.0, 0.0, 0.0)), Sphere((0.02, 0.0, 0.0))]
FILM = "fix film all lubrication"
WEIGHT = "fix weight all gravity 9.81 vector 0 -1 0"
SOFT_FILM = f"{FILM} viscosity 1e-3 range 4e-4"
TABLE = "fix t all collision/table file t.csv"
SHIPPED = [
    "fix p1 all property/global youngsModulus peratomtype 5e6",
    "fix p2 all property/global poissonsRatio peratomtype 0.3",
    "fix p3 all property/global coefficientRollingFriction peratomtypepair 1 0.05",
    "fix p4 all property/global cohesionEnergyDensity peratomtypepair 1 1e3",
]
HERTZ = "model hertz tangential history"
UNHEARD = f"fix floor all wall/gran {HERTZ} rolling_friction cdt primitive type 1 yplane -0.05"
HEARD = f"fix floor all wall/gran {HERTZ} primitive type 1 yplane -0.05"
MEETING = [Sphere((0.0, 0.0, 0.0), diameter=0.01), Sphere((0.0, 0.00999, 0.0), (0.0, -0.1, 0.0), diameter=0.01)]

CLUMPS = [
    "fix two all particletemplate/multisphere 15485863 atom_type 1 density constant 2500 nspheres 2 ntry 100000 "
    "spheres 0.0 0.0 0.0 0.004 0.005 0.0 0.0 0.004 type 1",
    "fix mixture all particledistribution/discrete 32452843 1 two 1.0",
    "region middle block -0.02 0.02 -0.03 0.03 -0.02 0.02 units box",
    "fix insert all insert/pack seed 49979687 distributiontemplate mixture insert_every once overlapcheck yes "
    "particles_in_region 1 region middle",
    "fix clumps all multisphere",
]

# Per case: what differs from a good scene, and words of the sentence: what is wrong, what was found,
# what is allowed or missing.
CASES = {
    "no restitution": (
        dict(without="coefficientRestitution"),
        ["actm needs", "property/global coefficientRestitution peratomtypepair 1"],
    ),
    "no friction": (
        dict(without="coefficientFriction"),
        ["haff_werner needs", "property/global coefficientFriction peratomtypepair 1"],
    ),
    "no fluid step": (
        dict(without="fluidTimeStep"),
        ["actm needs the fluid time step", "couple/fluid", "fluidTimeStep scalar"],
    ),
    "fluid step 0": (dict(fluid_step=0.0), ["fluidTimeStep has to be more than 0", "found 0"]),
    "property of a viscosity below 0": (
        dict(properties=["fix nu all property/global fluidViscosity scalar -1e-3"]),
        ["fluidViscosity has to be more than 0", "found -0.001"],
    ),
    "cells below 0": (
        dict(contact="model rpm", properties=["fix h all property/global fluidCellSize scalar -5e-4"],
             lines=[WEIGHT]),
        ["fluidCellSize has to be more than 0", "found -0.0005"],
    ),
    "density below 0": (
        dict(spheres=MEETING, properties=["fix rho all property/global fluidDensity scalar -1000"],
             lines=[WEIGHT]),
        ["fluidDensity has to be at least 0", "found -1000"],
    ),
    "T_c of two DEM steps": (
        dict(spheres=MEETING, contact="model actm tangential haff_werner collisionSteps 2", substeps=1),
        ["actm", "lasts 2 of LIGGGHTS' steps", "has to last 3"],
    ),
    "rpm without weights": (
        dict(spheres=MEETING, contact="model rpm", settings="range 1e-3", lines=[WEIGHT.replace("9.81", "0.0")]),
        ["rpm measures its force in weights", "fix gravity has none"],
    ),
    "e of 0": (
        dict(restitution=0.0),
        ["coefficientRestitution", "between 0.01 and 1", "found 0", "types 1 and 1"],
    ),
    "e above 1": (dict(restitution=1.2), ["coefficientRestitution", "found 1.2"]),
    "friction below 0": (dict(friction=-0.1), ["coefficientFriction", "found -0.1"]),
    "text for collisionSteps": (
        dict(settings="collisionSteps ten"),
        ["collisionSteps needs a number", "'ten'"],
    ),
    "collisionSteps below 0": (
        dict(settings="collisionSteps -3"),
        ["collisionSteps has to be more than 0", "-3"],
    ),
    "two durations of a collision": (
        dict(settings="collisionSteps 8 collisionTime 1e-2"),
        ["collisionTime and collisionSteps both", "leave out one"],
    ),
    "two durations of rpm": (
        dict(contact="model rpm", settings="range 1e-4 collisionSteps 8 collisionTime 1e-2",
             lines=[WEIGHT]),
        ["model rpm: collisionTime and collisionSteps both", "leave out one"],
    ),
    "two durations of slip": (
        dict(settings="slipTime 1e-4 tangentialDamping 1"),
        ["tangentialDamping and slipTime both", "leave out one"],
    ),
    "no such rule": (
        dict(settings="enduring always"),
        ["enduring has to be one of plain, kempe_froehlich, biegert", "'always'"],
    ),
    "criticalStokes without its rule": (
        dict(settings="enduring plain criticalStokes 2"),
        ["criticalStokes has no effect", "plain"],
    ),
    "restingOverlap without its rule": (
        dict(settings="enduring kempe_froehlich restingOverlap 0.01"),
        ["restingOverlap belongs to enduring biegert"],
    ),
    "unknown keyword": (
        dict(settings="collisionStep 10"),
        ["unknown keyword 'collisionStep'", "the nearest is 'collisionSteps'"],
    ),
    "gapMin above the range": (
        dict(lines=[f"{FILM} viscosity 1e-3 range 1e-3 gapMin 0.3"]),
        ["gapMin of 0.3 radii is a gap of 0.0015", "the range 0.001"],
    ),
    "no such model": (dict(contact="model actn"), ["Invalid model"]),
    "combination not registered": (
        dict(contact="model actm tangential haff_werner cohesion sjkr"),
        ["normal model"],
    ),
    "viscosity below 0": (
        dict(lines=[f"{FILM} viscosity -1e-3 range 1e-3"]),
        ["fix lubrication: viscosity has to be more than 0", "-0.001"],
    ),
    "text for range": (
        dict(lines=[f"{FILM} viscosity 1e-3 range wide"]),
        ["fix lubrication: range needs a number", "'wide'"],
    ),
    "no viscosity": (
        dict(lines=[f"{FILM} range 1e-3"]),
        ["fix lubrication", "'viscosity <value>' is missing", "couple/fluid"],
    ),
    "no range": (
        dict(lines=[f"{FILM} viscosity 1e-3"]),
        ["fix lubrication", "'range <value>' is missing", "couple/fluid"],
    ),
    "tangential maybe": (
        dict(lines=[f"{FILM} viscosity 1e-3 range 1e-3 tangential maybe"]),
        ["fix lubrication: tangential is on or off", "'maybe'"],
    ),
    "tangential film without a grid": (
        dict(lines=[f"{FILM} viscosity 1e-3 range 1e-3 tangential on"]),
        ["fix lubrication: tangential on adds what a grid lacks", "here is no grid"],
    ),
    "tangential film of the published law": (
        dict(lines=["fix h all property/global fluidCellSize scalar 1e-3",
                    f"{FILM} viscosity 1e-3 law published tangential on"]),
        ["fix lubrication: tangential on adds what a grid lacks", "here law is published"],
    ),
    "lubrication keyword": (
        dict(lines=[f"{FILM} viscos 1e-3"]),
        ["unknown keyword 'viscos'", "the nearest is 'viscosity'", "viscosity, range, gapMin, law"],
    ),
    "two lubrications": (
        dict(lines=[f"{FILM} viscosity 1e-3 range 1e-3", "fix b all lubrication"]),
        ["there is one already"],
    ),
    "films with newton on": (
        dict(contact="model hertz tangential off", properties=SHIPPED, lines=[SOFT_FILM], without="newton off"),
        ["fix lubrication needs the line 'newton off'"],
    ),
    "rows with newton on": (
        dict(contact="model hertz tangential off", properties=SHIPPED, lines=[TABLE], without="newton off"),
        ["fix collision/table needs the line 'newton off'"],
    ),
    "films in a plane": (
        dict(lines=[SOFT_FILM, "fix plane all setforce NULL NULL 0.0"]),
        ["fix lubrication", "'fix plane setforce'", "leave them out of the group"],
    ),
    "films of a wall that is not heard": (
        dict(properties=SHIPPED, lines=[SOFT_FILM, UNHEARD]),
        ["fix lubrication does not hear of the wall 'floor'", "leave the wall's spheres out"],
    ),
    "rows of a wall that is not heard": (
        dict(properties=SHIPPED, lines=[TABLE, UNHEARD]),
        ["fix collision/table does not hear of the wall 'floor'"],
    ),
    "films of pairs that are not heard": (
        dict(contact=f"{HERTZ} cohesion sjkr", properties=SHIPPED, lines=[HEARD, SOFT_FILM]),
        ["fix lubrication works with pair_style gran", "actm, rpm, hertz or hooke", "without cohesion"],
    ),
    "rows of pairs that are not heard": (
        dict(contact=f"{HERTZ} cohesion sjkr", properties=SHIPPED, lines=[HEARD, TABLE]),
        ["fix collision/table works with pair_style gran"],
    ),
    "skin too small for lubrication": (
        dict(
            lines=[
                f"{FILM} viscosity 1e-3 range 1e-3",
                "fix floor all wall/gran model actm primitive type 1 yplane -0.05",
            ],
        ),
        ["fix lubrication", "skin of 0.001 is too small", "'floor'", "neighbor 0.002 bin"],
    ),
    "skin too small for rpm": (
        dict(
            contact="model rpm",
            settings="range 1e-3",
            lines=[
                WEIGHT,
                "fix floor all wall/gran model rpm primitive type 1 yplane -0.05 range 1e-3",
            ],
        ),
        ["normal model rpm", "skin of 0.001 is too small", "neighbor 0.002 bin"],
    ),
    "no range for rpm": (dict(contact="model rpm", lines=[WEIGHT]), ["rpm needs its range", "range <m>"]),
    "no gravity for rpm": (
        dict(contact="model rpm", settings="range 1e-3"),
        ["rpm", "needs a fix gravity"],
    ),
    "table without file": (
        dict(lines=["fix t all collision/table every 10"]),
        ["needs the keyword 'file <name>'"],
    ),
    "table in no folder": (
        dict(lines=["fix t all collision/table file nowhere/t.csv"]),
        ["cannot write the file 'nowhere/t.csv'"],
    ),
    "a list that finds no contacts": (
        dict(lines=["neighbor 1e-3 multi"]),
        ["'neighbor ... multi' finds no contacts", "write 'neighbor 0.001 bin'"],
    ),
    "clumps": (dict(lines=CLUMPS), ["normal model actm: fix multisphere (id clumps) makes clumps", "spheres only"]),
    "rigid bodies": (
        dict(lines=["fix body all rigid single"]),
        ["normal model actm: fix rigid (id body) makes clumps", "spheres only"],
    ),
    "films in another integrator": (
        dict(lines=["fix film all lubrication viscosity 1e-2 range 1e-4", "run_style respa 2 2"]),
        ["films act with run_style verlet alone", "'respa"],
    ),
    "a wall's word behind those of the models": (
        dict(lines=["fix w all wall/gran model actm primitive type 1 yplane -0.05 collisionSteps 9 shear x 1.0"]),
        ["'shear' has to stand in front of the contact models' keywords"],
    ),
    "models in another order": (
        dict(contact="model actm rolling_friction off cohesion off"),
        ["'cohesion' comes too late", "tangential, cohesion, rolling_friction and surface stand in this order"],
    ),
    "wall settings": (
        dict(
            lines=[
                "fix w all wall/gran model actm primitive type 1 yplane -0.05 collisionSteps few"
            ]
        ),
        ["collisionSteps needs a number", "'few'"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_one_clear_sentence(tmp_path, case):
    change, words = CASES[case]
    change = dict(change)
    without = change.pop("without", None)
    scene = Scene(change.pop("spheres", PAIR), **{"contact": "model actm tangential haff_werner", **change})
    lines = [w for w in scene.script(10) if not (without and without in w)]
    if scene.fluid_step == 0:
        lines = ["timestep 1e-5" if w.startswith("timestep") else w for w in lines]
    (tmp_path / "spheres.data").write_text(scene.data_file())
    done = launch(tmp_path, lines)
    said = done.stdout + done.stderr
    assert done.returncode != 0, said
    # mpirun has words of its own, ORTE_ERROR_LOG among them.
    errors = [w for w in said.splitlines() if w.lstrip().startswith("ERROR")]
    assert len(errors) == 1, said
    for word in words:
        assert word in errors[0]


def test_the_good_scene_runs(tmp_path):
    """What the cases above differ from."""
    scene = Scene(PAIR, contact="model actm tangential haff_werner")
    scene.run(tmp_path, 10)


@pytest.mark.parametrize("ranks", [1, 2])
def test_what_the_fixes_do_not_need_to_hear_of(tmp_path, ranks):
    """A wall of another model and a sphere in its plane are allowed where the group of the fixes has no
    sphere of theirs that can move; and a wall may change its model between two runs."""
    scene = Scene(
        [*PAIR, Sphere((0.0, 0.03, 0.0)), Sphere((0.0, -0.03, 0.0))],
        contact="model actm tangential haff_werner",
        properties=SHIPPED,
        lines=[
            "group wet id 1 2 3", "group dry id 4", "group held id 3", "group lower id 3 4",
            SOFT_FILM.replace(" all ", " wet "), TABLE.replace(" all ", " wet "),
            UNHEARD.replace(" all ", " lower "), "fix plane lower setforce NULL NULL 0.0",
        ],
        integrate="group free subtract all held\nfix integrate free nve/sphere",
    )  # fmt: skip
    scene.run(tmp_path, ["run 5", "unfix floor", HEARD, "run 5"], ranks)


def test_spheres_that_move_as_prescribed_are_taken(tmp_path):
    """In all directions: at rest in one is prescribed, too."""
    for n, line in enumerate([
        "move linear 0.5 0 0 units box", "move wiggle 0.5 0 0 2.0 units box", "move rotate 0 0 0 0 0 1 2.0",
        "move variable v_p v_p v_p NULL NULL NULL units box",
    ]):  # fmt: skip
        lines = ["variable p equal 1e-4*step", f"fix drag all {line}"]
        Scene(PAIR, contact="model actm tangential haff_werner", lines=lines).run(tmp_path / str(n), 10)


def test_a_line_that_stands_again_replaces_the_first(tmp_path):
    """As with LIGGGHTS' own fixes, by the same ID."""
    scene = Scene(
        PAIR, contact="model actm tangential haff_werner",
        lines=[SOFT_FILM, TABLE, SOFT_FILM.replace("1e-3", "2e-3"), TABLE.replace("t.csv", "u.csv")],
    )  # fmt: skip
    scene.run(tmp_path, ["run 5", SOFT_FILM, "run 5"])
    assert (tmp_path / "u.csv").is_file() and not (tmp_path / "t.csv").exists()


def check_warning(folder, spheres, change, without, words):
    """The run goes on with both, and says `words` with `change` alone."""
    for place, given, warns in (("with", change, True), ("without", without, False)):
        scene = Scene(spheres, **{"contact": "model actm", **given})
        (folder / place).mkdir()
        (folder / place / "spheres.data").write_text(scene.data_file())
        done = launch(folder / place, scene.script(2))
        said = " ".join((done.stdout + done.stderr).split())
        assert done.returncode == 0, said
        assert ("WARNING" in said and words in said) == warns, said


@pytest.mark.parametrize(
    ("change", "without", "words"),
    [
        (dict(settings="enduring kempe_froehlich"), dict(settings="enduring plain"), "kempe_froehlich has no effect"),
        (dict(settings="criticalStokes 9"), dict(settings="criticalStokes 0"), "criticalStokes has no effect"),
        (dict(settings="enduring kempe_froehlich"),
         dict(settings="enduring kempe_froehlich",
              properties=["fix nu all property/global fluidViscosity scalar 1e-3"]),
         "without the fluid's viscosity"),
        (dict(contact="model rpm", settings="range 1e-4 strength 50 collisionSteps 8", lines=[WEIGHT]),
         dict(contact="model rpm", settings="range 1e-4 strength 50", lines=[WEIGHT]),
         "with a strength, collisionTime and collisionSteps have no effect"),
    ],
)  # fmt: skip
def test_settings_without_effect_are_warned_of(tmp_path, change, without, words):
    """The run goes on: a dry start may not know the viscosity yet, and models/rpm.liggghts gives a duration always."""
    check_warning(tmp_path, PAIR, change, without, words)


@pytest.mark.parametrize(
    ("spheres", "change", "without", "words"),
    [
        (PAIR, dict(settings="collisionSteps 2", substeps=1), dict(settings="collisionSteps 3", substeps=1),
         "lasts 2 of LIGGGHTS' steps of"),
        (PAIR, dict(contact="model rpm", settings="range 1e-4 collisionSteps 2", substeps=1, lines=[WEIGHT]),
         dict(contact="model rpm", settings="range 1e-4 collisionSteps 3", substeps=1, lines=[WEIGHT]),
         "the run ends at the first one"),
        (MEETING, dict(contact="model rpm", settings="range 1e-3 strength 1e6", lines=[WEIGHT]),
         dict(contact="model rpm", settings="range 1e-3 strength 10", lines=[WEIGHT]), "spheres gain energy"),
    ],
    ids=["actm", "rpm", "strength of rpm"],
)  # fmt: skip
def test_collisions_that_no_step_resolves_are_said_early(tmp_path, spheres, change, without, words):
    """At the start of the run, which may go for hours before anything touches; rpm's strength at its first force."""
    check_warning(tmp_path, spheres, change, without, words)


def test_all_ranks_end(tmp_path):
    """On two ranks the job ends as well, at once, with the sentence and a code that is not 0."""
    scene = Scene(PAIR, restitution=1.5)
    (tmp_path / "spheres.data").write_text(scene.data_file())
    done = launch(tmp_path, scene.script(10), ranks=2)
    assert done.returncode != 0
    assert "coefficientRestitution" in done.stdout + done.stderr
