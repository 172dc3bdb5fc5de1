"""The fluid's force on fixed spheres: history.csv has the sum, spheres.h5 each sphere's."""

import json
import re

import h5py
import numpy as np
import pytest

from programs import BIN, SCENES, command, run
from pocket import rows

SCENE = SCENES / "pocket"
PLACES = [(x + 0.5, 0.5, z + 0.5) for x in range(4) for z in range(2)]
VOLUME = 4.0 * 3.0 * 2.0
AREA = 4.0 * 2.0


def flow_over_a_bed(folder, *options, ranks=1, out="out", before=(), places=PLACES, said=None):
    """history.csv by column, and /fixed of spheres.h5; what the run prints is added to `said`."""
    text = (SCENE / "fluid.toml").read_text(encoding="utf-8")
    (folder / "fluid.toml").write_text(text.replace("[spheres]", '[spheres]\nfile = "bed.txt"'))
    (folder / "bed.txt").write_text("".join("{} {} {} 0.5\n".format(*place) for place in places))
    fluid = [*before, str(BIN / "bedload-fluid"), "fluid.toml", "--out", out, "--set", "time.end=0.4", *options]
    result = run(command(fluid, None, (ranks, 0)), folder)
    assert result.status == 0, result.output
    if said is not None:
        said.append(result.output)
    table = rows(folder / out / "history.csv")
    with h5py.File(folder / out / "spheres.h5") as file:
        fixed = {name: data[:] for name, data in file["fixed"].items()}
    return {name: np.array([float(row[name]) for row in table]) for name in table[0]}, fixed


@pytest.mark.parametrize("ranks", [1, 2])
def test_drag_of_the_bed_is_what_driving_and_walls_leave(tmp_path, ranks):
    """0 = G V - tau A - sum F_x: the bulk velocity is kept. The walls' stress is that of the end of the step,
    the others means over it, and what the fluid inside gains is left out: 2 % of the driving (seen: 0.5 %);
    a force that is left out, doubled or turned shows as 60 % and more."""
    history, fixed = flow_over_a_bed(tmp_path, ranks=ranks)
    walls = (history["wall_stress_lower"] + history["wall_stress_upper"]) * AREA
    driven = history["driving"] * VOLUME
    late = slice(5, None)
    left = driven - walls - history["fixed_force_x"]
    assert np.abs(left[late]).max() < 0.02 * driven[late].max()
    assert (history["fixed_force_x"][late] > 0.6 * driven[late]).all()

    assert fixed["force"].shape == (1, 3 * len(PLACES))
    assert fixed["force_step"][0] == history["step"][-1]
    each = fixed["force"].reshape(len(PLACES), 3)
    total = [history[f"fixed_force_{d}"][-1] for d in "xyz"]
    np.testing.assert_allclose(each.sum(axis=0), total, rtol=1e-10, atol=1e-10)
    # The first one is sheltered by what the flow began with; another one's force in its place would show.
    assert abs(each[0, 0]) < 2e-4 and (each[1:, 0] > 5e-3).all()


def test_buoyancy_belongs_to_it_and_samples_come_when_asked_for(tmp_path):
    history, fixed = flow_over_a_bed(tmp_path, "--set", "output.fixed_every=0.1")
    without, _ = flow_over_a_bed(tmp_path, "--set", "fluid.gravity=[0.0, 0.0, 0.0]", out="weightless")
    weight = len(PLACES) * np.pi / 6.0 * 0.5
    np.testing.assert_allclose(history["fixed_force_y"] - without["fixed_force_y"], weight, rtol=1e-9)
    np.testing.assert_allclose(fixed["force_time"], [0.1, 0.2, 0.3, 0.4], rtol=1e-9)


def test_columns_that_follow_from_others(tmp_path):
    """u_tau_driving² ρ = driving × reference.height, between two walls half of it; what viscosity takes at a step's end
    is what it took in its stages, within what the flow changes in a step."""
    history, _ = flow_over_a_bed(tmp_path, "--set", "fluid.density=2.0", "--set", 'output.energy_work="on"')
    driving = np.abs(history["driving"])
    np.testing.assert_allclose(2.0 * history["u_tau_driving"] ** 2, driving * 2.0, rtol=1e-9)
    between, _ = flow_over_a_bed(tmp_path, "--set", 'boundary.y="no_slip"', "--set", "reference.height=3", out="walls")
    np.testing.assert_allclose(between["u_tau_driving"] ** 2, np.abs(between["driving"]) * 1.5, rtol=1e-9)
    late = slice(5, None)
    assert history["dissipation"][late].min() > 0
    np.testing.assert_allclose(history["dissipation"][late], -history["viscous_work"][late], rtol=0.1)


def test_the_error_at_the_markers_is_that_of_the_whole_run(tmp_path):
    """Root mean square and largest of all rows, those before a restart among them; it falls from the start on."""
    said = []
    flow_over_a_bed(tmp_path, "--steps", "10", said=said)
    history, _ = flow_over_a_bed(tmp_path, "--restart", "out", said=said)
    for text, rms, largest in zip(said, (history["slip_rms"][:10], history["slip_rms"]),
                                  (history["slip_max"][:10], history["slip_max"]), strict=True):  # fmt: skip
        found = re.search(r"error at the markers .*: (\S+) \(root mean square\), (\S+) \(largest\)", text)
        wanted = [np.sqrt(np.mean(rms**2)), largest.max()]
        assert [float(word) for word in found.groups()] == pytest.approx(wanted, rel=6e-3)
        assert wanted[0] > 1.02 * rms.mean()  # so that their mean would show


def test_buoyancy_is_of_what_lies_in_the_box(tmp_path):
    """Hemispheres on the floor: half of their volume."""
    bed = [(x, 0.0, z) for x, _, z in PLACES]
    forces = [
        flow_over_a_bed(tmp_path, "--steps", "3", "--set", f"fluid.gravity=[0.0, {g}, 0.0]", out=f"g{g}", places=bed)[0]
        for g in (-0.5, 0.0)
    ]
    half_weight = len(PLACES) * np.pi / 12.0 * 0.5
    np.testing.assert_allclose(forces[0]["fixed_force_y"] - forces[1]["fixed_force_y"], half_weight, rtol=1e-9)


def test_a_run_that_is_over_adds_no_row(tmp_path):
    """Given again with nothing left to do, at a step that history_every leaves out."""
    over = ("--set", "time.end=0.14", "--set", "output.history_every=5")
    first, _ = flow_over_a_bed(tmp_path, *over)
    assert list(first["step"]) == [5, 7]
    for _ in range(2):
        again, _ = flow_over_a_bed(tmp_path, *over, "--restart", "out")
        for name in first:
            np.testing.assert_array_equal(again[name], first[name])


def test_a_restart_that_makes_no_step_writes_no_row(tmp_path):
    """Into another folder: it does not know what the step before gave to the bed."""
    flow_over_a_bed(tmp_path, "--set", "time.end=0.14")
    line = ["fluid.toml", "--restart", "out", "--out", "other", "--set", "time.end=0.14"]
    result = run(command([str(BIN / "bedload-fluid"), *line], None, (1, 0)), tmp_path)
    assert result.status == 0 and "nothing is left to do" in result.output
    assert rows(tmp_path / "other" / "history.csv") == []


def test_round_off_costs_no_sample(tmp_path):
    """Ten steps of 0.02 are 2e-17 less than 0.2, where statistics begin."""
    for begin, samples in (("0.2", 2), ("0.21", 1)):
        flow_over_a_bed(tmp_path, "--set", "statistics.every=10", "--set", f"statistics.from={begin}", out=begin)
        with h5py.File(tmp_path / begin / "statistics.h5") as file:
            assert file.attrs["samples"] == samples


@pytest.mark.parametrize("radius", [0.5, 0.3])
def test_the_table_of_effects_asks_the_spheres_for_their_core(tmp_path, radius):
    """Eight cells across have one, 4.8 have none, whatever reference.diameter is (1, eight cells)."""
    (tmp_path / "fluid.toml").write_text((SCENE / "fluid.toml").read_text(encoding="utf-8"))
    (tmp_path / "bed.txt").write_text(f"1.5 0.5 1.0 {radius}\n")
    line = ["fluid.toml", "--out", "out", "--steps", "1", "--set", 'spheres.file="bed.txt"']
    result = run(command([str(BIN / "bedload-fluid"), *line], None, (1, 0)), tmp_path)
    assert result.status == 0, result.output
    row = next(line for line in result.output.splitlines() if line.startswith("rigid core"))
    assert row.split()[2] == ("on" if radius == 0.5 else "off")
    assert f"the largest diameter is {16 * radius:.3g} cells" in row


def test_a_restart_leaves_one_sample(tmp_path):
    whole = flow_over_a_bed(tmp_path, out="whole")[1]
    flow_over_a_bed(tmp_path, "--steps", "7")
    again = flow_over_a_bed(tmp_path, "--restart", "out")[1]
    for name in whole:  # not bit for bit: the whole run has written no checkpoint on its way
        assert again[name].shape == whole[name].shape
        np.testing.assert_allclose(again[name], whole[name], rtol=1e-6, atol=1e-12)


def test_any_ranks_write_the_same_bed_and_none_gathers_it(tmp_path):
    """The spheres once, forces every step, a checkpoint and a restart from it on another number of ranks. What MPI
    gathers was 104 B of each sphere and 56 B of each force when the first rank did it."""
    one = flow_over_a_bed(tmp_path, "--set", "output.fixed_every=1e-6", out="one")[1]
    counted = ["env", f"BEDLOAD_COUNTS={tmp_path}", f"LD_PRELOAD={BIN / 'count_use.so'}"]
    every = ("--set", "output.fixed_every=1e-6")
    flow_over_a_bed(tmp_path, *every, "--steps", "7", ranks=3, out="many", before=counted)
    many = flow_over_a_bed(tmp_path, *every, "--restart", "many", ranks=2, out="many", before=counted)[1]
    told = [json.loads(file.read_text(encoding="utf-8")) for file in tmp_path.glob("[0-9]*.json")]
    gathered = [each["gathered"] for each in told if each["program"] == "bedload-fluid"]
    assert gathered == [0] * 5
    for name in one:
        assert many[name].shape == one[name].shape
        np.testing.assert_allclose(many[name], one[name], rtol=1e-6, atol=1e-9)
    assert len(one["force"]) > 7


def test_a_run_without_a_step_writes_the_forces_of_its_checkpoint(tmp_path):
    whole = flow_over_a_bed(tmp_path, out="whole", ranks=2)[1]
    (tmp_path / "whole" / "spheres.h5").unlink()
    again = flow_over_a_bed(tmp_path, "--restart", "whole", out="whole")[1]
    for name in whole:
        np.testing.assert_allclose(again[name], whole[name], rtol=1e-12, atol=1e-12)
