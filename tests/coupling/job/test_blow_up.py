"""Runs that blow up, for real or by a number planted in them: they stop before the step that made it is
written anywhere, in one sentence that names the step, the place and the last checkpoint, and that
checkpoint is good."""

import math
import re

import h5py
import numpy as np
import pytest

from programs import BIN, command, run
from pocket import SCENE, checkpoint, checkpoints, job, line, rows, spoken

BUSY = ["--set", "checkpoint.every=0.08", "--set", "output.fields_every=0.02",
        "--set", "statistics.every=1"]  # fmt: skip
FLUID_LIMIT = math.sqrt(3.0)
PLACE = r"near cell \((\d+), (\d+), (\d+)\)"


def flow_alone(out, *options, ranks=1, before=()):
    fluid = [*before, str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--without-grains"]
    return run(command([*fluid, "--out", str(out), *options], None, (ranks,)), out.parent)


def script(folder, change):
    """The pocket's LIGGGHTS script with another text."""
    file = folder / "in.liggghts"
    file.write_text(change((SCENE / "in.liggghts").read_text(encoding="utf-8")), encoding="utf-8")
    return file


def history(out):
    return [{k: float(v) for k, v in row.items()} for row in rows(out / "history.csv")]


def check_written(out):
    """All that was written is finite: fields, spheres, checkpoints, tables."""
    files = list(out.glob("**/*.h5"))
    assert files
    for file in files:
        with h5py.File(file) as content:
            content.visititems(lambda name, item: check_finite(file, name, item))
    for row in history(out):
        # Works are followed on demand only (output.energy_work).
        assert all(math.isfinite(v) for k, v in row.items() if not k.endswith("_work")), row


def check_finite(file, name, item):
    if isinstance(item, h5py.Dataset) and item.dtype.kind == "f":
        assert np.all(np.isfinite(item[()])), f"{file.name}: {name}"


def check_stop(result, out, words):
    """One sentence; the step that it names was not written; the named checkpoint is the last one."""
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    for word in words:
        assert re.search(word, said[0]), said[0]
    last = checkpoints(out)[-1]
    assert f"--restart {checkpoint(out, last)}" in said[0]
    check_written(out)
    return int(re.search(r"step (\d+)", said[0])[1])


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_flow_that_gets_too_fast_for_its_step(tmp_path, ranks):
    """Driven by a force until the step is too long. With a shorter one its last checkpoint goes on."""
    out = tmp_path / "out"
    push = ["--set", 'flow.driving="pressure_gradient"', "--set", "flow.pressure_gradient=25"]
    result = flow_alone(out, *BUSY, *push, ranks=ranks)
    step = check_stop(result, out, ["CFL", PLACE])
    rows = history(out)
    assert rows[-1]["step"] == step - 1
    assert max(row["cfl"] for row in rows) <= FLUID_LIMIT
    i, j, k = map(int, re.search(PLACE, spoken(result.output)[0]).groups())
    assert 0 <= i < 32 and 0 <= k < 16
    assert 12 <= j < 24  # the wall holds the lower half back
    last = checkpoints(out)[-1]
    again = flow_alone(out, *BUSY, *push, "--set", "time.step=0.01", "--steps", "4", "--restart", str(out),
                       ranks=ranks)  # fmt: skip
    assert again.status == 0, again.output
    assert history(out)[-1]["step"] == last + 4
    check_written(out)


def test_steps_that_shrink_without_end(tmp_path):
    """A force that nothing balances, and steps that follow the flow: each would be shorter than the last.
    The second one, at CFL 1, is below 2^-13 of time.step."""
    push = ["--set", 'flow.driving="pressure_gradient"', "--set", "flow.pressure_gradient=1e9",
            "--set", "time.cfl=1.0"]  # fmt: skip
    result = flow_alone(tmp_path / "out", *push)
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    assert re.search("step 1 .*'time.cfl' = 1 allows steps of .* only, .* " + PLACE, said[0]), said[0]


def test_too_little_memory(tmp_path):
    """A grid that does not fit into what ulimit allows ends in a sentence that says so."""
    limited = ["sh", "-c", 'ulimit -v 900000 && exec "$@"', "sh"]
    big = ["--set", "grid.cells=[768,576,384]"]
    result = flow_alone(tmp_path / "out", *big, before=limited)
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    assert "not enough memory" in said[0] and "./bedload estimate" in said[0], said[0]


def test_a_scheme_that_is_unstable_for_its_spheres(tmp_path):
    """The whole old pressure in the predictor makes light spheres swing, and the swing grows."""
    out = tmp_path / "out"
    light = script(tmp_path, lambda text: text.replace("density 2.5", "density 0.35"))
    result = job(out, *BUSY, "--set", "spheres.pressure_share=1.0", "--set", "time.step=0.03",
                 "--set", "checkpoint.every=0.06", script=light)  # fmt: skip
    step = check_stop(result, out, ["CFL|not finite|radius", r"cell \(|atom \d+ at \("])
    assert step < 60
    assert history(out)[-1]["step"] == step - 1


@pytest.mark.parametrize(
    ("ranks", "push"), [((1, 1), "1e200*1e200"), ((2, 2), "1e12")], ids=["without end", "too fast"]
)
def test_grains_that_something_throws_away(tmp_path, push, ranks):
    """From LIGGGHTS' step 186 on, the first of fluid step 13."""
    out = tmp_path / "out"
    throwing = script(tmp_path, lambda text: text.replace(
        "coupled_run", f"variable push equal (step>185)*{push}\n"
        "fix push grains addforce v_push 0 0\ncoupled_run"))  # fmt: skip
    result = job(out, *BUSY, "--set", "output.spheres_every=0.0", script=throwing, ranks=ranks)
    check_stop(result, out, [r"atom (9|10) at \(.*\) with", "moves by more than its radius", "step 13"])


@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)], ids=["1+1", "2+2"])
def test_grains_that_leave_the_box(tmp_path, ranks):
    """LIGGGHTS drops them without a word."""
    out = tmp_path / "out"
    away = script(tmp_path, lambda text: text.replace(
        "coupled_run", "coupled_run steps 13\ndisplace_atoms grains move 0 2 0 units box\ncoupled_run"))
    check_stop(job(out, *BUSY, script=away, ranks=ranks), out,
               [r"atom (9|10) at \(.*\) with", "has left the box", "step 14"])  # fmt: skip


@pytest.mark.parametrize("coupled", [False, True], ids=["flow alone", "with grains"])
def test_a_number_planted_in_the_pressure(tmp_path, coupled):
    """Transforms spread it over the whole field, so that the next sum over it shows it."""
    out = tmp_path / "out"
    before = ["env", "BEDLOAD_POISON=bedload-fluid 0 transform 15000", f"LD_PRELOAD={BIN / 'kill_at.so'}"]
    if coupled:
        result = run(line(out, *BUSY, fluid_before=before), tmp_path)
    else:
        result = flow_alone(out, *BUSY, before=before)
    step = check_stop(result, out, ["not finite", r"cell \(\d+, \d+, \d+\)"])
    # Named is the last step that was whole, and nothing was written after it.
    assert history(out)[-1]["step"] == step
