"""Onset of motion: numbers worked out by hand, and thresholds of made-up points."""

import argparse
import math
from dataclasses import replace

import numpy as np
import pytest

from bedload_launcher.errors import UserError
from bedload_post import incipient_motion
from bedload_post.batches import Estimate
from bedload_post.bed_friction import driving_friction, driving_friction_interval
from bedload_post.incipient_motion import (
    Point,
    crossing,
    flux_of,
    flux_scale,
    shields_curve,
    threshold_of_share,
    threshold_of_transport,
    wong_parker,
)
from bedload_post.outputs import Run
from bedload_studies import threshold, threshold_report
from synthetic import SETTINGS, wandering_story, write_run


def value(mean, half=0.0):
    return Estimate(mean, half, np.array([mean]))


def point(theta, moving=0.5, transport=0.0, half=0.0):
    return Point("actm", theta, value(moving, half), value(0.0), value(0.0), value(transport, half))


def test_wong_and_parker():
    assert wong_parker(0.04) == 0.0
    # 4.93 (0.147 - 0.047)^1.6 = 4.93 * 10^-1.6
    assert wong_parker(0.147) == pytest.approx(4.93 * 10**-1.6)


def test_shields_curve():
    # D* = 10: 0.30/13 + 0.055 (1 - e^-0.2)
    assert shields_curve(10.0) == pytest.approx(0.0230769 + 0.055 * 0.1812692, rel=1e-5)
    assert shields_curve(1e6) == pytest.approx(0.055, rel=1e-3)  # coarse grains
    assert shields_curve(1.0) == pytest.approx(0.1375, rel=0.01)  # fine ones


def test_transport_rate():
    """Over an area of 5 a grain of diameter 2 (volume 4.18879) and speed 3 and one half as large of 4: 14.66077/5; q/q*
    of (s-1) g = 0.5 and D = 2 is sqrt(0.5 * 8)."""
    found = flux_of(np.array([[3.0, 4.0], [0.0, 4.0]]), np.array([1.0, 0.5]), 5.0)
    assert found == pytest.approx([14.66077 / 5.0, 0.418879], rel=1e-6)
    assert flux_scale(2.0, 0.5) == pytest.approx(2.0)


def test_crossing():
    assert crossing([0.01, 0.03], [0.0, 0.2]) == pytest.approx(0.02)
    assert crossing([0.03, 0.01], [0.2, 0.0]) == pytest.approx(0.02)  # in any order
    assert math.isnan(crossing([0.01, 0.03], [0.0, 0.05]))
    assert math.isnan(crossing([0.01, 0.03], [0.2, 0.5]))
    assert crossing([1, 2, 3, 4], [0.2, 0.0, 0.05, 0.15]) == pytest.approx(3.5)  # the last one


def test_threshold_of_share_with_its_interval():
    points = [point(0.02, 0.02, half=0.02), point(0.04, 0.12, half=0.02), point(0.06, 0.5, half=0.02)]
    found = threshold_of_share(points)
    assert found.value == pytest.approx(0.036)  # 0.02 + 0.02 * 0.08/0.10
    assert (found.low, found.high) == (0.02, 0.06)  # at 0.04 it may still be a tenth
    assert found.holds(0.045) and not found.holds(0.065)


def test_a_threshold_is_anywhere_between_two_shields_numbers():
    """A steep share has a tenth at 0.05; the line between 0.033 and 0.06 has it at 0.038."""
    shares = zip((0.06, 0.017, 0.024, 0.033, 0.085), (0.5, 0.0, 0.0, 0.0008, 0.98), strict=True)
    found = threshold_of_share([point(theta, share, half=0.01) for theta, share in shares])
    assert found.value == pytest.approx(0.0384, abs=5e-5)
    assert (found.low, found.high) == (0.033, 0.06)
    for expected, side in ((0.0401, "agrees"), (0.032, "later"), (0.07, "earlier")):
        assert threshold_report.side(found, [], expected) == side
    # A share that falls again for a while: the interval holds the last crossing.
    shares = ((0.01, 0.02), (0.02, 0.15), (0.03, 0.08), (0.04, 0.5))
    found = threshold_of_share([point(theta, share, half=0.03) for theta, share in shares])
    assert (found.low, found.high) == (0.01, 0.04) and found.holds(found.value)


def test_an_end_that_the_points_do_not_reach_is_open():
    """At the highest Shields number 0.12 ± 0.05 may still be less than a tenth."""
    points = [point(0.01, 0.02, half=0.01), point(0.017, 0.05, half=0.03), point(0.024, 0.12, half=0.05)]
    found = threshold_of_share(points)
    assert found.high == np.inf and str(found) == "0.0220 (0.0170 or more)" and found.holds(0.03)
    for expected, side, words in ((0.03, "unknown", "cannot be told from"), (0.02, "agrees", "agrees with"),
                                  (0.01, "later", "later than Shields' curve, 0.0100, by a factor of at least 1.7")):
        assert threshold_report.side(found, points, expected) == side
        assert words in threshold_report.verdict(found, points, expected)
    assert "at least 1.70 times that of exposed grains" in threshold_report.beside_exposed(found)
    points = [point(0.045, 0.08, half=0.05), point(0.06, 0.25, half=0.05)]
    found = threshold_of_share(points)
    assert found.low == 0.0 and "cannot be told" in threshold_report.beside_exposed(found)
    assert threshold_report.side(found, points, 0.04) == "unknown"


def test_threshold_of_transport_finds_what_made_the_points():
    def law(theta):
        return 3.0 * (theta - 0.031) ** 1.6

    exact = [point(t, transport=law(t), half=1e-9) for t in (0.04, 0.06, 0.1)]
    assert threshold_of_transport(exact).value == pytest.approx(0.031, abs=1e-6)
    noisy = [point(t, transport=law(t), half=0.05 * law(t)) for t in (0.04, 0.06, 0.1)]
    found = threshold_of_transport(noisy)
    assert found.low < 0.031 < found.high
    assert 0.0002 < found.high - found.low < 0.01
    # A point that cannot be told from zero says nothing of where zero is.
    lost = [*noisy, point(0.02, transport=1e-5, half=1e-4)]
    assert threshold_of_transport(lost).value == pytest.approx(found.value)
    assert math.isnan(threshold_of_transport(noisy[:2]).value)
    # Nor does one without a grain in motion.
    still = [*noisy, point(0.02, moving=0.0, transport=1e-5, half=1e-7)]
    assert threshold_of_transport(still).value == pytest.approx(found.value)
    # Points that lie on no line: the interval is that of their scatter about it.
    off = [point(t, transport=law(t) * more, half=1e-3 * law(t))
           for t, more in ((0.04, 1.0), (0.06, 1.5), (0.08, 1.0), (0.1, 1.0))]  # fmt: skip
    scattered = threshold_of_transport(off)
    assert scattered.high - scattered.low > 0.001  # 3e-5 from the points' own intervals
    # Grains that move however weak the flow is have no threshold.
    ever = [point(t, transport=t**1.6 + 0.01, half=1e-9) for t in (0.04, 0.06, 0.1)]
    assert math.isnan(threshold_of_transport(ever).value)
    assert str(threshold_of_transport(noisy[:2])) == "not found"


def test_the_threshold_on_shields_curve_is_its_own_gravity_s():
    theta = incipient_motion.shields_threshold(1.0, 0.0728, 2.99e-3)
    weight = 0.0728**2 / theta
    number = incipient_motion.diameter_number(1.0, weight, 2.99e-3)
    assert shields_curve(number) == pytest.approx(theta)
    assert 0.03 < theta < 0.045  # D+ = 24: the paper reads 0.035 from the diagram
    # Of the same D+ in other units of length and time.
    assert incipient_motion.shields_threshold(2.0, 3 * 0.0728, 6 * 2.99e-3) == pytest.approx(theta)


def experiment(level, half=0.01, **changes):
    """Shares in motion of actm at four Shields numbers; Shields' curve has 0.0318 there."""
    points = [
        Point("actm", t, value(m, half), value(m, half), value(0.1 * m, 0.001), value(0.01 * m, 1e-4))
        for t, m in zip((0.01, 0.03, 0.06, 0.1), level, strict=True)
    ]
    made = threshold_report.Experiment(
        "made_up", 6, 12, 4, 0.0728, "by hand", 2.99e-3, 1.0, 1.2, points, {"commit": "none"}
    )
    return replace(made, **changes)


def test_the_report_says_what_its_numbers_say(tmp_path):
    early = threshold_report.as_text(experiment((0.05, 0.4, 0.6, 0.9)))
    assert "- actm: 0.0129 (0.0100 to 0.0300): begins to move earlier than Shields' curve, 0.0318, by a" in early
    fitting = threshold_report.as_text(experiment((0.0, 0.085, 0.2, 0.9)))
    assert "0.0339 (0.0300 to 0.0600): agrees with Shields' curve, 0.0318, within" in fitting
    never = threshold_report.as_text(experiment((0.0, 0.01, 0.02, 0.05)))
    assert "lies above the highest Shields number computed, 0.1." in never and "| actm | above 0.1 | " in never
    always = threshold_report.as_text(experiment((0.3, 0.4, 0.6, 0.9)))
    assert "lies below the lowest Shields number computed, 0.01, where 30 % move: begins to move earlier" in always
    assert "| actm | below 0.01 | " in always
    unclear = threshold_report.as_text(experiment((0.105, 0.11, 0.12, 0.13)))
    assert "is not found among the Shields numbers computed" in unclear and "| actm | not found | " in unclear
    threshold_report.write(experiment((0.05, 0.4, 0.6, 0.9)), tmp_path)
    assert (tmp_path / "threshold.png").stat().st_size > 10000
    assert "begins to move earlier" in (tmp_path / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "level, side",
    [
        ((0.05, 0.4, 0.6, 0.9), "begin to move earlier: actm 0.0129 (0.0100 to 0.0300)."),
        ((0.3, 0.4, 0.6, 0.9), "begin to move earlier: actm below 0.01."),
        ((0.0, 0.085, 0.2, 0.9), "agree: actm 0.0339 (0.0300 to 0.0600)."),
        ((0.0, 0.0, 0.02, 0.9), "begin to move later: actm 0.0636 (0.0600 to 0.1000)."),
        ((0.0, 0.0, 0.02, 0.05), "begin to move later: actm above 0.1."),
        ((0.105, 0.11, 0.12, 0.13), "cannot be told: actm not found."),
    ],
)
def test_the_threshold_s_opening(level, side):
    text = threshold_report.as_text(experiment(level)).split("\n\n")[1]
    assert text.startswith(f"Beside Shields' curve, 0.0318 (10 % of the grains in motion), {side}")


@pytest.mark.parametrize(
    "level, side",
    [((0.05, 0.4, 0.6, 0.9), "agree: actm"), ((0.3, 0.4, 0.6, 0.9), "begin to move earlier: actm"),
     ((0.0, 0.085, 0.2, 0.9), "begin to move later: actm")],
)  # fmt: skip
def test_the_threshold_s_opening_knows_exposed_grains(level, side):
    """0.01, at which grains in the pockets of a fixed layer are reported to move."""
    text = threshold_report.opening(experiment(level))
    assert f"in the pockets of a fixed layer, 0.01 (Fenton & Abbott 1977), {side}." in text


@pytest.mark.parametrize(
    "moving, verdict",
    [(0.4, "all models contradict that"), (0.105, "no model contradicts that"), (0.0, "no model contradicts that")],
)
def test_what_moves_at_the_paper_s_shields_number(moving, verdict):
    """0.03 is nearest to 0.0241, and under 0.035."""
    found = experiment((0.0, moving, 0.6, 0.9))
    assert f"here actm {100 * moving:.0f} ± 1 %: {verdict}." in threshold_report.opening(found)
    second = [replace(p, model="rpm", moving=value(0.5, 0.01)) for p in found.points]
    both = threshold_report.opening(replace(found, points=[*found.points, *second]))
    assert (": all models contradict" in both) == (moving > 0.2)
    assert (": not all models contradict" in both) == (moving < 0.2)
    high = replace(found, points=[p for p in found.points if p.shields > 0.05])
    assert "Setup II" not in threshold_report.opening(high)


def test_intervals_that_promise_too_much_are_named(tmp_path):
    """Eight flow-throughs: eight batches that know nothing of each other, or that rise; old records kept none."""
    found = experiment((0.05, 0.4, 0.6, 0.9))
    old = [replace(p, moving=replace(p.moving, batches=np.empty(0))) for p in found.points]
    assert "This record has not kept its batches" in threshold_report.as_text(replace(found, points=old))
    calm, rising = (replace(value(0.4, 0.01), batches=b) for b in (np.tile([0.3, 0.5], 4), np.linspace(0.2, 0.6, 8)))
    of = [replace(p, moving=b) for p, b in zip(found.points, (calm, rising, calm, rising), strict=True)]
    threshold_report.write(replace(found, points=of), tmp_path)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "the share in motion of 2 of 4 runs" in text and "more than 0.3: actm at 0.03; actm at 0.1." in text
    threshold_report.rewrite(tmp_path)
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == text
    calm_all = replace(found, points=[replace(p, moving=calm) for p in found.points])
    assert threshold_report.narrow_sentence(calm_all) == ""
    # Batches shorter than a flow-through.
    assert "4 of 4 runs" in threshold_report.narrow_sentence(replace(calm_all, throughs=10))


def test_a_kept_threshold_is_written_anew(tmp_path):
    threshold_report.write(experiment((0.05, 0.4, 0.6, 0.9)), tmp_path)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    (tmp_path / "README.md").unlink()
    (tmp_path / "threshold.png").unlink()
    threshold_report.rewrite(tmp_path)
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == text
    assert (tmp_path / "threshold.png").is_file()
    (tmp_path / "motion.png").write_bytes(b"kept")
    threshold_report.rewrite(tmp_path)
    assert "(motion.png)" in (tmp_path / "README.md").read_text(encoding="utf-8")
    assert (tmp_path / "motion.png").read_bytes() == b"kept"


def write_study(folder, shields=0.03):
    """Runs of a study of six cells and 2.5 flow-throughs, whose scene has their settings; words of its command."""
    scene = folder / "scene"
    scene.mkdir()
    (scene / "fluid.toml").write_text(SETTINGS.format(nx=80, ny=45, nz=40), encoding="utf-8")
    variables = {"model": "rpm", "placing": "dropped", "gravity": "0.99"}
    lines = [f"variable {name} index {value}\nprint ${{{name}}}\n" for name, value in variables.items()]
    (scene / "in.liggghts").write_text("".join(lines), encoding="utf-8")
    for name in ("bed", "rpm-0.03", "actm-0.03"):
        settings = write_run(folder / name, wandering_story(), cells=(96, 54, 48)) / "settings.toml"
        gravity = 0.004 * 8.0 / (0.25 * shields)  # u_tau^2 of the driving force
        settings.write_text(settings.read_text().replace("-0.99", "-0.99" if name == "bed" else repr(-gravity)))
    return ["--scene", str(scene), "--report-only", "--models", "rpm", "actm", "--shields", "0.03", "--cells", "6",
            "--throughs", "2.5", "--discard", "0.1", "--out", str(folder)]  # fmt: skip


@pytest.mark.parametrize(
    ("shields", "words", "sentence"),
    [
        (0.03, ["--cells", "8"], "bed holds a run without grid.cells="),
        (0.03, ["--throughs", "12"], "bed holds a run without time.end=192.0"),
        (0.03, ["--scene", "setup2_small"], "bed holds a run without grid.length="),
        (0.02, [], "rpm-0.03 holds a run at a Shields number of 0.02, not 0.03"),
    ],
)
def test_a_report_is_of_the_runs_that_its_command_says(tmp_path, shields, words, sentence):
    """Its page is made from the command: grid, length, scene and Shields numbers have to be those of the runs."""
    parser = argparse.ArgumentParser()
    threshold.add_options(parser)
    with pytest.raises(UserError, match=sentence):
        threshold.run(parser.parse_args([*write_study(tmp_path, shields), *words]))


def test_a_run_that_is_asked_for_twice_counts_once(tmp_path):
    parser = argparse.ArgumentParser()
    threshold.add_options(parser)
    line = [*write_study(tmp_path), "--models", "actm", "rpm", "actm", "--shields", "0.03", "0.030"]
    assert threshold.run(parser.parse_args(line)) == 0
    assert [p.model for p in threshold_report.read(tmp_path / "report").points] == ["actm", "rpm"]


def test_a_run_that_is_not_over_is_left_out_of_the_report(tmp_path, capsys):
    """At the Shields number whose maps of motion are drawn, too."""
    line = write_study(tmp_path)
    samples = tmp_path / "rpm-0.03" / "spheres.h5"
    samples.rename(samples.with_name("spheres.h5.part"))
    parser = argparse.ArgumentParser()
    threshold.add_options(parser)
    assert threshold.run(parser.parse_args(line)) == 0
    said = capsys.readouterr().out
    assert "left out of the report" in said and "rpm-0.03/spheres.h5.part is of a run that goes on" in said
    found = threshold_report.read(tmp_path / "report")
    assert [p.model for p in found.points] == ["actm"]
    # Of the driving force, not of the outer flow's stress, which still remembers the grains: at every instant the bed
    # takes up the driving.
    bed, since = Run(tmp_path / "bed"), 0.1 * 16.0 / 3.0
    assert found.friction_velocity == pytest.approx(driving_friction(bed, since))
    assert found.friction_source.startswith("driving force times depth, t = ")
    assert found.friction_half_width == pytest.approx(driving_friction_interval(bed, since), nan_ok=True)


@pytest.mark.parametrize("table", ["collisions.csv", "collisions_open.csv"])
def test_a_run_without_its_contacts_ends_the_study(tmp_path, table):
    """It is no run that is only too short: with its contacts at rest counted as jumps it would look like one."""
    line = write_study(tmp_path)
    (tmp_path / "rpm-0.03" / table).unlink()
    parser = argparse.ArgumentParser()
    threshold.add_options(parser)
    with pytest.raises(UserError, match=f"rpm-0.03 has no {table}"):
        threshold.run(parser.parse_args(line))


def test_a_threshold_stands_beside_that_of_exposed_grains():
    beside, limit = threshold_report.beside_exposed, incipient_motion.Threshold
    assert beside(limit(math.nan, math.nan, math.nan)) == ""
    assert "agrees with that of exposed grains, 0.01" in beside(limit(0.012, 0.009, 0.015))
    assert "1.27 to 1.50 times that of exposed grains" in beside(limit(0.014, 0.0127, 0.015))


def test_a_verdict_follows_the_interval():
    verdict = threshold_report.verdict
    agrees = incipient_motion.Threshold(0.03, 0.02, 0.04)
    assert "agrees" in verdict(agrees, [], 0.035)
    assert "later" in verdict(incipient_motion.Threshold(0.07, 0.06, 0.08), [], 0.035)
    assert "factor of 1.71 to 2.29" in verdict(incipient_motion.Threshold(0.07, 0.06, 0.08), [], 0.035)
    assert "factor of 1.75 to 3.50" in verdict(incipient_motion.Threshold(0.015, 0.01, 0.02), [], 0.035)


def test_the_commands_are_those_of_the_runs(tmp_path):
    """rpm was computed at one Shields number more than actm: two commands; at the same ones it is one."""
    found = experiment((0.05, 0.4, 0.6, 0.9))
    same = [replace(p, model="rpm") for p in found.points]
    assert "--models actm rpm --shields 0.01 0.03 0.06 0.1 --cells" in threshold_report.commands(
        replace(found, points=[*found.points, *same])
    )
    more = replace(found, points=[*found.points, *same, replace(same[0], shields=0.005)])
    assert threshold_report.commands(more).count("./bedload study threshold") == 2
    assert "--models rpm --shields 0.005 0.01 0.03 0.06 0.1 --cells" in threshold_report.commands(more)
