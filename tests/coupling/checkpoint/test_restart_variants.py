"""A run that goes on is the run itself, whatever it consists of: blocks along z, statistics, a step
that follows the flow, each contact model, grains that are inserted on the way, a wall of triangles."""

import shutil

import numpy as np
import pytest

from pocket import FLOOR, PACK, RATE, SCENE, checkpoint, job, numbers, rows, same_numbers, with_mesh_floor

HALF = 24  # steps up to the first checkpoint
EVERY = ["--set", f"checkpoint.every={HALF * 0.02}"]
ACTM = "model actm tangential haff_werner"
RPM = dict(settings="range 0.25")
# The script changes spheres at the very step of the checkpoint: one goes, one comes.
BETWEEN = f"""coupled_run steps {HALF}
create_atoms 2 single 0.7 2.2 1.4 units box
group new id 11
set group new diameter 0.8 density 2.5
velocity new set 0.5 -0.4 0 units box
group grains union grains new
group gone id 10
delete_atoms group gone compress no
coupled_run"""
# The one that comes has the number of the one that goes.
REUSED = f"""coupled_run steps {HALF}
group gone id 10
delete_atoms group gone compress no
create_atoms 2 single 0.7 2.2 1.4 units box
group new id 10
set group new diameter 0.8 density 2.5
velocity new set 0.5 -0.4 0 units box
group grains union grains new
coupled_run"""
# Fixes that keep something of each sphere, made behind a coupled_run that is over at the checkpoint.
NEW_FIXES = """coupled_run steps 12
fix mark all property/atom mark vector yes no no 1. 2. 3.
fix ceiling all wall/gran model actm tangential haff_werner primitive type 1 yplane 2.9
coupled_run"""
ABOVE_THE_BED = 1.05  # where grains meet the triangles before the first checkpoint
VARIANTS = {
    "blocks along z": dict(ranks=(2, 1), fluid=["--set", "ranks.along_z=2"]),
    "four blocks": dict(ranks=(4, 2), fluid=["--set", "ranks.along_z=2"]),
    "statistics": dict(fluid=["--set", "statistics.every=1", "--set",
                              "statistics.spectra_heights=[1.5]"], files=["statistics.h5"]),
    "cfl": dict(fluid=["--set", "time.cfl=0.35", "--set", "time.step=0.04"], restless=True),
    "implicit diffusion": dict(fluid=["--set", 'fluid.diffusion="implicit"']),
    "implicit diffusion on two": dict(fluid=["--set", 'fluid.diffusion="implicit"'], ranks=(2, 1)),
    "rpm": dict(model="model rpm", **RPM),
    "rpm_hw": dict(model="model rpm tangential haff_werner", **RPM),
    "actm": dict(model="model actm"),
    "insert/pack": dict(insertion=PACK),
    "insert/pack on two": dict(insertion=PACK, ranks=(1, 2)),
    "insert/rate/region": dict(insertion=RATE),
    "changes between two runs": dict(between=BETWEEN),
    "another of the same number": dict(between=REUSED),
    "changes between two runs on two": dict(between=BETWEEN, ranks=(2, 2)),
    "fixes between two runs": dict(between=NEW_FIXES),
    "statistics on two": dict(ranks=(2, 1), fluid=["--set", "statistics.every=1", "--set",
                                                   "ranks.along_z=2"], files=["statistics.h5"]),
    "mesh wall": dict(triangles=4),
}


def script(folder, variant):
    """The pocket's LIGGGHTS script with the variant's lines in it."""
    text = (SCENE / "in.liggghts").read_text()
    if "model" in variant:
        settings = variant.get("settings", "")
        text = text.replace(f"pair_style      gran {ACTM}", f"pair_style gran {variant['model']} {settings}")
        text = text.replace(FLOOR, FLOOR.replace(ACTM, variant["model"]) + f" {settings}")
        assert ACTM not in text
    if "insertion" in variant:
        text = text.replace("fix             fluid", variant["insertion"])
        assert "insert/" in text
    if "between" in variant:
        assert text.endswith("coupled_run\n")
        text = text.removesuffix("coupled_run\n") + variant["between"] + "\n"
    if "triangles" in variant:
        text = with_mesh_floor(text, folder, variant["triangles"], ABOVE_THE_BED)
    (folder / "in.liggghts").write_text(text)
    return folder / "in.liggghts"


@pytest.mark.parametrize("name", VARIANTS)
def test_it_goes_on_as_if_nothing_had_been(tmp_path, name):
    variant = VARIANTS[name]
    ranks, fluid = variant.get("ranks", (1, 1)), [*EVERY, *variant.get("fluid", [])]
    lines = script(tmp_path, variant)
    whole = tmp_path / "whole"
    result = job(whole, *fluid, "--steps", str(2 * HALF), ranks=ranks, script=lines)
    assert result.status == 0, result.output
    steps = sorted(int(path.name[-8:]) for path in whole.glob("checkpoint_*"))
    first = steps[0]
    assert first < 2 * HALF
    again = tmp_path / "again"
    shutil.copytree(whole, again)
    for step in steps[1:]:
        shutil.rmtree(checkpoint(again, step))
    rest = [*fluid, "--steps", str(2 * HALF - first)]
    result = job(again, *rest, ranks=ranks, script=lines, restart=again)
    assert result.status == 0, result.output
    for file in ("state.h5", "fields.h5", "spheres.h5", *variant.get("files", [])):
        assert same_numbers(whole / file, again / file, but=["run/fftw_wisdom"]), file
    for file in ("history.csv", "collisions.csv"):
        assert (whole / file).read_bytes() == (again / file).read_bytes(), file
    if variant.get("restless"):
        assert len({row["dt"] for row in rows(whole / "history.csv")}) > 1, "the step should have changed"

    if "insertion" in variant:
        found = numbers(whole / "spheres.h5")
        come = [found["mobile/tag"][found["mobile/step"] == step].max() for step in (first, 2 * HALF)]
        assert come[1] > come[0] > 10, "grains should come before the checkpoint and behind it"
        return  # on other ranks other random numbers are drawn
    if ranks != (1, 1):
        return
    other = tmp_path / "other"
    result = job(other, *rest, ranks=(2, 2), script=lines, restart=checkpoint(whole, first))
    assert result.status == 0, result.output
    a, b = numbers(whole / "spheres.h5"), numbers(other / "spheres.h5")
    behind = a["mobile/step"] > first
    assert np.array_equal(a["mobile/tag"][behind], b["mobile/tag"])
    for name in ("velocity", "angular_velocity", "force"):
        apart = np.abs(a[f"mobile/{name}"][behind] - b[f"mobile/{name}"])
        # As in test_restart: round-off grows to 1e-13; what is forgotten shows as 1e-6.
        assert apart.max() < 1e-10, name


# A sphere that was told to be elsewhere, or of another size, at the very end of the first part: the fluid's memory
# of it must be that of the run that makes both parts.
MOVED = f"""coupled_run steps {HALF}
group moved id 10
displace_atoms moved move 0.6 0.4 0 units box
coupled_run"""
GROWN = f"""coupled_run steps {HALF}
group grown id 10
set group grown diameter 1.1
coupled_run"""
ENDS = {"another of the same number": REUSED, "moved": MOVED, "grown": GROWN}


@pytest.mark.parametrize("name", ENDS)
def test_the_first_part_ends_where_the_script_changes_spheres(tmp_path, name):
    lines = script(tmp_path, {"between": ENDS[name]})
    whole, first, second = tmp_path / "whole", tmp_path / "first", tmp_path / "second"
    for out, steps, start in ((whole, HALF + 6, None), (first, HALF, None), (second, 6, first)):
        result = job(out, "--steps", str(steps), script=lines, **({"restart": start} if start else {}))
        assert result.status == 0, result.output
    a, b = numbers(whole / "spheres.h5"), numbers(second / "spheres.h5")
    behind = a["mobile/step"] > HALF
    assert np.array_equal(a["mobile/tag"][behind], b["mobile/tag"])
    for number in ("velocity", "force"):
        apart = np.abs(a[f"mobile/{number}"][behind] - b[f"mobile/{number}"]).max()
        assert apart < 1e-10, number  # as above: round-off, and what is forgotten shows as 0.07 and more


def test_the_mean_force_is_known_before_the_next_step_is_over(tmp_path):
    """f_ID[1..6] of the first rows behind a restart, which are those of the last whole step before."""
    text = (SCENE / "in.liggghts").read_text()
    mean = 'variable mean equal f_fluid[1]\nfix mean all print 1 "${mean}" file ${out}/mean.txt screen no\n'
    (tmp_path / "in.liggghts").write_text(text.replace("thermo ", mean + "thermo "))
    means = {}
    for out, steps, start in (("whole", 6, None), ("first", 4, None), ("second", 2, tmp_path / "first")):
        result = job(tmp_path / out, "--steps", str(steps), script=tmp_path / "in.liggghts",
                     **({"restart": start} if start else {}))  # fmt: skip
        assert result.status == 0, result.output
        means[out] = [float(line) for line in (tmp_path / out / "mean.txt").read_text().split("\n")[1:] if line]
    assert len(means["second"]) == 30 and means["second"][0] != 0.0
    assert means["second"] == pytest.approx(means["whole"][-30:], rel=1e-9)  # round-off of the transforms' plan


def test_an_insertion_that_was_over_stays_over(tmp_path):
    """The first part ends behind the last grain put in and before the script's second coupled_run."""
    insertion = RATE.replace("nparticles 30", "nparticles 2")
    assert insertion != RATE
    lines = script(tmp_path, {"insertion": insertion, "between": f"coupled_run steps {HALF + 3}\ncoupled_run"})
    whole, first, second = tmp_path / "whole", tmp_path / "first", tmp_path / "second"
    for out, steps, start in ((whole, HALF + 8, None), (first, HALF, None), (second, 8, first)):
        result = job(out, "--steps", str(steps), script=lines, **({"restart": start} if start else {}))
        assert result.status == 0, result.output
        assert "Inserting no particle" not in result.output, result.output
    a, b = numbers(whole / "spheres.h5"), numbers(second / "spheres.h5")
    behind = a["mobile/step"] > HALF
    assert np.array_equal(a["mobile/tag"][behind], b["mobile/tag"])
    assert np.abs(a["mobile/velocity"][behind] - b["mobile/velocity"]).max() < 1e-10
    assert len(set(b["mobile/tag"])) == len(set(a["mobile/tag"][a["mobile/step"] == HALF])) > 2


@pytest.mark.parametrize("steps", [1, 4, 9])
def test_a_coupled_run_in_pieces_is_one_run(tmp_path, steps):
    """A grain that slides over the bed within a cell: what markers leave between them is that of the run before."""
    near = (SCENE / "in.liggghts").read_text().replace("single 1.95 1.75 1.1", "single 1.95 1.32 1.1")
    found = {}
    for name, runs in (("whole", "coupled_run\n"), ("pieces", f"coupled_run steps {steps}\ncoupled_run\n")):
        lines = tmp_path / f"{name}.liggghts"
        lines.write_text(near.removesuffix("coupled_run\n") + runs)
        result = job(tmp_path / name, "--steps", "12", script=lines)
        assert result.status == 0, result.output
        found[name] = numbers(tmp_path / name / "spheres.h5")
    for number in ("velocity", "angular_velocity", "force"):
        apart = np.abs(found["whole"][f"mobile/{number}"] - found["pieces"][f"mobile/{number}"]).max()
        assert apart < 1e-11, number  # round-off; films made anew at the cut change the speed by 1e-9 to 1e-8
