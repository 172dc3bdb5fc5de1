"""LIGGGHTS scripts, read as LIGGGHTS reads them: continued lines, comments, quotes, variables, parts in other files."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .errors import UserError


@dataclass(frozen=True)
class Line:
    """One line with those that `&` adds to it."""

    text: str  # as it stands
    command: str  # without its comment
    filled: str  # with the values of variables as far as they are known
    parts: list[Path] = field(default_factory=list)  # files that it includes or jumps to, between quotes of `if` too

    @property
    def lost(self) -> bool:
        """Whether it leads to a file that is not known before the run."""
        return not all(part.is_file() for part in self.parts)

    @property
    def replaced(self) -> bool:
        """Whether it is no more than an include whose file is known."""
        return words(self.command)[:1] == ["include"] and bool(self.parts) and not self.lost

    @property
    def index_variable(self) -> tuple[str, str] | None:
        """Name and value of `variable NAME index VALUE`."""
        match words(self.command):
            case ["variable", name, "index", *values]:
                return name, " ".join(values).strip()
        return None

    def reads(self, name: str) -> bool:
        """Whether it has ${name}, $n (a name of one letter), v_name or `next name`."""
        word = re.escape(name)
        short = rf"|\${word}" if len(name) == 1 else ""
        reading = re.compile(rf"\${{{word}}}{short}|(?<![\w{{])v_{word}\b")
        used = (re.sub(r"^\s*variable\s+\w+", "", text) for text in (self.command, self.filled))
        stepped = (name in rest for first, *rest in _commands(self.filled) if first == "next")
        return any(map(reading.search, used)) or any(stepped)


def walk(script: Path, folder: Path, given: Mapping[str, str], jumps: bool = False) -> Iterator[Line]:
    """The lines of a script, those of a file that it includes behind the include.

    folder: where names of files begin; given: values of variables; jumps: whether also files that it jumps to, or
    includes in an `if`, are read. Raises UserError where a script includes itself.
    """
    known = dict(given)

    def lines(file: Path, above: tuple[Path, ...] = (), included: bool = True) -> Iterator[Line]:
        chain = (*above, file.resolve())
        if chain[-1] in above:
            if not included:
                return
            way = " -> ".join(part.name for part in chain[above.index(chain[-1]) :])
            raise UserError(f"{file} includes itself ({way}).")
        for text in _joined(file.read_text(encoding="utf-8", errors="replace")):
            command = _without_comment(text.replace("&\n", ""))
            filled = re.sub(r"\$(?:{(\w+)}|(\w))", lambda m: known.get(m[1] or m[2], m[0]), command)
            line = Line(text, command, filled)
            for part in _commands(filled):
                certain = part == words(filled)
                match part:
                    case ["variable", name, "index", *values]:
                        known.setdefault(name, " ".join(values).strip() if certain else f"${{{name}}}")
                    case ["variable", name, "string", value]:
                        known[name] = value if certain else f"${{{name}}}"
                    case ["variable", name, "delete"]:
                        known.pop(name, None)
                    case ["include" | "jump", name, *_] if name != "SELF":
                        line.parts.append(folder / name)  # an absolute name stands for itself
            yield line
            if jumps or line.replaced:
                for path in filter(Path.is_file, line.parts):
                    yield from lines(path, chain, included and line.replaced)

    return lines(script)


def words(command: str) -> list[str]:
    """A command's words; text between quotes is one."""
    return [bare or quoted for _, quoted, bare in re.findall(r"""(["'])(.*?)\1|(\S+)""", command)]


def _commands(line: str) -> Iterator[list[str]]:
    """The words of its command; of `if` and `run`, of the commands between their quotes."""
    match words(line):
        case ["if" | "run", *inner]:
            for command in inner:
                yield from _commands(command)
        case [_, *_] as command:
            yield command


def _joined(text: str) -> list[str]:
    """Its lines, one that ends in `&` together with the next."""
    return re.split(r"(?<!&)\n", re.sub(r"&[ \t]+$", "&", text, flags=re.MULTILINE).rstrip("\n"))


def _without_comment(line: str) -> str:
    """A # between quotes begins no comment."""
    return re.sub(r"""("[^"]*"?|'[^']*'?)|#.*""", r"\1", line)
