"""What the documentation says of keys and keywords is what the programs declare."""

import os
import re
from pathlib import Path

import pytest

import tables

BIN = Path(os.environ["BEDLOAD_BIN"])
REPAIR = "run: /usr/bin/python3 tests/manual/tables.py build/release/bin"


def documents():
    for folder in (".", "coupling", "fluid", "inputs", "liggghts_styles", "postproc", "tests"):
        depth = "*.md" if folder == "." else "**/*.md"
        yield from (f for f in (tables.ROOT / folder).glob(depth) if "reports" not in f.parts)


def test_pages_of_styles():
    found = tables.styles(BIN)
    assert len(found) >= 8
    for style, words in found.items():
        page = tables.page_of(style)
        if page is None:  # the coupling's
            text = (tables.ROOT / "coupling" / "README.md").read_text(encoding="utf-8")
            assert style.split()[-1] in text
            assert all(word.name in text for word in words)
        else:
            assert tables.keyword_table(words) in page.read_text(encoding="utf-8"), (page, REPAIR)


def test_page_of_keys():
    assert tables.KEYS.read_text(encoding="utf-8") == tables.key_page(tables.keys(BIN)), REPAIR


def test_every_page_is_of_a_style():
    pages = {tables.page_of(style) for style in tables.styles(BIN)}
    assert set(tables.STYLES.glob("*.md")) <= pages


@pytest.mark.parametrize("document", documents(), ids=lambda f: str(f.relative_to(tables.ROOT)))
def test_keys_in_the_text_exist(document):
    names = {word.name for word in tables.keys(BIN)}
    groups = {name.split(".")[0] for name in names if "." in name}
    text = document.read_text(encoding="utf-8")
    said = re.findall(r"`(?:--set )?'?(\w+\.\w+)\b(?:[ =`])", text) + re.findall(r"--set '?(\w+\.\w+)=", text)
    known_files = {"toml", "part", "h5", "csv", "md", "py", "cpp", "hpp", "cmake", "png", "xdmf", "html"}
    for key in said:
        group, leaf = key.split(".")
        if group in groups and leaf not in known_files:
            assert key in names, document
