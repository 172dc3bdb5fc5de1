"""Every shipped scene starts: its bed has no overlap and the reported gap, its grains touch nothing.

On coarse grids and for two steps: the paper's full-size scenes need hours otherwise.
"""

import math
import re

import h5py
import numpy as np
import pytest

from scene_run import run_scene

# Grid with four cells to a diameter (the least that is allowed) or five; what the bed has to be.
SCENES = {
    "setup1": ([288, 52, 144], 82, 36, 1),
    "setup1_small": ([130, 65, 65], 30, 13, 1),
    "setup2": ([208, 40, 108], 60, 27, 500),
    "setup2_small": ([130, 50, 65], 30, 13, 125),
}


@pytest.fixture(scope="module", params=SCENES)
def run(request, tmp_path_factory):
    """(name, output folder) of a scene's first two steps."""
    out = tmp_path_factory.mktemp("scenes") / request.param
    settings = [f"grid.cells={SCENES[request.param][0]}", "output.spheres_every=0.0"]
    run_scene(request.param, "actm_hw", out, settings, 2)
    return request.param, out


def nearest_distances(some, others, box, same):
    """From each of `some` (n, 3) to the nearest of `others` (m, 3), x and z periodic."""
    d = some[:, None, :] - others[None, :, :]
    for axis in (0, 2):
        d[..., axis] -= box[axis] * np.round(d[..., axis] / box[axis])
    distance = np.sqrt((d**2).sum(axis=2))
    if same:
        np.fill_diagonal(distance, np.inf)
    return distance.min(axis=1)


def test_bed_and_grains(run):
    name, out = run
    cells, rows, columns, grains = SCENES[name]
    with h5py.File(out / "spheres.h5") as file:
        bed, tag = file["fixed/position"][:], file["mobile/tag"][:]
        first = file["mobile/position"][: len(np.unique(tag))]
    settings = (out / "settings.toml").read_text()
    box = [float(v) for v in re.search(r"grid.length = \[(.*?)\]", settings)[1].split(",")]
    assert len(bed) == rows * columns
    assert len(first) == grains
    # Touching along z, sqrt((L_x/rows)^2 + 1/4) from row to row.
    gap = math.hypot(box[0] / rows, 0.5) - 1
    assert gap >= 0
    assert nearest_distances(bed, bed, box, True) == pytest.approx(1.0, abs=1e-9)
    across = [row for row in np.unique(bed[:, 0].round(9))]
    assert np.diff(across) == pytest.approx(box[0] / rows, abs=1e-8)
    log = (out / "log.liggghts").read_text()
    told = re.search(r"^bed: (\d+) rows of (\d+) spheres, gap between rows (\S+) D", log, re.M)
    assert (int(told[1]), int(told[2])) == (rows, columns)
    assert float(told[3]) == pytest.approx(gap, abs=1e-9)
    # Dropped grains start free; the exposed one 2e-4 above its three supports.
    assert nearest_distances(first, bed, box, False).min() > 1.0
    if grains > 1:
        assert nearest_distances(first, first, box, True).min() > 1.0


def test_held_grains_of_an_earlier_run_stay(tmp_path):
    """They come with the motion that they had; held, they are spheres of the bed, which must not move, and the flow
    is that around grains that never did."""
    flows = []
    for name, motion in (("moved", "vx 0.3 vy -0.2 vz 0.1 omegax 1 omegay 2 omegaz 3"), ("still", "vx 0")):
        out = tmp_path / name
        out.mkdir()
        lines = ["create_atoms 2 single 13 3 6.5 units box", f"set type 2 {motion}"]
        (out / "grains.liggghts").write_text("\n".join(lines) + "\n")
        settings = [f"grid.cells={SCENES['setup2_small'][0]}", "output.history_every=1"]
        run_scene("setup2_small", "actm_hw", out, settings, 3, {"placing": "placed", "hold": "1"})
        flows.append(np.genfromtxt(out / "history.csv", delimiter=",", skip_header=1))
    assert len(flows[0]) == 3
    # FFTW chooses its plans by the clock: two runs in single precision part by roundings, 1e-6 after three steps.
    np.testing.assert_allclose(flows[0], flows[1], rtol=1e-4, atol=1e-5)
