"""The output folder of a run: who writes in it, what it holds, how the run in it was started.

OUT/launch.json says how `./bedload run` started the run, and is held by flock(2) as long as the launcher
lives; OUT/run.lock is held by bedload-fluid in the same way. The system gives both up with the process,
however that ends.
"""

import datetime
import fcntl
import json
import os
import shutil
import socket
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path

from .errors import UserError

LAUNCH = "launch.json"
RUN_LOCK = "run.lock"
RESULTS = ("history.csv", "checkpoint_*", "state.h5")  # what only a run leaves that has begun


@dataclass(frozen=True)
class Launch:
    """How a run was started. scene: its folder; sets, variables: as --set and --var give them."""

    scene: str
    model: str | None = None
    accuracy: str | None = None
    sets: Sequence[str] = ()
    variables: Mapping[str, str] = field(default_factory=dict)
    ranks: str | None = None
    host: str = field(default_factory=socket.gethostname)
    process: int = field(default_factory=os.getpid)
    began: str = field(
        default_factory=lambda: datetime.datetime.now().astimezone().isoformat(timespec="seconds")
    )

    @classmethod
    def read(cls, out: Path) -> "Launch | None":
        """None where the run in `out` was not started by the launcher."""
        try:
            kept = json.loads((out / LAUNCH).read_text(encoding="utf-8"))
            return cls(**{f.name: kept[f.name] for f in fields(cls) if f.name in kept})
        except (OSError, ValueError, TypeError):
            return None

    def said(self) -> str:
        """What the run was told, as the command line has it; empty where it was told nothing."""
        words = [f"--accuracy {self.accuracy}"] if self.accuracy else []
        words += [f"--set {text}" for text in self.sets]
        words += [f"--var {name}={value}" for name, value in self.variables.items()]
        return " ".join(words)


def key_of(setting: str) -> str:
    """KEY of KEY=VALUE."""
    return setting.partition("=")[0].strip()


def merged(before: Sequence[str], now: Sequence[str]) -> list[str]:
    """The settings of a run that goes on: those of before, where nothing else is said now."""
    again = {key_of(text) for text in now}
    return [text for text in before if key_of(text) not in again] + list(now)


class Folder:
    """An output folder while a run is started and runs in it; to be entered and left."""

    def __init__(self, out: Path):
        self.out = out
        self._file: int | None = None

    def __enter__(self) -> "Folder":
        """Takes the folder, which is made where it is missing.

        Raises UserError that names whose it is when another run writes in it.
        """
        self.out.mkdir(parents=True, exist_ok=True)
        refuse_if_running(self.out)
        self._file = os.open(self.out / LAUNCH, os.O_RDWR | os.O_CREAT, 0o666)
        # Another command may have moved the folder since its file was opened: the lock is then that of an earlier run.
        if not _flock(self._file) or not _is_file(self._file, self.out / LAUNCH):
            self.__exit__()
            raise _in_use(self.out)
        return self

    def __exit__(self, *_) -> None:
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def make_room(self) -> Path | None:
        """Moves an earlier run in the folder to `<out>.previous` (`.previous2`, ... where that is
        taken) and returns where it went; a start that failed is taken over.

        Raises UserError when the folder holds something that is no run.
        """
        if not is_run(self.out):
            if not holds_only_a_start(self.out):
                if (self.out / LAUNCH).stat().st_size == 0:  # ours, of a moment ago
                    (self.out / LAUNCH).unlink()
                raise UserError(f"{self.out} is not empty and holds no earlier run; name another with --out.")
            return None
        aside = next_previous(self.out)
        self.out.rename(aside)
        self.__exit__()
        self.__enter__()
        return aside

    def take_back(self, aside: Path) -> bool:
        """Moves the earlier run, which went to `aside`, to its place again when the run here was refused.

        False, and all stays as it is, where the run has opened its output or another command holds one of the two.
        """
        try:
            refuse_if_running(self.out)
            if not was_refused(self.out):
                return False
            with Folder(aside):
                refused = Path(tempfile.mkdtemp(prefix=f"{self.out.name}.refused", dir=self.out.parent))
                self.out.rename(refused)
                try:
                    aside.rename(self.out)  # not into a folder that another command has filled meanwhile
                finally:
                    shutil.rmtree(refused)
        except (UserError, OSError):
            return False
        return True

    def note(self, launch: Launch) -> bytes:
        """Writes how the run is started into the file that is held; returns what stood there."""
        assert self._file is not None  # the folder was entered
        before = os.pread(self._file, os.fstat(self._file).st_size, 0)
        self.put_back((json.dumps(asdict(launch), indent=1, ensure_ascii=False) + "\n").encode())
        return before

    def put_back(self, text: bytes) -> None:
        """Gives the file that is held the text of an earlier start."""
        assert self._file is not None
        os.ftruncate(self._file, 0)
        os.pwrite(self._file, text, 0)


def next_previous(out: Path) -> Path:
    """The first name that is free for an earlier run of `out`."""
    number = 1
    while (aside := out.with_name(f"{out.name}.previous{number if number > 1 else ''}")).exists():
        number += 1
    return aside


def is_run(out: Path) -> bool:
    """Whether a run in `out` has left a result: a row of history.csv, a checkpoint, a state."""
    if any(out.glob("checkpoint_" + "[0-9]" * 8)) or (out / "state.h5").is_file():
        return True
    history = out / "history.csv"
    if not history.is_file():
        return False
    with history.open(encoding="utf-8", errors="replace") as stream:
        return sum(1 for _, line in zip(range(2), stream, strict=False) if line.strip()) > 1


def holds_only_a_start(out: Path) -> bool:
    """Whether `out`, where no run has left a result, is empty or was begun in by a start, whose script may have
    written files of any name: a start has a folder for itself."""
    started = (out / "settings.toml").is_file() or (out / LAUNCH).stat().st_size > 0
    return started or all(file.name == LAUNCH for file in out.iterdir())


def was_refused(out: Path) -> bool:
    """Whether the start in `out` ended before bedload-fluid opened its output: by settings, script or spheres."""
    return not is_run(out) and holds_only_a_start(out) and not (out / "settings.toml").exists()


def settings_mark(out: Path) -> tuple[int, int] | None:
    """Tells one settings.toml in `out` from the next: bedload-fluid writes it when it opens its output."""
    try:
        found = (out / "settings.toml").stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns


def refuse_if_running(out: Path) -> None:
    """Raises UserError when a bedload-fluid writes in `out`, however it was started."""
    try:
        file = os.open(out / RUN_LOCK, os.O_RDWR)
    except OSError:
        return
    try:
        if not _flock(file):
            text = os.pread(file, 4096, 0).decode(errors="replace")
            holder = dict(line.split(" = ", 1) for line in text.splitlines() if " = " in line)
            job = f", job {holder['job']}" if holder.get("job") else ""
            raise UserError(
                f"{out}: another run writes in this folder, process {holder.get('process', '?')} on "
                f"{holder.get('host', '?')}{job}; wait for its end, or name another folder with --out."
            )
    finally:
        os.close(file)


def _flock(file: int) -> bool:
    """Takes the lock; False where another process has it. File systems without locks have none to refuse."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        pass
    return True


def _is_file(file: int, path: Path) -> bool:
    """Whether `path` still names the open file."""
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def _in_use(out: Path) -> UserError:
    launch = Launch.read(out)
    who = f"process {launch.process} on {launch.host}, since {launch.began}" if launch else "another process"
    return UserError(
        f"{out}: another `./bedload run` writes in this folder, {who}; wait for its end, or name another "
        "folder with --out."
    )
