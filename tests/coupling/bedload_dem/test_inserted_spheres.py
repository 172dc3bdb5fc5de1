"""A sphere that is inserted during a run meets the rules of one that is there at its begin."""

import pytest

from pocket import SCENE, changed_jobs, check_refused, job

EMPTY = [(line + "\n", "") for line in (
    "create_atoms    1 region layer",
    "create_atoms    2 single 1.95 1.75 1.1 units box",
    "create_atoms    2 single 3.3 2.0 0.5 units box",
    "set             group all diameter 1.0 density 2.5",
    "velocity        grains set 0.7 -0.6 0.05 units box",
)]  # fmt: skip
RAIN = """timestep 1e-3
region drop block 0 4 2.2 2.5 0 2 units box
fix one all particletemplate/sphere 15485863 atom_type 2 density constant 2.5 radius constant 0.35
fix mix all particledistribution/discrete 32452867 1 one 1.0
fix rain {} insert/pack seed 32452843 distributiontemplate mix{} insert_every once overlapcheck yes &
    all_in no vel constant 0 -0.5 0 region drop ntry_mc 1000 particles_in_region 1
coupled_run"""
WEIGHT, FLUID, MOTION = "weight all gravity", "fix             fluid all", "motion grains nve/sphere"
LINE = "\ncoupled_run"


def rain(into, more=""):
    return [*EMPTY, ("\ncoupled_run", "\n" + RAIN.format(into, more))]


REFUSED = {
    "moved by nothing": (rain("all"), ["is mobile and has a speed, but no fix moves it"]),
    "moved twice": (
        [*rain("grains"), (LINE, "\nfix second all nve/sphere" + LINE)],
        ["is moved by two fixes", "second"],
    ),
    "no weight": ([*rain("grains"), (WEIGHT, "weight bed gravity")], ["after an insertion in step 1, gravity is"]),
    "held before the load comes": (
        [*rain("grains"), (FLUID, "fix plane grains planeforce 0 1 0\n" + FLUID)],
        ["planeforce", "stands before it"],
    ),
    "held before the films act": (
        [*rain("grains"), (MOTION, "motion grains nve/sphere\nfix lane grains setforce NULL 0 NULL")],
        ["the films act behind 'fix lane setforce'"],
    ),
    "renumbered": (rain("grains", " compress_tags yes"), ["leave out 'compress_tags yes'"]),
}


def test_mistakes_are_refused(tmp_path):
    cases = {case: changes for case, (changes, _) in REFUSED.items()}
    cases["sound"] = rain("grains")
    results = changed_jobs(tmp_path, cases, 2)
    assert results.pop("sound").status == 0
    for case, result in results.items():
        check_refused(result, REFUSED[case][1])


def test_what_is_not_in_the_fluid_is_said(tmp_path):
    changes = [*rain("all"), (FLUID, "fix fluid grains"), (MOTION, "motion all nve/sphere")]
    result = changed_jobs(tmp_path, {"dry": changes}, 2)["dry"]
    assert result.status == 0, result.output
    assert "is not in its group: it meets other spheres" in result.output


@pytest.mark.parametrize("step, counts", [("1e-4", True), (f"{0.02 / 15:.9g}", False)])
def test_times_that_are_counted_in_other_steps_are_said(tmp_path, step, counts):
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    lines = RAIN.format("grains", "").replace("1e-3", step).replace("insert_every once", "insert_every_time 0.06")
    script = tmp_path / "in.liggghts"
    script.write_text(text.replace("\ncoupled_run", "\n" + lines), encoding="utf-8")
    result = job(tmp_path / "out", "--steps", "1", script=script)
    assert result.status == 0, result.output
    assert ("insert_every_time was counted in steps of the script's timestep, 0.0001" in result.output) == counts
