"""`./bedload run`: what is asked, put together with what an earlier run was told, becomes one MPI job."""

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from . import folders, job, presets
from .build import build
from .errors import UserError
from .folders import Folder, Launch
from .scenes import DEFAULT, Scene, choose_model, find_scene, models, read_variables
from .words import plain


@dataclass(frozen=True)
class Ask:
    """The options of the command line, as they stand there; None, and no `sets` or `variables`: nothing was said."""

    scene: str | None = None
    model: str | None = None
    accuracy: str | None = None
    sets: Sequence[str] = ()
    variables: Sequence[str] = ()
    ranks: str | None = None
    steps: int | None = None
    out: Path | None = None
    restart: Path | None = None


def run_folder(restart: Path) -> Path:
    """The folder of the run that `--restart` names, itself or by one of its checkpoints."""
    return restart.parent if restart.name.startswith("checkpoint_") else restart


def last_checkpoint(out: Path) -> Path | None:
    """The newest checkpoint of the run in `out`."""
    return max(out.glob("checkpoint_" + "[0-9]" * 8), default=None)


def check_restart(restart: Path) -> None:
    """Refuses what holds no checkpoint."""
    if not restart.is_dir() or (restart == run_folder(restart) and last_checkpoint(restart) is None):
        raise UserError(f"--restart {restart}: is neither a checkpoint nor a run that holds one.")


def check_same_model(restart: Path, before: str | None, model: str | None) -> None:
    """Refuses another model than the run's, as bedload-dem does: what one keeps of a contact no other can read.

    Models of a scene's own may be alike in that; bedload-dem judges them.
    """
    if before != model and {before, model} <= set(models()):
        state = run_folder(restart) / "state.h5"
        raise UserError(
            f"--restart {restart}: the run has the model '{before}', and its contacts cannot go on with '{model}'; "
            f"begin a new run, which can take its flow: ./bedload run SCENE --model {model} --set start.from=state "
            f"--set start.file={shlex.quote(str(state))}"
        )


def with_memory(ask: Ask, before: Launch | None) -> Launch:
    """How the run is started: what is asked, and for all else what the run that goes on was told."""
    if before is None:
        scene = find_scene(DEFAULT if ask.scene is None else ask.scene)
        before = Launch(str(scene.folder))
    scene = find_scene(before.scene if ask.scene is None else ask.scene)
    if not scene.moves_grains and (before.model or before.variables):  # what only a run with grains was told
        raise UserError(
            f"--restart {ask.restart}: the run has grains, but scene '{scene.name}' has no in.liggghts; begin a new "
            "run, which can take its flow: ./bedload run SCENE --set start.from=state --set start.file=RUN/state.h5."
        )
    model = choose_model(scene, before.model if ask.model is None else ask.model)
    given = folders.merged([f"{n}={v}" for n, v in before.variables.items()], ask.variables)
    variables = read_variables(scene, model, given)
    return Launch(
        str(scene.folder), model, before.accuracy if ask.accuracy is None else ask.accuracy,
        folders.merged(before.sets, ask.sets), variables, before.ranks if ask.ranks is None else ask.ranks,
    )  # fmt: skip


def output_folder(ask: Ask, scene: Scene, launch: Launch, restart: Path | None) -> Path:
    """--out; the folder of the run that goes on; runs/SCENE-MODEL-ACCURACY."""
    if ask.out is not None:
        if ask.out.exists() and not ask.out.is_dir():
            raise UserError(f"--out is {ask.out}, which is a file, but has to be a folder.")
        return ask.out.resolve()
    if restart is not None:
        return run_folder(restart)
    name = "-".join(filter(None, (scene.name, launch.model, launch.accuracy)))
    return (Path("runs") / name).resolve()


def checkpoint_mark(out: Path) -> tuple[str, int, int] | None:
    """Tells the last checkpoint in `out` from the next one: a run that has made a step writes one at its end."""
    last = last_checkpoint(out)
    found = last.stat() if last else None
    return (last.name, found.st_ino, found.st_mtime_ns) if last and found else None


def start(ask: Ask) -> tuple[int, Path]:
    """Builds, takes the folder, runs the job; returns its status and its folder."""
    restart = ask.restart.resolve() if ask.restart is not None else None
    if restart is not None:
        check_restart(restart)
    before = Launch.read(run_folder(restart)) if restart else None
    if restart is not None and before is None and ask.scene is None:
        raise UserError(
            f"--restart {restart}: its run was not started by ./bedload run, so nothing there says which scene it is; "
            "name it: ./bedload run SCENE --restart …"
        )
    launch = with_memory(ask, before)
    if restart is not None and before is not None:
        check_same_model(restart, before.model, launch.model)
    scene = find_scene(launch.scene)
    settings = presets.settings_of(launch.accuracy, scene, list(launch.sets), launch.model)
    out = output_folder(ask, scene, launch, restart)
    ranks = job.Ranks.parse(launch.ranks, scene)
    work = job.Job(scene, launch.model, ranks, out, settings, ask.steps, launch.variables, restart)
    work.command()  # its mistakes are found before anything in the folder moves
    build(["bedload-fluid", "bedload-dem"] if scene.moves_grains else ["bedload-fluid"])
    aside = None
    goes_on = restart is not None and run_folder(restart) == out
    with Folder(out) as folder:
        mark, reached = folders.settings_mark(out), checkpoint_mark(out)
        moved = job.keep_part(out) if goes_on else {}
        if not goes_on and (aside := folder.make_room()):
            print(f"bedload: the earlier run there is now {plain(str(aside))}", flush=True)
        noted = folder.note(launch)
        if restart is not None and launch.said():
            print(f"bedload: with {plain(launch.said())}", flush=True)
        print(f"bedload: {plain(work.summary())}; output in {plain(str(out))}", flush=True)
        job.warn_of_crowding(ranks)
        status = job.run_job(work)
        taken_back = status != 0 and aside is not None and folder.take_back(aside)
        refused = status != 0 and folders.settings_mark(out) == mark
        if goes_on and (refused or (status == 0 and checkpoint_mark(out) == reached)):  # or nothing was left to do
            folder.put_back(noted)
            for name, part in moved.items():
                part.replace(name)
    if taken_back:
        print(
            f"bedload: the run was refused with status {status} before its first step; the earlier run is {out} again",
            file=sys.stderr,
        )
        return status, out
    if goes_on and refused:  # the programs have said what to go on from, if anything
        print(f"bedload: the run was refused with status {status} before its first step; {out} is as it was",
              file=sys.stderr)  # fmt: skip
    elif status != 0:
        last = last_checkpoint(out)
        how = f"; go on with --restart {shlex.quote(str(last))}" if last else ""
        print(f"bedload: the run ended with status {status}; its output is {out}{how}", file=sys.stderr)
    elif scene.moves_grains and (advice := job.advice_on_ranks(out, ranks)):
        print(f"bedload: {advice}", flush=True)
    return status, out
