"""Grains that LIGGGHTS inserts and deletes while the flow goes on: both programs count the same ones, and
what was on its way to a grain that is deleted is booked, no other load is lost."""

import re

import numpy as np
import pytest
from pocket import PACK, SCENE, halves, job, numbers, rows, write_triangles

STEPS = 60
STEP = 0.02
GATE = 2.6  # grains that pass this x are deleted
# LIGGGHTS' own count at the end of each fluid step.
COUNT = """variable grains_now equal count(grains)
fix count all print 15 "${grains_now}" file ${out}/count.txt screen no title "grains"
"""


def gate(folder):
    """A mesh across the box whose triangles are small enough for its periodic length."""
    heights, depths = np.linspace(0.05, 2.95, 5), np.linspace(0.0, 2.0, 5)
    write_triangles(folder / "gate.stl", (1, 0, 0),
                    [[(GATE, y, z) for y, z in half] for half in halves(heights, depths)])  # fmt: skip
    return f"""fix gate all mesh/surface file {folder}/gate.stl type 1
fix gone grains massflow/mesh mesh gate vec_side 1 0 0 count once delete_atoms yes
"""


def start(folder, ranks, before_thermo="", last="coupled_run"):
    """What the job said, and its output folder."""
    text = (SCENE / "in.liggghts").read_text().replace("fix             fluid", PACK)
    text = text.replace("thermo ", before_thermo + COUNT + "thermo ")
    text = text.replace("\ncoupled_run", f"\n{last}")
    assert "insert/pack" in text and text.rstrip().endswith("coupled_run")
    script = folder / "in.liggghts"
    script.write_text(text)
    out = folder / "out"
    return out, job(out, "--steps", str(STEPS), "--set", f"output.spheres_every={STEP}", ranks=ranks,
                    script=script)  # fmt: skip


def run(*scene, **changes):
    """history.csv by column, the tags after each step, LIGGGHTS' counts."""
    out, result = start(*scene, **changes)
    assert result.status == 0, result.output
    table = rows(out / "history.csv")
    history = {name: np.array([float(row[name]) for row in table]) for name in table[0]}
    spheres = numbers(out / "spheres.h5")
    tags = [set(spheres["mobile/tag"][spheres["mobile/step"] == step]) for step in range(STEPS + 1)]
    counts = [int(line) for line in (out / "count.txt").read_text().split()[1:]]
    return history, tags, counts


def check_counts(history, tags, counts):
    """Fluid, output and LIGGGHTS have the same number of grains after each step."""
    assert [len(now) for now in tags[1:]] == history["mobile_spheres"].astype(int).tolist()
    assert counts[-STEPS:] == [len(now) for now in tags[1:]]


# What history.csv allows elsewhere: sums in double over two programs. A load that went astray or was borne
# twice shows as 0.01 to 0.1 (so did that of a deleted grain before it was booked).
ROUND_OFF = 1e-13


def check_loads(history, tags):
    """Momentum is exchanged to round-off in all steps, those included in which a grain went with a load on
    its way; returns the numbers of grains that came and went in each step."""
    come, gone = ([len(a - b) for a, b in pairs] for pairs in
                  (list(zip(tags[1:], tags)), list(zip(tags, tags[1:]))))  # fmt: skip
    assert np.abs(history["momentum_residual"]).max() < ROUND_OFF
    assert history["max_divergence"].max() < 1e-12
    return come, gone


@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)], ids=["1+1", "2+2"])
def test_come_and_go_in_one_run(tmp_path, ranks):
    history, tags, counts = run(tmp_path, ranks, before_thermo=gate(tmp_path))
    check_counts(history, tags, counts)
    come, gone = check_loads(history, tags)
    assert sum(come) >= 5 and sum(gone) >= 3


def two_runs(how):
    """The lower grains are deleted in between."""
    return "\n".join([f"coupled_run steps {STEPS // 2}", "region low block 0 4 0 1.8 0 2 units box",
                      "group low region low", "group going intersect low grains",
                      f"delete_atoms group going {how}", "coupled_run"])  # fmt: skip


def test_deleted_between_two_runs(tmp_path):
    """The fluid hears of it before its next step."""
    last = two_runs("compress no")
    history, tags, counts = run(tmp_path, (2, 2), last=last)
    check_counts(history, tags, counts)
    gone = check_loads(history, tags)[1]
    assert [step for step, left in enumerate(gone, 1) if left] == [STEPS // 2 + 1]


def test_numbered_anew(tmp_path):
    """As LIGGGHTS does by itself; the fluid would take one grain for another."""
    result = start(tmp_path, (1, 2), last=two_runs("compress yes"))[1]
    assert result.status != 0
    assert "compress no" in result.output and "had another number" in result.output


def test_into_an_empty_box(tmp_path):
    """No sphere at the start, neither fixed nor mobile; the fluid knows those that come."""
    text = (SCENE / "in.liggghts").read_text().replace("fix             fluid", PACK)
    kept = [line for line in text.splitlines() if not line.startswith(("create_atoms", "set ", "velocity"))]
    (tmp_path / "in.liggghts").write_text("\n".join(kept).replace("thermo ", COUNT + "thermo ") + "\n")
    result = job(tmp_path / "out", "--steps", "8", script=tmp_path / "in.liggghts", ranks=(1, 2))
    assert result.status == 0, result.output
    assert re.search(r"^moving boundary +on .*inserted by the script", result.output, re.MULTILINE)
    spheres = numbers(tmp_path / "out" / "spheres.h5")
    assert len(spheres["fixed/tag"]) == 0
    last = spheres["mobile/step"] == 8
    assert last.sum() >= 5 and (np.abs(spheres["mobile/force"][last]) > 0).all()
    assert max(float(row["momentum_residual"]) for row in rows(tmp_path / "out" / "history.csv")) < ROUND_OFF
