"""The small scene `pocket` with both real programs: its command line, its checkpoints, its files."""

import csv

import h5py
import numpy as np

from job import BIN, SCENES, command, run

SCENE = SCENES / "pocket"


def line(out, *fluid_options, ranks=(1, 1), restart=None, script=SCENE / "in.liggghts",
         fluid_before=(), dem_before=()):
    """`fluid_before`, `dem_before`: what stands in front of a program's name."""
    fluid = [*fluid_before, str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--out", str(out)]
    fluid += [*fluid_options, *(["--restart", str(restart)] if restart else [])]
    dem = [*dem_before, str(BIN / "bedload-dem"), "-in", str(script), "-var", "out", str(out)]
    return command(fluid, [*dem, "-log", "none"], ranks)


def job(out, *fluid_options, **options):
    return run(line(out, *fluid_options, **options), out.parent, timeout=300)


def two_checkpoints(out):
    """A run's folder with the checkpoints of steps 2 and 4."""
    result = job(out, "--steps", "4", "--set", "checkpoint.every=0.04")
    assert result.status == 0, result.output
    return out


def checkpoint(folder, step):
    return folder / f"checkpoint_{step:08d}"


def checkpoints(out):
    """Steps of the checkpoints in a run's folder."""
    return sorted(int(folder.name.removeprefix("checkpoint_"))
                  for folder in out.glob("checkpoint_" + 8 * "[0-9]"))


def spoken(output):
    """What the programs said of their end, one sentence each."""
    return [text for text in output.splitlines()
            if text.startswith("bedload-") and "WARNING" not in text and "caution" not in text]


FLOOR = "wall/gran model actm tangential haff_werner primitive type 1 yplane 0.0"


def halves(first, second):
    """Two triangles for each rectangle between two rows of numbers; corners (a, b)."""
    for a, b in zip(first, first[1:]):
        for c, d in zip(second, second[1:]):
            yield (a, c), (a, d), (b, c)
            yield (b, c), (a, d), (b, d)


def write_triangles(file, normal, triangles):
    """An STL file of triangles given by three corners (x, y, z)."""
    def words(numbers):
        return " ".join(str(number) for number in numbers)

    text = [f"facet normal {words(normal)}\nouter loop\n"
            + "".join(f"vertex {words(corner)}\n" for corner in corners)
            + "endloop\nendfacet\n" for corners in triangles]  # fmt: skip
    file.write_text(f"solid {file.stem}\n" + "".join(text) + f"endsolid {file.stem}\n")


def with_mesh_floor(text, folder, pieces, height=0.0):
    """The script `text` with the floor of the pocket as a mesh of 2 pieces^2 triangles in `folder`."""
    along_x, along_z = np.linspace(0.0, 4.0, pieces + 1), np.linspace(0.0, 2.0, pieces + 1)
    write_triangles(folder / "floor.stl", (0, 1, 0),
                    [[(x, height, z) for x, z in half] for half in halves(along_x, along_z)])  # fmt: skip
    assert FLOOR in text
    mesh = FLOOR.replace("primitive type 1 yplane 0.0", "mesh n_meshes 1 meshes cad")
    surface = f"fix cad all mesh/surface file {folder}/floor.stl type 1\n"
    return text.replace(f"fix             floor all {FLOOR}", f"{surface}fix floor all {mesh}")


def rows(path):
    """A table with a head, by names of columns."""
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def numbers(file):
    """Every dataset of an HDF5 file by name."""
    found = {}
    with h5py.File(file) as content:
        content.visititems(
            lambda name, item: found.update({name: item[()]})
            if isinstance(item, h5py.Dataset) else None
        )  # fmt: skip
    return found


def same_numbers(a, b, but=()):
    """Whether two files hold the same, `but` these datasets."""
    a, b = numbers(a), numbers(b)
    for name in but:
        a.pop(name, None), b.pop(name, None)
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)
