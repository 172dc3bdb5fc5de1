"""The tables of keys and keywords in the documentation, made from what the programs declare.

    /usr/bin/python3 tests/manual/tables.py BIN_FOLDER     writes them anew
"""

import functools
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
KEYS = ROOT / "inputs" / "KEYS.md"
STYLES = ROOT / "liggghts_styles" / "doc"
KEYWORD_HEAD = "| keyword | meaning | allowed | default |\n|---|---|---|---|\n"
KEY_HEAD = "| key | meaning | unit | allowed | default |\n|---|---|---|---|---|\n"


@dataclass(frozen=True)
class Word:
    """A key of fluid.toml or a keyword of a style, as the help prints it."""

    name: str
    meaning: str
    unit: str
    allowed: str
    default: str


@functools.cache
def help_of(program: Path, option: str) -> str:
    return subprocess.run(
        [str(program), option], check=True, text=True, stdout=subprocess.PIPE, timeout=60
    ).stdout


def read_word(name: str, meaning: str, rule: str) -> Word:
    unit, allowed = "-", "text"
    if rule.startswith("unit "):
        found = re.fullmatch(r"unit (.*?); (.*); default (.*)", rule)
        unit, allowed, default = found.groups()
    else:
        default = re.fullmatch(r"text; default (.*)", rule)[1]
    return Word(name, meaning, unit, allowed, default)


def keys(bin_folder: Path) -> list[Word]:
    lines = help_of(bin_folder / "bedload-fluid", "--help-keys").splitlines()
    triples = zip(lines[::3], lines[1::3], lines[2::3], strict=True)
    return [read_word(name, meaning.strip(), rule.strip()) for name, meaning, rule in triples]


def styles(bin_folder: Path) -> dict[str, list[Word]]:
    """The keywords by style."""
    found: dict[str, list[Word]] = {}
    lines = iter(help_of(bin_folder / "bedload-dem", "--help-styles").splitlines())
    for line in lines:
        if not line.startswith(" "):
            words = found.setdefault(line, [])
        elif not line.startswith("    "):
            words.append(read_word(line.strip(), next(lines).strip(), next(lines).strip()))
    return found


def page_of(style: str) -> Path | None:
    """The page of a style; what belongs to the coupling stands in coupling/README.md."""
    name = style.replace("model ", "").replace(" ", "_").replace("/", "_")
    page = STYLES / f"{name}.md"
    return page if page.is_file() else None


def cell(text: str) -> str:
    return text.replace("|", "\\|")


def keyword_table(words: list[Word]) -> str:
    rows = []
    for word in words:
        unit = "" if word.unit == "-" else f" [{word.unit}]"
        rows.append(f"| {word.name} | {cell(word.meaning)} | {word.allowed}{unit} | {word.default} |\n")
    return KEYWORD_HEAD + "".join(rows)


def key_page(words: list[Word]) -> str:
    text = (
        "# Keys of fluid.toml\n\n"
        "Made from their declarations (`bedload-fluid --help-keys` prints the same). Units: L, T and M are\n"
        "the scene's own length, time and mass; h is the cell size; s is a second on the clock. `--set KEY=VALUE`\n"
        "sets any of them for one run.\n"
    )
    sections: dict[str, list[Word]] = {}
    for word in words:
        sections.setdefault(word.name.split(".")[0] if "." in word.name else "", []).append(word)
    for section, members in sections.items():
        text += f"\n## {section}\n\n{KEY_HEAD}" if section else f"\n{KEY_HEAD}"
        text += "".join(
            f"| `{w.name}` | {cell(w.meaning)} | {w.unit} | {cell(w.allowed)} | `{w.default}` |\n"
            for w in members
        )
    return text


def with_table(page: str, table: str) -> str:
    """The page with its table of keywords exchanged."""
    return re.sub(
        re.escape(KEYWORD_HEAD) + r"(\|.*\n)*", lambda _: table, page, count=1, flags=re.MULTILINE
    )


if __name__ == "__main__":
    programs = Path(sys.argv[1]).resolve()
    KEYS.write_text(key_page(keys(programs)), encoding="utf-8")
    for style, words in styles(programs).items():
        if page := page_of(style):
            page.write_text(
                with_table(page.read_text(encoding="utf-8"), keyword_table(words)), encoding="utf-8"
            )
