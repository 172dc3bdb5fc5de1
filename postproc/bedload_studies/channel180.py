"""Turbulent channel at Re_tau = 180 against published direct numerical simulations.

Runs inputs/channel180 (a coarse start that becomes turbulent, then the scene's own grid), or takes
the outputs of runs made before (--from), and compares: mean velocity within 2 %, peaks of the
fluctuations within 3 %, total stress a straight line. Leaves profiles.png and numbers.json in
postproc/reports/channel180. The command may be given again: a run that is done is left alone, one that
was interrupted, or has to become longer, goes on.
"""

import argparse
import csv
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from bedload_launcher import bench, job
from bedload_launcher.build import BIN, ROOT
from bedload_launcher.errors import UserError
from bedload_launcher.numbers import positive
from bedload_launcher.scenes import find_scene
from bedload_post import flow_statistics, profile_figures

from . import made_by, models

SCENE = "channel180"
REFERENCE = Path(__file__).parent / "reference"
REPORT = ROOT / "postproc" / "reports" / SCENE
MEAN_BOUND, RMS_BOUND, STRESS_BOUND = 0.02, 0.03, 0.02
MAY_DIFFER = ("time.end=", "start.file=")  # a longer flow goes on; the folders may have moved


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--ranks", help="MPI ranks of the fluid (default: every core)")
    parser.add_argument(
        "--time", type=positive, default=200.0, help="that is averaged over, in half heights over U_b"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("runs") / SCENE, help="where the runs leave their files"
    )
    parser.add_argument(
        "--from", dest="outputs", type=Path, nargs="+", metavar="OUT",
        help="compare these outputs, pieces of one flow, and run nothing",
    )  # fmt: skip
    parser.add_argument("--report", type=Path, default=REPORT, help="folder of figure and numbers")


def columns(file: Path) -> dict[str, np.ndarray]:
    """A reference table by column; lines that begin with # are its source."""
    with file.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def compute(options: argparse.Namespace) -> Path:
    """The two runs; returns the output of the second."""
    scene = find_scene(SCENE)
    ranks = job.Ranks.parse(options.ranks, scene)
    cells = scene.cells([])
    half = [max(4, n // 2) for n in cells]
    coarse, fine = (options.out.resolve() / name for name in ("coarse", "fine"))
    # On half the cells a sixteenth of the work: there the start may take its time (the rolls that it
    # begins with leave one wall ahead of the other for some 70 half heights over U_b).
    start = [f"grid.cells={half}", "time.end=150.0", "time.step=0.12", "statistics.every=0",
             "statistics.spectra_heights=[]"]  # fmt: skip
    go_on = ['start.from="state"', f'start.file="{coarse}/state.h5"', "statistics.from=15.0",
             f"time.end={options.time + 15.0}"]  # fmt: skip
    for out, changes in ((coarse, start), (fine, go_on)):
        status = make(job.Job(scene, None, ranks, out, changes))
        if status != 0:
            sys.exit(status)
    return fine


def make(work: job.Job) -> int:
    """Starts a run, or goes on with it; returns the job's status. One that is done is left alone."""
    out, made = work.out, made_by.now(work, BIN)
    end = models.settings_of(work.scene, work.overrides)["time"]["end"]
    done = models.finished(out, end) and (out / "state.h5").is_file()
    if done or any(out.glob("checkpoint_*")):
        check_same(work, made)
    if done:
        print(f"bedload: {out.name} is done", flush=True)
        return 0
    going_on = models.taken_up(out)
    made_by.note(out, made)
    print(f"bedload: {work.summary()}{', going on' if going_on else ''}; {out}", flush=True)
    return job.run(replace(work, restart=out if going_on else None).command(), work.scene.folder)


def check_same(work: job.Job, made: dict[str, str]) -> None:
    """Raises UserError where the run in the job's folder has other settings, or was made by others."""
    made_by.check(work.out, made)
    models.refuse_other(work.out, work.overrides, MAY_DIFFER)


def largest_difference(y, values, y_reference, reference, lowest, highest) -> float:
    """Largest relative difference at the reference's points with lowest < y < highest."""
    inside = (y_reference > lowest) & (y_reference < highest)
    here = np.interp(y_reference[inside], y, values)
    return float(np.abs(here / reference[inside] - 1).max())


def peak(y: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Largest value and its place, by the parabola through the three points about it."""
    n = int(np.clip(np.argmax(values), 1, len(values) - 2))
    a, b, c = np.polyfit(y[n - 1 : n + 2] - y[n], values[n - 1 : n + 2], 2)
    at = float(np.clip(-b / (2 * a), y[n - 1] - y[n], y[n + 1] - y[n])) if a < 0 else 0.0
    return float(a * at**2 + b * at + c), float(y[n] + at)


def steady_defect(s: flow_statistics.FlowStatistics) -> float:
    """As stress_defect, of the stress less what the planes sped up by: int rho d<u>/dt dy."""
    gained = np.concatenate([[0.0], np.cumsum(s["acceleration"] * np.diff(s["y_face"]))])
    stress = s.total_stress - gained
    line = stress[0] + (stress[-1] - stress[0]) * s["y_face"] / s["y_face"][-1]
    return float(np.abs(stress - line).max() / (s.density * s.u_tau**2))


def compare(s: flow_statistics.FlowStatistics) -> tuple[dict, flow_statistics.WallProfiles]:
    """All numbers of the comparison."""
    mean, rms = columns(REFERENCE / "mkm180_mean.csv"), columns(REFERENCE / "channel180_rms.csv")
    p = flow_statistics.wall_profiles(s)
    bulk = float(np.average(s["u"], weights=np.diff(s["y_face"])))
    numbers: dict[str, Any] = {
        "samples": s.samples,
        "Re_tau": p.reynolds,
        "u_tau_over_U_b": s.u_tau / bulk,
        "U_b_plus": bulk / s.u_tau,
        "U_c_plus": float(p.u[-1]),
        "mean_difference": largest_difference(
            p.y, p.u, mean["yplus"], mean["Uplus"], p.y[0], p.y[-1]
        ),
        "stress_defect": s.stress_defect,
        "stress_defect_less_acceleration": steady_defect(s),
        "peaks": {},
    }
    for q in "uvw":
        found, at = peak(p.y, p.rms[q])
        wanted, wanted_at = peak(rms["yplus"], rms[f"{q}rms"])
        numbers["peaks"][q] = {
            "found": found, "at": at, "reference": wanted, "reference_at": wanted_at,
            "difference": found / wanted - 1,
        }  # fmt: skip
    found, at = peak(p.y, -p.uv)
    wanted, wanted_at = peak(rms["yplus"], -rms["uv"])
    numbers["peaks"]["uv"] = {
        "found": found, "at": at, "reference": wanted, "reference_at": wanted_at,
        "difference": found / wanted - 1,
    }  # fmt: skip
    numbers["holds"] = {
        "mean within 2 %": numbers["mean_difference"] < MEAN_BOUND,
        "rms peaks within 3 %": all(abs(numbers["peaks"][q]["difference"]) < RMS_BOUND for q in "uvw"),
        "total stress a straight line": numbers["stress_defect"] < STRESS_BOUND,
    }
    return numbers, p


def run(options: argparse.Namespace) -> int:
    outputs = options.outputs or [compute(options)]
    s = flow_statistics.read_all(outputs)
    if s.stress_defect is None:
        raise UserError(f"{outputs[0]} is of no plain channel: its {flow_statistics.FILE} has no stress_defect.")
    numbers, p = compare(s)
    options.report.mkdir(parents=True, exist_ok=True)
    mean, rms = columns(REFERENCE / "mkm180_mean.csv"), columns(REFERENCE / "channel180_rms.csv")
    profile_figures.draw_against(p, mean, rms, s, options.report / "profiles.png")
    record = numbers | bench.circumstances()
    if options.outputs:  # the runs may be older than the program of today
        record["commit_of_comparison"] = record.pop("commit")
    else:
        record["commit"] = made_by.of_all(outputs)
    (options.report / "numbers.json").write_text(json.dumps(record, indent=2, default=bool) + "\n")
    print(f"Re_tau {numbers['Re_tau']:.1f}, U_b+ {numbers['U_b_plus']:.2f}, U_c+ {numbers['U_c_plus']:.2f}")
    print(f"mean velocity: largest difference {100 * numbers['mean_difference']:.2f} %")
    for q, values in numbers["peaks"].items():
        print(
            f"peak of {q:2}: {values['found']:.3f} at y+ {values['at']:.1f}; reference "
            f"{values['reference']:.3f} at {values['reference_at']:.1f}: "
            f"{100 * values['difference']:+.1f} %"
        )
    print(f"total stress off a straight line: {100 * numbers['stress_defect']:.2f} % of rho u_tau^2")
    print(
        "the same less what the planes sped up by meanwhile: "
        f"{100 * numbers['stress_defect_less_acceleration']:.2f} %"
    )
    for what, holds in numbers["holds"].items():
        print(f"{'ok  ' if holds else 'MISS'} {what}")
    print(f"in {options.report}")
    return 0 if all(numbers["holds"].values()) else 1
