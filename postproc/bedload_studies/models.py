"""The paper's comparison: one scene with each collision model, then figures, Table 2 and a report.

Each run has a folder runs/models/SCENE-MODEL. One that has reached time.end is left alone, one that was
interrupted goes on from its last checkpoint, so the command may be given as often as one likes. Runs of
other programs, of another commit or of another scene are not gone on with, nor put into one report.
"""

import argparse
import contextlib
import datetime
import io
import json
import math
import platform
import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from bedload_launcher import job, presets
from bedload_launcher.build import BIN
from bedload_launcher.errors import UserError
from bedload_launcher.machine import cores
from bedload_launcher.numbers import finite, whole
from bedload_launcher.override import override_table
from bedload_launcher.scenes import Scene, choose_model, find_scene, models, read_variables
from bedload_post.bed_friction import bed_top, driving_friction, driving_friction_interval, side_walls
from bedload_post.model_figures import in_order
from bedload_post.model_numbers import Bed, make_case
from bedload_post.models_report import Comparison, rewrite, write
from bedload_post.other_records import Record
from bedload_post.outputs import MissingOutput, Run, UnknownContacts

from . import made_by, turbulence
from .earlier_run import EarlierRun
from .kept_numbers import kept_numbers, refuse_others

START_UP = 3.0  # flow-throughs L_x/u_b, of a scene that does not say
PAPER_MODELS = ("rpm", "rpm_hw", "actm", "actm_hw")
PAPER_DENSITIES, PAPER_DENSITY_2 = (1.25, 1.75, 2.25), 1.2  # Setup I, Setup II
BED = "bed"  # the run without mobile grains
# Of fluid.toml, as far as the studies read it (inputs/KEYS.md).
DEFAULTS = {"fluid": {"density": 1.0}, "reference": {"velocity": 1.0, "height": 1.0, "diameter": 1.0}}
REQUIRED = (
    ("grid", "cells"), ("grid", "length"), ("fluid", "kinematic_viscosity"), ("time", "step"), ("time", "end"),
)  # fmt: skip


@dataclass(frozen=True)
class Member:
    """One run of the comparison."""

    scene: Scene
    model: str
    density: float | None  # rho_p/rho_f, None: the scene's own
    gravity: float | None  # g, None: the scene's own
    out: Path
    given: Mapping[str, str]  # --var

    @property
    def grains(self) -> bool:
        """Whether there are mobile grains."""
        return self.given.get("placing") != "none"

    def overrides(self, settings: dict) -> list[str]:
        """Keys of fluid.toml that follow from another density or gravity; each varies alone."""
        keys = []
        if self.density is not None:
            keys.append(f"reference.sphere_density={self.density * settings['fluid']['density']!r}")
        if self.gravity is not None:
            keys.append(f"fluid.gravity={[0.0, -self.gravity, 0.0]!r}")
        return keys

    def variables(self) -> dict[str, str]:
        """Variables of in.liggghts."""
        own = {"density": self.density, "gravity": self.gravity}
        return {name: repr(v) for name, v in own.items() if v is not None} | dict(self.given)


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", default="setup2_small", help="default: setup2_small")
    parser.add_argument(
        "--models", nargs="+", default=list(PAPER_MODELS), metavar="MODEL",
        help="collision models (default: the paper's four)",
    )  # fmt: skip
    parser.add_argument(
        "--densities", nargs="+", type=finite, metavar="RATIO",
        help="density ratios ρp/ρf, gravity stays (default: the scene's own, for setup1 and "
        "setup1_small the paper's range 1.25 1.75 2.25)",
    )  # fmt: skip
    parser.add_argument(
        "--gravity", type=finite, metavar="G", help="g D/u_b² in place of the scene's own"
    )
    parser.add_argument(
        "--cells", type=whole(1), metavar="N",
        help="cells to a diameter (default: the scene's own); the time step follows, the collision "
        "models' scales stay",
    )  # fmt: skip
    parser.add_argument(
        "--flow-throughs", type=finite, metavar="N",
        help="length of each record behind the start-up, in L_x/u_b (default: as the scene says)",
    )  # fmt: skip
    parser.add_argument(
        "--start-from", type=Path, metavar="DIR",
        help="folder of an earlier study of this scene, at any resolution: flow and grains of each run "
        "begin as its run of that model ended",
    )  # fmt: skip
    parser.add_argument(
        "--no-bed", action="store_true",
        help="leave out the run without mobile grains, which gives Re_τ and the Shields number of "
        "the bed (made where many grains lie on it)",
    )  # fmt: skip
    parser.add_argument(
        "--other-commit", action="store_true",
        help="go on although the commit differs; programs and scene have to be the same still",
    )  # fmt: skip
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="as for run")
    parser.add_argument("--var", action="append", default=[], metavar="NAME=VALUE", help="as for run")
    parser.add_argument(
        "--discard", type=finite, metavar="N",
        help="start-up that is left out, in flow-through times L_x/u_b (default: the scene's "
        f"statistics.from, {START_UP:g} without)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("runs/models"), help="folder of the runs")
    parser.add_argument("--report", type=Path, help="folder of the report (default: in --out)")
    parser.add_argument(
        "--beside", nargs="+", type=Path, default=[], metavar="REPORT",
        help="folders of other reports of this study: those of the same settings make the trend with "
        "resolution, the mean velocities of others (experiments) stand beside these",
    )  # fmt: skip
    parser.add_argument(
        "--rewrite", nargs="+", type=Path, default=[], metavar="REPORT",
        help="only make the pages of kept reports anew from their numbers.json, and the figures that are "
        "drawn from it; --beside as kept, or as given with it",
    )  # fmt: skip
    parser.add_argument("--remarks", type=Path, help="a file of HTML that goes into the report")
    parser.add_argument(
        "--report-only", action="store_true", help="start nothing, report on what there is"
    )


def members(options: argparse.Namespace, scene: Scene) -> list[Member]:
    """All runs: every model at every density ratio, once each however often it was given."""
    densities: Sequence[float | None] = options.densities or [None]
    if options.densities is None and scene.name.startswith("setup1"):
        densities = PAPER_DENSITIES
    check(options, scene)
    found = []
    if with_bed(options, scene):
        out = (options.out / f"{scene.name}-{BED}").resolve()
        found.append(Member(scene, "actm", None, options.gravity, out, bed_variables(options, scene)))
    for density in dict.fromkeys(densities):
        for asked in dict.fromkeys(options.models):
            model = choose_model(scene, asked) or asked
            name = f"{scene.name}-{model}" + ("" if density is None else f"-{density:g}")
            given = read_variables(scene, model, variables_for(options, scene, model))
            out = (options.out / name).resolve()
            found.append(Member(scene, model, density, options.gravity, out, given))
    return found


def variables_for(options: argparse.Namespace, scene: Scene, model: str) -> list[str]:
    """Those of --var that this model's script reads, and those that no model of the study does, to be refused."""
    def read_by(text: str, by: str) -> bool:
        return scene.reads(text.partition("=")[0].strip(), {"model": by})

    asked = [choose_model(scene, name) or name for name in options.models]
    return [text for text in options.var
            if read_by(text, model) or not any(read_by(text, other) for other in asked)]  # fmt: skip


def bed_variables(options: argparse.Namespace, scene: Scene) -> dict[str, str]:
    """Of in.liggghts without mobile grains: those of --var that it reads whatever the collision model."""
    none = {"placing": "none"}
    known = scene.variables({"model": ""} | none)
    names = {text: text.partition("=")[0].strip() for text in options.var}
    texts = [text for text, name in names.items() if name in known and scene.reads(name, {"model": "actm"} | none)]
    return read_variables(scene, "actm", texts) | none


def check(options: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError for values that make no study."""
    for density in options.densities or []:
        if density <= 1.0:
            raise UserError(f"--densities has {density:g}, but grains must sink: above 1.")
    if options.gravity is not None and not options.gravity > 0.0:
        raise UserError(f"--gravity is {options.gravity:g}, but must be above 0.")
    if options.flow_throughs is not None and not options.flow_throughs > 0.0:
        raise UserError(f"--flow-throughs is {options.flow_throughs:g}, but must be above 0.")
    if options.discard is not None and options.discard < 0.0:
        raise UserError(f"--discard is {options.discard:g}, but must be at least 0.")
    # LIGGGHTS would not miss a variable that its script does not read: the grains would keep their own value.
    for option, name in (("densities", "density"), ("gravity", "gravity")):
        if getattr(options, option) and name not in scene.variables():
            raise UserError(f"--{option}: {scene.script} has no line 'variable {name} index VALUE', so the grains "
                            "would keep their own.")  # fmt: skip


def with_bed(options: argparse.Namespace, scene: Scene) -> bool:
    """Whether the bed without mobile grains is run too: where many drag at the flow, and no side walls bear a part of
    what drives it."""
    settings = settings_of(scene, options.set)
    return not options.no_bed and scene.variables().get("placing") == "dropped" and not side_walls(settings)


def asked_settings(options: argparse.Namespace, scene: Scene) -> list[str]:
    """--set with what --cells, --discard and --flow-throughs say in front of it."""
    own = []
    settings = settings_of(scene, options.set)
    if options.cells is not None:
        own += refined(settings_of(scene, []), options.cells, settings)
    if options.flow_throughs is not None:
        through = settings["grid"]["length"][0] / settings["reference"]["velocity"]
        discard = start_up(options, scene)
        own.append(f"time.end={(discard + options.flow_throughs) * through!r}")
        own.append(f"statistics.from={discard * through!r}")
    return [*own, *options.set]


def refined(settings: dict, cells: int, asked: dict | None = None) -> list[str]:
    """Grid and time step with so many cells to a diameter, at the Courant number of the scene's `settings`; `asked`:
    settings of another box or diameter."""
    box = asked or settings
    length, diameter = box["grid"]["length"], box["reference"]["diameter"]
    grid = [round(edge / diameter * cells) for edge in length]
    own = settings["grid"]["length"][0] / settings["grid"]["cells"][0]
    step = settings["time"]["step"] * length[0] / grid[0] / own
    return [f"grid.cells={grid}", f"time.step={float(f'{step:.6g}')!r}"]


def finished(out: Path, end: float) -> bool:
    """Whether the run in `out` has reached the time `end` and written its last files."""
    try:
        history = Run(out).history()
    except MissingOutput:
        return False
    done = len(history["time"]) > 0 and history["time"][-1] > end - 0.75 * history["dt"][-1]
    return bool(done) and (out / "timing.csv").is_file()


def settings_of(scene: Scene, overrides: Sequence[str]) -> dict:
    """fluid.toml over the DEFAULTS, with the values of --set laid over it.

    Raises UserError where a key is missing that has no default.
    """
    file = scene.folder / "fluid.toml"
    settings = laid_over(DEFAULTS, scene.settings())
    for text in overrides:
        settings = laid_over(settings, override_table(text))
    for table, key in REQUIRED:
        if key not in settings.get(table, {}):
            raise UserError(f"{file}: the key '{table}.{key}' is missing.")
    return settings


def laid_over(values: dict, others: dict) -> dict:
    """`values` with what `others` say in its place, table by table."""
    both = values | others
    for name in values.keys() & others.keys():
        if isinstance(values[name], dict) and isinstance(others[name], dict):
            both[name] = laid_over(values[name], others[name])
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


def earlier(member: Member, start_from: Path | None) -> EarlierRun | None:
    """The earlier run that this one begins with: of its name, or the bed's of any with grains."""
    return None if start_from is None else EarlierRun.of(start_from / member.out.name)


def begin(member: Member, start_from: Path | None) -> list[str]:
    """Keys of fluid.toml for a flow that an earlier run left."""
    run = earlier(member, start_from)
    return [] if run is None else run.keys()


def placed(member: Member, start_from: Path | None) -> dict[str, str]:
    """Variables of in.liggghts for grains where an earlier run left them."""
    run = earlier(member, start_from)
    if run is None or not member.grains:
        return {}
    run.place(member.out)
    return run.variables(member.scene)


def run_member(
    member: Member, ranks: job.Ranks, overrides: Sequence[str],
    start_from: Path | None = None, other_commit: bool | None = None,
) -> int:  # fmt: skip
    """Starts a run, or goes on with it; returns the job's status."""
    settings = settings_of(member.scene, overrides)
    if finished(member.out, settings["time"]["end"]):
        refuse_other(member.out, [*overrides, *member.overrides(settings)])
        print(f"bedload: {member.out.name} is done", flush=True)
        return 0
    going_on = taken_up(member.out)
    work = job.Job(
        member.scene, member.model, ranks, member.out,
        [*overrides, *member.overrides(settings), *begin(member, start_from)],
        variables=member.variables() | placed(member, start_from),
        restart=member.out if going_on else None,
    )  # fmt: skip
    made_by.note(member.out, made_by.now(work, BIN), other_commit)
    print(f"bedload: {work.summary()}{', going on' if going_on else ''}; {member.out}", flush=True)
    return job.run(work.command(), member.scene.folder)


def refuse_other(out: Path, overrides: Sequence[str], may_differ: tuple[str, ...] | None = None) -> None:
    """Raises UserError where the run in `out` has other values than `overrides` (KEY=VALUE) say, but for keys that
    begin with one of `may_differ`, of their own accord NO_SETTINGS."""
    settings = Run(out).settings
    skipped = NO_SETTINGS if may_differ is None else may_differ
    for text in overrides:
        asked = override_table(text)
        if not text.startswith(skipped) and '"auto"' not in text and laid_over(settings, asked) != settings:
            raise UserError(f"{out} holds a run without {text}, which is this study's: name another folder with "
                            "--out, or start anew without the folder.")  # fmt: skip


def taken_up(out: Path) -> bool:
    """Makes the folder `out` ready for a run; whether one there goes on from its last checkpoint."""
    going_on = any(out.glob("checkpoint_*"))
    if going_on:
        job.keep_part(out)
    elif (out / "settings.toml").is_file():
        # Nothing to go on from: its output would be mixed with the new run's.
        out.rename(_free_name(out))
    out.mkdir(parents=True, exist_ok=True)
    return going_on


def _free_name(out: Path) -> Path:
    number = 1
    while out.with_name(f"{out.name}.cut{number}").exists():
        number += 1
    return out.with_name(f"{out.name}.cut{number}")


def hours(out: Path) -> tuple[float, bool]:
    """Hours on the clock that the parts of a run took, and whether all of them have said it."""
    tables, told = Run(out).timings()
    seconds = sum(float(table["seconds_mean_over_ranks"].sum()) for table in tables)
    return seconds / 3600, told


def circumstances(
    members_: Sequence[Member], ranks: job.Ranks, made: str = ""
) -> dict[str, str]:
    """When, what (`made`: the commit) and where, and how many hours the runs took; `ranks` are those of
    the command, for runs that do not say theirs."""
    each = [job.Ranks.parse(made_by.ranks_of(member.out)) if made_by.ranks_of(member.out) else ranks
            for member in members_]  # fmt: skip
    try:
        spent, told = zip(*(hours(member.out) for member in members_), strict=True)
        more = "" if all(told) else "more than "
        clock = f"{more}{sum(spent):.2f}"
        core = f"{more}{sum(h * r.fluid for h, r in zip(spent, each, strict=True)):.2f}"
    except MissingOutput:
        clock = core = "not known"
    # Other studies of these runs say their command themselves.
    words = sys.argv[sys.argv.index("models") + 1 :] if "models" in sys.argv else None
    command = {"command": "./bedload study models " + shlex.join(words)} if words is not None else {}
    return command | {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "commit": made or "unknown",
        "processor": f"{platform.machine()}, {cores()} cores",
        "ranks of each run": "; ".join(
            dict.fromkeys(f"{r.fluid} of the fluid, {r.dem} of LIGGGHTS" for r in each)
        ),
        "hours on the clock, all runs": clock,
        "core-hours of the fluid's ranks": core,
    }


def report(options: argparse.Namespace, scene: Scene, runs: Sequence[Member]) -> Path:
    """Writes the report of all runs that have got beyond the start-up; returns its folder."""
    cases, described = [], []
    discard = start_up(options, scene)
    bed = None
    for member in runs:
        try:
            if member.grains:
                cases.append(make_case(member.model, Run(member.out), discard))
            else:
                bed = measured_bed(Run(member.out), discard)
            described.append(member)
        except UnknownContacts as unknown_contacts:
            raise UserError(str(unknown_contacts)) from unknown_contacts
        except MissingOutput as missing:
            print(f"bedload: left out of the report: {missing}", flush=True)
    if not cases:
        raise UserError(f"no run in {options.out} has got beyond {discard:g} flow-throughs.")
    folder = options.report or options.out / f"report-{scene.name}"
    kept = folder / "circumstances.json"  # of runs made elsewhere, for instance in parts
    made = made_by.of_all([member.out for member in described], options.other_commit)
    facts = circumstances(described, job.Ranks.parse(options.ranks), made)
    if bed is not None:
        facts["bed without mobile grains"] = f"Re_τ {bed.reynolds:.0f}, {bed.source}"
    if kept.is_file():
        facts |= json.loads(kept.read_text(encoding="utf-8"))
    remarks = options.remarks.read_text(encoding="utf-8") if options.remarks else ""
    cases.sort(key=lambda case: in_order(case.model, case.density_ratio))
    own = facts.get("command", "")
    beside = [record_of(folder, own) for folder in options.beside]
    folder.mkdir(parents=True, exist_ok=True)
    facts |= keep_correlations(cases[0].run, cases[0].since, folder)
    title = title_of(scene.name, {case.model for case in cases})
    setup = setup_of(scene.name, options)
    write(Comparison(title, cases, setup, facts, bed, scene.name, beside), folder, remarks)
    return folder


def title_of(scene: str, names: set[str]) -> str:
    return f"{scene}: {len(names)} collision model{'s' if len(names) > 1 else ''}"


def setup_of(scene: str, options: argparse.Namespace | None) -> int:
    """Which of the paper's setups a scene repeats; 0: neither. Setup II has one density and one gravity."""
    changed = options is not None and (
        options.gravity is not None or any(density != PAPER_DENSITY_2 for density in options.densities or [])
    )
    return 1 if scene.startswith("setup1") else 2 if scene.startswith("setup2") and not changed else 0


def record_of(folder: Path, own_command: str) -> Record:
    """The runs of another report beside one that was made by `own_command`."""
    kept = kept_numbers(folder, NEEDED)
    other = settings_said(kept["circumstances"].get("command", ""))
    same = other is not None and other == settings_said(own_command)
    return Record(folder.name, kept["runs"], same, kept["circumstances"].get("commit", ""))


NEEDED = ("runs", "circumstances")  # of numbers.json

# Keys of --set that do not change what is computed, but for how long and from where on.
NO_SETTINGS = ("time.", "statistics.", "output.", "start.")


def told(command: str) -> argparse.Namespace | None:
    """The options of a kept command of this study; None where it is none."""
    _, found, words = command.partition("study models")
    parser = argparse.ArgumentParser()
    add_options(parser)
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            return parser.parse_args(shlex.split(words)) if found else None
    except SystemExit:  # an option that is no more
        return None


def settings_said(command: str) -> tuple | None:
    """What a command says of scene and settings but for resolution, models, densities and length."""
    options = told(command)
    if options is None:
        return None
    keys = sorted(text for text in options.set if not text.startswith(NO_SETTINGS))
    return options.scene, options.gravity, sorted(options.var), keys


def rewrite_kept(folder: Path, beside: Sequence[Path]) -> None:
    """Pages and figures of the kept report in `folder` anew from its numbers; `beside`: other reports in place of
    those that its command names, as far as these are there, and of what it has kept of them."""
    kept = kept_numbers(folder, NEEDED)
    command = kept["circumstances"].get("command", "")
    options = told(command)
    scene = kept.get("scene") or (options.scene if options else "")
    named = beside or [file for file in (options.beside if options else []) if (file / "numbers.json").is_file()]
    records = {record["name"]: Record(**record) for record in kept.get("beside", [])} if not beside else {}
    records |= {file.name: record_of(file, command) for file in named}
    title = title_of(scene, {v["model"] for v in kept["runs"]})
    today = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
    facts = kept["circumstances"] | {"page made anew from the numbers": today}
    setup = setup_of(scene, options)
    rewrite(Comparison(title, [], setup, facts, None, scene, list(records.values())), kept, folder)


def keep_correlations(run: Run, since: float, folder: Path) -> dict[str, str]:
    """Two-point correlations of the flow, where snapshots were kept behind the start-up: a figure, and a line on
    what is left at half the box, along directions that are periodic."""
    (folder / "correlations.png").unlink(missing_ok=True)  # of an earlier report
    periodic = [math.isfinite(run.periods[d]) for d in (0, 2)]
    if not any(periodic):
        return {}
    heights = [bed_top(run) + share * run.depth for share in (0.1, 0.3, 0.7)]
    try:
        along_x, along_z, count = turbulence.correlations(run, heights, since)
    except MissingOutput:
        return {}
    turbulence.draw(run, heights, along_x, along_z, folder / "correlations.png")
    at = ", ".join(f"{height / run.diameter:.2g}" for height in heights)
    left = ", ".join(
        f"along {name} " + ", ".join(f"{line[-1]:.2f}" for line in along)
        for name, along, told in zip("xz", (along_x, along_z), periodic, strict=True)
        if told
    )
    return {"correlation of u left at half the box": f"{left} at y = {at} D, {count} snapshots"}


def measured_bed(run: Run, discard: float) -> Bed:
    """Friction of the bed without mobile grains, from `discard` flow-throughs on.

    From the driving force, which is what the bed takes up at every instant where the bulk velocity is held;
    the stress of the outer flow lags behind it for hundreds of D/u_b after the grains are gone.
    """
    if side_walls(run.settings):
        raise MissingOutput(f"the side walls of {run.folder} bear a part of the driving force: no friction velocity.")
    since = discard * run.box[0] / run.bulk_velocity
    last = float(run.history()["time"][-1])
    friction = driving_friction(run, since)
    if not friction > 0:
        raise MissingOutput(f"{run.folder} has no driving force after t = {since:g}.")
    scale = run.depth / run.viscosity
    late = driving_friction(run, 0.5 * (since + last)) * scale
    source = f"driving force times depth, t = {since:g} to {last:.4g}; second half {late:.0f}"
    half = driving_friction_interval(run, since) * scale
    return Bed(friction / run.bulk_velocity, friction * scale, source, half)


def run(options: argparse.Namespace) -> int:
    if options.rewrite:
        refuse_others(options, add_options, ["rewrite", "beside"])
        for folder in options.rewrite:
            rewrite_kept(folder, options.beside)
            print(f"bedload: {folder} anew from its numbers", flush=True)
        return 0
    scene = find_scene(options.scene)
    if not scene.moves_grains:
        raise UserError(f"scene '{scene.name}' has no in.liggghts, so no collision models.")
    if unknown_models := set(options.models) - set(models()):
        choose_model(scene, sorted(unknown_models)[0])  # says which one, and the nearest
    for folder in options.beside:
        kept_numbers(folder, NEEDED)  # found wrong before the long runs, not behind them
    if options.remarks and not options.remarks.is_file():
        raise UserError(f"--remarks is {options.remarks}, which is no file.")
    runs = members(options, scene)
    if options.cells is not None:
        presets.warn_of_counted_steps(scene, scene.default_model())
    ranks = job.Ranks.parse(options.ranks)
    asked = asked_settings(options, scene)
    if not options.report_only:
        for member in runs:
            status = run_member(member, ranks, asked, options.start_from, options.other_commit)
            if status != 0 or not finished(member.out, settings_of(scene, asked)["time"]["end"]):
                print(f"bedload: {member.out.name} ended before its time, with status {status}; "
                      "give the command again to go on", flush=True)  # fmt: skip
                return status or 1
    print(f"bedload: report in {report(options, scene, runs)}", flush=True)
    return 0
