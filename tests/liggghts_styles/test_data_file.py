"""Data files of LIGGGHTS: a row that is no row of numbers is refused with file and line. LIGGGHTS itself reads a
word as 0 and puts a sphere at NaN at the begin of a periodic box."""

import pytest

from liggghts_script import Scene, Sphere, launch

PAIR = [Sphere((0.0, 0.0, 0.0)), Sphere((0.02, 0.0, 0.0), (0.0, -0.125, 0.0))]
SCENE = Scene(PAIR, boundary="p p p", contact="model actm tangential haff_werner")
FIRST, SECOND = "1 1 0.01 2500.0 0.0 0.0 0.0", "2 1 0.01 2500.0 0.02 0.0 0.0"

# Replaced, put in its place, words of the sentence.
REFUSED = {
    "NaN": ("0.02 0.0 0.0", "nan 0.0 0.0", ["line 13", "the x is 'nan'", "finite number"]),
    "infinite": ("0.02 0.0 0.0", "0.02 inf 0.0", ["the y is 'inf'"]),
    "too large": ("0.02 0.0 0.0", "0.02 0.0 1e999", ["the z is '1e999'"]),
    "a word": ("0.02 0.0 0.0", "o.02 0.0 0.0", ["line 13", "the x is 'o.02'"]),
    "a comma": ("0.02 0.0 0.0", "0,02 0.0 0.0", ["the x is '0,02'"]),
    "diameter": ("2 1 0.01", "2 1 one", ["the diameter is 'one'"]),
    "density": (SECOND, SECOND.replace("2500.0", "nan"), ["the density is 'nan'"]),
    "type": ("2 1 0.01", "2 1.5 0.01", ["the type is '1.5'", "whole number"]),
    "number": ("2 1 0.01", "b 1 0.01", ["the number is 'b'"]),
    "a word too many": (SECOND, SECOND + " 0.0", ["line 13", "8 words", "first row of this section has 7"]),
    "a word too few": (FIRST, FIRST.removesuffix(" 0.0"), ["line 13", "7 words", "has 6"]),
    "velocity": ("-0.125", "nan", ["line 18", "the vy is 'nan'"]),
}  # fmt: skip


def read(folder, text):
    folder.mkdir(exist_ok=True)
    (folder / "spheres.data").write_text(text)
    return launch(folder, SCENE.script(2))


@pytest.mark.parametrize("case", REFUSED)
def test_refused(tmp_path, case):
    found, given, words = REFUSED[case]
    assert SCENE.data_file().count(found) == 1
    done = read(tmp_path, SCENE.data_file().replace(found, given))
    said = [line for line in (done.stdout + done.stderr).splitlines() if line.lstrip().startswith("ERROR")]
    assert done.returncode != 0 and len(said) == 1, done.stdout
    for word in ("read_data: spheres.data", *words):
        assert word in said[0]


def test_other_ways_to_write_a_row_are_taken(tmp_path):
    """Signs, exponents, tabs, comments, places beyond a periodic end, the box's number behind a place."""
    text = SCENE.data_file().replace(FIRST, "1\t1 +1e-2 2.5E3 0 -.0 0.00 # the first")
    done = read(tmp_path / "signs", text)
    assert done.returncode == 0, done.stdout
    text = SCENE.data_file().replace(FIRST, FIRST + " 0 0 0").replace(SECOND, SECOND + " 1 0 -1")
    done = read(tmp_path / "boxes", text)
    assert done.returncode == 0, done.stdout


def test_atoms_that_are_added(tmp_path):
    """Also from the file of the present step (`*`), and on two ranks."""
    lines = SCENE.script(2)
    place = lines.index("read_data spheres.data")
    lines[place:place + 1] = [
        "region box block -0.1 0.1 -0.1 0.1 -0.1 0.1 units box", "create_box 1 box", "read_data spheres.*.data add",
    ]  # fmt: skip
    (tmp_path / "spheres.0.data").write_text(SCENE.data_file().replace("0.02 0.0 0.0", "0.02 nan 0.0"))
    done = launch(tmp_path, lines, ranks=2)
    assert done.returncode != 0 and "spheres.0.data, line 13: the y is 'nan'" in done.stdout, done.stdout
    (tmp_path / "spheres.0.data").write_text(SCENE.data_file())
    done = launch(tmp_path, lines, ranks=2)
    assert done.returncode == 0, done.stdout
