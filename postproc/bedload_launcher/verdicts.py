"""`--accuracy auto`: leaves out what `./bedload study effects SCENE` found certain to be left out.

The study's table is runs/effects-SCENE/effects.csv where somebody has made one, else, of a scene that is shipped, the
kept one; of the same scene, model and --set. Followed is
a row that turned an effect off by values of fluid.toml, took less time and has the verdict "leave it out":
the answer stays within 2 %, certainly. Several of them add up, so they are taken, the greatest gain first, as long as
their changes with intervals together stay within these 2 %. Output and statistics stay: a person asked for them.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .build import ROOT
from .errors import UserError
from .scenes import INPUTS, Scene, choose_model
from .words import read_rows

KEPT = ROOT / "postproc" / "reports" / "effects"
LEAVE_OUT = "leave it out"
TOLERANCE = 0.02  # of an answer: what a person would not see
ASKED_FOR = ("output", "statistics")
ASKED = "asked.json"  # beside a table: scene, model and --set of its study
OF_NO_EFFECT = ("output.", "statistics.", "checkpoint.", "time.end")  # on what an effect changes
# Names in the table of effects that a run prints.
ROWS = {"precision": "single precision", "forcing loops": "extra forcing loops", "diffusion": "implicit diffusion"}


@dataclass(frozen=True)
class Followed:
    """One verdict: values of fluid.toml, and why, in words for the run's table of effects."""

    effect: str
    keys: list[str]
    why: str


def table(scene: Scene) -> Path | None:
    """The table of one's own, or the kept one of a shipped scene; None where there is neither."""
    places = [Path("runs") / f"effects-{scene.name}" / "effects.csv"]
    if scene.folder.resolve().is_relative_to(INPUTS):
        places.append(KEPT / f"{scene.name}.csv")
    return next((place for place in places if place.is_file()), None)


def followed(rows: list[dict[str, str]]) -> list[Followed]:
    """Of a study's table, what is certain."""
    certain = [
        row for row in rows
        if row.get("verdict") == LEAVE_OUT and float(row["time"]) < 1.0 and row.get("keys")
        and row["effect"] not in ASKED_FOR
    ]  # fmt: skip
    found: dict[str, Followed] = {}
    left = TOLERANCE
    for row in sorted(certain, key=lambda row: float(row["time"])):
        change, interval = float(row["change"]), float(row["interval"])
        if row["effect"] in found or abs(change) + interval > left:
            continue
        left -= abs(change) + interval
        answer = f"answer {100 * change:+.2f} +- {100 * interval:.2f} %"
        why = f"study effects: {float(row['time']):.2f} of the time, {answer}"
        found[row["effect"]] = Followed(row["effect"], row["keys"].split("; "), why)
    return list(found.values())


def note(folder: Path, scene: Scene, model: str | None, given: Sequence[str]) -> None:
    """Keeps what the study whose table is in `folder` was asked: scene, collision model, --set."""
    asked = {"scene": str(scene.folder.resolve()), "model": model, "set": list(given)}
    (folder / ASKED).write_text(json.dumps(asked, indent=1) + "\n", encoding="utf-8")


def other_than_asked(file: Path, scene: Scene, model: str | None, given: Sequence[str]) -> str:
    """What the table `file` is of, where that is not this run; else empty. A kept one is of the scene's own model."""
    beside = file.with_name(ASKED)
    if not beside.is_file():
        own = choose_model(scene, None) if file.parent == KEPT else model
        return "" if model == own else f"model {own}"
    asked = json.loads(beside.read_text(encoding="utf-8"))
    if asked["scene"] != str(scene.folder.resolve()):
        return f"the scene {asked['scene']}"
    if asked["model"] != model:
        return f"model {asked['model']}"
    if _that_count(asked["set"]) != _that_count(given):
        return " ".join(f"--set '{text}'" for text in _that_count(asked["set"])) or "no --set"
    return ""


def _that_count(given: Sequence[str]) -> list[str]:
    return sorted(text for text in given if not text.startswith(OF_NO_EFFECT))


def settings_of(scene: Scene, given: Sequence[str] = (), model: str | None = None) -> list[str]:
    """Values of fluid.toml, and the words for the run's table of effects; `given`: the --set of the run.

    Raises UserError where there is no table, or one of another scene of this name, another model or --set.
    """
    file = table(scene)
    if file is None:
        raise UserError(
            f"--accuracy auto follows the table of ./bedload study effects {scene.name}, which is neither in runs "
            f"nor kept in postproc/reports/effects."
        )
    if words := other_than_asked(file, scene, model, given):
        raise UserError(f"--accuracy auto: {file} is of runs with {words}, unlike this one; give the same, or first "
                        "./bedload study effects with the scene, --model and --set of this run.")  # fmt: skip
    taken = followed(read_rows(file))
    words = "; ".join(f"{ROWS.get(one.effect, one.effect)}: {one.why}" for one in taken)
    told = [f'accuracy.verdicts="{words}"'] if words else []
    return [key for one in taken for key in one.keys] + told
