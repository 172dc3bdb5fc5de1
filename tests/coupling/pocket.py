"""The small scene `pocket` with both real programs: its command line, its checkpoints, its files."""

import csv
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np

from programs import BIN, SCENES, command, run

SCENE = SCENES / "pocket"


def line(out, *fluid_options, ranks=(1, 1), restart=None, script=SCENE / "in.liggghts",
         fluid_before=(), dem_before=(), dem_more=()):
    """`fluid_before`, `dem_before`: what stands in front of a program's name; `dem_more`: options."""
    fluid = [*fluid_before, str(BIN / "bedload-fluid"), str(SCENE / "fluid.toml"), "--out", str(out)]
    fluid += [*fluid_options, *(["--restart", str(restart)] if restart else [])]
    dem = [*dem_before, str(BIN / "bedload-dem"), "-in", str(script), "-var", "out", str(out)]
    return command(fluid, [*dem, *dem_more, "-log", "none"], ranks)


def job(out, *fluid_options, **options):
    return run(line(out, *fluid_options, **options), out.parent, timeout=300)


def two_checkpoints(out, **more):
    """A run's folder with the checkpoints of steps 2 and 4; `more` as job() takes it."""
    result = job(out, "--steps", "4", "--set", "checkpoint.every=0.04", **more)
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
            if text.startswith("bedload-")
            and not any(word in text for word in ("WARNING", "NOTE", "restart: "))]


# Two kinds of grains at random places and speeds, every 100 of LIGGGHTS' steps (fluid steps 0, 6, 13,
# 20, 26, 33, 40, 46): no more than there is room for, so that the overlap check draws anew as well.
INSERTION = """timestep 1e-3
region drop block 0 4 2.2 2.95 0 2 units box
fix one all particletemplate/sphere 15485863 atom_type 2 density constant 2.5 radius constant 0.35
fix two all particletemplate/sphere 15485867 atom_type 2 density constant 2.4 radius constant 0.3
fix mix all particledistribution/discrete 32452867 2 one 0.5 two 0.5
fix rain grains insert/{} seed 32452843 distributiontemplate mix{} insert_every 100 overlapcheck yes &
    all_in no vel {} 0.5 -1.5 0 0.1 0.1 0.1 region drop ntry_mc 10000{}
fix fluid"""
PACK = INSERTION.format("pack", "", "uniform", " particles_in_region 5")
RATE = INSERTION.format("rate/region", " nparticles 30 particlerate 30", "gaussian", "")


def changed_jobs(folder, cases, steps):
    """Results of the scene `pocket` with changed LIGGGHTS scripts, by the names of `cases`: pairs of what is
    replaced and what by. Four at a time: a job that is refused mostly waits for mpirun's second of grace."""
    def run_changed(place, changes):
        text = (SCENE / "in.liggghts").read_text(encoding="utf-8")
        for found, given in changes:
            assert found in text
            text = text.replace(found, given)
        place.mkdir()
        (place / "in.liggghts").write_text(text, encoding="utf-8")
        return job(place / "out", "--steps", str(steps), script=place / "in.liggghts")

    with ThreadPoolExecutor(4) as pool:
        runs = {case: pool.submit(run_changed, folder / str(n), changes)
                for n, (case, changes) in enumerate(cases.items())}  # fmt: skip
    return {case: result.result() for case, result in runs.items()}


def check_refused(result, words):
    """One sentence, with these words in it."""
    assert result.status != 0, result.output
    said = spoken(result.output)
    assert len(said) == 1, result.output
    for word in words:
        assert word in said[0]


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
    """Whether two files hold the same, `but` these datasets and the number that each checkpoint has
    of its own."""
    a, b = numbers(a), numbers(b)
    for name in ("run/checkpoint_id", *but):
        a.pop(name, None), b.pop(name, None)
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)
