"""Onset of motion: share of moving grains and transport rate over the Shields number, for each collision model.

The Shields number is that of the bed without mobile grains, whose friction velocity a run of its own
measures first; gravity then sets it. Each run has a folder runs/threshold/MODEL-SHIELDS; one that is done is
left alone, one that was interrupted goes on, so the command may be given as often as one likes.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.numbers import finite
from bedload_launcher.scenes import Scene, choose_model, find_scene
from bedload_post import incipient_motion as motion
from bedload_post.bed_friction import side_walls
from bedload_post.batches import estimate_over_time
from bedload_post.frames import frames
from bedload_post.incipient_motion import Point
from bedload_post.model_figures import MODELS
from bedload_post.outputs import MissingOutput, Run, UnknownContacts
from bedload_post.states import RESTING, RESTING_SPEED
from bedload_post.transport import measure

from . import made_by, models
from .kept_numbers import refuse_others
from .threshold_report import Experiment, rewrite, write

# Of the scene, what the report says or its numbers are made with.
SCENE_KEYS = (
    ("grid", "length"), ("fluid", "density"), ("fluid", "kinematic_viscosity"), ("reference", "velocity"),
    ("reference", "diameter"), ("reference", "sphere_density"),
)  # fmt: skip
MAY_DIFFER = ("time.step", "statistics.", "output.")
SAME_SHIELDS = 1e-6  # between the Shields number of a run and the one that it was made for, by round-off
SHIELDS = (0.01, 0.017, 0.024, 0.033, 0.045, 0.06, 0.085, 0.12)


@dataclass(frozen=True)
class Plan:
    """What all runs of the study have in common."""

    scene: Scene
    cells_per_diameter: int
    throughs: float  # length of a run, in L_x/u_b
    discard: float  # of them, left out as start-up
    out: Path

    @property
    def settings(self) -> dict:
        return models.settings_of(self.scene, [])

    @property
    def time_unit(self) -> float:
        """A flow-through L_x/u_b [T]."""
        return self.settings["grid"]["length"][0] / self.settings["reference"]["velocity"]

    def overrides(self) -> list[str]:
        """Keys of fluid.toml: the grid, a step of the scene's Courant number, the end."""
        s = self.settings
        old = s["grid"]["cells"][0] / s["grid"]["length"][0]
        every = s.get("statistics", {}).get("every", 0)  # 0: none are taken
        every = max(1, round(every * self.cells_per_diameter / old)) if every else 0
        return [
            *models.refined(s, self.cells_per_diameter),
            f"time.end={self.throughs * self.time_unit!r}",
            f"statistics.from={self.discard * self.time_unit!r}",
            f"statistics.every={every}",
            "output.fields_every=0.0",
        ]

    def bare_bed(self) -> models.Member:
        """The run that measures the bed's friction velocity."""
        out = (self.out / models.BED).resolve()
        return models.Member(self.scene, "actm", None, None, out, {"placing": "none"})

    def member(self, model: str, shields: float, gravity: float) -> models.Member:
        """The run of a collision model at a Shields number."""
        out = (self.out / f"{model}-{shields:g}").resolve()
        return models.Member(self.scene, model, None, gravity, out, {})


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scene", default="setup2_small", help="default: setup2_small")
    parser.add_argument(
        "--models", nargs="+", default=list(models.PAPER_MODELS), metavar="MODEL",
        help="collision models (default: the paper's four)",
    )  # fmt: skip
    parser.add_argument(
        "--shields", nargs="+", type=finite, default=list(SHIELDS), metavar="THETA",
        help=f"Shields numbers (default: {' '.join(f'{s:g}' for s in SHIELDS)})",
    )  # fmt: skip
    parser.add_argument("--cells", type=int, default=6, help="cells to a diameter (default: 6)")
    parser.add_argument(
        "--throughs", type=finite, default=12.0,
        help="length of each run in flow-through times L_x/u_b (default: 12)",
    )  # fmt: skip
    parser.add_argument(
        "--discard", type=finite, default=4.0, help="of them, left out as start-up (default: 4)"
    )
    parser.add_argument("--ranks", metavar="FLUID:DEM", help="as for run")
    parser.add_argument("--out", type=Path, default=Path("runs/threshold"), help="folder of the runs")
    parser.add_argument("--report", type=Path, help="folder of the report (default: in --out)")
    parser.add_argument(
        "--report-only", action="store_true", help="start nothing, report on what there is"
    )
    parser.add_argument(
        "--rewrite", type=Path, metavar="REPORT",
        help="only make the page of a kept report anew from its numbers.json, and the figure drawn from it",
    )  # fmt: skip


def check(options: argparse.Namespace, scene: Scene) -> None:
    """Raises UserError for values that make no study."""
    if not (models.settings_of(scene, []).get("reference", {}).get("sphere_density")):
        raise UserError(f"scene '{scene.name}' has no reference.sphere_density, so no Shields number.")
    if side_walls(models.settings_of(scene, [])):
        raise UserError(f"scene '{scene.name}' has side walls, which bear a part of the driving force, "
                        "so no Shields number.")  # fmt: skip
    # LIGGGHTS would not miss a variable that its script does not read: the bed would not be bare, gravity not set.
    for name, what in (("placing", "NAME"), ("gravity", "VALUE")):
        if name not in scene.variables():
            raise UserError(f"{scene.script} has no line 'variable {name} index {what}', which this study sets.")
    for value in options.shields:
        if not value > 0.0:
            raise UserError(f"--shields has {value:g}, but a Shields number is above 0.")
    if not 0.0 <= options.discard < options.throughs:
        raise UserError(
            f"--discard is {options.discard:g}, but must be below --throughs, {options.throughs:g}."
        )
    if options.cells < 4:
        raise UserError(f"--cells is {options.cells}, but a sphere needs four cells at least.")
    for model in options.models:
        choose_model(scene, model)


def gravity_for(shields: float, friction: float, settings: dict) -> float:
    """g [L/T^2] = u_tau^2/((s - 1) theta D)."""
    reference = settings["reference"]
    excess = reference["sphere_density"] / settings["fluid"]["density"] - 1.0
    return friction**2 / (excess * shields * reference["diameter"])


def refuse_other(out: Path, plan: Plan) -> None:
    """Raises UserError where the run in `out` is of another scene, grid or length than the plan."""
    settings = plan.settings
    scene = [f"{table}.{key}={settings[table][key]!r}" for table, key in SCENE_KEYS]
    models.refuse_other(out, [*scene, *plan.overrides()], MAY_DIFFER)


def refuse_other_shields(run: Run, shields: float, friction: float, discard: float) -> None:
    """Raises UserError where the run's own gravity gives another Shields number than `shields`."""
    weight = run.submerged_weight / run.value("fluid.density")
    found = friction**2 / (weight * run.diameter)
    if abs(found - shields) > SAME_SHIELDS * shields:
        raise UserError(f"{run.folder} holds a run at a Shields number of {found:.6g}, not {shields:g}, with the bed's "
                        f"friction after {discard:g} flow-throughs: give the --discard that it was made with, "
                        "or name another folder with --out.")  # fmt: skip


def point_of(run: Run, model: str, shields: float, since: float) -> Point:
    """The numbers of one run from the time `since` on."""
    grains = measure(run, since)
    time, share, count, flux = [], [], [], []
    area = run.box[0] * run.box[2]
    for part in frames(run.sample_blocks(since=since)):
        speed = np.linalg.norm(part.velocity, axis=-1)
        time.append(part.time)
        share.append((speed > RESTING_SPEED * run.bulk_velocity).mean(axis=1))
        count.append(np.full(len(part.time), speed.shape[1]))
        flux.append(motion.flux_of(part.velocity[..., 0], part.radius, area))
    weight = run.submerged_weight / run.value("fluid.density")
    scale = motion.flux_scale(run.diameter, weight)
    instants, batches = np.concatenate(time), grains.batches
    return Point(
        model, shields,
        moving=estimate_over_time(
            instants, np.concatenate(share), batches=batches, counts=np.concatenate(count)
        ),
        not_resting=motion.complement(grains.share_of(RESTING)),
        velocity=grains.mean("velocity"),
        transport=estimate_over_time(instants, np.concatenate(flux) / scale, batches=batches),
    )


def complete(member: models.Member, plan: Plan, ranks: job.Ranks) -> None:
    """Runs a member to its end; raises UserError when it does not get there."""
    status = models.run_member(member, ranks, plan.overrides())
    end = models.settings_of(plan.scene, plan.overrides())["time"]["end"]
    if status != 0 or not models.finished(member.out, end):
        raise UserError(f"{member.out} ended before its time, with status {status}; "
                        "give the command again to go on.")  # fmt: skip


def experiment(plan: Plan, options: argparse.Namespace) -> Experiment:
    """All runs, or what there is of them, and their points."""
    ranks, since = job.Ranks.parse(options.ranks), plan.discard * plan.time_unit
    bare = plan.bare_bed()
    if options.report_only:
        refuse_other(bare.out, plan)
    else:
        complete(bare, plan, ranks)
    bed_run = Run(bare.out)
    bed = models.measured_bed(bed_run, plan.discard)
    friction = bed.u_tau * bed_run.bulk_velocity
    half_width = friction * bed.reynolds_interval / bed.reynolds
    settings, points, runs = plan.settings, [], [bare]
    outputs: dict[tuple[str, float], Run] = {}
    for shields in sorted(set(options.shields)):
        gravity = gravity_for(shields, friction, settings)
        for model in dict.fromkeys(options.models):
            member = plan.member(model, shields, gravity)
            if not options.report_only:
                complete(member, plan, ranks)
            try:
                run = Run(member.out)
                if options.report_only:
                    refuse_other(member.out, plan)
                    refuse_other_shields(run, shields, friction, plan.discard)
                points.append(point_of(run, model, shields, since))
                outputs[model, shields] = run
                runs.append(member)
            except UnknownContacts as unknown_contacts:
                raise UserError(str(unknown_contacts)) from unknown_contacts
            except MissingOutput as missing:
                print(f"bedload: left out of the report: {missing}", flush=True)
    if not points:
        raise UserError(f"no run in {plan.out} has got beyond {plan.discard:g} flow-throughs.")
    found = Experiment(
        plan.scene.name, plan.cells_per_diameter, plan.throughs, plan.discard, friction, bed.source,
        settings["fluid"]["kinematic_viscosity"], settings["reference"]["diameter"],
        settings["reference"]["sphere_density"] / settings["fluid"]["density"],
        points, models.circumstances(runs, ranks, made_by.of_all([r.out for r in runs])), half_width,
    )  # fmt: skip
    nearest = min({p.shields for p in points}, key=lambda shields: abs(np.log(shields / found.shields_threshold)))
    return replace(found, shown=[
        (MODELS.get(model, (model,))[0], one) for (model, shields), one in outputs.items() if shields == nearest
    ])  # fmt: skip


def run(options: argparse.Namespace) -> int:
    if options.rewrite:
        refuse_others(options, add_options, ["rewrite"])
        rewrite(options.rewrite)
        print(f"bedload: {options.rewrite} anew from its numbers", flush=True)
        return 0
    scene = find_scene(options.scene)
    check(options, scene)
    plan = Plan(scene, options.cells, options.throughs, options.discard, options.out)
    found = experiment(plan, options)
    folder = options.report or options.out / "report"
    write(found, folder)
    print(f"bedload: report in {folder}", flush=True)
    return 0
