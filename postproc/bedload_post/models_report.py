"""The report of a model comparison: figures, Table 2 beside the paper's, the paper's statements right or wrong.

`write` leaves the figures, numbers.json, README.md (to be kept) and report.html (the same with its figures
in one file) in a folder. Every sentence is made from the numbers; `rewrite` makes those of a kept report, and the
figures that need no more than its numbers, anew from its numbers.json.
"""

import html
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from . import bed_motion, flow_statistics, path
from . import model_figures as figures
from . import model_sentences as sentences
from . import paper_statements as paper
from .collision_statistics import collision_statistics
from .flow_statistics import FlowStatistics
from .model_figures import MODELS, Case, in_order
from .model_numbers import Bed, numbers
from .least_intervals import widened_sentence
from .model_table import number_rows
from .other_records import (
    Record, comparable, experiment_rows, repeated_sentence, trend_rows, trend_sentence, with_least_intervals,
)  # fmt: skip
from .outputs import MissingOutput, Run, Samples
from .report import image, page, table
from .states import unwrap

WAY_SHOWN = 26.0  # of the path in the figure, in D
PAPER = "Vowinckel, Kempe, Fröhlich, Impact of collision models on particle transport in open channel flow"
THIN = "bands and bars: 95 % intervals, thin: too few samples for one"
# Figures that need no runs: they are drawn from the numbers.
MEAN_VELOCITY, SHARES, TREND = "mean_velocity.png", "shares.png", "trend.png"
CAPTIONS = {
    MEAN_VELOCITY: "Mean particle velocity",
    TREND: "Mean particle velocity over the resolution; a line joins the longest record of each, hollow: others",
    "heights.png": f"PDF of the grains' height, mean spin and mean velocity over height ({THIN})",
    "jumping.png": f"Jumping grains: spin and height of the jumps ({THIN}; of the heights by Poisson)",
    "creeping.png": f"Creeping grains: velocity, spin, slip over the way between collisions ({THIN})",
    SHARES: "Share of time resting, creeping, jumping",
    "collisions.png": "Collisions: Stokes number of the impact, duration over T_c, largest overlap",
    "series.png": "Mean velocity of all grains over time",
    "motion.png": "Where and when grains of the bed move",
    "flow.png": "The flow: mean velocity, rms, total shear stress (time means, without intervals)",
    "correlations.png": "Two-point correlations of u",
}


@dataclass(frozen=True)
class Comparison:
    """What is compared and under which circumstances (date, commit, ranks, hours)."""

    title: str
    cases: Sequence[Case]
    setup: int  # of the paper, 1 or 2, whose numbers stand beside these; 0: neither
    circumstances: dict[str, str]
    bed: Bed | None = None  # the same bed without mobile grains
    scene: str = ""
    beside: Sequence[Record] = ()

    @property
    def with_paper(self) -> bool:
        """Table 2 has values for these."""
        return self.setup == 2


def _profiles(cases: Sequence[Case]) -> list[tuple[Case, FlowStatistics]]:
    found = []
    for case in cases:
        try:
            found.append((case, flow_statistics.read(case.run)))
        except MissingOutput:
            continue
    return found


def first_way(samples: Samples, run: Run) -> Samples:
    """A grain's samples until it has gone WAY_SHOWN diameters downstream."""
    x = unwrap(samples.position, run.periods)[:, 0]
    beyond = np.flatnonzero(x - x[0] > WAY_SHOWN * run.diameter)
    return samples.rows(slice(None, beyond[0] if len(beyond) else None))


def draw_figures(comparison: Comparison, values: Sequence[dict], folder: Path) -> list[tuple[str, str]]:
    """All figures as PNGs in `folder`; (file, caption) in the report's order. None is empty: what no run
    has is not drawn."""
    cases = comparison.cases
    measured = [(case, collision_statistics(case.run, case.since)) for case in cases]
    flows = _profiles(cases)
    since = min(case.since for case in cases)
    drawn = draw_numbers(comparison, values, folder)

    def draw(name: str, figure: Callable[[Path], bool], more: str = "") -> None:
        (folder / name).unlink(missing_ok=True)  # of an earlier report
        if figure(folder / name):
            drawn.append((name, CAPTIONS[name] + more))

    draw("heights.png", lambda file: figures.heights(cases, file))
    draw("jumping.png", lambda file: figures.jumping(cases, file))
    draw("creeping.png", lambda file: figures.creeping(cases, file))
    draw("collisions.png", lambda file: figures.collisions(measured, file))
    draw("series.png", lambda file: figures.velocity_series(cases, file))
    draw("motion.png", lambda file: bed_motion.compare([(case.label, case.run) for case in cases], file, since),
         "; the dashed line ends the start-up" if since > 0.0 else "")  # fmt: skip
    if flows:
        draw("flow.png", lambda file: figures.flow(flows, file))
    if (folder / "correlations.png").is_file():
        drawn.append(("correlations.png", f"{CAPTIONS['correlations.png']}, {cases[0].label}"))
    for case in cases:
        name = f"path-{case.model}" + (f"-{case.density_ratio:g}" if len(case.ratios) > 1 else "")
        tag = path.chosen_grain(case.transport.phases)
        samples = first_way(case.run.samples_of(tag, case.since), case.run)
        path.draw(case.run, case.transport.phases, samples, tag, folder / f"{name}.png", dpi=80)
        drawn.append((f"{name}.png", f"The longest way of a grain, {case.label}"))
    return drawn


def draw_numbers(comparison: Comparison, values: Sequence[dict], folder: Path) -> list[tuple[str, str]]:
    """The figures that are drawn from the numbers of the runs; (file, caption)."""
    with_paper = comparison.with_paper
    values, beside = with_least_intervals(values, comparison.beside)
    table_2 = " (the paper's Table 2)" if with_paper else ""
    records = [record.runs for record in comparable(values, beside)]
    figures.mean_velocities(values, folder / MEAN_VELOCITY, with_paper)
    drawn = [(MEAN_VELOCITY, CAPTIONS[MEAN_VELOCITY] + table_2)]
    if figures.trend(records, folder / TREND, with_paper):
        drawn.append((TREND, CAPTIONS[TREND]))
    figures.shares(values, folder / SHARES)
    return [*drawn, (SHARES, CAPTIONS[SHARES])]


def statement_rows(found: Sequence[paper.Verdict]) -> list[list[str]]:
    """The paper's statements: where, what, right or wrong, what the runs give; those that are wrong come first."""
    ordered = sorted(found, key=lambda v: (False, None, True).index(v.holds))
    return [[v.place + (f", ρp/ρf {v.at}" if v.at else ""), v.statement, v.word, v.found] for v in ordered]


def experiment_lines(comparison: Comparison, values: Sequence[dict]) -> list[str]:
    """For each mean velocity further than 20 % from the paper's, the commands that vary its causes."""
    lines = []
    for v, off in paper.far_off(comparison.setup, values):
        cells = f"{v['cells_per_diameter']:g}"
        lines.append(f"{MODELS[v['model']][0]}, {100 * off:+.0f} % from the paper's:")
        lines += [
            f"    {command}    # {what}"
            for what, command in paper.experiments(v["model"], comparison.scene, cells)
        ]
    return lines


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """Rows of text as a Markdown table, the first one its head."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


@dataclass(frozen=True)
class Sections:
    """What both forms of the report are made of."""

    answer: str  # how fast the grains go, and how many
    opening: str  # what contradicts the paper and what agrees
    sentences: list[str]
    details: list[str]  # on single runs
    numbers: list[list[str]]
    statements: list[list[str]]
    experiments: list[str]
    trend: list[list[str]]
    beside: list[list[str]]
    facts: list[list[str]]
    drawn: list[tuple[str, str]]


def sections(
    comparison: Comparison, values: Sequence[dict], drawn: list[tuple[str, str]]
) -> Sections:
    values, beside = with_least_intervals(values, comparison.beside)
    names = sentences.names_of(values)
    found = paper.verdicts(comparison.setup, values)
    told = [
        sentences.order_sentences(values, comparison.with_paper),
        trend_sentence(values, beside, comparison.with_paper),
        repeated_sentence(values, beside),
        sentences.record_sentence(comparison.setup, values),
        sentences.interval_sentence(names, values),
        widened_sentence(names, values),
        sentences.drift_sentence(names, values),
    ]  # fmt: skip
    return Sections(
        sentences.answer(values, comparison.with_paper),
        paper.opening(found) + (sentences.caution(values) if found else ""),
        [text for text in told if text],
        [*sentences.collision_lines(names, values), *sentences.neighbour_lines(names, values)],
        [["", *names], *number_rows(values)],
        statement_rows(found),
        experiment_lines(comparison, values),
        trend_rows(values, beside, comparison.with_paper),
        experiment_rows(values, beside),
        [[name, value] for name, value in comparison.circumstances.items()],
        drawn,
    )


STATEMENT_HEAD = ["where", "the paper", "here", "found"]
OF_PAPER = f"The paper: {PAPER}."
TREND_HEAD, BESIDE_HEAD = "Trend with resolution", "Other records beside these"
TREND_NOTE = (
    "Each value is compared with that of the longest record of the next coarser resolution. Records of one resolution "
    "are listed, not pooled: each has its own start and interval. Records of other commits differ by what changed "
    "between them, too."
)


def html_page(title: str, parts: Sections, folder: Path, remarks: str) -> str:
    """The report as one file with its figures in it."""
    body = [f"<h1>{html.escape(title)}</h1>"]
    plain = parts.answer.replace("**", "").replace("`", "")
    body += [f"<p>{html.escape(text)}</p>" for text in (plain, parts.opening, OF_PAPER, *parts.sentences) if text]
    if parts.statements:
        body += ["<h2>The paper's statements</h2>", table(parts.statements, [""] * 4, STATEMENT_HEAD)]
    body += ["<h2>Numbers</h2>", table(parts.numbers, ["", *["number"] * (len(parts.numbers[0]) - 1)]), remarks]
    if parts.trend:
        head, *rows = parts.trend
        body += [f"<h2>{TREND_HEAD}</h2><p>{TREND_NOTE}</p>", table(rows, [""] * len(head), head)]
    if parts.beside:
        head, *rows = parts.beside
        body += [f"<h2>{BESIDE_HEAD}</h2>", table(rows, [""] * len(head), head)]
    if parts.experiments:
        text = html.escape("\n".join(parts.experiments))
        body += [f"<h2>Experiments on what is off by more than 20 %</h2><pre>{text}</pre>"]
    if parts.details:
        lines = "".join(f"<li>{html.escape(text)}</li>" for text in parts.details)
        body.append(f"<h2>Collisions and neighbours</h2><ul>{lines}</ul>")
    body += [image(folder / file, caption) for file, caption in parts.drawn]
    body += [image(folder / "picture.png", "The scene")]
    if (folder / "film.mp4").is_file():
        body.append('<p>Film of the moving bed: <a href="film.mp4">film.mp4</a></p>')
    body.append("<h2>Circumstances</h2>" + table(parts.facts, ("", "")))
    return page(title, body)


def markdown_page(title: str, parts: Sections, remarks: str, folder: Path) -> str:
    """The report for the folder of kept results, figures beside it."""
    opening = (parts.answer, parts.opening, links(folder), OF_PAPER)
    text = [f"# {title}", *(t for t in opening if t), *parts.sentences]
    if parts.statements:
        text += ["## The paper's statements", markdown_table([STATEMENT_HEAD, *parts.statements])]
    text += ["## Numbers", markdown_table(parts.numbers)]
    if remarks:
        text.append(remarks)
    if parts.trend:
        text += [f"## {TREND_HEAD}", TREND_NOTE, markdown_table(parts.trend)]
    if parts.beside:
        text += [f"## {BESIDE_HEAD}", markdown_table(parts.beside)]
    if parts.experiments:
        lines = "\n".join(parts.experiments)
        text += ["## Experiments on what is off by more than 20 %", f"```\n{lines}\n```"]
    if parts.details:
        text += ["## Collisions and neighbours", "\n".join(f"- {line}" for line in parts.details)]
    text.append("## Figures")
    text += [f"![{caption}]({file})" for file, caption in parts.drawn if not file.startswith("path-")]
    text += ["## Circumstances", "\n".join(f"- {name}: {value}" for name, value in parts.facts)]
    return "\n\n".join(text) + "\n"


def links(folder: Path) -> str:
    """Where a reader of a kept report goes on: none outside the folder of kept results."""
    found = {"../README.md": "All kept records, and which are older than what",
             "../../../inputs/models/README.md": "which model to take"}  # fmt: skip
    there = {file: text for file, text in found.items() if (folder.resolve() / file).resolve().is_file()}
    return "; ".join(f"[{text}]({file})" for file, text in there.items()) + "." if len(there) == len(found) else ""


def write(comparison: Comparison, folder: Path, remarks: str = "") -> list[dict]:
    """Figures, report.html, README.md and numbers.json into `folder`; returns the numbers.

    `remarks`: paragraphs of HTML that stand under the table.
    """
    folder.mkdir(parents=True, exist_ok=True)
    ratios = tuple(sorted({case.density_ratio for case in comparison.cases}))
    ordered = sorted(comparison.cases, key=lambda case: in_order(case.model, case.density_ratio))
    comparison = replace(comparison, cases=[replace(case, ratios=ratios) for case in ordered])
    values = [numbers(case, comparison.bed) for case in comparison.cases]
    for value in values if comparison.with_paper else ():
        if value["model"] in MODELS:
            value["paper_mean_velocity"] = MODELS[value["model"]][2]
    drawn = draw_figures(comparison, values, folder)
    keep(comparison, values, drawn, folder, remarks)
    text = html_page(comparison.title, sections(comparison, values, drawn), folder, remarks)
    (folder / "report.html").write_text(text, encoding="utf-8")
    return values


def keep(
    comparison: Comparison, values: Sequence[dict], drawn: list[tuple[str, str]], folder: Path, remarks: str
) -> None:
    """numbers.json and README.md into `folder`."""
    kept = {
        "title": comparison.title, "scene": comparison.scene, "setup": comparison.setup,
        "circumstances": comparison.circumstances, "figures": drawn, "remarks": remarks,
        "runs": values, "beside": [record.kept() for record in comparison.beside],
    }  # fmt: skip
    text = json.dumps(kept, indent=1, ensure_ascii=False, default=float)
    (folder / "numbers.json").write_text(text + "\n", encoding="utf-8")
    text = markdown_page(comparison.title, sections(comparison, values, drawn), remarks, folder)
    (folder / "README.md").write_text(text, encoding="utf-8")


def rewrite(comparison: Comparison, kept: dict, folder: Path) -> None:
    """README.md, numbers.json and the figures that are drawn from numbers, of a report whose runs may be gone; other
    figures stay as they are. `kept`: its numbers.json."""
    values = sorted(kept["runs"], key=lambda v: in_order(v["model"], v["density_ratio"]))
    drawn = draw_numbers(comparison, values, folder)
    done = {file for file, _ in drawn}
    # Of figures whose captions were not kept nothing is said but what they show.
    plain = [(file, text.split(" (")[0].split(";")[0]) for file, text in CAPTIONS.items()]
    others = kept.get("figures") or [(file, text) for file, text in plain if (folder / file).is_file()]
    drawn += [(file, text) for file, text in others if file not in done and file != TREND]
    keep(comparison, values, drawn, folder, kept.get("remarks", ""))
