"""Spheres in the flow against theory and experiments, one case after the other, with the errors.

Every case runs scenes of inputs/validation and hands back rows (a number, what it should be, the bound)
and curves; validation_arrays.py, _steady.py, _sliding.py, _spin.py, _falls.py, _rebounds.py, _suspensions.py,
_packings.py, _incipient.py, _erosion.py and _erosion_law.py have them. Results stand in the report's folder as
CASE.json, CASE.png and, all together, README.md.
"""

import argparse
from collections.abc import Collection, Mapping
from pathlib import Path

from bedload_launcher.errors import UserError, unknown
from bedload_launcher.job import Ranks

from . import (
    validation_arrays, validation_erosion, validation_erosion_law, validation_falls, validation_figures,
    validation_incipient, validation_packings, validation_rebounds, validation_sliding, validation_spin,
    validation_steady, validation_suspensions,
)  # fmt: skip
from .validation_runs import Result, Row, Runner

CASES = (
    validation_arrays.CASES | validation_steady.CASES | validation_sliding.CASES | validation_spin.CASES
    | validation_falls.CASES | validation_rebounds.CASES | validation_suspensions.CASES
    | validation_packings.CASES | validation_incipient.CASES | validation_erosion.CASES | validation_erosion_law.CASES
)  # fmt: skip


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", nargs="*", metavar="CASE", help=f"which ones: {', '.join(CASES)}")
    parser.add_argument("--ranks", default="1:1", metavar="FLUID:DEM", help="MPI ranks (default 1:1)")
    parser.add_argument(
        "--runs", type=Path, default=Path("runs/validation"), metavar="DIR",
        help="where the runs go; those that stand there are not made again (default runs/validation)",
    )  # fmt: skip
    parser.add_argument("--afresh", action="store_true", help="make all runs again")
    parser.add_argument(
        "--report", type=Path, default=None, metavar="DIR",
        help="folder of tables and figures (default: DIR/report; the kept one is "
        "postproc/reports/validation)",
    )  # fmt: skip
    parser.add_argument(
        "--rewrite", type=Path, default=None, metavar="DIR",
        help="figures and page of a kept report anew from its numbers; nothing is run",
    )  # fmt: skip


def rewrite(report: Path, names: Collection[str] = ()) -> None:
    """Figures (of `names`, or all) and page of a kept report from its CASE.json."""
    for name in names or CASES:
        if (kept := report / f"{name}.json").is_file():
            validation_figures.draw(name, Result.load(kept), report / f"{name}.png")
    _write_page(report)


def run(options: argparse.Namespace) -> int:
    for name in options.case:
        if name not in CASES:
            raise unknown("case", name, CASES)
    if options.rewrite is not None:
        if not any(options.rewrite.glob("*.json")):
            raise UserError(f"{options.rewrite} has no CASE.json.")
        rewrite(options.rewrite.resolve(), options.case)
        print(f"bedload: figures and page anew in {options.rewrite}")
        return 0
    report = (options.report or options.runs / "report").resolve()
    report.mkdir(parents=True, exist_ok=True)
    failed = 0
    for name in options.case or CASES:
        runner = Runner(options.runs.resolve(), Ranks.parse(options.ranks), options.afresh)
        try:
            result = CASES[name](runner)
        except UserError as error:
            print(f"bedload: {name}: {error}", flush=True)
            failed += 1
            continue
        result.costs, result.made_by = runner.costs, runner.made_by
        result.save(report / f"{name}.json")
        validation_figures.draw(name, result, report / f"{name}.png")
        _print(result)
        failed += sum(row.passed is False for row in result.rows)
    _write_page(report)
    print(f"\nbedload: report in {report}/README.md; {failed or 'none'} outside their bounds")
    return 1 if failed else 0


def _error(row) -> str:
    return "" if row.error is None else f"{100 * row.error:+.2f} %"


def _bound(row) -> str:
    return "" if row.bound is None else f"{100 * row.bound:g} %"


def _print(result: Result) -> None:
    print(f"\n{result.title} ({sum(result.costs.values()):.0f} s)")
    for row in result.rows:
        reference = "" if row.reference is None else f"{row.reference:.5g}"
        verdict = {True: "ok", False: "MISSED", None: ""}[row.passed]
        print(f"  {row.found:10.5g} {reference:>10} {_error(row):>9} {_bound(row):>6} {verdict:<6} "
              f"{row.what}", flush=True)  # fmt: skip


def _write_page(report: Path) -> None:
    """README.md of all cases that have a result."""
    files = {name: report / f"{name}.json" for name in CASES}
    results = {name: Result.load(file) for name, file in files.items() if file.is_file()}
    (report / "README.md").write_text(page_of(results), encoding="utf-8")


def page_of(results: Mapping[str, Result]) -> str:
    """The page of all results by case: what misses its bound first, an overview, then every number."""
    page = ["# Spheres in the flow against theory and experiments", "",
            "Written by `./bedload study validation [CASE ...] --report postproc/reports/validation`. "
            "A bound stands where the case must keep one; the other rows inform. Seconds are of the "
            "runs as they were made, many of them on a busy machine.", ""]  # fmt: skip
    bounded = {name: [row for row in result.rows if row.passed is not None] for name, result in results.items()}
    missed = [(name, row) for name, rows in bounded.items() for row in rows if not row.passed]
    count = sum(map(len, bounded.values()))
    page += [f"**{len(missed)} of {count} numbers miss their bounds" + (":**" if missed else ".**"), ""]
    page += [f"- `{name}`: {row.what}: {row.found:.5g}, should be {_should_be(row)}, {_error(row)}, bound {_bound(row)}"
             for name, row in missed]  # fmt: skip
    page += [""] * bool(missed) + ["| case | what | bounds kept |", "|---|---|---|"]
    for name, result in results.items():
        kept = sum(row.passed is True for row in bounded[name])
        of = len(bounded[name])
        verdict = "" if of == 0 else f"{kept} of {of}" if kept == of else f"**{kept} of {of}**"
        page.append(f"| [{name}](#{_anchor(name, result)}) | {result.title} | {verdict} |")
    page.append("")
    for name, result in results.items():
        page += [f"## {name}: {result.title}", ""]
        page += ["| what | found | should be | error | bound | |", "|---|---|---|---|---|---|"]
        for row in result.rows:
            verdict = {True: "kept", False: "**missed**", None: ""}[row.passed]
            page.append(f"| {row.what} | {row.found:.5g} | {_should_be(row)} | {_error(row)} | {_bound(row)} "
                        f"| {verdict} |")  # fmt: skip
        made = f", made {' and '.join(result.made_by)}" if result.made_by else ""
        page += ["", *result.remarks, f"Runs: {sum(result.costs.values()):.0f} s in all{made}.", "",
                 f"![{result.title}]({name}.png)", ""]  # fmt: skip
    return "\n".join(page)


def _should_be(row: Row) -> str:
    return "" if row.reference is None else f"{row.reference:.5g} ({row.source})"


def _anchor(name: str, result: Result) -> str:
    """Of the heading that page_of() gives a case, as pages on the web make it: small letters, hyphens for spaces,
    nothing else but letters, digits and underscores."""
    heading = f"{name}: {result.title}".lower()
    return "".join("-" if c == " " else c for c in heading if c.isalnum() or c in " -_")
