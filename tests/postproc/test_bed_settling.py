"""Beds that settle: sizes, the rain, the packing and overlap that are measured, the search for a packing."""

import argparse
import math
import shutil

import numpy as np
import pytest
from bedload_launcher import bed_options
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import find_scene
from bedload_studies import bed_settling
from bedload_studies.packing import Bed
from bedload_studies.rain import GAP, diameters, rain, read_sizes


def options(*words):
    parser = argparse.ArgumentParser()
    bed_options.add_options(parser)
    return parser.parse_args([*words, "--out", "bed.data"])


def test_shares_are_of_the_number_and_exact():
    diameter = diameters(read_sizes("0.7:0.2 1:0.8"), 501)
    assert len(diameter) == 501
    assert (diameter == 1.0).sum() in (400, 401) and (diameter == 0.7).sum() in (100, 101)
    assert diameter[0] == 1.0  # the largest first: they find places while there is room


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["8x8", "--grains", "9", "--sizes", "1:0.5"], "add up to 0.5, but must be 1"),
        (["8x8", "--grains", "9", "--sizes", "1:a"], "must be DIAMETER:SHARE"),
        (["8x8", "--grains", "9", "--sizes", "0:1"], "are above 0"),
        (["8x8", "--grains", "9", "--sizes", "1"], "--sizes has '1', but must be DIAMETER:SHARE"),
        (["nanx4", "--grains", "9"], "the box is 'nanx4', but must be two lengths"),
        (["8xinf", "--grains", "9"], "the box is '8xinf', but must be two lengths"),
        (["8x8", "--grains", "9", "--wet", "-1"], "--wet is -1, but must be at least 0"),
        (["8x8", "--grains", "0"], "--grains is 0, but must be at least 1"),
        (["8x8", "--grains", "9", "--packing", "0.9"], "pack between 0.53 and 0.62"),
        (["8x8", "--grains", "9", "--tolerance", "0"], "--tolerance is 0, but must be above 0"),
        (["8x8", "--grains", "9", "--tolerance", "0.1"], "--tolerance is 0.1, but no --packing is asked for"),
        (["8x8", "--grains", "9", "--fixed", "-1"], "--fixed is -1, but must be at least 0"),
        (["8x2", "--grains", "9"], "needs three diameters"),
        (["8x8", "--grains", "9", "--wet", "1"], "--wet runs a scene, but 8x8 is a box"),
        (["channel180", "--grains", "9", "--wet", "1"], "--wet runs a scene with the bed's grains, but 'channel180'"),
        (["8x8", "--grains", "9", "--base", "hexagonal", "--sizes", "2:1"], "must be 1"),
        (["8x8", "--grains", "9", "--base", "hexagonal", "--sizes", "0.7:1"], "must be 1"),
        (["setup2_smal", "--grains", "9"], "no scene 'setup2_smal'; the nearest is 'setup2_small'"),
    ],
)
def test_mistakes_get_one_sentence(words, sentence):
    with pytest.raises(UserError) as error:
        bed_settling.wish(options(*words))
    assert sentence in str(error.value) and "\n" not in str(error.value)


def test_a_scene_gives_its_box():
    want, scene = bed_settling.wish(options("setup2_small", "--grains", "9"))
    assert want.box == (26.0, 13.0) and want.height == 10.0 and scene is not None


def test_a_bed_between_side_walls_is_refused(tmp_path):
    """It settles in a periodic box: its grains would stand in the walls."""
    scene = tmp_path / "duct"
    shutil.copytree(find_scene("exposed_sphere").folder, scene)
    text = (scene / "fluid.toml").read_text()
    assert 'z = "periodic"' in text
    (scene / "fluid.toml").write_text(text.replace('z = "periodic"', 'z = ["no_slip", "no_slip"]'))
    with pytest.raises(UserError, match="'boundary.z' is .*no_slip.*, but a bed settles in a box that is periodic"):
        bed_settling.wish(options(str(scene), "--grains", "20"))


def test_rain_is_free_of_contact_and_the_same_for_a_seed():
    diameter, box = diameters(read_sizes("1:0.5 0.6:0.5"), 200), (5.0, 4.0)
    found = rain(diameter, box, 1.0, 7)
    assert np.array_equal(found, rain(diameter, box, 1.0, 7))
    assert not np.array_equal(found, rain(diameter, box, 1.0, 8))
    assert found[:, 1].min() >= 1.0
    # All pairs the slow way, nearest image.
    d = found[:, None] - found[None]
    d[..., 0] -= 5.0 * np.round(d[..., 0] / 5.0)
    d[..., 2] -= 4.0 * np.round(d[..., 2] / 4.0)
    distance = np.linalg.norm(d, axis=2) - 0.5 * (diameter[:, None] + diameter[None]) * (1.0 + GAP)
    np.fill_diagonal(distance, 1.0)
    assert distance.min() >= -1e-12


def cubic(spacing, count):
    x = spacing * (np.arange(count) + 0.5)
    return np.array(np.meshgrid(x, x, x)).reshape(3, -1).T, (spacing * count, spacing * count)


def test_packing_of_a_simple_cubic_lattice():
    position, box = cubic(1.0, 6)
    bed = Bed(position, np.full(len(position), 0.5), box)
    assert bed.surface(0.0) == pytest.approx(6.0)
    assert bed.packing() == pytest.approx(math.pi / 6.0, rel=1e-12)  # whole layers between y = 1 and 5
    assert bed.volume_below(6.0) == pytest.approx(bed.volume, rel=1e-12)
    assert bed.volume_below(0.25) == pytest.approx(36 * math.pi * 0.25**2 * (1.5 - 0.25) / 3.0, rel=1e-12)


def close_packed(layers, first):
    """Layers of 36 touching spheres, the lowest centres at y = `first`."""
    n, i, j = (index.ravel() for index in np.indices((layers, 6, 6)))
    x = np.mod(i + 0.5 * (j % 2) + 0.5 * (n % 2), 6.0)
    z = np.mod(j * math.sqrt(0.75) + (n % 2) / math.sqrt(12.0), 6.0 * math.sqrt(0.75))
    position = np.stack([x, first + n * math.sqrt(2.0 / 3.0), z], axis=1)
    return Bed(position, np.full(len(n), 0.5), (6.0, 6.0 * math.sqrt(0.75)))


@pytest.mark.parametrize("layers", [1, 2, 3, 4, 6, 10, 20])
def test_the_surface_over_a_hexagonal_base_is_the_top_of_close_packed_layers(layers):
    """Each layer takes sqrt(2/3), the base's upper half begins at its centres. The packing is pi/sqrt(18); planes that
    cut layers see up to 0.04 more or less of it."""
    bed = close_packed(layers, 0.5 + math.sqrt(2.0 / 3.0))
    assert bed.overlap() == pytest.approx(0.0, abs=1e-12)
    want, _ = bed_settling.wish(options("6x5.196", "--grains", "9", "--base", "hexagonal"))
    assert bed.surface(want.floor()) == pytest.approx(0.5 + (layers + 0.5) * math.sqrt(2.0 / 3.0), rel=1e-12)
    assert bed.packing(want.floor()) == pytest.approx(math.pi / math.sqrt(18.0), abs=0.04)
    on_floor, _ = bed_settling.wish(options("6x5.196", "--grains", "9"))
    assert on_floor.floor() == 0.0


def test_overlap_is_seen_inside_through_the_seam_and_at_the_floor():
    position, box = cubic(1.1, 4)
    radius = np.full(len(position), 0.5)
    assert Bed(position, radius, box).overlap() == pytest.approx(-0.05)  # the floor is 0.05 away, others 0.1
    for axis, place in ((0, 0.5 * 1.1 - 0.13), (0, 0.5 * 1.1 + 0.13), (2, 0.5 * 1.1 - 0.13), (1, 0.47)):
        moved = position.copy()
        at = np.argmin(np.linalg.norm(position - 0.55, axis=1))
        moved[at, axis] = place  # against the next through the seam, in the row, or the floor
        assert Bed(moved, radius, box).overlap() == pytest.approx(0.03, abs=1e-12)


class FakeFalls:
    """Beds whose packing is a known function of s; counts the falls."""

    def __init__(self, packing):
        self.packing_of, self.count = packing, 0

    def __call__(self, s):
        self.count += 1
        found = self.packing_of(s)

        class One:
            def packing(self, _):
                return found

        return One()


def search_for(packing, falls, tolerance=0.003):
    want, _ = bed_settling.wish(
        options("8x8", "--grains", "9", "--packing", str(packing), "--tolerance", str(tolerance))
    )
    return bed_settling.search(want, falls)


@pytest.mark.parametrize("packing", [0.56, 0.6, 0.632])
def test_search_finds_a_packing_between(packing):
    falls = FakeFalls(lambda s: 0.635 - 0.05 * s)  # looser than the table says
    _, found = search_for(packing, falls)
    assert abs(found - packing) <= 0.003 and falls.count <= 6


def test_search_says_what_it_could_not_reach():
    said = "--packing 0.66 was not reached within 0.003: the nearest of these falls is 0.6350"
    with pytest.raises(UserError, match=said):
        search_for(0.66, FakeFalls(lambda s: 0.635 - 0.05 * s))


def test_the_file_has_every_sphere_with_its_type_and_stays_in_the_box(tmp_path):
    bed = Bed(np.array([[0.5, 1.0, 3.9999999], [3.0, 2.0, 0.0]]), np.array([0.5, 0.35]), (4.0, 4.0))
    bed_settling.write_bed(tmp_path / "bed", bed, np.array([1, 2]), (4.0, 6.0, 4.0), 4, first_tag=11)
    lines = (tmp_path / "bed").read_text().splitlines()
    assert "2 atoms" in lines and "0 6.0 ylo yhi" in lines
    assert lines[-2:] == ["11 1 1 1 0.5 1 0", "12 2 0.7 1 3 2 0"]


def test_an_earlier_bed_moves_aside_once_the_new_one_is_made(tmp_path, monkeypatch, capsys):
    """Not for one that is refused; nothing that is no file moves."""
    position, box = cubic(1.0, 6)
    made = Bed(position, np.full(len(position), 0.5), box)
    out = tmp_path / "bed.data"
    line = options("6x6", "--grains", str(len(position)))
    line.out = out
    monkeypatch.setattr(bed_settling, "fall", lambda *_: made)
    for text, names in (("none", ["bed.data"]), ("first", ["bed.data", "bed.data.previous"]),
                        ("second", ["bed.data", "bed.data.previous", "bed.data.previous2"])):  # fmt: skip
        if text != "none":
            out.write_text(text)
        assert bed_settling.settle(line) == 0
        assert sorted(file.name for file in tmp_path.iterdir()) == names
        assert out.read_text().startswith("bed of 216 grains")
        assert (f"the earlier file there is now {tmp_path / names[-1]}" in capsys.readouterr().out) == (text != "none")
    assert (tmp_path / "bed.data.previous2").read_text() == "second"
    out.write_text("third")
    monkeypatch.setattr(bed_settling, "fall", lambda *_: Bed(made.position, 1.1 * made.radius, box))
    with pytest.raises(UserError, match="the bed is not at rest"):
        bed_settling.settle(line)
    assert out.read_text() == "third"
    line.out = tmp_path
    with pytest.raises(UserError, match=f"--out is the folder {tmp_path}, but must be a file"):
        bed_settling.settle(line)
