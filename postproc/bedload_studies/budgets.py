"""A small bed over very many steps: mass, momentum, energy and the number of grains accounted for.

Two grains over nine fixed ones under a stream, eight cells to a diameter, in single precision. A run that was cut
short goes on from its last checkpoint. The energy that the driving force brings must be found again, to rounding, in
what viscosity takes, what the grains are given, what the forcing at markers takes, what is left in the flow, and what
convection takes, which is an error of the time scheme and has a bound of its own.
"""

import argparse
import csv
import math
import subprocess
import sys
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import h5py
import matplotlib
import numpy as np
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import Scene
from bedload_post.outputs import Run
from bedload_post.report import image, page, table

from .criteria import PASS, Check
from .small_scenes import Ball, SmallScene

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

GRAINS, GRAIN_DENSITY, GRAVITY = 2, 1.3, 0.3
COURANT, CELLS = 0.3, 8  # to a diameter
EDGE = 3  # of the box, in diameters
ROUNDING = 2.0**-24  # of single precision
REST_ALLOWED, CONVECTION_ALLOWED = 1e-4, 0.01  # of the driving's power


def scene(steps: int, shorter: int = 1) -> SmallScene:
    """`steps` time steps, each `shorter` times as short as usual."""
    bed = [Ball((0.5 + i, 0.5, 0.5 + k), mobile=False) for i in range(EDGE) for k in range(EDGE)]
    height = 0.5 + math.sqrt(0.5) + 0.01
    grains = [Ball((1.0 + i, height, 1.0 + i), density=GRAIN_DENSITY) for i in range(GRAINS)]
    dt = COURANT / CELLS / shorter
    keys = {
        "flow.driving": '"bulk_velocity"', "flow.bulk_velocity": "1.0",
        "start.from": '"logarithmic"', "start.velocity": "1.0", "start.height": "1.0",
        "start.disturbance": "0.2", "accuracy.precision": '"single"',
        "output.spheres_every": "0.0", "output.energy_work": '"on"',
        "checkpoint.wall_every": "120.0",
    }  # fmt: skip
    return SmallScene(
        (EDGE, EDGE, EDGE), CELLS, 0.005, dt, steps * dt, [*bed, *grains], gravity=GRAVITY,
        y_ends=("no_slip", "free_slip"), keys=keys,
    )  # fmt: skip


INTERRUPTED = 3  # status of a program that ends in good order before its time


def run_scene(small: SmallScene, folder: Path, wall_limit: float = 0.0) -> Path | None:
    """Runs `small` in `folder`, or goes on with what is there; returns its output folder, or None when
    `wall_limit` (s, 0: none) came first."""
    small.write(folder)
    out = folder / "out"
    out.mkdir(parents=True, exist_ok=True)
    if (out / "done").is_file():
        return out
    begun = any(out.glob("checkpoint_????????"))
    work = job.Job(
        Scene(folder), small.model, job.Ranks(1, 1), out, [f"time.wall_limit={wall_limit}"],
        restart=out if begun else None,
    )  # fmt: skip
    with (folder / "screen.txt").open("a", encoding="utf-8") as screen:
        status = subprocess.run(
            work.command(), cwd=folder, env=job.environment(), stdin=subprocess.DEVNULL,
            stdout=screen, stderr=subprocess.STDOUT, check=False,
        ).returncode  # fmt: skip
    if status == INTERRUPTED:
        return None
    if status != 0:
        raise UserError(f"the run ended with status {status}; see {folder}/screen.txt.")
    (out / "done").touch()
    return out


@dataclass(frozen=True)
class Series:
    """A run step by step: columns of history.csv (m), and the grains' power and number (m).

    to_grains: power of the fluid's loads on the grains, buoyancy included; by_weight: that of their weight;
    by_buoyancy: that of buoyancy; kinetic: the grains' energy at the instants 0 .. m; inside: no grain was
    ever beyond a wall.
    """

    history: dict[str, np.ndarray]
    to_grains: np.ndarray
    by_weight: np.ndarray
    by_buoyancy: np.ndarray
    kinetic: np.ndarray
    inside: bool
    volume: float


def read_series(out: Path) -> Series:
    run = Run(out)
    history = run.history()
    with h5py.File(out / "spheres.h5") as file:
        group = file["mobile"]
        step = group["step"][:]
        count = int(np.sum(step == step[0]))
        rows = len(step) // count

        def vectors(name: str) -> np.ndarray:
            return group[name][: rows * count].reshape(rows, count, 3)

        x, v, w, f, m = map(
            vectors, ("position", "velocity", "angular_velocity", "force", "torque")
        )
        r = group["radius"][:count]
    size = 4.0 / 3.0 * math.pi * r**3
    dt = history["dt"]
    mean_v, mean_w = 0.5 * (v[1:] + v[:-1]), 0.5 * (w[1:] + w[:-1])
    power = np.sum(f[1:] * mean_v + m[1:] * mean_w, axis=(1, 2))
    fall = -GRAVITY * np.diff(x[:, :, 1], axis=0) / dt[:, None]
    energy = 0.5 * np.sum(v**2, axis=2) + 0.2 * r**2 * np.sum(w**2, axis=2)
    return Series(
        history, power, GRAIN_DENSITY * fall @ size, -fall @ size,
        energy @ (GRAIN_DENSITY * size),
        bool(np.all((x[..., 1] > 0.0) & (x[..., 1] < run.box[1]))), float(np.prod(run.box)),
    )  # fmt: skip


@dataclass(frozen=True)
class Budget:
    """A number of the account beside its limit, over all steps."""

    what: str
    number: float
    limit: float
    reason: str

    @property
    def closed(self) -> bool:
        return Check(self.what, self.number, self.limit).verdict().kind == PASS


def energy_shares(s: Series) -> dict[str, float]:
    """Where the power of the driving force goes, as shares of it, means over the run but for its first
    step, before which nobody knows the flow's energy.

    viscosity: as the stages took it. grains: the loads' work on the grains without buoyancy, which is no work of the
    flow; the kinetic energy of the fluid inside them, which goes with them, stays the same but for its first and
    last value. slip: what the forcing at markers takes beyond it, because the flow before it does not yet move with
    them. grains and slip are two shares of one number, the forcing's work. convection: what it takes, which would
    be nothing were it not taken at velocities of earlier stages. rest: what nothing of that explains.
    """
    h = {name: values[1:] for name, values in s.history.items()}
    time = float(np.sum(h["dt"]))

    def mean(values) -> float:
        return float(np.sum(values * h["dt"])) / time

    driving = mean(h["driving"] * h["bulk_velocity"])
    grains = mean((s.to_grains - s.by_buoyancy)[1:]) / s.volume
    parts = {
        "viscosity": -mean(h["viscous_work"]),
        "grains": grains,
        "slip": -mean(h["forcing_work"]) - grains,
        "convection": -mean(h["convective_work"]),
        "stored": float(np.diff(s.history["kinetic_energy"][[0, -1]])[0]) / time,
    }
    parts["rest"] = driving - sum(parts.values())
    scale = driving if driving != 0.0 else math.nan
    return {name: value / scale for name, value in parts.items()}


def share_over_time(s: Series, share: str, parts: int = 10) -> list[float]:
    """A share of the driving's power in each of `parts` equal parts of the run: whether it grows."""
    edges = np.linspace(0, len(s.history["step"]), parts + 1).astype(int)
    shares = []
    for begin, end in zip(edges, edges[1:], strict=False):
        steps = slice(begin, end)
        part = replace(
            s, history={name: values[steps] for name, values in s.history.items()},
            to_grains=s.to_grains[steps], by_weight=s.by_weight[steps], by_buoyancy=s.by_buoyancy[steps],
            kinetic=s.kinetic[begin : end + 1],
        )  # fmt: skip
        shares.append(energy_shares(part)[share])
    return shares


def account(s: Series) -> list[Budget]:
    h = s.history
    shares = energy_shares(s)
    time = np.sum(h["dt"])
    given = float(np.sum((s.to_grains + s.by_weight) * h["dt"]))
    contacts = float(s.kinetic[-1] - s.kinetic[0]) - given
    size = float(np.sum(np.abs(s.to_grains) * h["dt"]))
    # What the fluid inside the grains has gained with them is in the forcing's work and not lost.
    driven = float(np.sum((h["driving"] * h["bulk_velocity"] * h["dt"])[1:])) * s.volume
    inside = float(s.kinetic[-1] - s.kinetic[0]) / GRAIN_DENSITY / driven if driven else math.nan
    return [
        Budget("mass: largest |div u| h / U", float(np.max(h["max_divergence"])) / CELLS,
               64 * ROUNDING, "single precision of three differences of velocities up to 2 U, and of "
               "the transforms (log2 of their length)"),
        Budget("mass: bulk velocity off 1", float(np.max(np.abs(h["bulk_velocity"] - 1.0))),
               4 * ROUNDING, "the shift of the field is rounded to single precision"),
        Budget("momentum: largest residual of a step", float(np.max(h["momentum_residual"])),
               16 * ROUNDING, "sums in double of fields in single: three stages of a few roundings"),
        Budget("grains lost or come", float(np.max(np.abs(h["mobile_spheres"] - GRAINS)))
               + (0.0 if s.inside else GRAINS), 0.5, "a count"),
        Budget("energy: driving that is not found again, of the driving", abs(shares["rest"]),
               REST_ALLOWED, "rounding of the velocities to single precision, 2e-4 if it all went one way"),
        Budget("energy: what convection takes or gives, of the driving", abs(shares["convection"]),
               CONVECTION_ALLOWED, "the time scheme: velocities beside markers differ from stage to stage; "
               "of first order in the step"),
        Budget("energy: slip that gives instead of takes, of the driving",
               max(-shares["slip"] - inside, 0.0), 1e-3, "it only takes, but for what the fluid inside the "
               "grains has gained"),
        Budget("energy: what contacts gave the grains, over the fluid's work on them",
               contacts / size, 1e-3, "contacts only take; a thousandth for the trapezoidal sums"),
        Budget("time steps not made", abs(len(h["step"]) - float(h["step"][-1])) / len(h["step"])
               + abs(time / h["time"][-1] - 1.0), 1e-6, "every step has its row"),
    ]  # fmt: skip


def draw(s: Series, file: Path) -> None:
    """The account over the run, its rows thinned to means, or largest values, of a hundredth of it."""
    h = s.history
    parts = np.array_split(np.arange(len(h["step"])), 100)
    when = [float(h["step"][p[-1]]) for p in parts]

    def mean(values):
        return np.array([np.mean(values[p]) for p in parts])

    figure, axes = plt.subplots(2, 2, figsize=(10, 6.4), layout="constrained")
    power = mean(h["driving"] * h["bulk_velocity"])
    axes[0, 0].plot(when, power, label="driving")
    axes[0, 0].plot(when, -mean(h["viscous_work"]), label="viscosity")
    axes[0, 0].plot(when, mean(s.to_grains - s.by_buoyancy) / s.volume, label="to the grains")
    axes[0, 0].plot(when, -mean(h["convective_work"]), label="convection (error)")
    axes[0, 0].set(ylabel="power / (rho U^3 / D)")
    axes[0, 1].plot(when, [np.max(h["momentum_residual"][p]) for p in parts], label="momentum residual")
    axes[0, 1].plot(when, [np.max(h["max_divergence"][p]) / CELLS for p in parts], label="|div u| h / U")
    axes[0, 1].set(yscale="log", ylabel="largest", ylim=(1e-8, 1e-6))
    axes[1, 0].plot(when, mean(h["kinetic_energy"]))
    axes[1, 0].set(ylabel="energy of the flow / (rho U^2)")
    axes[1, 1].plot(when, [s.kinetic[p[-1]] for p in parts])
    axes[1, 1].set(ylabel="energy of the grains / (rho U^2 D^3)")
    for axis in axes[0]:
        axis.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=2, fontsize=9)
    for axis in axes.flat:
        axis.set_xlabel("step")
        axis.grid(alpha=0.25)
    figure.savefig(file, dpi=100)
    plt.close(figure)


def rows_of(name: str, series: Series) -> list[dict[str, object]]:
    """What the table says of one run."""
    rows: list[dict[str, object]] = [
        {"run": name, "closed": int(b.closed)} | asdict(b) for b in account(series)
    ]

    def add(what: str, number: float) -> None:
        rows.append({"run": name, "closed": "", "what": what, "number": number, "limit": "", "reason": ""})

    for part, value in energy_shares(series).items():
        add(f"share of the driving's power: {part}", value)
    for share in ("convection", "rest"):
        tenths = share_over_time(series, share)
        for which, value in (("lowest", min(tenths)), ("highest", max(tenths)),
                             ("first", tenths[0]), ("last", tenths[-1])):  # fmt: skip
            add(f"{share} in a tenth of the run: {which}", value)
    return rows


def write_report(folder: Path, runs: dict[str, Series]) -> bool:
    """budgets.csv, .png and .html of runs by name, the picture of the first; whether every budget is closed."""
    rows = [row for name, series in runs.items() for row in rows_of(name, series)]
    first = next(iter(runs))
    draw(runs[first], folder / "budgets.png")
    body = ["<h1>Budgets of a small bed</h1>", image(folder / "budgets.png", first)]
    columns = ("run", "what", "number", "limit", "closed", "reason")
    text = ([str(r["run"]), str(r["what"]), f"{r['number']:.3g}", f"{r['limit']:.3g}" if r["limit"] != "" else "",
             {"1": "yes", "0": "NO"}.get(str(r["closed"]), ""), str(r["reason"])] for r in rows)  # fmt: skip
    body.append(table(text, ("", "", "number", "number", "", "note"), columns))
    (folder / "budgets.html").write_text(page("Budgets of a small bed", body), encoding="utf-8")
    with (folder / "budgets.csv").open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for r in rows:
        print(f"{r['run']:20} {r['what']:72} {r['number']:10.3g} {r['limit']!s:>10} {r['closed']}")
    return all(r["closed"] != 0 for r in rows)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--steps", type=int, default=100_000, help="of the run (default: 100000)")
    parser.add_argument(
        "--shorter", type=int, nargs="+", default=[], metavar="N",
        help="besides, the same time in N times as many steps",
    )  # fmt: skip
    parser.add_argument(
        "--piece", type=float, default=0.0, metavar="SECONDS",
        help="end after so long with a checkpoint; the same command goes on",
    )  # fmt: skip
    parser.add_argument("--runs", type=Path, default=Path("runs/budgets"), help="where runs go")
    parser.add_argument("--report", type=Path, help="folder of the report (default: RUNS/report)")


def run(options: argparse.Namespace) -> int:
    if options.steps < 100:
        raise UserError(f"--steps is {options.steps}, but must be at least 100.")
    if any(shorter < 2 for shorter in options.shorter):
        raise UserError(f"--shorter is {min(options.shorter)}, but must be at least 2.")
    report = options.report or options.runs / "report"
    report.mkdir(parents=True, exist_ok=True)
    runs = {}
    for shorter in [1, *options.shorter]:
        name = f"{shorter * options.steps} steps" + (f" of 1/{shorter}" if shorter > 1 else "")
        print(f"bedload: {name}", file=sys.stderr, flush=True)
        folder = options.runs.resolve() / name.replace(" ", "_").replace("/", "_")
        out = run_scene(scene(shorter * options.steps, shorter), folder, options.piece)
        if out is None:
            print("bedload: not over yet; the same command goes on", file=sys.stderr)
            return INTERRUPTED
        runs[name] = read_series(out)
    return 0 if write_report(report, runs) else 1
