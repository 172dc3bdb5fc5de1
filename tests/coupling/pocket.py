"""The small scene `pocket` with both real programs: its command line, its checkpoints, its files."""

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
