"""The summary knows what kind of scene it has: a sphere that settles does not jump, an array has no bed."""

import h5py
import numpy as np
import pytest
from bedload_post import show, states, summary
from bedload_post.frames import time_ranges
from bedload_post.outputs import Run
from synthetic import Story, even, wandering_story, write_run, write_samples


def free_run(folder, story):
    """The made-up run without its bed: nothing fixed, periodic along y, gravity along x and y."""
    write_run(folder, story)
    with h5py.File(folder / "spheres.h5", "r+") as file:
        del file["fixed"]
    text = (folder / "settings.toml").read_text()
    text = text.replace('boundary.y = ["no_slip", "free_slip"]', 'boundary.y = ["periodic", "periodic"]')
    text = text.replace("gravity = [0.0, -0.99, 0.0]", "gravity = [0.6, -0.8, 0.0]")
    (folder / "settings.toml").write_text(text)
    return Run(folder)


def lines_of(run):
    phases = states.analyse(
        run.collisions(), time_ranges(run.instants()), run.sample_blocks(), run.periods,
        run.bulk_velocity, run.diameter,
    )  # fmt: skip
    return {line.what: line.value for line in summary.grain_lines(run, phases)}


def test_a_sphere_that_settles(tmp_path):
    story = even(Story(position=(3.0, 8.0, 4.0)).piece(4.0, velocity=(0.3, -0.4, 0.0)), 0.1)
    run = free_run(tmp_path / "run", story)
    found = lines_of(run)
    assert float(found["mean velocity along gravity"]) == pytest.approx(0.6 * 0.3 + 0.8 * 0.4)
    assert float(found["largest speed"]) == pytest.approx(0.5)
    assert float(found["Reynolds number at the end"]) == pytest.approx(0.5 / 2.6578e-3, rel=1e-2)
    assert not any(what.startswith(("time ", "jump", "mean grain")) for what in found)
    flow = {line.what for line in summary.flow_lines(run)}
    assert not flow & {"Re_tau", "friction velocity", "Shields number", "D+"}


def test_no_picture_of_a_bed_where_there_is_none(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(show.bed_motion, "draw", lambda run, file: drawn.append(file))
    monkeypatch.setattr(show, "_render", lambda console, run: None)
    story = even(Story(position=(3.0, 8.0, 4.0)).piece(4.0, velocity=(0.3, -0.4, 0.0)), 0.1)
    show.show(free_run(tmp_path / "free", story).folder)
    assert not drawn
    show.show(write_run(tmp_path / "bed", wandering_story()))
    assert len(drawn) == 1


def test_a_bed_keeps_its_states_and_its_friction(tmp_path):
    run = Run(write_run(tmp_path / "run", wandering_story()))
    assert "time jumping" in lines_of(run)
    assert "Re_tau" in {line.what for line in summary.flow_lines(run)}
    # Side walls bear a part of the driving that nobody knows.
    settings = run.folder / "settings.toml"
    text = settings.read_text()
    assert 'boundary.z = ["periodic", "periodic"]' in text
    settings.write_text(text.replace('boundary.z = ["periodic", "periodic"]', 'boundary.z = ["no_slip", "no_slip"]'))
    walled = Run(run.folder)
    assert not {line.what for line in summary.flow_lines(walled)} & {"Re_tau", "friction velocity", "Shields number"}
    settings.write_text(text)
    # A wall in place of the bed, under a stream: the same.
    with h5py.File(run.folder / "spheres.h5", "r+") as file:
        del file["fixed"]
    assert not summary.has_bed(Run(run.folder))
    with (run.folder / "settings.toml").open("a") as settings:
        settings.write('flow.driving = "bulk_velocity"\n')
    assert summary.has_bed(Run(run.folder))


def test_a_suspension_in_shear(tmp_path):
    """(lower - upper)/2 over rho nu dU/H, by the fluid and by grains, in the second half alone; not where the walls
    go together, a force drives the flow, or an older run says nothing of its grains."""
    story = even(Story(position=(3.0, 8.0, 4.0)).piece(4.0, velocity=(0.3, 0.0, 0.0)), 0.1)
    folder = write_run(tmp_path / "run", story)
    text = (folder / "settings.toml").read_text()
    text = text.replace('boundary.y = ["no_slip", "free_slip"]', 'boundary.y = ["no_slip", "no_slip"]')
    text += "boundary.y_lower_velocity = [-1.0, 0.0, 0.0]\nboundary.y_upper_velocity = [2.0, 0.0, 0.0]\n"
    (folder / "settings.toml").write_text(text)
    header, *rows = (folder / "history.csv").read_text().splitlines()
    alone = 2.6578e-3 * 3.0 / 9.0
    more = [f",{2.0 * alone},{-3.0 * alone},{0.5 * alone},{-0.3 * alone}"] * len(rows)
    more[: len(rows) // 3] = [",9,9,9,9"] * (len(rows) // 3)
    names = ",wall_stress_lower,wall_stress_upper,grain_stress_lower,grain_stress_upper"
    (folder / "history.csv").write_text("\n".join([header + names, *(a + b for a, b in zip(rows, more))]) + "\n")

    def found():
        return {line.what: line for line in summary.flow_lines(Run(folder))}

    assert found()["relative viscosity"].value == "2.900"
    assert "2.500 of it by the fluid, 0.400 by grains" in found()["relative viscosity"].note
    (folder / "settings.toml").write_text(text.replace("[2.0, 0", "[-1.0, 0"))
    assert "relative viscosity" not in found()
    (folder / "settings.toml").write_text(text + 'flow.driving = "bulk_velocity"\n')
    assert "relative viscosity" not in found()
    (folder / "settings.toml").write_text(text)
    (folder / "history.csv").write_text("\n".join([header, *rows]) + "\n")
    assert "relative viscosity" not in found()


def test_grains_of_a_short_record_are_there(tmp_path):
    """One instant of sixty grains: no phase, but sixty grains."""
    folder = write_run(tmp_path / "run", wandering_story())
    (folder / "collisions.csv").write_text((folder / "collisions.csv").read_text().splitlines()[0] + "\n")
    vectors = np.zeros((60, 3))
    write_samples(folder, {
        "time": np.full(60, 0.1), "tag": np.arange(60), "position": vectors + 2.0, "velocity": vectors - 1e-9,
        "angular_velocity": vectors, "radius": np.full(60, 0.5),
    })  # fmt: skip
    found = lines_of(Run(folder))
    assert found["mobile grains"] == "60"
    assert found["mean grain velocity"] == "0.0000 u_b"


def test_no_number_is_minus_nothing():
    assert summary.fixed_point(-1e-9, 4) == "0.0000"
    assert summary.fixed_point(-0.25, 2) == "-0.25"
