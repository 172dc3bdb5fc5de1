"""What the two programs' command lines say wrongly, or in vain, is told in one sentence."""

import pytest

from pocket import SCENE, job, spoken
from programs import BIN, command, run

FLUID, DEM = str(BIN / "bedload-fluid"), str(BIN / "bedload-dem")
TOML, SCRIPT = str(SCENE / "fluid.toml"), str(SCENE / "in.liggghts")

MISTAKES = {
    "option": ([FLUID, TOML, "--stepps", "1"], "no option '--stepps'; the nearest is '--steps'"),
    "two scenes": ([FLUID, TOML, "other.toml"], "'other.toml' is one word too many"),
    "warm-up": ([FLUID, TOML, "--steps", "2", "--warm-up", "2"], "--warm-up 2 leaves none of the --steps 2"),
    "compact state of a run": ([FLUID, TOML, "--compact-state", "state.h5", "small.h5"], "excludes --compact-state"),
    "bare script": ([DEM, "in.liggghts"], "'in.liggghts' is no option; the script is given by -in in.liggghts"),
    "no such script": ([DEM, "-in", "in.ligghts"], "the script 'in.ligghts' is not there"),
    "no script": ([DEM, "-in"], "-in says no script"),
    "a folder": ([DEM, "-in", "."], "-in says '.', which is a folder"),
    "no value": ([DEM, "-in", SCRIPT, "-var", "model"], "'-var' needs a name and a value"),
    "unknown": ([DEM, "-in", SCRIPT, "-foo"], "'-foo' is no option; the nearest is '-l"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(tmp_path, mistake):
    words, sentence = MISTAKES[mistake]
    result = run(words, tmp_path)
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1 and sentence in said[0], result.output


COUPLED = {
    "nothing": ([DEM], "names no script, and the fluid waits for one"),
    "several": ([DEM, "-in", SCRIPT, "-partition", "1x2"], "'-partition' divides LIGGGHTS"),
    **{name: MISTAKES[name] for name in ("bare script", "no such script", "no script", "a folder", "unknown")},
}


@pytest.mark.parametrize("mistake", COUPLED)
def test_mistakes_in_a_coupled_job(tmp_path, mistake):
    """The whole job ends by the one sentence of the program that knows."""
    words, sentence = COUPLED[mistake]
    result = run(command([FLUID, TOML, "--out", str(tmp_path / "out")], words, (1, 1)), tmp_path)
    assert result.status != 0
    assert [sentence in said for said in spoken(result.output)] == [True], result.output


def test_a_byte_order_mark_is_named(tmp_path):
    script = tmp_path / "in.liggghts"
    script.write_text((SCENE / "in.liggghts").read_text(encoding="utf-8"), encoding="utf-8-sig")
    result = job(tmp_path / "out", "--steps", "1", script=script)
    assert result.status != 0
    assert ["begins with a byte order mark" in said for said in spoken(result.output)] == [True], result.output


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    out = tmp_path_factory.mktemp("finished") / "out"
    result = job(out, "--steps", "2", dem_more=("-var", "modle", "rpm"))
    assert result.status == 0, result.output
    return out, result.output


def test_a_variable_that_no_line_uses(finished):
    assert finished[1].count("uses the variable 'modle' that the command line sets") == 1
    assert "'out'" not in finished[1]


def test_a_declared_variable_is_named(tmp_path):
    """The nearest one; what lines use without a declaration is used."""
    text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
    text = f"variable model index actm\n{text}".replace("model actm", "model ${model}")
    text = text.replace("0.15", "${friction}", 1)
    script = tmp_path / "in.liggghts"
    script.write_text(text, encoding="utf-8")
    result = job(tmp_path / "out", "--steps", "1", script=script,
                 dem_more=("-var", "modl", "rpm", "-var", "friction", "0.15"))  # fmt: skip
    assert result.status == 0, result.output
    assert result.output.count("uses the variable") == 1
    assert "'modl' that the command line sets; the nearest that it declares is 'model'" in result.output


def test_a_compact_state_replaces_no_file(finished, tmp_path):
    out = finished[0]
    before = (out / "fields.h5").read_bytes()
    for target in ("fields.h5", "state.h5"):
        result = run([FLUID, "--compact-state", str(out / "state.h5"), str(out / target)], tmp_path)
        assert result.status != 0 and f"{target} is there already" in spoken(result.output)[0]
    assert (out / "fields.h5").read_bytes() == before
    result = run([FLUID, "--compact-state", str(out / "state.h5"), str(tmp_path / "small.h5")], tmp_path)
    assert result.status == 0 and (tmp_path / "small.h5").is_file(), result.output


def test_flags_that_contradict_the_job(finished, tmp_path):
    out = finished[0]
    dem = [DEM, "-in", SCRIPT, "-var", "out", str(tmp_path), "-log", "none"]
    for words, sentence in (
        (["--out", str(tmp_path / "out"), "--without-grains"], "--without-grains asks for the flow alone"),
        (["--restart", str(out), "--overwrite"], "--overwrite removes the checkpoints of"),
    ):
        result = run(command([FLUID, TOML, "--steps", "1", *words], dem, (1, 1)), tmp_path)
        assert result.status != 0
        said = spoken(result.output)
        assert len(said) == 1 and sentence in said[0], result.output


def test_a_warm_up_that_never_ends_is_said(finished, tmp_path):
    result = job(tmp_path / "out", "--set", "time.end=0.04", "--warm-up", "3")
    assert result.status == 0, result.output
    assert "NOTE: --warm-up 3 is not less than the 2 steps made" in result.output


def test_nothing_left_to_do_is_said(finished):
    result = job(finished[0], "--set", "time.end=0.02", restart=finished[0])
    assert result.status == 0, result.output
    assert "the checkpoint is at t = 0.04, and 'time.end' is 0.02: nothing is left to do" in result.output
