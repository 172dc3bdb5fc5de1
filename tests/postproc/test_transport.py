"""Distributions, shares, batches and friction velocity of made-up records whose numbers are known."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import matplotlib.image
import numpy as np
import pytest
from bedload_post import (
    bed_friction, flow_statistics, model_figures, model_numbers, model_sentences, models_report, summary, transport,
)  # fmt: skip
from bedload_post.batches import batches_of, estimate, estimate_over_time, mean_over_time, second_half
from bedload_post.frames import first_above, frames, grains_per_instant, pieces, time_ranges
from bedload_post.outputs import MissingOutput, Run, Samples
from bedload_post.states import CREEPING, JUMPING, RESTING
from bedload_studies import models
from scipy.signal import lfilter
from synthetic import Story, even, wandering_story, write_run, write_samples


def story_of_three_states():
    """5 at rest, 2 creeping (u 0.25, rolling), 3 jumping (u 1, spin -0.4), 10 at rest."""
    story = Story(samples_per_time=100).piece(5.0, contact=True)
    story.piece(2.0, (0.25, 0, 0), spin_z=-0.5).touch(1e-3)
    story.piece(3.0, (1.0, 0, 0), spin_z=-0.4, jump_height=0.3).touch(1e-3)
    return story.piece(10.0, contact=True)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return Run(write_run(tmp_path_factory.mktemp("run") / "actm", even(story_of_three_states())))


@pytest.fixture(scope="module")
def measured(run):
    return transport.measure(run)


def test_mean_velocity_and_shares(measured):
    # 0.5 D creeping and 3 D jumping in 20.002; bounds: one sample at each change of speed.
    assert measured.mean("velocity").mean == pytest.approx(3.5 / 20.0, abs=0.01 * 2.5 / 20)
    shares = [measured.share_of(s).mean for s in (RESTING, CREEPING, JUMPING)]
    assert shares == pytest.approx([0.75, 0.10, 0.15], abs=2e-3)


def test_samples_know_the_state_of_their_phase(measured):
    # Spin -0.4 belongs to jumping alone, -0.5 to creeping alone (bins are 0.025 wide).
    x, density = measured.spin_pdf(JUMPING)
    assert x[np.argmax(density)] == pytest.approx(-0.4, abs=0.0126)
    x, density = measured.spin_pdf(CREEPING)
    assert x[np.argmax(density)] == pytest.approx(-0.5, abs=0.0126)
    x, density = measured.velocity_pdf(CREEPING)
    assert x[np.argmax(density)] == pytest.approx(0.25, abs=0.0051)
    assert measured.velocities[JUMPING].sum() == pytest.approx(300, abs=3)
    assert measured.velocities.sum() == pytest.approx(measured.samples)


def test_the_mean_spin_is_that_of_the_samples(measured, tmp_path):
    """Not of the bins of its distribution, 0.025 wide from -3 to 3; grains at rest do not turn."""
    found = [measured.mean_spin(state)[0] for state in (RESTING, CREEPING, JUMPING)]
    assert found == pytest.approx([0.0, 0.5, 0.4], abs=3e-3)  # one sample of 200 at a change of state
    story = Story(samples_per_time=100).piece(2.0, contact=True)
    for spin in (-0.01, 4.0, -0.01, 4.0):
        story.piece(2.0, (1.0, 0, 0), spin_z=spin, jump_height=0.3).touch(1e-3)
    fast = transport.measure(Run(write_run(tmp_path / "run", even(story.piece(2.0, contact=True)))))
    mean, half = fast.mean_spin(JUMPING)
    assert mean == pytest.approx(2.005, abs=0.02)
    # Ten parts of 1.2, the first and the last without a jump, two of both spins; t_{0.975, 7} = 2.365.
    parts = [0.01, 0.01, (0.01 + 2 * 4) / 3, 4.0, 0.01, (2 * 0.01 + 4) / 3, 4.0, 4.0]
    assert half == pytest.approx(2.365 * np.std(parts, ddof=1) / np.sqrt(8), rel=0.02)


def test_densities_integrate_to_one(measured):
    for x, density in (measured.height_pdf(), measured.velocity_pdf(JUMPING)):
        assert (density * (x[1] - x[0])).sum() == pytest.approx(1.0, abs=1e-12)


def test_profiles_over_height(measured):
    # All motion at rest height 1.5 except the parabola, where u = 1 and spin = -0.4.
    y, velocity = measured.over_height(2)
    _, spin = measured.over_height(1)
    assert velocity[y > 1.52] == pytest.approx(1.0, abs=1e-9)
    assert spin[y > 1.52] == pytest.approx(-0.4, abs=1e-9)
    low = np.argmin(np.abs(y - 1.51))
    # 15 at rest, 2 at 0.25, and the parabola's ends below 1.52 at 1.
    assert 0.02 < velocity[low] < 0.1


def test_start_up_is_left_out(run):
    late = transport.measure(run, since=7.0)
    assert late.time[0][0] == pytest.approx(7.0, abs=1e-9)
    assert late.mean("velocity").mean == pytest.approx(3.0 / 13.0, abs=0.01 * 2 / 13)
    with pytest.raises(MissingOutput, match="after t = 50"):
        transport.measure(run, since=50.0)


def test_jump_heights_and_slip(measured):
    assert transport.jump_heights(measured.phases, 1.0) == pytest.approx([0.3], abs=1e-3)
    # Speed 0.25 and omega R = 0.25: rolls, L_slip = 0 over L = 0.5.
    story = Story(samples_per_time=100)
    for spin in (-0.5, -0.5, 0.0, 0.0):
        story.touch(1e-3).piece(2.0, (0.25, 0, 0), spin_z=spin)
    story.touch(1e-3)
    from test_states import analysed

    phases = analysed(story)
    length, slip, half = transport.creeping_slip(phases, 1.0, np.array([0.3, 0.6]))
    # Two roll (0), two slide (-0.5): s = 0.28868, t_{0.975, 3} = 3.18245.
    assert length == pytest.approx([0.5], abs=0.01)
    assert slip == pytest.approx([-0.25], abs=0.01)
    assert half == pytest.approx([3.18245 * 0.28868 / 2], abs=0.02)


def test_samples_of_short_steps_count_for_little(tmp_path):
    """Two grains, sampled in every step: 1 u_b at 1.5 D, and 3 u_b at 1.7 D from the middle of the time on, where ten
    of eleven samples are."""
    run = Run(write_run(tmp_path / "run", even(story_of_three_states())))
    time, speed = uneven()
    rows = np.repeat(np.arange(len(time)), 2)
    x = np.concatenate([[0.0], np.cumsum(np.diff(time) * speed[1:])])
    one = np.ones(len(rows))
    along = np.array([1.0, 0.0, 0.0])
    write_samples(run.folder, {
        "time": time[rows], "tag": np.tile([1, 2], len(time)), "radius": 0.5 * one,
        "position": np.column_stack([x[rows] % 16.0, 1.41 + 0.1 * speed[rows], 3.0 * one]),
        "velocity": speed[rows, None] * along, "angular_velocity": -speed[rows, None] * along[::-1],
    })  # fmt: skip
    found = transport.measure(run)
    assert found.mean("velocity").mean == pytest.approx(2.0)
    assert found.mean("velocity").batches == pytest.approx([1.0, 1.0, 3.0, 3.0])
    assert [half.mean for half in found.halves("velocity")] == pytest.approx([1.0, 3.0])
    assert found.by_height[0].sum() == pytest.approx(2 * len(time))
    y, density = found.height_pdf()
    assert density[np.argmin(np.abs(y - 1.51))] * 0.02 == pytest.approx(0.5)
    assert found.low_height(0.45)[0] == pytest.approx(1.51)
    assert found.spread_of_height()[0] == pytest.approx(0.1)
    assert found.spin_parts.sum() == pytest.approx(2 * len(time))
    assert summary.mean_grain_velocity(run) == pytest.approx(2.0)


def test_a_fall_sampled_in_short_steps_is_of_its_time(tmp_path):
    """The second half of the time has 1 and then 3 u_b, ten of eleven of its samples 3."""
    run = Run(write_run(tmp_path / "run", even(story_of_three_states())))
    settings = run.folder / "settings.toml"
    settings.write_text(settings.read_text().replace("[0.0, -0.99, 0.0]", "[2.0, 0.0, 0.0]"))
    late, speed = uneven()
    time = np.concatenate([0.01 * np.arange(1, 201), 2.0 + late])
    speed = np.concatenate([np.full(200, 7.0), speed])
    velocity = speed[:, None] * [1.0, 0.0, 0.0]
    write_samples(run.folder, {
        "time": time, "tag": np.ones(len(time), int), "radius": np.full(len(time), 0.5),
        "position": 0.0 * velocity, "velocity": velocity, "angular_velocity": 0.0 * velocity,
    })  # fmt: skip
    falls = {line.what: line.value for line in summary.free_grain_lines(Run(run.folder))}
    assert float(falls["mean velocity along gravity"]) == pytest.approx(2.0, rel=0.01)


def test_heights_are_those_of_the_whole_box(run, tmp_path):
    """Grains on the floor, and on a bed of seven diameters: none is left out."""
    for place, low in ((0.5, 0.51), (7.5, 7.51)):
        story = Story(position=(1.0, place, 4.0), samples_per_time=100).piece(5.0, contact=True)
        story.piece(5.0, (1.0, 0, 0), jump_height=0.4).touch(1e-3)
        found = transport.measure(Run(write_run(tmp_path / f"{place}", even(story))))
        assert found.by_height[0].sum() == pytest.approx(found.samples)
        assert found.low_height()[0] == pytest.approx(low)
        # Half of the time a parabola: mean 2/3 0.4, mean square 8/15 0.4^2 of it; to half a bin.
        assert found.spread_of_height()[0] == pytest.approx(np.sqrt(0.5 * 8 / 15 - (1 / 3) ** 2) * 0.4, abs=0.0101)
        y, velocity = found.over_height(2)
        assert velocity[y > place + 0.02] == pytest.approx(1.0)


def test_interval_of_independent_batches_holds_the_mean_in_95_of_100():
    numbers = np.random.default_rng(3)
    held = 0
    for _ in range(400):
        found = estimate(numbers.normal(2.0, 1.0, 500), batches=10)
        held += abs(found.mean - 2.0) < found.half_width
    # Binomial: 380 +- 4.4; five standard deviations.
    assert 358 <= held <= 400


def correlated(numbers, memory, times, samples=10):
    """A record of so many `times` of a signal whose correlation falls by e in `memory`."""
    kept = np.exp(-1.0 / (memory * samples))
    values = lfilter([np.sqrt(1 - kept**2)], [1, -kept], numbers.normal(size=samples * (times + 20)))
    return values[20 * samples :]


def test_interval_is_wider_where_batches_remember():
    """A tenth of the record is memory: 91 of 100 intervals hold the mean, 77 as if independent."""
    numbers = np.random.default_rng(5)
    found = [estimate(correlated(numbers, 2.0, 20), batches=10) for _ in range(1000)]
    held = np.mean([abs(one.mean) < one.half_width for one in found])
    # Binomial: 0.91 +- 0.009; three standard deviations.
    assert held > 0.88
    # r = 0.5 - 1/4, f = 3: the variance of 4/3 batches, and no less than three degrees of freedom.
    rising = estimate(np.array([1.0, 2.0, 3.0, 4.0]), batches=4)
    assert rising.memory == pytest.approx(0.25)
    assert rising.half_width == pytest.approx(3.18245 * 1.29099 * np.sqrt(3 / 4), rel=1e-5)


def test_an_interval_that_promises_too_much_is_told():
    calm, rising = np.tile([1.0, 2.0], 5), np.arange(10.0)
    assert not estimate(calm).too_narrow(10.0)
    assert not estimate(calm).too_narrow(9.95)  # a sample short
    assert estimate(calm).too_narrow(9.5)  # batches shorter than a flow-through
    assert estimate(rising).too_narrow(40.0)
    values = [{"interval_too_narrow": True}, {"interval_too_narrow": False}]
    told = model_sentences.interval_sentence(["rpm", "actm"], values)
    assert "too narrow for rpm: batches" in told
    assert "too narrow" not in model_sentences.interval_sentence(["actm"], values[1:])
    assert model_sentences.caution(values).startswith(" Intervals of 1 of 2 runs are too narrow")
    assert model_sentences.caution(values[1:]) == ""


def test_batches_are_flow_throughs_where_the_record_is_long_enough():
    assert [batches_of(n) for n in (0.3, 5.9, 33.0)] == [4, 5, 10]


def test_interval_is_student_s():
    found = estimate(np.array([1.0, 4.0, 2.0, 3.0]), batches=4)  # memory -0.65: as if independent
    # s = 1.29099, t_{0.975, 3} = 3.18245
    assert found.half_width == pytest.approx(3.18245 * 1.29099 / 2, rel=1e-5)
    assert estimate(np.array([0.0, 1.0] * 8), batches=16).memory == pytest.approx(-15 / 16)
    assert np.isnan(estimate(np.array([1.0]), batches=4).half_width)


def uneven():
    """Times of a record of 2, a hundred steps in its first half and a thousand in its second, and values 1 and 3."""
    time = np.concatenate([np.arange(1, 101) * 0.01, 1.0 + np.arange(1, 1001) * 0.001])
    return time, np.where(np.arange(1100) < 100, 1.0, 3.0)


def test_rows_of_short_steps_count_for_little():
    time, values = uneven()
    assert mean_over_time(time, values) == pytest.approx(2.0)
    assert mean_over_time(time, values, 0.505) == pytest.approx((0.5 * 1.0 + 1.0 * 3.0) / 1.5)
    assert np.isnan(mean_over_time(time, values, 5.0))
    assert second_half(time) == 100
    found = estimate_over_time(time, values, batches=4)
    assert found.batches == pytest.approx([1.0, 1.0, 3.0, 3.0])
    assert found.mean == pytest.approx(2.0) and found.half_width == estimate(found.batches, 4).half_width
    # A row that reaches over the end of a batch goes into both by its time.
    assert estimate_over_time(np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, 6.0]), batches=2).batches == (
        pytest.approx([(1.0 + 2.0 + 0.5 * 6.0) / 2.5, 6.0])
    )


def test_even_rows_are_what_they_were():
    numbers = np.random.default_rng(8).normal(size=120)
    time = 0.3 + 0.1 * np.arange(120)
    for batches in (4, 10):
        one, other = estimate(numbers, batches), estimate_over_time(time, numbers, batches=batches)
        assert (one.mean, one.half_width) == (pytest.approx(other.mean), pytest.approx(other.half_width))
        assert one.batches == pytest.approx(other.batches)
    assert second_half(time) == 60
    assert (second_half(time[:1]), mean_over_time(time[:1], numbers[:1])) == (0, numbers[0])


def test_friction_is_of_the_force_over_time(tmp_path):
    """Force 1 up to 1, 3 up to 1.4 and 5 up to 2, a depth of 8: the second half, of which ten of eleven rows are, has
    4.2; half of the rows would have 5."""
    run = Run(write_run(tmp_path / "run", wandering_story()))
    time, _ = uneven()
    force = np.select([time < 1.0005, time < 1.4005], [1.0, 3.0], 5.0)
    lines = ["step,time,driving,cfl,max_divergence,slip_rms,slip_max,momentum_residual"]
    lines += [f"1,{t!r},{f!r},0.5,1e-9,{0.01 * f!r},0.02,1e-9" for t, f in zip(time, force, strict=True)]
    (run.folder / "history.csv").write_text("\n".join(lines) + "\n")
    assert bed_friction.driving_friction(run, 0.0) == pytest.approx(np.sqrt(2.6 * 8))
    relative = estimate(np.array([1.0, 1.0, 3.4, 5.0]), 4).half_width / 2.6
    half = 0.5 * relative * np.sqrt(2.6 * 8)
    assert bed_friction.driving_friction_interval(run, 0.0) == pytest.approx(half, rel=1e-6)
    found = {line.what: line.value for line in summary.flow_lines(run)}
    assert found["friction velocity"] == f"{np.sqrt(4.2 * 8):.4f} u_b"
    assert found["slip at markers, rms"] == "4.20e-02 u_b"


def test_bed_stress_is_extrapolated_from_the_clear_flow(tmp_path):
    """tau = f (top - y) above the grains; below, spheres take it up."""
    face = np.linspace(0.0, 9.0, 46)
    stress = np.where(face > 3.0, 0.002 * (9.0 - face), 0.001)
    folder = write_run(tmp_path / "run", wandering_story())
    facts = {"samples": 10, "begin": 0.0, "end": 50.0, "driving": 0.002, "wall_stress": [0.0, 0.0]}
    with h5py.File(folder / "statistics.h5", "w") as file:
        file.attrs.update(facts | {"u_tau": 0.1, "stress_defect": 0.0})
        file["profiles/y_face"] = face
        file["profiles/viscous"], file["profiles/turbulent"] = 0.25 * stress, 0.75 * stress
    run = Run(folder)
    found = bed_friction.bed_stress(flow_statistics.read(run), 1.0, 4.0)
    assert found == pytest.approx(0.016, rel=1e-12)
    friction, source = bed_friction.friction_velocity(run, 0.0)
    assert friction == pytest.approx(np.sqrt(0.016), rel=1e-12)
    assert "total stress" in source
    assert "total stress" in bed_friction.friction_velocity(run, 4.0)[1]  # of the statistics' 50, history.csv's 22
    assert "driving force" in bed_friction.friction_velocity(run, 6.0)[1]  # an eighth of them is the start-up
    with h5py.File(folder / "statistics.h5", "r+") as file:
        file.attrs["end"] = 1.0  # of some twenty: not the record's
    assert "driving force" in bed_friction.friction_velocity(run, 0.0)[1]
    (folder / "statistics.h5").unlink()
    # history.csv has driving 0.004 over a depth of 8.
    assert bed_friction.friction_velocity(run, 0.0)[0] == pytest.approx(np.sqrt(0.032), rel=1e-12)


@pytest.mark.parametrize(("depth", "start", "height", "without"), [
    (9.0, 0.0, 4.5, 4.5), (4.5, 0.0, 4.5, 4.5), (7.0, 2.1, 3.5, 5.5), (3.4, 2.1, 3.4, 5.6),
])  # fmt: skip
def test_two_walls_share_the_driving_force(tmp_path, depth, start, height, without):
    """reference.height is their distance or half of it, start.height the bed's top: f half of the distance on each."""
    folder = write_run(tmp_path / "run", wandering_story())
    text = (folder / "settings.toml").read_text().replace('["no_slip", "free_slip"]', '["no_slip", "no_slip"]')
    text = text.replace("reference.height = 8.0", f"reference.height = {depth}\nstart.height = {start}")
    (folder / "settings.toml").write_text(text)
    run = Run(folder)
    assert bed_friction.driving_friction(run, 0.0) == pytest.approx(np.sqrt(0.004 * height), rel=1e-12)
    assert bed_friction.bed_top(run) == pytest.approx(without - height)
    face = np.linspace(0.0, 9.0, 46)
    with h5py.File(folder / "statistics.h5", "w") as file:
        file.attrs.update(samples=10, begin=0.0, end=22.0, driving=0.004, wall_stress=[0.0, 0.0], u_tau=0.1)
        file["profiles/y_face"], file["profiles/turbulent"] = face, 0.0 * face
        file["profiles/viscous"] = 0.004 * (without - face)
    friction, source = bed_friction.friction_velocity(run, 0.0)
    assert friction == pytest.approx(np.sqrt(0.004 * height), rel=1e-12)
    assert "total stress" in source


def test_side_walls_leave_no_friction_velocity(tmp_path):
    """They bear a part of the driving force; the report has all other numbers."""
    folder = write_run(tmp_path / "run", even(story_of_three_states()))
    text = (folder / "settings.toml").read_text()
    text = text.replace('boundary.z = ["periodic", "periodic"]', 'boundary.z = "no_slip"')
    (folder / "settings.toml").write_text(text)
    case = model_numbers.make_case("rpm", Run(folder), 0.0)
    found, = models_report.write(models_report.Comparison("duct", [case], 1, {}), tmp_path / "report")
    assert [found[name] for name in ("u_tau", "re_tau", "d_plus", "shields")] == [None] * 4
    assert "side walls" in found["u_tau_from"]
    page = (tmp_path / "report" / "README.md").read_text()
    assert "no run has a friction velocity" in page and "| mean particle velocity / u_b | 0.17" in page
    assert "D⁺" not in page


def test_figures_of_an_earlier_report_go(run, tmp_path):
    """Of what these runs do not have: one jump and one creeping phase make no figure."""
    for name in ("jumping.png", "correlations.png"):
        (tmp_path / name).write_bytes(b"old")
    models.keep_correlations(Run(run.folder), 1e9, tmp_path)
    case = model_numbers.make_case("rpm", run, 0.0)
    models_report.write(models_report.Comparison("made up", [case], 0, {}), tmp_path)
    assert not {"jumping.png", "correlations.png"} & {file.name for file in tmp_path.iterdir()}


def test_short_records_have_no_empty_figure(run, tmp_path, monkeypatch):
    """Too few samples at any height for a mean; no running mean where the record has not two flow-throughs."""
    case = model_numbers.make_case("rpm", run, 0.0)
    assert model_figures.heights([case], tmp_path / "heights.png")
    short = Run(shutil.copytree(run.folder, tmp_path / "short"))
    rows = even(story_of_three_states()).arrays(1, 16.0)
    write_samples(short.folder, {name: values[:30] for name, values in rows.items()})
    few = model_numbers.make_case("rpm", short, 0.0)
    assert not model_figures.heights([few], tmp_path / "none.png") and not (tmp_path / "none.png").exists()
    labels = []
    monkeypatch.setattr(model_figures, "_save", lambda figure, _: labels.append(figure.axes[0].get_ylabel()))
    monkeypatch.setitem(vars(case.run), "box", np.array([5.0, 9.0, 8.0]))  # its time of 20 is four flow-throughs
    for cases in ([case], [few], [case, few]):
        model_figures.velocity_series(cases, tmp_path / "series.png")
    assert ["running mean" in label for label in labels] == [True, False, True]
    assert ["short records" in label for label in labels] == [False, False, True]


def test_a_film_has_its_frames(tmp_path):
    """Three frames, white around the scene, and a grain in them that moves."""
    folder = write_run(tmp_path / "run", wandering_story())
    show = Path(__file__).resolve().parents[2] / "postproc" / "show.py"
    line = ["xvfb-run", "-a", sys.executable, "-I", "-B", show, folder, "--film", "8.0"]
    done = subprocess.run([*line, "--frames", "3"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    raw = subprocess.run(
        ["ffmpeg", "-loglevel", "error", "-i", folder / "film.mp4", "-f", "rawvideo",
         "-pix_fmt", "rgb24", "-"], capture_output=True, check=True,
    ).stdout  # fmt: skip
    images = np.frombuffer(raw, np.uint8).reshape(3, 560, 1120, 3).astype(int)
    assert 0.3 < np.mean(images[0].min(axis=2) > 245) < 0.97
    grain = [(im[:480, :, 0] > 150) & (im[:480, :, 2] < 110) for im in images]
    place = [np.argwhere(where).mean(axis=0) for where in grain]
    assert np.linalg.norm(place[2] - place[0]) > 1.0


def test_a_block_of_whole_instants_is_one_rectangle():
    tag, time = np.tile([4, 7, 9], 5), np.repeat(np.arange(5.0), 3)
    assert grains_per_instant(time, tag) == 3
    assert grains_per_instant(time[:-1], tag[:-1]) == 0
    swapped = tag.copy()
    swapped[3:5] = swapped[[4, 3]]
    assert grains_per_instant(time, swapped) == 0
    assert time_ranges([(time, tag), (time + 5, tag)]) == {4: (0, 9), 7: (0, 9), 9: (0, 9)}


def test_pieces_are_searched_all_at_once():
    values = np.array([1.0, 2.0, 4.0, 0.0, 4.0, 4.0, 5.0])
    begin, end = np.array([0, 3, 6, 7]), np.array([3, 6, 7, 7])
    assert first_above(values, begin, end, 4.0).tolist() == [3, 6, 6, 7]
    assert first_above(values, begin, end, 1.0).tolist() == [1, 4, 6, 7]
    rows, column = pieces(np.array([1, 4, 6]), np.array([3, 6, 6]))
    assert (rows.tolist(), column.tolist()) == ([1, 2, 4, 5], [0, 0, 1, 1])


def test_grains_that_come_and_go():
    """Grain 2 is there for instants 3 to 6 alone: a new rectangle begins where it comes and goes."""
    rows = [(t, g) for t in range(10) for g in (1, 2) if g == 1 or 3 <= t <= 6]
    time, tag = np.array(rows, float)[:, 0], np.array(rows)[:, 1]
    three = np.tile(time[:, None], 3)
    block = Samples(time, tag, three, three, three, np.full(len(time), 0.5))
    parts = [(f.tag.tolist(), f.time.tolist()) for f in frames([block])]
    assert parts == [([1], [0, 1, 2]), ([1, 2], [3, 4, 5, 6]), ([1], [7, 8, 9])]
    assert all((f.position[..., 0] == f.time[:, None]).all() for f in frames([block]))
    assert time_ranges([(time, tag)]) == {1: (0, 9), 2: (3, 6)}


def test_one_grain_takes_another_s_place():
    """As many grains as before, but others."""
    time, tag = np.repeat(np.arange(4.0), 2), np.array([1, 2, 2, 1, 1, 3, 3, 1])
    three = np.tile(tag[:, None], 3)
    block = Samples(time, tag, three, three, three, np.full(len(time), 0.5))
    parts = list(frames([block]))
    assert [(f.tag.tolist(), f.time.tolist()) for f in parts] == [([1, 2], [0, 1]), ([1, 3], [2, 3])]
    assert all((f.position[..., 0] == f.tag).all() for f in parts)


def test_every_sample_counts_alike_where_a_grain_goes(run, tmp_path, monkeypatch):
    """20 grains of 210 instants in five blocks; the fastest goes in the second: 19 for the rest."""
    folder = tmp_path / "run"
    shutil.copytree(run.folder, folder)
    rows = [(0.5 * t, g) for t in range(210) for g in range(1, 21) if g < 20 or t < 80]
    time, tag = np.array(rows)[:, 0], np.array(rows)[:, 1].astype(int)
    speed = (0.01 * tag + 0.001 * time) * np.where(tag == 20, 10.0, 1.0)
    zero = np.zeros((len(time), 3))
    position = np.column_stack([np.zeros_like(time), 1.0 + 0.1 * tag, np.zeros_like(time)])
    write_samples(folder, {
        "time": time, "tag": tag, "position": position, "radius": np.full(len(time), 0.5),
        "velocity": zero + speed[:, None] * [1, 0, 0], "angular_velocity": zero,
    })  # fmt: skip
    monkeypatch.setattr(Run.sample_blocks, "__defaults__", (1000, -np.inf))
    assert len(list(Run(folder).sample_blocks())) == 5
    found = transport.measure(Run(folder))
    assert np.concatenate(found.time).tolist() == np.unique(time).tolist()
    assert found.mean("velocity").mean == pytest.approx(speed.mean(), rel=1e-12)
    # 105 D/u_b of 16 D: six batches of equal length in time.
    batches = [speed[np.isin(time, part)].mean() for part in np.array_split(np.unique(time), 6)]
    assert found.mean("velocity").batches == pytest.approx(batches, rel=1e-12)
    assert found.mean("height").mean == pytest.approx(position[:, 1].mean(), rel=1e-12)
    assert found.share_of(CREEPING).mean + found.share_of(RESTING).mean == pytest.approx(1.0)


def test_a_grain_with_one_sample_has_no_say(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run.folder, folder)
    with h5py.File(folder / "spheres.h5") as file:
        names = ("time", "tag", "position", "velocity", "angular_velocity", "radius")
        rows = {name: file[f"mobile/{name}"][:] for name in names}
    late = {name: values[-1:].copy() for name, values in rows.items()}
    late["tag"][:] = 2
    write_samples(folder, {name: np.concatenate([rows[name], late[name]]) for name in names})
    alone, both = transport.measure(run), transport.measure(Run(folder))
    assert both.samples == alone.samples
    assert both.mean("velocity").half_width == alone.mean("velocity").half_width
    write_samples(folder, late)
    with pytest.raises(MissingOutput, match="no mobile sphere with two samples after t = 0"):
        transport.measure(Run(folder))
    show = Path(__file__).resolve().parents[2] / "postproc" / "show.py"
    done = subprocess.run(
        [sys.executable, "-I", "-B", show, folder], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert not (folder / "path.png").exists()


def test_figures_of_jumps_and_creeping_need_some(tmp_path):
    """Twelve of each are drawn, with intervals; one of each is not."""
    story = Story(samples_per_time=100).piece(1.0, contact=True)
    for _ in range(12):
        story.piece(1.0, (0.25, 0, 0), spin_z=-0.5).touch(1e-3)
        story.piece(1.0, (1.0, 0, 0), spin_z=-0.4, jump_height=0.3).touch(1e-3)
    many = Run(write_run(tmp_path / "rpm", even(story.piece(1.0, contact=True))))
    few = Run(write_run(tmp_path / "actm", even(story_of_three_states())))
    for name, one, drawn in (("rpm", many, True), ("actm", few, False)):
        case = model_numbers.make_case(name, one, 0.0)
        for draw in (model_figures.jumping, model_figures.creeping):
            file = tmp_path / f"{name}-{draw.__name__}.png"
            assert draw([case], file) is drawn
            assert file.is_file() is drawn
    height = model_numbers.make_case("rpm", many, 0.0).transport.mean_jump_height(1.0)
    assert height == (pytest.approx(0.3, abs=0.003), pytest.approx(0.0, abs=0.004))  # samples miss the top by 1 %


def test_report_of_two_models(run, tmp_path):
    cases = [model_numbers.make_case(name, run, 0.0) for name in ("rpm", "actm_hw")]
    folder = tmp_path / "report"
    told = {"date": "2026-01-01"}
    models_report.write(
        models_report.Comparison("made up", cases, 2, told), folder, "<p>Because.</p>"
    )
    kept = json.loads((folder / "numbers.json").read_text())
    assert kept["circumstances"] == told
    assert kept["runs"][0]["mean_velocity"] == pytest.approx(0.175, abs=2e-3)
    assert kept["runs"][1]["paper_mean_velocity"] == 0.093
    page = (folder / "report.html").read_text()
    assert kept["runs"][0]["interval_too_narrow"] is True
    assert "<p>Because.</p>" in page
    assert "too narrow for rpm; actm + HW: batches shorter" in page  # one and a quarter flow-throughs
    assert "The intervals do not part rpm and actm + HW." in page  # the same run twice
    # What contradicts the paper stands first.
    assert (folder / "README.md").read_text().split("\n\n")[2].startswith("Of ")
    # Everything is in the one file; one jump and one creeping phase make no figure.
    assert page.count("data:image/png;base64") == len(list(folder.glob("*.png"))) >= 6
    assert not {"jumping.png", "creeping.png"} & {file.name for file in folder.iterdir()}
    assert 'src="' not in page.replace('src="data:', "")


def test_several_densities_stand_side_by_side(run, tmp_path):
    heavy = tmp_path / "heavy"
    shutil.copytree(run.folder, heavy)
    text = (heavy / "settings.toml").read_text()
    (heavy / "settings.toml").write_text(text.replace("sphere_density = 1.25", "sphere_density = 2.25"))
    cases = [model_numbers.make_case("rpm", one, 0.0) for one in (run, Run(heavy))]
    folder = tmp_path / "report"
    found = models_report.write(models_report.Comparison("made up", cases, 0, {}), folder)
    assert [v["density_ratio"] for v in found] == [1.25, 2.25]
    # S = u_tau^2/((rho_p - rho_f) g D): five times the submerged weight.
    assert found[0]["shields"] == pytest.approx(5 * found[1]["shields"], rel=1e-12)
    page = (folder / "report.html").read_text()
    assert "rpm, ρp/ρf 2.25" in page
    assert "paper_mean_velocity" not in found[0]  # Table 2 is of Setup II
    assert "ean velocity falls" not in page  # one model at each ratio
    assert {"path-rpm-1.25.png", "path-rpm-2.25.png"} <= {file.name for file in folder.iterdir()}
    models_report.write(models_report.Comparison("one", cases[:1], 0, {}), tmp_path / "o")
    two, one = (matplotlib.image.imread(f / "heights.png").shape for f in (folder, tmp_path / "o"))
    assert two[0] / two[1] > 1.8 * one[0] / one[1]  # a row of panels for each ratio
    assert "| rpm, ρp/ρf 1.25 | rpm, ρp/ρf 2.25 |" in (folder / "README.md").read_text()


def test_order_is_told_as_it_is():
    def value(model, velocity):
        return {"model": model, "mean_velocity": velocity, "mean_velocity_interval": 0.01}

    right = [value(m, u) for m, u in zip(("rpm", "rpm_hw", "actm", "actm_hw"), (4, 3, 2, 1))]
    assert model_sentences.order_sentence(right, True).endswith("actm + HW, the paper's.")
    unknown = [value(m, u) | {"mean_velocity_interval": np.nan} for m, u in (("rpm", 4), ("actm", 2))]
    assert "do not part rpm and actm." in model_sentences.order_sentence(unknown, True)
    wrong = [value("rpm", 1.0), value("actm", 2.0)]
    assert model_sentences.order_sentence(wrong, False) == "Mean velocity falls in the order actm > rpm."
    assert "actm > rpm; the paper's is rpm > actm." in model_sentences.order_sentence(wrong, True)


def test_each_density_has_an_order_of_its_own():
    def value(model, ratio, velocity):
        found = {"model": model, "mean_velocity": velocity, "mean_velocity_interval": 0.01}
        return found | {"density_ratio": ratio}

    told = model_sentences.order_sentences([
        value("rpm", 1.25, 0.4), value("actm", 1.25, 0.3), value("mine", 1.25, 0.1),
        value("rpm", 2.25, 0.1), value("actm", 2.25, 0.2), value("rpm", 1.75, 0.2),
    ], True)  # fmt: skip
    assert told == (
        "At ρp/ρf 1.25: mean velocity falls in the order rpm > actm, the paper's. "
        "At ρp/ρf 2.25: mean velocity falls in the order actm > rpm; the paper's is rpm > actm."
    )
    assert model_sentences.order_sentences([value("rpm", 1.2, 0.2), value("mine", 1.2, 0.1)], True) == ""
