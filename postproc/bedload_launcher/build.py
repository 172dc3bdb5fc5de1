"""Configures and builds a preset of CMakePresets.json: quietly, with one progress line and a log."""

import fcntl
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from .errors import UserError
from .machine import compile_jobs, instruction_sets

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "release"
SANITIZERS = ROOT / "build" / "sanitizers"  # of the preset sanitizers
BIN = FOLDER / "bin"


class ProgressLine:
    """One line rewritten in place on a terminal; elsewhere a line every tenth of the way."""

    def __init__(self, what: str, stream: TextIO = sys.stderr):
        self._what, self._stream, self._last = what, stream, -1
        self._in_place = stream.isatty()

    def show(self, done: int, total: int) -> None:
        if self._in_place:
            self._stream.write(f"\r\033[Kbedload: {self._what} {done}/{total}")
        elif done * 10 // max(total, 1) > self._last:
            self._last = done * 10 // max(total, 1)
            self._stream.write(f"bedload: {self._what} {done}/{total}\n")
        self._stream.flush()

    def finish(self) -> None:
        if self._in_place:
            self._stream.write("\r\033[K")
            self._stream.flush()


def _must_configure(folder: Path) -> bool:
    """Whether the build folder is missing, older than the presets, or from another place."""
    ninja_file = folder / "build.ninja"
    presets = ROOT / "CMakePresets.json"
    if not ninja_file.exists() or ninja_file.stat().st_mtime < presets.stat().st_mtime:
        return True
    cache = (folder / "CMakeCache.txt").read_text(encoding="utf-8", errors="replace")
    return f"CMAKE_HOME_DIRECTORY:INTERNAL={ROOT}\n" not in cache


PROCESSOR = "processor.txt"  # in a build folder: the instruction sets that its programs may use


def missing_instructions(folder: Path) -> list[str]:
    """Instruction sets of the processor for which `folder` was built that this one has not; none of programs for
    all."""
    file = folder / PROCESSOR
    built_for = set(file.read_text(encoding="ascii").split()) if file.is_file() else set()
    return sorted(built_for - instruction_sets())


def _clean_of_another_processor(folder: Path) -> None:
    """Empties a folder whose programs would end with SIGILL here."""
    if missing := missing_instructions(folder):
        lacking = ", ".join(missing[:4]) + (", ..." if len(missing) > 4 else "")
        print(f"bedload: built for another processor (with {lacking}); building anew", file=sys.stderr, flush=True)
        subprocess.run(["ninja", "-C", str(folder), "-t", "clean"], stdout=subprocess.DEVNULL, check=False)
        (folder / PROCESSOR).unlink()


def _note_processor(folder: Path) -> None:
    """Of a folder that has been configured just now, or before there was such a note."""
    cache = (folder / "CMakeCache.txt").read_text(encoding="utf-8", errors="replace")
    names = sorted(instruction_sets()) if "BEDLOAD_NATIVE:BOOL=OFF" not in cache else []
    (folder / PROCESSOR).write_text(" ".join(names) + "\n", encoding="ascii")


def _configure(folder: Path, *options: str) -> None:
    """Configures from scratch: what an earlier attempt found, or missed, may have changed."""
    log = folder / "configure.log"
    print("bedload: configuring", file=sys.stderr, flush=True)
    with log.open("w", encoding="utf-8") as out:
        code = subprocess.run(
            ["cmake", "--preset", folder.name, "--fresh", "-S", str(ROOT), *options],
            cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, check=False,
        ).returncode  # fmt: skip
    if code != 0:
        tail = [line for line in log.read_text(encoding="utf-8").splitlines() if line.strip()]
        print("\n".join(tail[-25:]), file=sys.stderr)
        raise UserError(f"configuring failed; the whole log is {log}.")


def _ninja(folder: Path, targets: Sequence[str], log: Path) -> list[str]:
    """Builds `targets` with a progress line; returns what went wrong, nothing when all is well."""
    progress = ProgressLine("building" if folder == FOLDER else f"building {folder.name}")
    failed: list[str] = []
    command = ["ninja", "-C", str(folder), "-j", str(compile_jobs()), *targets]
    environment = dict(os.environ, NINJA_STATUS="[%f/%t] ")
    with log.open("w", encoding="utf-8") as out, subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
        env=environment,
    ) as ninja:  # fmt: skip
        for line in ninja.stdout or ():
            out.write(line)
            step = re.match(r"\[(\d+)/(\d+)\] ", line)
            if step:
                progress.show(int(step[1]), int(step[2]))
            if failed or line.startswith(("FAILED:", "ninja: error")):
                failed.append(line)
    progress.finish()
    return failed if ninja.returncode != 0 else []


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Waits until no other command builds in `folder`: two at once would write the same files."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "build.lock").open("w", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("bedload: another command is building here; waiting", file=sys.stderr, flush=True)
            fcntl.flock(lock, fcntl.LOCK_EX)
        except OSError:  # a file system without locks
            pass
        yield


def build(targets: Sequence[str] = ("all",), portable: bool = False, folder: Path | None = None) -> None:
    """Configures if needed and builds `targets`; does and prints nothing when all is up to date.

    portable: for other processors than this one, from now on.
    folder: FOLDER unless SANITIZERS is given; its name is the preset's.

    Raises UserError, after printing the compiler's words, when it does not succeed. A checkout that may only be read
    (an image, another user's) serves as it is where `targets` are there.
    """
    folder = folder or FOLDER
    if not os.access(folder, os.W_OK) and all((folder / "bin" / target).is_file() for target in targets):
        if missing := missing_instructions(folder):
            raise UserError(f"{folder} may only be read and was built for another processor (with {missing[0]}, which "
                            "this one has not); there, ./bedload build --portable.")  # fmt: skip
        return
    with one_at_a_time(folder):
        _build(folder, targets, portable)


def _build(folder: Path, targets: Sequence[str], portable: bool) -> None:
    _clean_of_another_processor(folder)
    configured = portable or _must_configure(folder)
    if configured:
        _configure(folder, *(["-DBEDLOAD_NATIVE=OFF"] if portable else []))
    if configured or not (folder / PROCESSOR).is_file():
        _note_processor(folder)
    log = folder / "build.log"
    failed = _ninja(folder, targets, log)
    if failed and failed[0].startswith("FAILED: build.ninja"):
        # Ninja could not bring the configuration up to date with what an old cache remembers.
        _configure(folder)
        _note_processor(folder)
        failed = _ninja(folder, targets, log)
    if failed:
        sys.stderr.writelines(failed[:60])
        raise UserError(f"the build failed; the whole log is {log}.")
