"""Whether turbulence is alive in a run, and whether its box is long and wide enough: two-point correlations.

    R(r) = <u'(x) u'(x + r)> / <u'^2>

along x and z, where these are periodic, at several heights, from the snapshots of fields.h5. In a box that is
large enough R has fallen to about zero at half its length; where it has not, the largest motions are the box's.
"""

import argparse
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402
from bedload_launcher.errors import UserError, unknown  # noqa: E402
from bedload_launcher.numbers import finite  # noqa: E402
from bedload_post.batches import mean_over_time  # noqa: E402
from bedload_post.bed_friction import bed_top, friction_velocity  # noqa: E402
from bedload_post.outputs import MissingOutput, Run  # noqa: E402
from matplotlib.backend_bases import FigureCanvasBase  # noqa: E402

LAMINAR = 1e-12  # <u'^2> / u_b^2, up to which a plane has no fluctuations but those of single precision


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="OUT", help="output folder of a run")
    parser.add_argument("--since", type=finite, default=0.0, help="leave out what is earlier [T]")
    parser.add_argument(
        "--heights", type=finite, nargs="+", metavar="Y",
        help="heights over the floor [L] (default: bed's top + 0.1, 0.3 and 0.7 of the depth)",
    )  # fmt: skip
    parser.add_argument("--figure", type=Path, help="the correlations, a PNG by its name's ending, or a PDF, ...")


def correlation(field: np.ndarray, axis: int) -> np.ndarray:
    """<q(x) q(x+r)> of a periodic plane over the separations 0 ... half its length along `axis`."""
    fluctuation = field - field.mean()
    count = field.shape[axis]
    modes = np.abs(np.fft.rfft(fluctuation, axis=axis)) ** 2
    covariance = np.fft.irfft(modes, n=count, axis=axis).mean(axis=1 - axis) / count
    return covariance[: count // 2 + 1]


def planes(run: Run, heights: list[float], since: float) -> Iterator[np.ndarray]:
    """u on the planes nearest to `heights`, shape (heights, nz, nx), snapshot by snapshot."""
    path = run.folder / "fields.h5"
    if not path.is_file():
        raise MissingOutput(f"{run.folder} has no fields.h5.")
    with h5py.File(path) as file:
        face = file["grid/y"][:]
        rows = [int(np.argmin(np.abs(0.5 * (face[1:] + face[:-1]) - y))) for y in heights]
        for name in sorted(n for n in file if n.startswith("step_")):
            if file[name].attrs["time"] >= since:
                yield np.stack([file[name]["u"][:, row, :] for row in rows])


def correlations(
    run: Run, heights: list[float], since: float, least: float = 0.0
) -> tuple[np.ndarray, np.ndarray, int]:
    """R along x and z, shapes (heights, nx//2+1) and (heights, nz//2+1), and the number of snapshots.

    nan at heights where <u'^2> is not above `least` [L^2/T^2], and along a direction that is not periodic.
    """
    along_x: np.ndarray = np.zeros(1)
    along_z, count = along_x, 0
    for snapshot in planes(run, heights, since):
        along_x = along_x + np.stack([correlation(u, 1) for u in snapshot])
        along_z = along_z + np.stack([correlation(u, 0) for u in snapshot])
        count += 1
    if count == 0:
        raise MissingOutput(f"fields.h5 of {run.folder} has no snapshot after t = {since:g}.")
    moves = along_x[:, :1] > least * count  # the mean of u'^2 over a plane is the same along both
    of_x, of_z = (
        np.where(moves & np.isfinite(period), r / np.where(moves, r[:, :1], 1.0), np.nan)
        for r, period in ((along_x, run.periods[0]), (along_z, run.periods[2]))
    )
    return of_x, of_z, count


def separations(run: Run, direction: int) -> np.ndarray:
    """r [L] of the values of `correlations` along x (0) or z (2): whole cells, up to half of the box."""
    cells = run.value("grid.cells")[direction]
    return np.arange(cells // 2 + 1) * run.box[direction] / cells


def draw(run: Run, heights, along_x: np.ndarray, along_z: np.ndarray, file: Path) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
    for axis, values, d, name in ((axes[0], along_x, 0, "x"), (axes[1], along_z, 2, "z")):
        distance = separations(run, d) / run.depth
        for height, line, kind in zip(heights, values, cycle(("-", "--", ":", "-.")), strict=False):
            axis.plot(distance, line, kind, label=f"y = {height / run.diameter:.3g} D")
        axis.axhline(0, color="#999999", lw=0.8)
        axis.set(xlabel=f"separation along {name} / H" if np.isfinite(run.periods[d]) else f"{name} is not periodic")
    lowest = min(np.min(values, initial=-0.6, where=np.isfinite(values)) for values in (along_x, along_z))
    axes[0].set(ylabel="$R_{uu}$", ylim=(lowest, 1.02))
    axes[0 if np.isfinite(run.periods[0]) else 1].legend(frameon=False)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def check_figure(file: Path) -> None:
    """Refuses an ending that matplotlib does not write and a folder that is not there, before the work."""
    endings = FigureCanvasBase.get_supported_filetypes()
    if file.suffix[1:].lower() not in endings:
        raise unknown(f"ending of --figure {file}", file.suffix[1:], endings)
    if not file.parent.is_dir():
        raise UserError(f"--figure is {file}, but there is no folder {file.parent}.")


def last(values: np.ndarray) -> str:
    """R at half of the box, - where there is none."""
    return "-" if np.isnan(values[-1]) else f"{values[-1]:.3f}"


def smallest(values: np.ndarray, distance: np.ndarray) -> str:
    """Least R and where it is, - where there is none."""
    if np.isnan(values[0]):
        return "-"
    lowest = int(np.argmin(values))
    return f"{values[lowest]:.3f} at {distance[lowest]:.1f}"


def run(options: argparse.Namespace) -> int:
    case = Run(options.folder)
    if not np.isfinite(case.periods[[0, 2]]).any():
        raise UserError(f"{options.folder} is periodic along neither x nor z, so it has no two-point correlations.")
    if options.figure:
        check_figure(options.figure)
    heights = options.heights or [bed_top(case) + share * case.depth for share in (0.1, 0.3, 0.7)]
    for height in heights:
        if not 0.0 < height < case.box[1]:
            raise UserError(f"--heights has {height:g}, but the box of {options.folder} is {case.box[1]:g} high.")
    along_x, along_z, count = correlations(case, heights, options.since, LAMINAR * case.bulk_velocity**2)
    still = np.isnan(along_x[:, 0]) & np.isnan(along_z[:, 0])
    history = case.history()
    late = history["time"] >= options.since
    energy = history["kinetic_energy"][late]
    mean_energy = mean_over_time(history["time"], history["kinetic_energy"], options.since)
    try:
        friction, source = friction_velocity(case, options.since)
        print(f"u_tau / u_b      {friction / case.bulk_velocity:.4f} ({source})")
        print(f"Re_tau           {friction * case.depth / case.viscosity:.4g}")
    except MissingOutput as missing:  # side walls, or walls that drive the flow
        print(f"u_tau            unknown: {missing}")
    print(f"kinetic energy   {mean_energy:.4f}, between {energy.min():.4f} and {energy.max():.4f}")
    print(f"snapshots        {count}")
    if still.any():
        names = ", ".join(f"{height:g}" for height, none in zip(heights, still, strict=True) if none)
        no_figure = ", so there is no figure" if options.figure and still.all() else ""
        print(f"no fluctuations at y = {names}: the flow is laminar{no_figure}")
    if still.all():
        return 0
    print("height / D   R at half the length   R at half the width   smallest R along z at z / D")
    across = separations(case, 2) / case.diameter
    for height, x, z, none in zip(heights, along_x, along_z, still, strict=True):
        if not none:
            print(f"{height / case.diameter:10.2f} {last(x):>21} {last(z):>21} {smallest(z, across):>25}")
    if options.figure:
        draw(case, heights, along_x, along_z, options.figure)
    return 0
