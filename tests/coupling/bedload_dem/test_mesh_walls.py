"""Walls of triangles in a coupled run."""

import numpy as np
import pytest

from pocket import FLOOR, SCENE, job, numbers, spoken, with_mesh_floor

HEIGHT = 1.05  # above the bed's crowns, where the grains arrive within forty steps
STEPS = ["--steps", "60"]


def path(folder, text, ranks):
    folder.mkdir()
    (folder / "in.liggghts").write_text(text)
    result = job(folder / "out", *STEPS, ranks=ranks, script=folder / "in.liggghts")
    assert result.status == 0, result.output
    return numbers(folder / "out" / "spheres.h5")


@pytest.mark.parametrize("ranks", [(1, 1), (2, 2)], ids=["1+1", "2+2"])
def test_a_floor_of_triangles_is_a_floor(tmp_path, ranks):
    """Grains rebound from it as from the plane, to round-off that a collision magnifies: a contact that
    is lost or counted twice at an edge or a periodic end shows as 0.1."""
    text = (SCENE / "in.liggghts").read_text()
    plane = path(tmp_path / "plane", text.replace(FLOOR, FLOOR.replace("yplane 0.0", f"yplane {HEIGHT}")), ranks)
    for pieces in (3, 8):
        folder = tmp_path / f"mesh{pieces}"
        mesh = path(folder, with_mesh_floor(text, tmp_path, pieces, HEIGHT), ranks)
        assert plane["mobile/velocity"][-1, 1] > 0.0, "a grain should have rebounded"
        apart = np.abs(mesh["mobile/velocity"] - plane["mobile/velocity"]).max()
        assert apart < 1e-9, f"{pieces} pieces: {apart}"


@pytest.mark.parametrize("pieces", [1, 16], ids=["too large", "too small"])
@pytest.mark.parametrize("ranks", [(1, 1), (1, 2)], ids=["1+1", "1+2"])
def test_triangles_that_do_not_fit_are_refused(tmp_path, pieces, ranks):
    """Neighbour cut-off 2.05 (diameter 1, range 0.5, skin 0.55): radii from 0.34 to 2 - 1.02; those of
    3 and 8 pieces are 0.92 and 0.34, of 1 and 16 they are 2.7 and 0.17."""
    (tmp_path / "in.liggghts").write_text(
        with_mesh_floor((SCENE / "in.liggghts").read_text(), tmp_path, pieces))
    result = job(tmp_path / "out", *STEPS, ranks=ranks, script=tmp_path / "in.liggghts")
    assert result.status != 0
    said = spoken(result.output)
    assert len(said) == 1, result.output
    assert "a mesh wall has triangles" in said[0] and "sixth of the neighbour cut-off" in said[0]


def test_a_mesh_is_read_without_a_screen(tmp_path):
    """LIGGGHTS writes what it says of a mesh to its screen without asking whether it has one."""
    text = with_mesh_floor((SCENE / "in.liggghts").read_text(), tmp_path, 4)
    (tmp_path / "in.liggghts").write_text(text)
    result = job(tmp_path / "out", "--steps", "1", script=tmp_path / "in.liggghts", dem_more=("-screen", "none"))
    assert result.status == 0, result.output
