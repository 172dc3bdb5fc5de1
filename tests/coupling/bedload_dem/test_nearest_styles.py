"""A style, model or command that LIGGGHTS does not know: file, line and the nearest name stand with its sentence."""

import pytest

from pocket import SCENE, changed_jobs, check_refused
from programs import BIN, command, run

PAIRS = "pair_style      gran model actm tangential haff_werner"
FLOOR = "wall/gran model actm tangential haff_werner"
FLUID = "fix             fluid all couple/fluid fixed bed"
LINES = (SCENE / "in.liggghts").read_text(encoding="utf-8").splitlines()

# What is changed, lines that come before it, the nearest name.
CASES = {
    "normal model": ((PAIRS, PAIRS.replace("actm", "actmm")), 0, "behind 'model' to 'actmm' is 'actm'"),
    "tangential model": ((FLOOR, FLOOR + "r"), 0, "behind 'tangential' to 'haff_wernerr' is 'haff_werner'"),
    "model in a variable": (
        (PAIRS, "variable rolls string cdtt\n" + PAIRS + " rolling_friction ${rolls}"), 1,
        "behind 'rolling_friction' to 'cdtt' is 'cdt'",
    ),
    "models that do not go together": (
        (PAIRS, "pair_style      gran model actm tangential no_history"), 0, "these do not go together"),
    "fix": ((FLUID, FLUID.replace("couple/fluid", "couple/fluit")), 0, "fix style to 'couple/fluit' is 'couple/fluid'"),
    "in two lines": (
        (FLUID, "fix             fluid all couple/fluit &\n fixed bed"), 1,
        "fix style to 'couple/fluit' is 'couple/fluid'",
    ),
    "pair style": ((PAIRS, PAIRS.replace("gran ", "grann ")), 0, "pair style to 'grann' is 'gran'"),
    "command": (("coupled_run", "coupled_rum"), 0, "command to 'coupled_rum' is 'coupled_run'"),
    "command of LIGGGHTS": (("neigh_modify", "neigh_modfy"), 0, "command to 'neigh_modfy' is 'neigh_modify'"),
    "compute": (("coupled_run", "compute e all kee\ncoupled_run"), 0, "compute style to 'kee' is 'ke'"),
    "dump": (("coupled_run", "dump d all costum 1 d id\ncoupled_run"), 0, "dump style to 'costum' is 'custom'"),
    "region": (("region          layer block", "region          layer blok"), 0, "region style to 'blok' is 'block'"),
    "atom style": (("atom_style      granular", "atom_style      granula"), 0, "atom style to 'granula' is 'granular'"),
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return changed_jobs(tmp_path_factory.mktemp("nearest"), {case: (CASES[case][0],) for case in CASES}, steps=1)


@pytest.mark.parametrize("case", CASES)
def test_the_nearest_name_is_offered(results, case):
    (found, _), before, nearest = CASES[case]
    line = 1 + before + next(n for n, text in enumerate(LINES) if found in text)
    check_refused(results[case], [f"in.liggghts, line {line})", nearest])


def test_a_line_of_an_included_file_without_an_end(tmp_path):
    """The file is the included one; other mistakes have file and line, and no nearest name."""
    (tmp_path / "more.liggghts").write_text("# a comment\n\nfix one all couple/fluyd")
    include = ("coupled_run", f"include {tmp_path}/more.liggghts\ncoupled_run")
    results = changed_jobs(tmp_path, {
        "included": (include,), "missing": (("coupled_run", "include none.liggghts"),),
    }, steps=1)  # fmt: skip
    check_refused(results["included"], ["more.liggghts, line 3)", "to 'couple/fluyd' is 'couple/fluid'"])
    check_refused(results["missing"], ["none.liggghts' (in.liggghts, line "])
    assert "The nearest" not in results["missing"].output


def test_without_a_fluid(tmp_path):
    """A dry script has them, too, behind all that LIGGGHTS says, and a run that ends well says nothing of ours."""
    script = "units si\natom_style granular\nregion box block 0 1 0 1 0 1\ncreate_box 1 box\n"
    (tmp_path / "good").write_text(script, encoding="utf-8")
    (tmp_path / "bad").write_text(script + "fix motion all nve/spere\n", encoding="utf-8")
    good, bad = (run(command(None, [str(BIN / "bedload-dem"), "-in", name, "-log", "none"]), tmp_path)
                 for name in ("good", "bad"))  # fmt: skip
    assert good.status == 0 and "LIGGGHTS (Version" in good.output and "bedload-dem" not in good.output
    said = bad.output.splitlines()
    error = next(n for n, line in enumerate(said) if line.startswith("ERROR: "))
    assert said[error + 1] == ("bedload-dem: The script's line is 'fix motion all nve/spere' (bad, line 5). "
                               "The nearest fix style to 'nve/spere' is 'nve/sphere'.")  # fmt: skip
    assert bad.status != 0
