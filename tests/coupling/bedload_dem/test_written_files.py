"""Files that LIGGGHTS itself writes, on a full disk: the run ends with a sentence. LIGGGHTS does not look."""

import pytest

from pocket import SCENE, changed_jobs, spoken
from programs import BIN, run

RUN = "coupled_run"
DUMP = "dump {} all custom 10 {} id type x y z\ncoupled_run"

# Lines in place of `coupled_run`; FULL: a file of which nothing reaches the disk.
CASES = {
    "dump": DUMP.format("d", "FULL"),
    "dump of a file each step": DUMP.format("d", "FULL.*"),
    "dump of VTK": "dump d all custom/vtk 10 FULL.*.vtp id x\ncoupled_run",
    "average": "compute e all ke\nfix mean all ave/time 1 10 10 c_e file FULL\ncoupled_run",
    "words": 'fix say all print 10 "hello" file FULL\ncoupled_run',
    "data after the run": "coupled_run\nwrite_data FULL",
    "restart after the run": "coupled_run\nwrite_restart FULL",
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written")
    full = folder / "full"
    full.symlink_to("/dev/full")
    for name in ("full.20", "full.20.vtp"):  # the others of a file each step are written
        (folder / name).symlink_to("/dev/full")
    cases = {case: ((RUN, lines.replace("FULL", str(full))),) for case, lines in CASES.items()}
    good = (RUN, DUMP.format("d", "good.txt") + "\nwrite_data good.data")
    return changed_jobs(folder, cases | {"good": (good,)}, steps=3)


@pytest.mark.parametrize("case", CASES)
def test_a_file_that_cannot_be_written_ends_the_run(results, case):
    result = results[case]
    assert result.status == 1, result.output
    said = spoken(result.output)
    assert len(said) == 1, result.output
    assert said[0].startswith("bedload-dem: /dev/full: cannot be written (")
    # Within the run, before its end, where there is one to come.
    assert ("Output: " in result.output) == ("after the run" in case)


def test_files_that_can_be_written(results):
    assert results["good"].status == 0, results["good"].output
    assert "cannot be written" not in results["good"].output


def test_a_script_without_the_fluid(tmp_path):
    """Its run goes on, but the program does not end as if all were well."""
    head = (SCENE / "in.liggghts").read_text().partition("fix             m1")[0]
    lines = ["atom_modify sort 0 0.0", "fix move all nve/sphere", "dump d all custom 1 /dev/full id x", "run 2"]
    (tmp_path / "in.liggghts").write_text(head + "\n".join(lines) + "\n")
    result = run([str(BIN / "bedload-dem"), "-in", "in.liggghts", "-log", "none"], tmp_path)
    assert result.status == 1
    assert "bedload-dem: /dev/full: cannot be written (No space left on device)." in result.output
