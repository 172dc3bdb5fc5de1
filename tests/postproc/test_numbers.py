"""Every number of a report against values by hand, in units in which no factor is 1.

D = 2, u_b = 3, rho_f = 1.5, rho_p = 2.1, H = 8, nu = 0.01, g = 0.5; the grain's R is 0.8, so not D/2.
Bounds: 1 % or a bin of the heights; samples every 0.001 of pieces that begin and end between them.
"""

import shutil

import h5py
import numpy as np
import pytest
from bedload_post import bed_friction, flow_statistics, model_numbers, profile_figures, states, summary, transport
from bedload_post.collision_statistics import collision_statistics
from bedload_post.frames import time_ranges
from bedload_post.outputs import Run
from bedload_studies import scene_answers, threshold
from synthetic import Story, even, write_run

SINCE = 1.0
THROUGH = 16.0 / 3.0
UNITS = {
    "viscosity = 2.6578e-3": "viscosity = 0.01", "density = 1.0": "density = 1.5",
    "gravity = [0.0, -0.99, 0.0]": "gravity = [0.0, -0.5, 0.0]", "velocity = 1.0": "velocity = 3.0",
    "diameter = 1.0": "diameter = 2.0", "sphere_density = 1.25": "sphere_density = 2.1",
}  # fmt: skip


def story():
    """4 at rest; rolls, turning askew; jumps; slides; jumps; 4 at rest."""
    told = Story(position=(1.0, 3.0, 4.0), radius=0.8, samples_per_time=1000)
    told.piece(4.0, contact=True)
    told.piece(1.0, (0.6, 0, 0), spin_z=-0.5, spin_x=0.3).touch(1e-3)
    told.piece(2.0, (1.5, 0, 0), spin_z=-0.9, jump_height=0.5).touch(1e-3)
    told.piece(1.0, (0.4, 0, 0)).touch(1e-3)
    told.piece(1.0, (1.5, 0, 0), spin_z=0.3, jump_height=0.3).touch(1e-3)
    return told.piece(4.0, contact=True)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = write_run(tmp_path_factory.mktemp("numbers") / "rpm", even(story(), 0.001))
    text = (folder / "settings.toml").read_text()
    for old, new in UNITS.items():
        assert old in text
        text = text.replace(old, new)
    (folder / "settings.toml").write_text(text)
    # The force is 1 before SINCE, 0.004 up to the middle of the record, 0.001 after it.
    lines = ["step,time,dt,cfl,driving,max_divergence,slip_max,slip_rms,momentum_residual"]
    for n, t in enumerate(np.arange(0.1, 13.01, 0.1), start=1):
        force = 1.0 if t < SINCE else 0.004 if n <= 65 else 0.001
        lines.append(f"{n},{t:.3f},0.1,0.5,{force},1e-14,0.02,0.004,3e-15")
    (folder / "history.csv").write_text("\n".join(lines) + "\n")
    return Run(folder)


def test_collisions_are_measured_in_their_own_units(run, tmp_path):
    """St = rho_p u D/(9 rho_f nu), overlaps in D."""
    copy = tmp_path / "run"
    shutil.copytree(run.folder, copy)
    (copy / "collisions.csv").write_text(
        "tag_i,tag_j,time_start,time_end,impact_speed_normal,largest_overlap\n1,1000,2.0,2.5,0.3,0.05\n"
    )
    found = collision_statistics(Run(copy))
    assert found.stokes == pytest.approx([2.1 * 0.3 * 2 / (9 * 1.5 * 0.01)])
    assert found.overlap == pytest.approx([0.05 / 2])


def test_every_number_of_the_models_report(run):
    found = model_numbers.numbers(model_numbers.make_case("rpm", run, SINCE / THROUGH))
    u_tau = np.sqrt((56 * 0.004 + 65 * 0.001) / 121 * 8 / 1.5)
    exact = {
        "model": "rpm", "grains": 1, "jumps": 2, "batches": 4, "interval_too_narrow": True,
        "u_tau_from": "driving force times depth",
        # Four touches and the second rest, at speed 0 in the made-up table, which lacks overlaps; no log.
        "collisions": 5, "collisions_below_stokes_1": 1.0, "collisions_below_stokes_5": 1.0,
        "stokes_quantiles": [0.0] * 3, "duration_quantiles": [None] * 3, "overlap_quantiles": [None] * 3,
        "scales": {}, "velocity_drifts": False, "resting_drifts": False,
        "box_length": 8.0, "mean_jump_height_interval": None,  # two parts of the record have a jump
        # The bed's top is at y/D = 0.5: all grains are more than a diameter above it.
        "spin_peak": None, "spin_peak_height": None, "spin_peak_interval": None, "moving_spin_peak": None,
        "moving_spin_peak_interval": None,
    }  # fmt: skip
    t_1 = 12.706 / np.sqrt(2)  # t_{0.975, 1}/sqrt(2): halves have two batches
    near = {
        "cells_per_diameter": 2 / (16 / 80),
        "mean_height_interval": 3.182 * np.std([0, 2 / 9, 0.2 / 3, 0], ddof=1) / 2 / 2,
        "share_moving": 5 / 12,
        "share_moving_interval": 3.182 * np.std([0, 1, 2 / 3, 0], ddof=1) / 2,
        "velocity_halves": [3.6 / 6 / 3, 1.9 / 6 / 3],
        "velocity_halves_interval": t_1 * np.hypot(
            np.std([0, 0.4], ddof=1), np.std([1.9 / 9, 0], ddof=1)
        ),
        "resting_halves": [3 / 6, 4 / 6],
        "resting_halves_interval": t_1 * np.hypot(np.std([1, 0], ddof=1), np.std([1 / 3, 1], ddof=1)),
        "density_ratio": 1.4,
        "flow_throughs": 12 / THROUGH,
        "discarded_flow_throughs": SINCE / THROUGH,
        # 0.6 + 3 + 0.4 + 1.5 in 12; batches of 3 time units: 0, 1.2, 0.6333, 0; t_{0.975, 3} = 3.182.
        "mean_velocity": 5.5 / 12 / 3,
        "mean_velocity_interval": 3.182 * np.std([0, 1.2, 1.9 / 3, 0], ddof=1) / 2 / 3,
        "batch_memory": -0.290,
        "mean_spin": (-0.5 - 2 * 0.9 + 0.3) / 12 * 2 / 3,
        "mean_jump_height": (0.5 + 0.3) / 2 / 2,
        # |omega x R| = 0.8 hypot(0.3, 0.5) for one time unit on 0.6 and 0 on 0.4 of way.
        "creeping_slip": 0.8 * np.hypot(0.3, 0.5) - 1.0,
        # The roll in one part, the slide in another, off the common ratio by as much; five of the ten parts have a
        # way, if short; t_{0.975, 4} = 2.776.
        "creeping_slip_interval": 2.776 * np.sqrt(5 / 4 * 2) * abs(
            0.8 * np.hypot(0.3, 0.5) - 0.6 - (0.8 * np.hypot(0.3, 0.5) - 1.0) * 0.6
        ),
        "u_tau": u_tau / 3,
        "re_tau": u_tau * 8 / 0.01,
        "d_plus": u_tau * 2 / 0.01,
        "shields": 1.5 * u_tau**2 / ((2.1 - 1.5) * 0.5 * 2),
        "share_resting": 7 / 12,
        "share_creeping": 2 / 12,
        "share_jumping": 3 / 12,
        "share_resting_interval": 3.182 * np.std([1, 0, 1 / 3, 1], ddof=1) / 2,
        "share_creeping_interval": 3.182 * np.std([0, 1 / 3, 1 / 3, 0], ddof=1) / 2,
        "share_jumping_interval": 3.182 * np.std([0, 2 / 3, 1 / 3, 0], ddof=1) / 2,
    }
    # No batch remembers the one before.
    for name in ("mean_height", "share_moving", "mean_velocity", "share_resting", "share_creeping", "share_jumping"):
        near[f"{name}_interval_if_independent"] = near[f"{name}_interval"]
    # Parabolas of height h for a time T: int y = 2/3 h T, int y^2 = 8/15 h^2 T; y = 3 otherwise.
    mean = (2 / 3) * (0.5 * 2 + 0.3) / 12
    spread = np.sqrt((8 / 15) * (0.5**2 * 2 + 0.3**2) / 12 - mean**2)
    near["mean_height"] = (3 + mean) / 2
    # Ten parts of 1.2: the jumps fill the fourth and fifth, and end in the sixth and seventh.
    time = (np.arange(12_000) + 0.5) / 1000
    rise = np.zeros_like(time)
    for begin, lasts, height in ((4, 2, 0.5), (7, 1, 0.3)):
        s = (time - begin) / lasts
        rise += np.where((s > 0) & (s < 1), 4 * height * s * (1 - s), 0.0)
    parts = ((rise - mean) ** 2).reshape(10, -1).mean(axis=1)
    half = 2.262 * np.std(parts, ddof=1) / np.sqrt(10) / (2 * spread)
    # While jumping 0.9 for 2 and 0.3 for 1, in four of the parts, times D/u_b = 2/3.
    near["jumping_spin"] = (0.6 * 2 + 0.2) / 3
    near["jumping_spin_interval"] = 3.182 * np.std([0.6, 0.6, 0.2, 0.2], ddof=1) / 2
    bins = {  # y/D in bins of 0.02
        "spread_of_height": spread / 2, "spread_of_height_interval": half / 2,
        # Up to y/D = 1.7, farther up too few parts of the record have any: the second jump and most of the first.
        "spin_above": (-1 / 3 - 0.6 * 1.1056 + 0.2 * 1.0) / 11.1056,
        # More than half of the time is rest at 1.5.
        "low_height": 1.51, "low_height_interval": 0.01,
    }  # fmt: skip
    profiles = found.pop("profiles")
    assert profiles["height"] == pytest.approx([1.55, 1.65])
    # Below 1.6: at 1.5 for 9, jumps for 0.4508 and 0.4226.
    assert profiles["spin"] == pytest.approx([(-0.6 * 0.4508 + 0.2 * 0.4226 - 1 / 3) / 9.8734, -0.2251], abs=0.003)
    assert profiles["velocity"] == pytest.approx([(0.6 + 0.4 + 1.5 * 0.8734) / 3 / 9.8734, 0.5], abs=0.001)
    assert found.pop("spin_above_interval") == pytest.approx(
        np.average(profiles["spin_interval"], weights=[9.8734, 1.2322]), rel=0.01
    )
    assert {name: found[name] for name in exact} == exact
    for name, value in near.items():
        assert found[name] == pytest.approx(value, rel=0.012), name
    for name, value in bins.items():
        assert found[name] == pytest.approx(value, abs=0.0126 if "spin" in name else 0.0101), name
    assert exact.keys() | near.keys() | bins.keys() == found.keys()


def test_resting_grains_dilute_the_spin_at_a_height(run):
    """All grains at 1.5 D to 1.6 D: seven of nearly ten time units they rest."""
    measured = transport.measure(run, SINCE)
    everyone, moving = measured.coarse_profile(1), measured.coarse_profile(1, resting=False)
    assert moving.mean[0] == pytest.approx(everyone.mean[0] * 9.8734 / 2.8734, rel=0.01)
    assert everyone.samples[0] - moving.samples[0] == pytest.approx(7000, abs=10)
    assert everyone.largest(1.0, 1.6) == (everyone.mean[0], everyone.half[0], pytest.approx(1.55))
    assert everyone.largest(2.0, 2.5) is None
    weights = everyone.samples / everyone.samples.sum()
    mean, half = everyone.between(1.0, 2.0)
    assert mean == pytest.approx((weights * everyone.mean).sum())
    assert half == pytest.approx((weights * everyone.half).sum())
    assert everyone.between(2.0, 2.5) is None
    # From 1.6 to 1.7 the first jump dwells 0.6548, the second 0.5774. A bed whose top is at y/D = 1 has that next to
    # it, one at 0.6 only what is below 1.6.
    near = model_numbers.spin_over_height(measured, 1.0)
    assert near["spin_peak"] == pytest.approx((-0.6 * 0.6548 + 0.2 * 0.5774) / 1.2322, abs=0.003)
    assert (near["spin_peak_height"], near["spin_above"]) == (pytest.approx(1.65), None)
    low = model_numbers.spin_over_height(measured, 0.6)
    assert (low["spin_peak"], low["moving_spin_peak"]) == (everyone.mean[0], moving.mean[0])
    assert low["spin_above"] == everyone.mean[1]


def test_a_ratio_of_sums_has_its_interval():
    """R = 6/8; a - R b = 0.25, -0.5, 0.25 and nothing where b = 0; t_{0.975, 2} = 4.30265."""
    ratio, half = transport.ratio_of_sums(np.array([1.0, 1.0, 4.0, 0.0]), np.array([1.0, 2.0, 5.0, 0.0]))
    assert ratio == 0.75
    assert half == pytest.approx(4.30265 * np.sqrt(3 / 2 * (0.25**2 + 0.5**2 + 0.25**2)) / 8, rel=1e-5)
    few = transport.ratio_of_sums(np.array([2.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]))
    assert few[0] == 1.5 and np.isnan(few[1])
    assert np.isnan(transport.ratio_of_sums(np.zeros(3), np.zeros(3))).all()


def test_distributions_are_over_heights_spins_and_velocities_in_d_and_u_b(run):
    measured = transport.measure(run, SINCE)
    assert measured.mean("height").mean == pytest.approx((3 + 0.8667 / 12) / 2, rel=1e-3)
    y, velocity = measured.over_height(2)
    assert velocity[y > 1.66] == pytest.approx(0.5)  # the first jump alone: over y = 3.3
    assert y.max() == pytest.approx(1.75, abs=0.011)
    _, spin = measured.over_height(1)
    assert spin[y > 1.66] == pytest.approx(-0.9 * 2 / 3)
    x, density = measured.spin_pdf(states.CREEPING)
    assert set(np.round(x[density > 5], 2)) <= {-0.34, -0.01, 0.01}  # omega_3 D/u_b = -1/3 and 0
    x, density = measured.velocity_pdf(states.JUMPING)
    assert x[np.argmax(density)] == pytest.approx(0.5, abs=0.0101)


def test_slip_over_the_way(run):
    phases = transport.measure(run, SINCE).phases
    length, slip, half = transport.creeping_slip(phases, 2.0, np.array([0.1, 0.5]))
    slips = (0.8 * np.hypot(0.3, 0.5) - 0.6) / 2, -0.4 / 2
    assert length == pytest.approx([0.25], rel=0.02)
    assert slip == pytest.approx([np.mean(slips)], rel=0.02)
    assert np.isnan(half).all()  # of two phases
    assert sorted(transport.jump_heights(phases, 2.0)) == pytest.approx([0.15, 0.25], abs=1e-3)


def number(text):
    return float(text.split()[0])


def test_every_line_of_the_summary(run):
    phases = states.analyse(
        run.collisions(), time_ranges(run.instants()), run.sample_blocks(), run.periods,
        run.bulk_velocity, run.diameter,
    )  # fmt: skip
    grains = {line.what: line.value for line in summary.grain_lines(run, phases)}
    wanted = {
        "mobile grains": 1, "their diameters": 1.6, "mean grain velocity": 5.5 / 13 / 3, "finished collisions": 6,
        "time resting": 100 * 8 / 13, "time creeping": 100 * 2 / 13, "time jumping": 100 * 3 / 13,
        "jumps": 2, "jump height, mean": 0.2, "jump height, highest": 0.25,
        "slip while creeping": 0.8 * np.hypot(0.3, 0.5) - 1.0,
    }  # fmt: skip
    assert {what: number(text) for what, text in grains.items()} == pytest.approx(wanted, rel=0.012)
    assert grains["mean grain velocity"].endswith("u_b")

    # Second half: u_tau^2 = 0.001 * 8 / 1.5.
    u_tau = np.sqrt(0.001 * 8 / 1.5)
    wanted = {
        "fluid steps": 130, "time": 13, "CFL number, largest": 0.5,
        "friction velocity": u_tau / 3, "Re_tau": u_tau * 8 / 0.01, "D+": u_tau * 2 / 0.01,
        "Shields number": 1.5 * u_tau**2 / 0.6, "divergence, largest": 1e-14,
        "slip at markers, rms": 0.004 / 3, "slip at markers, largest": 0.02 / 3,
        "momentum residual": 3e-15,
    }  # fmt: skip
    flow = {line.what: number(line.value) for line in summary.flow_lines(run)}
    assert flow == pytest.approx(wanted, rel=0.01, abs=1e-17)
    # (s - 1) g = 0.6/(2 x 1.5), nu = 0.01: D* = 25.2.
    number_of_diameter = 2.0 * (0.2 / 0.01**2) ** (1 / 3)
    curve = 0.30 / (1 + 1.2 * number_of_diameter) + 0.055 * (1 - np.exp(-0.020 * number_of_diameter))
    notes = {line.what: line.note for line in summary.flow_lines(run)}
    assert notes["Shields number"] == f"critical: {curve:.3f}, Shields' curve"


def test_statistics_in_the_scene_s_units(run):
    """tau = 0.002 (9 - y): u_tau at the bed's top from it, in the summary from the file itself."""
    face = np.linspace(0.0, 9.0, 46)
    facts = {"samples": 10, "begin": 0.0, "end": 13.0, "driving": 0.002, "wall_stress": [0.0, 0.0]}
    file = run.folder / flow_statistics.FILE
    with h5py.File(file, "w") as written:
        written.attrs.update(facts | {"u_tau": 0.12, "stress_defect": 0.02})
        written["profiles/y_face"] = face
        written["profiles/viscous"] = 0.25 * 0.002 * (9.0 - face)
        written["profiles/turbulent"] = 0.75 * 0.002 * (9.0 - face)
    lines = {line.what: number(line.value) for line in summary.statistics_lines(run)}
    friction, source = bed_friction.friction_velocity(run, SINCE)
    file.unlink()
    assert "total stress" in source
    assert friction == pytest.approx(np.sqrt(0.016 / 1.5), rel=1e-12)
    assert lines == pytest.approx({
        "statistics over": 13, "friction velocity there": 0.04, "Re_tau there": 96,
        "stress off a straight line": 2,
    }, rel=1e-12)  # fmt: skip


@pytest.mark.parametrize("kept", [{}, {"u_tau": 0.0}])
def test_statistics_of_a_flow_that_nothing_holds(run, tmp_path, kept):
    """No friction velocity: no line of it, and profiles in the scene's units."""
    face = np.linspace(0.0, 9.0, 4)
    centre = np.ones(3)
    file = run.folder / flow_statistics.FILE
    with h5py.File(file, "w") as written:
        written.attrs.update(samples=10, begin=0.0, end=13.0, driving=0.0, wall_stress=[0.0, 0.0], **kept)
        for name in ("y", "fluid", "u", "uu", "ww"):
            written[f"profiles/{name}"] = centre
        for name in ("vv", "uv", "viscous", "turbulent"):
            written[f"profiles/{name}"] = 0.0 * face
        written["profiles/y_face"] = face
    lines = [line.what for line in summary.statistics_lines(run)]
    found = flow_statistics.read(run)
    file.unlink()
    assert lines == ["statistics over"]
    with np.errstate(all="raise"):
        profile_figures.draw(found, tmp_path / "profiles.png")
    assert (tmp_path / "profiles.png").stat().st_size > 1000


def test_a_point_of_the_threshold_study(run):
    """One grain of V = 4/3 pi 0.8^3 over 16 x 8, 5.5/12 fast: q* = V 5.5/12/128 over sqrt(g' D^3), g' = 0.2."""
    found = threshold.point_of(run, "rpm", 0.03, SINCE)
    assert (found.model, found.shields) == ("rpm", 0.03)
    numbers = (found.moving.mean, found.not_resting.mean, found.velocity.mean, found.transport.mean)
    rate = 4 / 3 * np.pi * 0.8**3 * 5.5 / 12 / 128 / np.sqrt(0.2 * 8)
    assert numbers == pytest.approx((5 / 12, 5 / 12, 5.5 / 12 / 3, rate), rel=0.012)
    assert found.transport.half_width == pytest.approx(rate / numbers[2] * found.velocity.half_width, rel=0.012)
    # S = u_tau^2/((rho_p/rho_f - 1) g D)
    settings = {"reference": {"sphere_density": 2.1, "diameter": 2.0}, "fluid": {"density": 1.5}}
    assert threshold.gravity_for(0.03, 0.12, settings) == pytest.approx(0.12**2 / (0.4 * 0.03 * 2.0))


def test_a_scene_s_own_answers(run):
    """At 4.5 the grain rolls at 0.6 along x, at 5.5 it jumps at 1.5 and 0.5 4 (1 - 2 f)/2 upwards, f = 1/4."""
    found = scene_answers.grain_series(run)
    speed = np.hypot(1.5, 0.5) / 3
    for time, wanted in ((2.0, (0.0, 1.5, 0.0, 0.0, 0.0)), (4.5, (0.2, 1.5, 1.0, 0.2, 0.2)),
                         (5.501, (0.5, (3 + 0.5 * 0.75) / 2, 1.0, speed, speed))):  # fmt: skip
        names = ("grain velocity", "grain height", "share moving", "grain speed", "largest grain speed")
        values = [float(np.interp(time, found[name].time, found[name].values)) for name in names]
        assert values == pytest.approx(wanted, abs=0.003)
