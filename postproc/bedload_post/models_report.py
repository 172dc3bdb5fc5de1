"""The report of a model comparison: figures, Table 2 beside the paper's, the paper's statements right or wrong.

`write` leaves the figures, numbers.json, README.md (to be kept) and report.html (the same with its figures
in one file) in a folder. Every sentence is made from the numbers.
"""

import html
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from . import bed_motion, flow_statistics, neighbours, path
from . import model_figures as figures
from . import paper_statements as paper
from .batches import HIGHEST_MEMORY, Estimate
from .bed_friction import friction_velocity
from .collision_statistics import STOKES_LIMITS, CollisionStatistics, collision_statistics, scales
from .flow_statistics import FlowStatistics
from .model_figures import MODELS, Case
from .outputs import MissingOutput, Run, Samples
from .report import image, page, table
from .paper_statements import CRITICAL_SHIELDS
from .states import CREEPING, JUMPING, NAMES, RESTING, unwrap
from .transport import Transport, jump_heights, measure

WAY_SHOWN = 26.0  # of the path in the figure, in D
MOST_SEPARATE = 20  # grains that may be meant to be far from each other
NEXT_TO_BED, ABOVE = (1.2, 1.55), (1.55, 2.5)  # y/D; a grain in a pocket is at 1.32 D
PAPER = "Vowinckel, Kempe, Fröhlich, Impact of collision models on particle transport in open channel flow"


@dataclass(frozen=True)
class Comparison:
    """What is compared and under which circumstances (date, commit, ranks, hours)."""

    title: str
    cases: Sequence[Case]
    setup: int  # of the paper, 1 or 2, whose numbers stand beside these; 0: neither
    circumstances: dict[str, str]
    bed: "Bed | None" = None  # the same bed without mobile grains
    scene: str = ""
    beside: dict[str, list[dict]] = field(default_factory=dict)  # numbers of other records by name

    @property
    def with_paper(self) -> bool:
        """Table 2 has values for these."""
        return self.setup == 2


@dataclass(frozen=True)
class Bed:
    """Friction of a bed without mobile grains."""

    u_tau: float  # over u_b
    reynolds: float  # u_tau H/nu
    source: str

    def shields(self, run: Run) -> float:
        """u_tau^2 rho_f/((rho_p - rho_f) g D) of the grains of `run` on this bed."""
        stress = run.value("fluid.density") * (self.u_tau * run.bulk_velocity) ** 2
        return stress / (run.submerged_weight * run.diameter)


def make_case(model: str, run: Run, flow_throughs: float) -> Case:
    """A run measured from `flow_throughs` L_x/u_b on."""
    since = flow_throughs * run.box[0] / run.bulk_velocity
    return Case(model, run, since, measure(run, since))


def numbers(case: Case, bed: Bed | None = None) -> dict:
    """Every number of the report for one run, as plain values; `bed`: without mobile grains."""
    run, t = case.run, case.transport
    through = run.box[0] / run.bulk_velocity
    time = np.concatenate(t.time)
    velocity = t.mean("velocity")
    phases = t.phases
    heights = jump_heights(phases, run.diameter)
    height = t.mean("height")
    collisions = collision_statistics(run, case.since)
    creep = phases.complete & (phases.state == CREEPING)
    path_length = float(phases.path[creep].sum())
    friction, source = friction_velocity(run, case.since)
    reynolds = friction * run.depth / run.viscosity
    weight = run.submerged_weight * run.diameter
    spread, spread_half = t.spread_of_height()
    spin, spin_half = t.mean_spin(JUMPING)
    found = {
        "model": case.model,
        "density_ratio": case.density_ratio,
        "flow_throughs": float((time[-1] - time[0]) / through),
        "discarded_flow_throughs": case.since / through,
        "grains": len(np.unique(phases.tag)),
        "mean_velocity": velocity.mean,
        "mean_velocity_interval": velocity.half_width,
        "batches": len(velocity.batches),
        "batch_memory": velocity.memory,
        "interval_too_narrow": velocity.too_narrow((time[-1] - time[0]) / through),
        "mean_height": height.mean,
        "mean_height_interval": height.half_width,
        "spread_of_height": spread,
        "spread_of_height_interval": _known(spread_half),
        "mean_spin": t.mean("spin").mean,
        "jumps": len(heights),
        "mean_jump_height": float(heights.mean()) if len(heights) else None,
        "mean_jump_height_interval": _known(
            1.96 * heights.std(ddof=1) / np.sqrt(len(heights)) if len(heights) > 1 else np.nan
        ),
        "share_moving": t.mean("moving").mean,
        "share_moving_interval": t.mean("moving").half_width,
        "jumping_spin": _known(spin),
        "jumping_spin_interval": _known(spin_half),
        "cells_per_diameter": run.diameter / (run.box[0] / run.value("grid.cells")[0]),
        "scales": {f"{style}: {what}": v for (style, what), v in scales(run).items()},
        **spin_over_height(t),
        **collision_numbers(collisions),
        **drift("velocity", *t.halves("velocity")),
        **drift("resting", *t.halves("share", RESTING)),
        "creeping_slip": float(phases.slip[creep].sum()) / path_length if path_length else None,
        "u_tau": friction / run.bulk_velocity,
        "u_tau_from": source,
        "re_tau": reynolds,
        "d_plus": reynolds * run.diameter / run.depth,
        "shields": run.value("fluid.density") * friction**2 / weight if weight else None,
    }
    if 1 < found["grains"] <= MOST_SEPARATE:
        near = neighbours.measure(run, case.since)
        if near is not None:
            found |= {"neighbours": near.sentence(), "share_near": near.share_near}
    if bed is not None:
        found |= {"bed_re_tau": bed.reynolds, "bed_u_tau_from": bed.source}
        found["bed_shields"] = bed.shields(run) if weight else None
    for state, name in enumerate(NAMES):
        share = t.share_of(state)
        found[f"share_{name}"], found[f"share_{name}_interval"] = share.mean, share.half_width
    return found


def _known(value: float) -> float | None:
    """None for what JSON has no word for."""
    return float(value) if np.isfinite(value) else None


def spin_over_height(transport: Transport) -> dict:
    """Largest mean omega_3 next to the bed with its height, and above it; None without samples there."""
    y, mean = transport.over_height(1)
    found: dict = {"spin_next_to_bed": None, "spin_peak_height": None, "spin_above": None}
    for name, (low, high) in (("spin_next_to_bed", NEXT_TO_BED), ("spin_above", ABOVE)):
        rows = np.flatnonzero((y >= low) & (y < high))
        if len(rows):
            peak = rows[np.argmax(np.abs(mean[rows]))]
            found[name] = float(mean[peak])
            if name == "spin_next_to_bed":
                found["spin_peak_height"] = float(y[peak])
    return found


def collision_numbers(found: CollisionStatistics) -> dict:
    """How many, how slow, how long and how deep."""
    numbers: dict = {"collisions": len(found)}
    for limit in STOKES_LIMITS:
        numbers[f"collisions_below_stokes_{limit:g}"] = _known(found.share_below(limit))
    for name in ("stokes", "duration", "overlap"):
        numbers[f"{name}_quantiles"] = [_known(q) for q in found.quantiles(name)]
    return numbers


def drift(name: str, first: Estimate, second: Estimate) -> dict:
    """Means of both halves, and whether they differ by more than their intervals."""
    difference = abs(second.mean - first.mean)
    half = float(np.hypot(first.half_width, second.half_width))
    return {
        f"{name}_halves": [first.mean, second.mean],
        f"{name}_halves_interval": _known(half),
        f"{name}_drifts": bool(difference > half) if np.isfinite(half) else None,
    }


def _rows(values: Sequence[dict], with_paper: bool) -> list[list[str]]:
    """The table of numbers: a row a quantity, a column a run."""

    def row(what: str, form) -> list[str]:
        return [what, *(form(v) for v in values)]

    def plain(name: str, digits: int = 3, scale: float = 1.0):
        return lambda v: "–" if v.get(name) is None else f"{scale * v[name]:.{digits}f}"

    def with_interval(name: str, digits: int = 3, scale: float = 1.0):
        return lambda v: (
            f"{scale * v[name]:.{digits}f} ± {scale * v[name + '_interval']:.{digits}f}"
        )

    def quantiles(name: str):
        return lambda v: ", ".join("–" if q is None else f"{q:.2g}" for q in v[name])

    def halves(name: str, scale: float = 1.0):
        return lambda v: " and ".join(f"{scale * half:.3g}" for half in v[f"{name}_halves"]) + (
            ": drifts" if v[f"{name}_drifts"] else ""
        )

    rows = [row("mean particle velocity / u_b", with_interval("mean_velocity"))]
    if with_paper:
        rows.append(row("the same in the paper", plain("paper_mean_velocity")))
    rows += [
        row(f"time {name}, %", with_interval(f"share_{name}", 1, 100.0)) for name in NAMES
    ]
    rows += [
        row("grains faster than 0.01 u_b, %", with_interval("share_moving", 1, 100.0)),
        row("mean height y / D", with_interval("mean_height")),
        row("spread of y / D", plain("spread_of_height")),
        row("mean ω₃ D / u_b", plain("mean_spin")),
        row("mean ω₃ D / u_b next to the bed, largest", plain("spin_next_to_bed")),
        row("mean |ω₃| D / u_b while jumping", plain("jumping_spin")),
        row("jumps", plain("jumps", 0)),
        row("mean jump height / D", plain("mean_jump_height")),
        row("L_slip / L while creeping (0 rolls, −1 slides)", plain("creeping_slip")),
        row("Re_τ of the bed without mobile grains", plain("bed_re_tau", 0)),
        row(f"Shields number of that bed (critical: {CRITICAL_SHIELDS})", plain("bed_shields", 4)),
        row("u_τ / u_b, the grains' drag included", plain("u_tau", 4)),
        row("Re_τ, the grains' drag included", plain("re_tau", 0)),
        row("D⁺, the grains' drag included", plain("d_plus", 1)),
        row("Shields number, the grains' drag included", plain("shields", 4)),
        row("flow-throughs measured", plain("flow_throughs", 1)),
        row("flow-throughs discarded before", plain("discarded_flow_throughs", 1)),
        row("collisions", plain("collisions", 0)),
        row("of them below St = 1, %", plain("collisions_below_stokes_1", 0, 100.0)),
        row("of them below St = 5, %", plain("collisions_below_stokes_5", 0, 100.0)),
        row("T / T_c: 5 %, median, 95 %", quantiles("duration_quantiles")),
        row("overlap / D: 5 %, median, 95 %", quantiles("overlap_quantiles")),
        row("mean velocity, first and second half", halves("velocity")),
        row("time resting, first and second half, %", halves("resting", 100.0)),
        row("cells to a diameter", plain("cells_per_diameter", 1)),
        row("batches", plain("batches", 0)),
        row("correlation of neighbouring batches", plain("batch_memory", 2)),
    ]
    return rows


def order_sentences(values: Sequence[dict]) -> str:
    """A sentence on the models' order for each density ratio that has two of them."""
    ratios = sorted({v["density_ratio"] for v in values})
    found = []
    for ratio in ratios:
        known = [v for v in values if v["density_ratio"] == ratio and v["model"] in MODELS]
        if len(known) > 1:
            text = order_sentence(known)
            found.append(
                text if len(ratios) == 1 else f"At ρp/ρf {ratio:g}: {text[0].lower()}{text[1:]}"
            )
    return " ".join(found)


def told_apart(a: dict, b: dict) -> bool:
    """Whether the intervals part the mean velocities of two runs; without an interval nothing is parted."""
    apart = abs(a["mean_velocity"] - b["mean_velocity"])
    return bool(apart >= np.hypot(a["mean_velocity_interval"], b["mean_velocity_interval"]))


def order_sentence(known: Sequence[dict]) -> str:
    """Whether the models stand in the paper's order, and which neighbours the intervals part."""
    order = sorted(known, key=lambda v: -v["mean_velocity"])
    names = [MODELS[v["model"]][0] for v in order]
    expected = [MODELS[m][0] for m in MODELS if m in {v["model"] for v in known}]
    text = "Mean velocity falls in the order " + " > ".join(names)
    text += ", the paper's." if names == expected else f"; the paper's is {' > '.join(expected)}."
    close = [
        f"{MODELS[a['model']][0]} and {MODELS[b['model']][0]}"
        for a, b in zip(order, order[1:], strict=False)
        if not told_apart(a, b)
    ]
    if close:
        text += f" The intervals do not part {'; '.join(close)}."
    return text


def interval_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """What ± is, and for which of the runs, by their `names`, it promises too much."""
    text = "± is a 95 % confidence interval from batches, wider where neighbouring ones are correlated."
    narrow = [name for name, v in zip(names, values, strict=True) if v["interval_too_narrow"]]
    if narrow:
        text += (
            f" It is still too narrow for {'; '.join(narrow)}: batches shorter than a flow-through, "
            f"or correlated by more than {HIGHEST_MEMORY:g}."
        )
    return text


def drift_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """Whether first and second half of the records differ."""
    told = {"velocity": "mean velocity", "resting": "time resting"}
    drifting = [
        f"{what} of {name}" for key, what in told.items()
        for name, v in zip(names, values, strict=True) if v[f"{key}_drifts"]
    ]  # fmt: skip
    if drifting:
        return "Drift: first and second half differ by more than their intervals in " + (
            "; ".join(drifting) + ", so these records are too short or began too early."
        )
    if any(v[f"{key}_drifts"] is None for key in told for v in values):
        return "Drift: some records are too short to compare their halves."
    return "No record drifts: first and second half agree within their intervals."


def collision_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """How many collisions each rule for slow impacts reaches, and how long they last in T_c."""
    parts = []
    for name, v in zip(names, values, strict=True):
        low, middle, high = v["duration_quantiles"]
        if v["collisions"] and middle is not None:
            parts.append(
                f"{name}: {100 * v['collisions_below_stokes_1']:.0f} % of {v['collisions']} collisions are "
                f"below St = 1, {100 * v['collisions_below_stokes_5']:.0f} % below 5; nine of ten last "
                f"{low:.2g} to {high:.2g} T_c, half of them less than {middle:.2g} T_c"
            )
    return "Collisions. " + "; ".join(parts) + "." if parts else ""


def neighbour_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """Whether several grains in one box are as good as several runs."""
    told = [f"{name}: {v['neighbours']}" for name, v in zip(names, values, strict=True) if "neighbours" in v]
    return "Several grains in one box. " + "; ".join(told) + "." if told else ""


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


def draw_figures(comparison: Comparison, folder: Path) -> list[tuple[str, str]]:
    """All figures as PNGs in `folder`; (file, caption) in the report's order. None is empty: what no run
    has is not drawn."""
    cases = comparison.cases
    table_2 = " (the paper's Table 2)" if comparison.with_paper else ""
    measured = [(case, collision_statistics(case.run, case.since)) for case in cases]
    flows = _profiles(cases)
    drawn = []

    def draw(name: str, caption: str, figure: Callable[[Path], bool | None]) -> None:
        if figure(folder / name) is not False:
            drawn.append((name, caption))

    draw("mean_velocity.png", f"Mean particle velocity{table_2}",
         lambda file: figures.mean_velocities(cases, file, comparison.with_paper))  # fmt: skip
    draw("heights.png", "PDF of the grains' height, mean spin and mean velocity over height",
         lambda file: figures.heights(cases, file))  # fmt: skip
    draw("jumping.png", "Jumping grains: spin and height of the jumps",
         lambda file: figures.jumping(cases, file))  # fmt: skip
    draw("creeping.png", "Creeping grains: velocity, spin, slip over the way between collisions",
         lambda file: figures.creeping(cases, file))  # fmt: skip
    draw("shares.png", "Share of time resting, creeping, jumping",
         lambda file: figures.shares(cases, file))  # fmt: skip
    draw("collisions.png", "Collisions: Stokes number of the impact, duration over T_c, largest overlap",
         lambda file: figures.collisions(measured, file))  # fmt: skip
    draw("series.png", "Mean velocity of all grains over time",
         lambda file: figures.velocity_series(cases, file))  # fmt: skip
    draw("motion.png", "Where and when grains of the bed move",
         lambda file: bed_motion.compare([(case.label, case.run) for case in cases], file))  # fmt: skip
    if flows:
        draw("flow.png", "The flow: mean velocity, rms, total shear stress",
             lambda file: figures.flow(flows, file))  # fmt: skip
    for case in cases:
        name = f"path-{case.model}" + (f"-{case.density_ratio:g}" if len(case.ratios) > 1 else "")
        tag = path.chosen_grain(case.transport.phases)
        samples = first_way(case.run.samples_of(tag, case.since), case.run)
        path.draw(case.run, case.transport.phases, samples, tag, folder / f"{name}.png", dpi=80)
        drawn.append((f"{name}.png", f"The longest way of a grain, {case.label}"))
    return drawn


def verdict_rows(comparison: Comparison, values: Sequence[dict]) -> list[list[str]]:
    """The paper's statements: where, what, right or wrong, what the runs give."""
    found = paper.verdicts(comparison.setup, values)
    return [[v.place, v.statement, v.word, v.found] for v in found]


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


def _change(other: dict, own: dict) -> str:
    """Of the mean velocity: in per cent of its own, or in u_b where that is not told apart from zero."""
    difference = other["mean_velocity"] - own["mean_velocity"]
    if abs(own["mean_velocity"]) > max(own["mean_velocity_interval"], 0.001):
        change = f"{100.0 * difference / own['mean_velocity']:+.0f} %"
    else:
        change = f"{difference:+.3f} u_b"
    return change if told_apart(other, own) else f"{change}, not told apart"


def beside_rows(comparison: Comparison, values: Sequence[dict]) -> list[list[str]]:
    """Mean velocities of other kept records beside these: a row a record, a column a model, and whether they differ."""
    if not comparison.beside:
        return []
    columns = [(v["model"], v["density_ratio"]) for v in values]

    def line(label: str, runs: Sequence[dict]) -> list[str]:
        by_column = {(v["model"], v["density_ratio"]): v for v in runs}
        cells = sorted({f"{v['cells_per_diameter']:.3g}" for v in runs if "cells_per_diameter" in v})
        texts, changes = [], []
        for column, own in zip(columns, values, strict=True):
            v = by_column.get(column)
            texts.append("–" if v is None else f"{v['mean_velocity']:.3f} ± {v['mean_velocity_interval']:.3f}")
            if v is not None and v is not own:
                changes.append(_change(v, own))
        return [label, ", ".join(cells) or "–", *texts, "; ".join(changes)]

    return [line("these", values), *(line(label, runs) for label, runs in comparison.beside.items())]


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """Rows of text as a Markdown table, the first one its head."""
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


@dataclass(frozen=True)
class Sections:
    """What both forms of the report are made of."""

    sentences: list[str]
    numbers: list[list[str]]
    verdicts: list[list[str]]
    experiments: list[str]
    beside: list[list[str]]
    facts: list[list[str]]
    drawn: list[tuple[str, str]]


def sections(
    comparison: Comparison, values: Sequence[dict], drawn: list[tuple[str, str]]
) -> Sections:
    names = [
        case.model_label + (f", ρp/ρf {case.density_ratio:g}" if len(case.ratios) > 1 else "")
        for case in comparison.cases
    ]
    sentences = [
        order_sentences(values), interval_sentence(names, values), drift_sentence(names, values),
        collision_sentence(names, values), neighbour_sentence(names, values),
    ]  # fmt: skip
    beside = beside_rows(comparison, values)
    return Sections(
        [text for text in sentences if text],
        [["", *names], *_rows(values, comparison.with_paper)],
        verdict_rows(comparison, values),
        experiment_lines(comparison, values),
        [["record", "cells to D", *names, "beside these"], *beside] if beside else [],
        [[name, value] for name, value in comparison.circumstances.items()],
        drawn,
    )


VERDICT_HEAD = ["where", "the paper", "here", "found"]


def html_page(title: str, parts: Sections, folder: Path, remarks: str) -> str:
    """The report as one file with its figures in it."""
    body = [f"<h1>{html.escape(title)}</h1>", f"<p>The paper: {html.escape(PAPER)}.</p>"]
    body += [f"<p>{html.escape(text)}</p>" for text in parts.sentences]
    body += [table(parts.numbers, ["", *["number"] * (len(parts.numbers[0]) - 1)]), remarks]
    if parts.verdicts:
        body += ["<h2>The paper's statements</h2>", table(parts.verdicts, [""] * 4, VERDICT_HEAD)]
    if parts.beside:
        head, *rows = parts.beside
        body += ["<h2>Mean velocity in other records</h2>", table(rows, [""] * len(head), head)]
    if parts.experiments:
        text = html.escape("\n".join(parts.experiments))
        body += [f"<h2>Experiments on what is off by more than 20 %</h2><pre>{text}</pre>"]
    body += [image(folder / file, caption) for file, caption in parts.drawn]
    body += [image(folder / "correlations.png", "Two-point correlations of u")]
    body += [image(folder / "picture.png", "The scene")]
    if (folder / "film.mp4").is_file():
        body.append('<p>Film of the moving bed: <a href="film.mp4">film.mp4</a></p>')
    body.append("<h2>Circumstances</h2>" + table(parts.facts, ("", "")))
    return page(title, body)


def markdown_page(title: str, parts: Sections, folder: Path, remarks: str) -> str:
    """The report for the folder of kept results, figures beside it."""
    text = [f"# {title}", f"The paper: {PAPER}.", *parts.sentences, markdown_table(parts.numbers)]
    if remarks:
        text.append(remarks)
    if parts.verdicts:
        text += ["## The paper's statements", markdown_table([VERDICT_HEAD, *parts.verdicts])]
    if parts.beside:
        text += ["## Mean velocity in other records", markdown_table(parts.beside)]
    if parts.experiments:
        lines = "\n".join(parts.experiments)
        text += ["## Experiments on what is off by more than 20 %", f"```\n{lines}\n```"]
    text.append("## Figures")
    text += [f"![{caption}]({file})" for file, caption in parts.drawn if not file.startswith("path-")]
    if (folder / "correlations.png").is_file():
        text.append("![two-point correlations of u](correlations.png)")
    text += ["## Circumstances", "\n".join(f"- {name}: {value}" for name, value in parts.facts)]
    return "\n\n".join(text) + "\n"


def write(comparison: Comparison, folder: Path, remarks: str = "") -> list[dict]:
    """Figures, report.html, README.md and numbers.json into `folder`; returns the numbers.

    `remarks`: paragraphs of HTML that stand under the table.
    """
    folder.mkdir(parents=True, exist_ok=True)
    ratios = tuple(sorted({case.density_ratio for case in comparison.cases}))
    cases = [replace(case, ratios=ratios) for case in comparison.cases]
    comparison = replace(comparison, cases=cases)
    values = [numbers(case, comparison.bed) for case in cases]
    for value in values if comparison.with_paper else ():
        if value["model"] in MODELS:
            value["paper_mean_velocity"] = MODELS[value["model"]][2]
    parts = sections(comparison, values, draw_figures(comparison, folder))
    kept = {"circumstances": comparison.circumstances, "runs": values}
    text = json.dumps(kept, indent=1, ensure_ascii=False, default=float)
    (folder / "numbers.json").write_text(text + "\n", encoding="utf-8")
    for name, form in (("report.html", html_page), ("README.md", markdown_page)):
        text = form(comparison.title, parts, folder, remarks)
        (folder / name).write_text(text, encoding="utf-8")
    return values
