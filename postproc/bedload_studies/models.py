"""The paper's comparison: one scene with each collision model, then figures, Table 2 and a report.

Each run has a folder runs/models/SCENE-MODEL. One that has reached time.end is left alone, one that was
interrupted goes on from its last checkpoint, so the command may be given as often as one likes.
"""

import argparse
import datetime
import json
import platform
import subprocess
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bedload_launcher import job
from bedload_launcher.build import ROOT
from bedload_launcher.errors import UserError
from bedload_launcher.machine import cores
from bedload_launcher.scenes import Scene, choose_model, find_scene, models, read_variables
from bedload_post.models_report import Comparison, make_case, write
from bedload_post.outputs import MissingOutput, Run

START_UP = 3.0  # flow-throughs L_x/u_b, of a scene that does not say
PAPER_MODELS = ("rpm", "rpm_hw", "actm", "actm_hw")


@dataclass(frozen=True)
class Member:
    """One run of the comparison."""

    scene: Scene
    model: str
    density: float | None  # rho_p/rho_f, None: the scene's own
    out: Path
    given: Mapping[str, str]  # --var

    def overrides(self, settings: dict) -> list[str]:
        """Keys of fluid.toml that follow from another density: g keeps Fr, so the weight."""
        if self.density is None:
            return []
        fluid, reference = settings["fluid"], settings["reference"]
        weight = reference["sphere_density"] / fluid["density"] - 1.0
        gravity = [g * weight / (self.density - 1.0) for g in fluid["gravity"]]
        return [
            f"reference.sphere_density={self.density * fluid['density']!r}",
            f"fluid.gravity={gravity!r}",
        ]

    def variables(self) -> dict[str, str]:
        """Variables of in.liggghts."""
        own = {} if self.density is None else {"density": repr(self.density)}
        return own | self.given


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", default="setup2_small", help="default: setup2_small")
    parser.add_argument(
        "--models", nargs="+", default=list(PAPER_MODELS), metavar="MODEL",
        help="collision models (default: the paper's four)",
    )  # fmt: skip
    parser.add_argument(
        "--densities", nargs="+", type=float, metavar="RATIO",
        help="density ratios ρp/ρf; Fr stays, so gravity follows (default: the scene's own, for "
        "setup1 and setup1_small the paper's range 1.25 1.75 2.25)",
    )  # fmt: skip
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")
    parser.add_argument("--var", action="append", default=[], metavar="NAME=VALUE", help="as for run")
    parser.add_argument(
        "--discard", type=float, metavar="N",
        help="start-up that is left out, in flow-through times L_x/u_b (default: the scene's "
        f"statistics.from, {START_UP:g} without)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("runs/models"), help="folder of the runs")
    parser.add_argument("--report", type=Path, help="folder of the report (default: in --out)")
    parser.add_argument("--remarks", type=Path, help="a file of HTML that goes into the report")
    parser.add_argument(
        "--report-only", action="store_true", help="start nothing, report on what there is"
    )


def members(options: argparse.Namespace, scene: Scene) -> list[Member]:
    """All runs: every model at every density ratio."""
    densities: Sequence[float | None] = options.densities or [None]
    if options.densities is None and scene.name.startswith("setup1"):
        densities = [1.25, 1.75, 2.25]
    for density in densities:
        if density is not None and density <= 1.0:
            raise UserError(f"--densities has {density:g}, but grains must sink: above 1.")
    found = []
    for density in densities:
        for asked in options.models:
            model = choose_model(scene, asked)
            name = f"{scene.name}-{model}" + ("" if density is None else f"-{density:g}")
            given = read_variables(scene, model, options.var)
            found.append(Member(scene, model, density, (options.out / name).resolve(), given))
    return found


def finished(out: Path, end: float) -> bool:
    """Whether the run in `out` has reached the time `end` and written its last files."""
    try:
        history = Run(out).history()
    except MissingOutput:
        return False
    done = len(history["time"]) > 0 and history["time"][-1] > end - 0.75 * history["dt"][-1]
    return bool(done) and (out / "timing.csv").is_file()


def settings_of(scene: Scene, overrides: Sequence[str]) -> dict:
    """fluid.toml with the values of --set laid over it."""
    settings = tomllib.loads((scene.folder / "fluid.toml").read_text(encoding="utf-8"))
    for text in overrides:
        try:
            settings = _laid_over(settings, tomllib.loads(text))
        except tomllib.TOMLDecodeError as error:
            raise UserError(
                f"--set {text}: {error}; write it as in TOML, for instance time.end=20."
            ) from error
    return settings


def _laid_over(values: dict, others: dict) -> dict:
    """`values` with what `others` say in its place, table by table."""
    both = values | others
    for name in values.keys() & others.keys():
        if isinstance(values[name], dict) and isinstance(others[name], dict):
            both[name] = _laid_over(values[name], others[name])
    return both


def start_up(options: argparse.Namespace, scene: Scene) -> float:
    """Flow-throughs L_x/u_b that the report leaves out: as told, else as the scene's statistics do."""
    if options.discard is not None:
        return options.discard
    settings = settings_of(scene, options.set)
    try:
        velocity, length = settings["reference"]["velocity"], settings["grid"]["length"][0]
        return settings["statistics"]["from"] * velocity / length
    except KeyError:
        return START_UP


def run_member(member: Member, ranks: job.Ranks, overrides: Sequence[str]) -> int:
    """Starts a run, or goes on with it; returns the job's status."""
    settings = settings_of(member.scene, overrides)
    if finished(member.out, settings["time"]["end"]):
        print(f"bedload: {member.out.name} is done", flush=True)
        return 0
    going_on = any(member.out.glob("checkpoint_*"))
    if going_on:
        job.keep_part(member.out)
    elif (member.out / "settings.toml").is_file():
        # Nothing to go on from: its output would be mixed with the new run's.
        member.out.rename(_free_name(member.out))
    member.out.mkdir(parents=True, exist_ok=True)
    work = job.Job(
        member.scene, member.model, ranks, member.out,
        [*overrides, *member.overrides(settings)], variables=member.variables(),
        restart=member.out if going_on else None,
    )  # fmt: skip
    print(f"bedload: {work.summary()}{', going on' if going_on else ''}; {member.out}", flush=True)
    return job.run(work.command(), member.scene.folder)


def _free_name(out: Path) -> Path:
    number = 1
    while out.with_name(f"{out.name}.cut{number}").exists():
        number += 1
    return out.with_name(f"{out.name}.cut{number}")


def hours(out: Path) -> tuple[float, bool]:
    """Hours on the clock that the parts of a run took, and whether all of them have said it."""
    run = Run(out)
    tables = [run.table(file.name) for file in out.glob("timing.part*.csv")] + [run.timing()]
    seconds = sum(float(table["seconds_mean_over_ranks"].sum()) for table in tables)
    return seconds / 3600, len(tables) > len(list(out.glob("log.part*.liggghts")))


def circumstances(members_: Sequence[Member], ranks: job.Ranks) -> dict[str, str]:
    """When, what and where, and how many hours the runs took."""
    commit = subprocess.run(
        ["git", "-C", str(ROOT), "describe", "--always", "--dirty"],
        capture_output=True, text=True, check=False,
    ).stdout.strip()  # fmt: skip
    try:
        spent, told = zip(*(hours(member.out) for member in members_), strict=True)
        clock = ("" if all(told) else "more than ") + f"{sum(spent):.2f}"
    except MissingOutput:
        clock = "not known"
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "commit": commit or "unknown",
        "processor": f"{platform.machine()}, {cores()} cores",
        "ranks of each run": f"{ranks.fluid} of the fluid, {ranks.dem} of LIGGGHTS",
        "hours on the clock, all runs": clock,
    }


def report(options: argparse.Namespace, scene: Scene, runs: Sequence[Member]) -> Path:
    """Writes the report of all runs that have got beyond the start-up; returns its folder."""
    cases, described = [], []
    discard = start_up(options, scene)
    for member in runs:
        try:
            cases.append(make_case(member.model, Run(member.out), discard))
            described.append(member)
        except MissingOutput as missing:
            print(f"bedload: left out of the report: {missing}", flush=True)
    if not cases:
        raise UserError(f"no run in {options.out} has got beyond {discard:g} flow-throughs.")
    folder = options.report or options.out / f"report-{scene.name}"
    kept = folder / "circumstances.json"  # of runs made elsewhere, for instance in parts
    facts = circumstances(described, job.Ranks.parse(options.ranks))
    if kept.is_file():
        facts |= json.loads(kept.read_text(encoding="utf-8"))
    remarks = options.remarks.read_text(encoding="utf-8") if options.remarks else ""
    title = f"{scene.name}: {len({case.model for case in cases})} collision models"
    write(Comparison(title, cases, scene.name.startswith("setup2"), facts), folder, remarks)
    return folder


def run(options: argparse.Namespace) -> int:
    scene = find_scene(options.scene)
    if not scene.moves_grains:
        raise UserError(f"scene '{scene.name}' has no in.liggghts, so no collision models.")
    if unknown_models := set(options.models) - set(models()):
        choose_model(scene, sorted(unknown_models)[0])  # says which one, and the nearest
    runs = members(options, scene)
    ranks = job.Ranks.parse(options.ranks)
    if not options.report_only:
        for member in runs:
            status = run_member(member, ranks, options.set)
            if status != 0 or not finished(member.out, settings_of(scene, options.set)["time"]["end"]):
                print(f"bedload: {member.out.name} ended before its time, with status {status}; "
                      "give the command again to go on", flush=True)  # fmt: skip
                return status or 1
    print(f"bedload: report in {report(options, scene, runs)}", flush=True)
    return 0
