"""Dumps of LIGGGHTS and the table of collisions when a run goes on from a checkpoint: what their files hold stays."""

import pytest

from pocket import SCENE, checkpoint, job

SCRIPT = (SCENE / "in.liggghts").read_text()
DUMPS = """dump one all custom 15 ${out}/one.txt id type x y z
dump each all custom 15 ${out}/each_*.txt id type x y z
"""
# Two coupled runs, and between them a command that initialises LIGGGHTS and with it the dumps.
SCRIPTS = {
    "one run": SCRIPT.replace("coupled_run", f"{DUMPS}coupled_run"),
    "two runs": SCRIPT.replace("coupled_run",
                               f"{DUMPS}coupled_run steps 2\nwrite_restart ${{out}}/grains\ncoupled_run"),
}  # fmt: skip


def steps_in(file):
    """LIGGGHTS' steps in a dump, and whether each of them has its ten spheres."""
    parts = file.read_text().split("ITEM: TIMESTEP\n")[1:]
    assert all(len(part.splitlines()) == 8 + 10 for part in parts)
    return [int(part.splitlines()[0]) for part in parts]


@pytest.fixture(scope="module", params=SCRIPTS)
def begun(request, tmp_path_factory):
    """A script, and the folder of its run of four steps with a checkpoint behind the third."""
    folder = tmp_path_factory.mktemp("begun")
    (folder / "in.liggghts").write_text(SCRIPTS[request.param])
    result = job(folder / "out", "--steps", "4", "--set", "checkpoint.every=0.06", script=folder / "in.liggghts")
    assert result.status == 0, result.output
    return folder


def test_a_refused_restart_leaves_them_as_they_are(begun):
    text = (begun / "in.liggghts").read_text().replace("fix             table", "#")
    (begun / "other.liggghts").write_text(text)
    before = (begun / "out" / "one.txt").read_bytes()
    result = job(begun / "out", restart=checkpoint(begun / "out", 4), script=begun / "other.liggghts")
    assert result.status == 1, result.output
    assert before and (begun / "out" / "one.txt").read_bytes() == before


def test_they_are_added_to(begun):
    """The step of the checkpoint stands in the first part already; a file of one step holds that one once,
    though the run before has written it as well."""
    out = begun / "out"
    assert steps_in(out / "one.txt") == [0, 15, 30, 45, 60]
    result = job(out, "--steps", "2", restart=checkpoint(out, 3), script=begun / "in.liggghts")
    assert result.status == 0, result.output
    assert steps_in(out / "one.txt") == [0, 15, 30, 45, 60, 60, 75]
    for step in (0, 15, 30, 45, 60, 75):
        assert steps_in(out / f"each_{step}.txt") == [step]


def test_tables_of_the_script_s_own_fixes_are_kept(tmp_path):
    """They begin anew, and what the parts before wrote stands beside them, also where nothing was left to do."""
    script, out = tmp_path / "in.liggghts", tmp_path / "out"
    tables = ("variable name string mean\nvariable n equal step\n"
              "fix mean all ave/time 15 1 15 v_n file ${out}/${name}.txt\n"
              "fix say all print 15 'at ${n}' file ${out}/said.txt screen no\n")  # fmt: skip
    script.write_text(SCRIPT.replace("coupled_run", f"{tables}coupled_run"))
    steps = []
    for part, more in enumerate(("2", "2", "1")):
        result = job(out, "--steps", more, script=script, restart=out if part else None)
        assert result.status == 0, result.output
        assert result.output.count("begins anew; what it held is") == (2 if part else 0)
        rows = [row.split() for row in (out / "mean.txt").read_text().splitlines() if not row.startswith("#")]
        steps.append([int(row[0]) for row in rows])
    assert steps[1][0] > steps[0][-1] - 15
    for part in (1, 2):
        kept = [row.split()[0] for row in (out / f"mean.part{part}.txt").read_text().splitlines() if row[0] != "#"]
        assert list(map(int, kept)) == steps[part - 1]
        assert "at " in (out / f"said.part{part}.txt").read_text()
    assert not (out / "mean.part3.txt").exists()


def test_the_table_of_collisions_keeps_its_rows(tmp_path):
    """Also where a command between two coupled runs, of which the first is over, initialises LIGGGHTS before its clock
    is set: a grain just above the bed has met it, in a collision of one step, before the checkpoint behind step 8."""
    text = SCRIPTS["two runs"].replace("steps 2", "steps 6").replace(DUMPS, "")
    for old, new in {"create_atoms    2 single 1.95 1.75 1.1": "create_atoms 2 single 1.95 1.35 1.1",
                     "set 0.7 -0.6 0.05": "set 0.0 -2.0 0.0",
                     "haff_werner\npair_coeff": "haff_werner collisionSteps 1\npair_coeff"}.items():
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "in.liggghts").write_text(text)
    out = tmp_path / "out"
    result = job(out, "--steps", "8", "--set", "checkpoint.every=0.16", script=tmp_path / "in.liggghts")
    assert result.status == 0, result.output
    rows = (out / "collisions.csv").read_text()
    assert rows.count("\n") > 1
    result = job(out, "--steps", "1", restart=out, script=tmp_path / "in.liggghts")
    assert result.status == 0, result.output
    assert (out / "collisions.csv").read_text().startswith(rows)
