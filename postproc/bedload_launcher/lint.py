"""`./bedload lint`: what tools say about the sources that no compiler says.

files        no large file and no page made by a program among those under version control
clang-format every C++ file
flake8       every Python file (ruff in its place where it is installed), settings in pyproject.toml
mypy         the Python of postproc
clang-tidy   some 20 s a file, so only those changed since the last commit or in it, at most MOST_TIDIED;
             --tidy FILE... names others, --all takes all
"""

import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .build import FOLDER, ROOT
from .machine import compile_jobs
from .words import say

LARGEST = 300_000  # bytes of a file under version control
MAY_BE_LARGE = ("inputs/*/developed.h5",)
CPP = (".cpp", ".hpp", ".c", ".h")
MOST_TIDIED = 4


def listed(*line: str) -> list[Path]:
    """Files that a git command names, below the project's root; none where this is no repository."""
    done = subprocess.run(["git", "-C", str(ROOT), *line], capture_output=True, text=True, check=False)
    names = done.stdout.split("\0") if done.returncode == 0 else []
    return [Path(name) for name in names if name and (ROOT / name).is_file()]


def tracked() -> list[Path]:
    """Sources under version control and new ones that git does not ignore."""
    return listed("ls-files", "-z", "--cached", "--others", "--exclude-standard")


def changed() -> list[Path]:
    """What differs from the last commit but one: what is being worked on."""
    files = listed("diff", "--name-only", "-z", "HEAD~1")
    return files + [f for f in listed("ls-files", "-z", "--others", "--exclude-standard") if f not in files]


def unfit_files(files: Iterable[Path], root: Path = ROOT) -> list[str]:
    """A sentence for each file that is too large, or a page that `./bedload show` makes."""
    found = []
    for file in files:
        size = (root / file).stat().st_size
        if file.name == "report.html":
            found.append(f"{file}: a page is made by `./bedload show {file.parent}`, not kept")
        elif size > LARGEST and not any(file.match(pattern) for pattern in MAY_BE_LARGE):
            found.append(f"{file}: {size} bytes, but the largest may have {LARGEST}")
    return found


def with_ending(files: Iterable[Path], endings: Sequence[str]) -> list[str]:
    return [str(file) for file in files if file.suffix in endings]


def python_line(files: list[str]) -> list[str]:
    """The linter of the Python files."""
    if shutil.which("ruff"):
        return ["ruff", "check", *files]
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]
    return ["flake8", f"--max-line-length={rules['line-length']}",
            f"--extend-ignore={','.join(rules['lint']['ignore'])}", *files]  # fmt: skip


def said(line: Sequence[str]) -> str:
    """What a tool says; nothing when it is content. One that is not installed is a finding."""
    try:
        done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return f"{line[0]} is not installed: apt-get install {line[0]}"
    return (done.stdout + done.stderr).strip() or f"status {done.returncode}" if done.returncode else ""


def tidied(files: list[str]) -> Iterator[str]:
    """What clang-tidy says about each file that the build compiles."""
    line = ["clang-tidy", "--quiet", "-p", str(FOLDER)]

    def one(file: str) -> str:
        return said([*line, file])

    with ThreadPoolExecutor(compile_jobs()) as pool:
        yield from pool.map(one, (file for file in files if file.endswith(".cpp")))


def lint(tidy: Sequence[str] | None, quick: bool) -> int:
    """Runs all tools; returns how many of them found something. `tidy`: files for clang-tidy."""
    files = tracked()
    python, cpp = with_ending(files, [".py"]), with_ending(files, CPP)
    mypy = ["mypy", f"--cache-dir={FOLDER / 'mypy'}", "--no-error-summary", "postproc"]
    found = {
        "files": "\n".join(unfit_files(files)),
        "clang-format": said(["clang-format", "--dry-run", "-Werror", *cpp]),
        "flake8": said(python_line(python)),
        "mypy": said(mypy),
    }
    if not quick:
        todo = list(tidy) if tidy is not None else with_ending(changed(), [".cpp"])[:MOST_TIDIED]
        say(f"bedload: clang-tidy on {len(todo)} files")
        found["clang-tidy"] = "\n".join(filter(None, tidied(todo)))
    for tool, words in found.items():
        print(f"{tool:13} {'' if words else 'nothing to say'}")
        if words:
            print(words, file=sys.stderr)
    return sum(bool(words) for words in found.values())
