"""Running the validation scenes, what a case compares with, and what it hands back. No study of its own."""

import csv
import datetime
import json
import math
import shutil
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from bedload_launcher.build import BIN
from bedload_launcher.errors import UserError
from bedload_launcher.job import Ranks, environment, readable, script_path
from bedload_launcher.scenes import INPUTS
from bedload_launcher.version import commit
from bedload_post.outputs import Run

SCENES = INPUTS / "validation"
REFERENCE = Path(__file__).resolve().parent / "reference"
DIFFUSION = 0.2  # nu dt / h^2 of the Stokes cases; explicit diffusion is stable up to 0.209


def of_loop(diffusion_number: float, loops: int = 1) -> float:
    """lambda, nu dt/h^2 of a step whose one loop leaves as little slip; in the range that was measured (as in
    liggghts_styles/formulas/diffusion_number.hpp)."""
    return min(0.2, max(0.003, diffusion_number / loops**1.3))


@dataclass(frozen=True)
class Row:
    """One number of a case beside what it should be.

    `error` is relative to the reference (or to `scale` where that is given); within `bound` it
    passes. Without a bound the row only informs.
    """

    what: str
    found: float
    reference: float | None = None
    bound: float | None = None
    scale: float | None = None
    source: str = ""

    @property
    def error(self) -> float | None:
        if self.reference is None:
            return None
        return (self.found - self.reference) / abs(self.scale or self.reference)

    @property
    def passed(self) -> bool | None:
        if self.bound is None or self.error is None:
            return None
        return abs(self.error) <= self.bound


@dataclass
class Curve:
    """A line (or, as `points`, marks) of a case's figure."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    points: bool = False


def marks(label: str, points: list[tuple[float, float]]) -> Curve:
    """A mark at each (x, y)."""
    return Curve(label, [x for x, _ in points], [y for _, y in points], points=True)


@dataclass
class Result:
    """What a case found: rows for the table, curves for the figure, remarks for the reader."""

    title: str
    rows: list[Row] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    axes: tuple[str, str] = ("", "")
    logarithmic: bool = False
    remarks: list[str] = field(default_factory=list)
    costs: dict[str, float] = field(default_factory=dict)  # seconds of each run
    made_by: list[str] = field(default_factory=list)  # days and commits of the runs

    def save(self, path: Path) -> None:
        record = asdict(self)
        record["rows"] = [asdict(row) for row in self.rows]
        path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> "Result":
        record = json.loads(path.read_text(encoding="utf-8"))
        record["rows"] = [Row(**row) for row in record["rows"]]
        record["curves"] = [Curve(**curve) for curve in record["curves"]]
        record["axes"] = tuple(record["axes"])
        return cls(**record)


def reference_rows(file: str, case: str) -> np.ndarray:
    """Rows of one case of a file in `reference/`, without its name, shape (rows, columns)."""
    with (REFERENCE / file).open(encoding="utf-8") as stream:
        lines = csv.reader(line for line in stream if not line.startswith("#"))
        return np.array([[float(v) for v in line[1:]] for line in lines if line[0] == case])


def thin(
    x: np.ndarray, y: np.ndarray, most: int = 150, digits: tuple[int, int] | None = (6, 6)
) -> tuple[list[float], list[float]]:
    """Evenly chosen points of a curve, less than twice `most`, for a Curve. `digits`: decimals to which x and y are
    rounded; None: as they are."""
    every = max(1, len(x) // most)
    x, y = x[::every], y[::every]
    if digits is not None:
        x, y = np.round(x, digits[0]), np.round(y, digits[1])
    return x.tolist(), y.tolist()


def from_coarser(run: Run | None, end: float) -> dict[str, object]:
    """Settings that start from another run's state, which lacks little, and end earlier."""
    if run is None:
        return {}
    state = str(run.folder / "state.h5")
    return {"start.from": "state", "start.file": state, "time.end": end}


def drag_factor(run: Run, length: float) -> float:
    """K from the driving force of the steady state, D = nu = U = 1."""
    return float(run.history()["driving"][-1]) * length**3 / (3.0 * math.pi)


@dataclass
class Runner:
    """Runs scenes of inputs/validation into `folder`; runs that stand there already are kept."""

    folder: Path
    ranks: Ranks
    afresh: bool = False
    costs: dict[str, float] = field(default_factory=dict)
    made_by: list[str] = field(default_factory=list)  # days and commits, each once

    def __call__(
        self, scene: str, label: str, settings: Mapping[str, object] = {},
        variables: Mapping[str, object] = {},
    ) -> Run:  # fmt: skip
        """`settings` override fluid.toml, `variables` those of in.liggghts."""
        out = self.folder / label
        fluid = [str(BIN / "bedload-fluid"), "fluid.toml", "--out", str(out)]
        for key, value in settings.items():
            fluid += ["--set", f"{key}={_toml(value)}"]
        dem = [str(BIN / "bedload-dem"), "-in", "in.liggghts", "-log", str(out / "log.liggghts")]
        way = script_path(out, SCENES / scene)
        for name, given in ({"out": way} | dict(variables)).items():
            dem += ["-var", name, str(given)]
        line = ["mpirun", "--quiet", "-np", str(self.ranks.fluid), *fluid, ":",
                "-np", str(self.ranks.dem), *dem]  # fmt: skip
        done = out / "done.json"
        kept = json.loads(done.read_text(encoding="utf-8")) if done.is_file() else {}
        words = [str(out) if part == way else part.removeprefix(f"{BIN}/") for part in line]
        if not readable(str(INPUTS)):  # else bedload-dem says where they are
            line += ["-var", "inputs", script_path(INPUTS, SCENES / scene)]
        if self.repeats(out) or kept.get("line") != words:
            today = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
            made = f"{today} by commit {commit() or 'unknown'}"
            kept = {"line": words, "seconds": self._run(line, scene, out), "made_by": made}
            done.write_text(json.dumps(kept), encoding="utf-8")
        self.costs[label] = kept["seconds"]
        if (made := kept.get("made_by", "by a commit that was not kept")) not in self.made_by:
            self.made_by.append(made)
        return Run(out)

    def repeats(self, out: Path) -> bool:
        """Whether the run in `out` is made even where it stands already."""
        return self.afresh

    def _run(self, line: Sequence[str], scene: str, out: Path) -> float:
        out.mkdir(parents=True, exist_ok=True)
        for file in [*out.glob("*.h5"), *out.glob("*.csv"), *out.glob("done.json")]:
            file.unlink()
        for checkpoint in out.glob("checkpoint_*"):
            shutil.rmtree(checkpoint)
        print(f"bedload: {scene}, {out.name} ...", flush=True)
        began = time.monotonic()
        with (out / "screen.txt").open("w", encoding="utf-8") as screen:
            code = subprocess.run(
                line, cwd=SCENES / scene, env=environment() | {"TERM": "dumb"},
                stdin=subprocess.DEVNULL, stdout=screen, stderr=subprocess.STDOUT, check=False,
            ).returncode  # fmt: skip
        if code != 0:
            raise UserError(f"validation/{scene} ended with status {code}; see {out}/screen.txt.")
        seconds = round(time.monotonic() - began, 1)
        print(f"bedload: {scene}, {out.name}: {seconds} s", flush=True)
        return seconds


def _toml(value: object) -> str:
    """A Python value as TOML."""
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return repr(value)
