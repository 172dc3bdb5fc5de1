"""Scales of the models that do not follow the fluid's steps, and the rules for slow impacts."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere, read_table, run_script

D = 0.01
T_C = 8e-3
TABLE = "fix table all collision/table file table.csv"
WEIGHT = ["group some type 1", "group none subtract all some",
          "fix weight none gravity 9.81 vector 0 -1 0"]  # fmt: skip


def impact(folder, speed=0.1, restitution=1.0, **more):
    """The one row of the table of a head-on impact, and the end state."""
    scene = Scene(
        [Sphere((0, 0, 0), (speed, 0, 0)), Sphere((D + more.pop("gap", 1e-9), 0, 0))],
        restitution=restitution, **more,
    )  # fmt: skip
    scene.lines = [*scene.lines, TABLE]
    end = scene.run(folder, int(4 * T_C / scene.dt))
    return {name: values[0] for name, values in read_table(folder / "table.csv").items()}, end


def lasted(row):
    return row["time_end"] - row["time_start"]


@pytest.mark.parametrize("fluid_step", [5e-4, 2e-3])
def test_collision_time_is_the_same_on_any_grid(tmp_path, fluid_step):
    row, _ = impact(tmp_path, fluid_step=fluid_step, settings=f"collisionTime {T_C}")
    assert lasted(row) == pytest.approx(T_C, rel=2e-3)
    # e = 1: 1.0934 u t*, T_c = 3.218 t*.
    assert row["largest_overlap"] == pytest.approx(1.0934 / 3.218 * 0.1 * T_C, rel=2e-3)


def test_collision_steps_follow_the_fluid(tmp_path):
    row, _ = impact(tmp_path, fluid_step=5e-4, settings="collisionSteps 8")
    assert lasted(row) == pytest.approx(8 * 5e-4, rel=2e-3)
    row, _ = impact(tmp_path / "default", fluid_step=5e-4)
    assert lasted(row) == pytest.approx(10 * 5e-4, rel=2e-3)


@pytest.mark.parametrize("fluid_step", [5e-4, 2e-3])
def test_collision_time_of_rpm(tmp_path, fluid_step):
    """Two equal spheres at sqrt(g D), within the step; they come u T/2.804 closer than the range."""
    u = np.sqrt(9.81 * D)
    row, _ = impact(
        tmp_path, u, fluid_step=fluid_step, gap=4.3e-4, contact="model rpm", lines=WEIGHT,
        settings=f"range 4e-4 collisionTime {T_C}",
    )  # fmt: skip
    assert lasted(row) == pytest.approx(T_C, abs=1.5 * fluid_step / 15)
    assert row["largest_overlap"] == pytest.approx(u * T_C / 2.80436 - 4e-4, rel=1e-3)


def test_slip_time_is_the_same_on_any_grid(tmp_path):
    """Slip at the first touch dies away as e^(-t/T); the same DEM step, another step of the fluid."""
    def spin(slip_time, fluid_step):
        scene = Scene(
            [Sphere((0, 0, 0), (0.1, 0.0, 0), (0, 0, 10.0)), Sphere((D + 1e-9, 0, 0))],
            friction=1e3, restitution=1.0, fluid_step=fluid_step, substeps=round(fluid_step / 5e-5),
            settings=f"collisionTime {T_C} slipTime {slip_time}",
        )  # fmt: skip
        return scene.run(tmp_path / f"{slip_time}-{fluid_step}", 40).spin[0, 2]

    assert spin(1e-3, 5e-4) == spin(1e-3, 2e-3)
    assert spin(0, 5e-4) != spin(0, 2e-3)
    # Slip 0.05 m/s at first; rolling shares it out: omega falls by (5/2)(2/7)/2 of 10 rad/s when it is
    # gone. 40 steps of 5e-5 are 2 T: forward Euler of M_t/(T + dt) leaves (1 - 1/21)^39.
    left = (1 - 1 / 21) ** 39
    assert spin(1e-3, 5e-4) == pytest.approx(10 - 10 * (5 / 14) * (1 - left), rel=0.01)


def test_friction_keeps_up_with_viscosity(tmp_path):
    """Without slipTime slip dies away in a step of the fluid, or in the time in which viscosity would leave 2 % of it:
    T = 1e-3 by that rule does what slipTime 1e-3 does. A longer one that is given stays, with a warning."""
    pair = [Sphere((0, 0, 0), (0.1, 0.0, 0), (0, 0, 10.0)), Sphere((D + 1e-9, 0, 0))]
    felt = 2 / 7 * pair[0].mass / 2  # M_t = 2/7 of the reduced mass
    resistance = felt / 1e-3 * 0.02 / 0.98  # zeta = 24 pi mu/(7 (1/R + 1/R))
    viscosity = resistance * 7 * 4 / D / (24 * np.pi)

    def scene(slip_time, mu):
        return Scene(pair, friction=1e3, restitution=1.0, fluid_step=2e-3, substeps=40,
                     settings=f"collisionTime {T_C} slipTime {slip_time}",
                     properties=[f"fix m4 all property/global fluidViscosity scalar {mu}"])  # fmt: skip

    def spin(slip_time, mu, folder):
        return scene(slip_time, mu).run(tmp_path / folder, 40).spin[0, 2]

    def told(slip_time, mu):
        (tmp_path / "spheres.data").write_text(scene(slip_time, mu).data_file())
        return run_script(tmp_path, scene(slip_time, mu).script(40))

    thin = 1e-6 * viscosity
    viscous = spin(0, viscosity, "viscous")
    assert viscous == pytest.approx(spin(1e-3, thin, "given"), rel=2e-4)  # 7e-5: not the same collision
    assert spin(0, thin, "thin") == spin(2e-3, thin, "step")
    assert spin(0.2, viscosity, "slow") != pytest.approx(viscous, rel=0.01)
    # A script that changes the viscosity between two runs of the same steps.
    thick = [f"fix m4 all property/global fluidViscosity scalar {viscosity}", "run 39"]
    later = scene(0, thin).run(tmp_path / "later", ["run 1", "unfix m4", *thick]).spin[0, 2]
    assert later == pytest.approx(viscous, rel=5e-3)  # thin: 12 % more
    # zeta/(zeta + M_t/T) = 0.8 with T = 0.2.
    slow = told(0.2, viscosity)
    assert "is slow to stop what the fluid's viscosity drives: 80 % of such a slip" in slow
    assert "a slipTime of 0.001 (or 0) would leave 2 %" in slow
    assert "is slow to stop" not in told(0, viscosity)


MU = 1e-3  # with rho_p 2500: St = 2500 u 0.01/(9 MU) = u/3.6e-4


@pytest.mark.parametrize(
    "rule, stokes", [("plain", 0.0), ("kempe_froehlich", 1.0), ("biegert", 5.0)]
)
@pytest.mark.parametrize("impact_stokes", [0.2, 3.0, 20.0])
def test_slow_impacts_by_rule(tmp_path, rule, stokes, impact_stokes):
    """Below St_crit the stiffness is that of an impact at St_crit, so T = T_c (u_crit/u)^(1/5)."""
    row, _ = impact(
        tmp_path, impact_stokes * 3.6e-4, settings=f"collisionTime {T_C} enduring {rule}",
        properties=[f"fix m4 all property/global fluidViscosity scalar {MU}"],
    )  # fmt: skip
    expected = T_C * max(1.0, stokes / impact_stokes) ** 0.2
    assert lasted(row) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("first", [0, 1])
def test_slow_impacts_are_judged_by_the_heavier_sphere(tmp_path, first):
    """Whichever is the first: T = T_c (u_crit/u)^(1/5) with its density and diameter; the lighter one's u_crit is 2.8
    times as high, which would draw the impact out 1.23 times as long."""
    heavy, light = dict(diameter=D, density=2500.0), dict(diameter=0.6 * D, density=1500.0)
    u_crit = 9 * 5 * MU / (heavy["density"] * heavy["diameter"])
    u = u_crit / 6
    spheres = [Sphere((0, 0, 0), (u, 0, 0), **heavy), Sphere((0.8 * D + 1e-9, 0, 0), **light)]
    if first == 1:
        spheres.reverse()
    properties = [f"fix m4 all property/global fluidViscosity scalar {MU}"]
    scene = Scene(spheres, restitution=1.0, settings=f"collisionTime {T_C}", properties=properties, lines=[TABLE])
    scene.run(tmp_path, int(4 * T_C / scene.dt))
    row = {name: values[0] for name, values in read_table(tmp_path / "table.csv").items()}
    assert lasted(row) == pytest.approx(T_C * 6**0.2, rel=5e-3)


@pytest.mark.parametrize("rule", ["plain", "kempe_froehlich", "biegert"])
def test_only_one_rule_stiffens_under_the_weight(tmp_path, rule):
    """A slow sphere on a floor: it presses in by 0.001 R with biegert, else as its impact was."""
    at_one = 40 * 3.6e-4  # speed at St = 1
    u = 0.5 * at_one  # g dt << u << g T_c: what it weighs turns it round in its first contact
    scene = Scene(
        [Sphere((0, 0.5 * D, 0), (0, -u, 0))], restitution=0.5, substeps=150,
        properties=[f"fix m4 all property/global fluidViscosity scalar {40 * MU}"],
        settings=f"collisionTime {T_C} enduring {rule}",
    )  # fmt: skip
    scene.lines = [
        "fix weight all gravity 9.81 vector 0 -1 0",
        f"fix floor all wall/gran {scene.contact} primitive type 1 yplane 0 {scene.settings}",
    ]
    end = scene.run(tmp_path, int(40 * T_C / scene.dt))
    overlap = 0.5 * D - end.x[0, 1]
    if rule == "biegert":
        assert overlap == pytest.approx(1e-3 * 0.5 * D, rel=1e-2)
        return
    # k = m/sqrt(u t*^5), k overlap^1.5 = m g; tau(0.5) = 3.503 in closed form (Ray et al. 2015).
    calibrated = u if rule == "plain" else at_one
    scale = np.sqrt(calibrated * T_C**5)
    ratio = (overlap**1.5 / (9.81 * scale)) ** -0.4  # = tau(e)
    assert ratio == pytest.approx(3.503, rel=0.005)


def test_the_log_has_the_scales(tmp_path):
    scene = Scene([Sphere((0, 0, 0))], settings=f"collisionTime {T_C} slipTime 1e-4")
    scene.lines = ["fix film all lubrication viscosity 1e-3 range 4e-4"]
    (tmp_path / "spheres.data").write_text(scene.data_file())
    lines = ["log log.liggghts", *scene.script(1)]
    printed = run_script(tmp_path, lines)
    told = (tmp_path / "log.liggghts").read_text()
    assert "scale: normal model actm: collision time = 0.008\n" in told
    assert "scale: tangential model haff_werner: slip time = 0.0001\n" in told
    assert "scale: fix lubrication: range = 0.0004\n" in told
    assert "NOTE" not in printed  # no fluid, so no grid to follow
