"""What a run was made by: commit, programs, scene. Runs of different ones do not make one record."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_launcher.version import commit

FILE = "made_by.json"  # in a run's folder
WORDS = {"commit": "the commit", "programs": "the programs", "scene": "the scene's files"}


def now(work: job.Job, programs: Path) -> dict[str, str]:
    """Commit, and digests of both programs and of the scene as this job reads it."""
    files = [programs / name for name in ("bedload-fluid", "bedload-dem")]
    chosen = dict(work.variables) | ({"model": work.model} if work.model else {})
    script = "\n".join(work.scene.script_lines(chosen)) if work.scene.moves_grains else ""
    scene = work.scene.settings_text() + script
    return {
        "commit": commit() or "unknown",
        "programs": _digest(b"".join(file.read_bytes() for file in files if file.is_file())),
        "scene": _digest(scene.encode()),
        "model": work.model or "",
        "ranks": f"{work.ranks.fluid}:{work.ranks.dem}",
    }


def note(out: Path, made: dict[str, str], other_commit: bool | None = None) -> None:
    """Keeps `made` beside the run in `out`; refuses to go on with a run that was made by another.

    other_commit: what --other-commit says, None of a study without it.
    """
    if before := check(out, made, other_commit):
        made = made | {"commit": _both(before["commit"], made["commit"])}
    (out / FILE).write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


def check(out: Path, made: dict[str, str], other_commit: bool | None = None) -> dict[str, str]:
    """What the run in `out` was made by, empty where that is not known; refuses one that was made by another."""
    file = out / FILE
    if not file.is_file():
        return {}
    before = json.loads(file.read_text(encoding="utf-8"))
    names = [n for n in WORDS if before.get(n) != made[n] and not (other_commit and n == "commit")]
    if names:
        raise UserError(
            f"{out} was begun with {WORDS[names[0]]} {before.get(names[0])}, and this is "
            f"{made[names[0]]}: a record is of one; take that one again, name another folder with "
            "--out, or start anew without the folder."
            + (" --other-commit goes on all the same." if names == ["commit"] and other_commit is not None else "")
        )
    return before


def _both(before: str, present: str) -> str:
    return before if present in before.split(", ") else f"{before}, {present}"


def ranks_of(out: Path) -> str | None:
    """FLUID:DEM with which the run in `out` was last started; None where that is not known."""
    file = out / FILE
    return json.loads(file.read_text(encoding="utf-8")).get("ranks") if file.is_file() else None


def of_all(outs: Sequence[Path], other_commit: bool = False) -> str:
    """The commit of the runs in `outs`; refuses runs of different commits or programs."""
    found = {}
    for out in outs:
        file = out / FILE
        text = file.read_text(encoding="utf-8") if file.is_file() else "{}"
        found[out] = json.loads(text)
    for name in ("commit", "programs"):
        values = {out.name: made.get(name, "unknown") for out, made in found.items()}
        if len(set(values.values())) > 1 and not (other_commit and name == "commit"):
            told = "; ".join(f"{run}: {value}" for run, value in values.items())
            raise UserError(f"the runs differ in {WORDS[name]}, so they are no one record: {told}.")
    return ", ".join(dict.fromkeys(made.get("commit", "unknown") for made in found.values()))


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]
