"""`./bedload lint` without the tools: which files are too large, what a tool's silence and words count for."""

from pathlib import Path

from bedload_launcher import lint


def test_large_files_and_pages_are_found(tmp_path):
    sizes = {
        "postproc/reports/a/figure.png": lint.LARGEST + 1, "postproc/reports/a/small.png": lint.LARGEST,
        "inputs/bed/developed.h5": 10 * lint.LARGEST, "postproc/reports/a/report.html": 5,
    }  # fmt: skip
    for name, size in sizes.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"x" * size)
    found = lint.unfit_files(map(Path, sizes), tmp_path)
    assert [line.split(":")[0] for line in found] == [
        "postproc/reports/a/figure.png", "postproc/reports/a/report.html",
    ]  # fmt: skip
    assert "./bedload show postproc/reports/a" in found[1]


def test_words_count_when_the_tool_is_not_content():
    assert lint.said(["true"]) == ""
    assert lint.said(["sh", "-c", "echo fine"]) == ""
    assert lint.said(["sh", "-c", "echo bad; exit 1"]) == "bad"
    assert lint.said(["false"]) == "status 1"
    assert "not installed: apt-get install no-such-tool" in lint.said(["no-such-tool"])


def test_the_python_linter_has_the_settings_of_pyproject(monkeypatch):
    monkeypatch.setattr(lint.shutil, "which", lambda _: None)
    assert lint.python_line(["a.py"])[:2] == ["flake8", "--max-line-length=120"]
    monkeypatch.setattr(lint.shutil, "which", lambda _: "/usr/bin/ruff")
    assert lint.python_line(["a.py"]) == ["ruff", "check", "a.py"]
