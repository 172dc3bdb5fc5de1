"""The report of a model comparison: figures, Table 2 beside the paper's, numbers, one HTML file."""

import html
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from . import flow_statistics, path
from . import model_figures as figures
from .batches import HIGHEST_MEMORY
from .bed_friction import friction_velocity
from .flow_statistics import FlowStatistics
from .model_figures import MODELS, Case
from .outputs import MissingOutput, Run, Samples
from .report import image, page, table
from .states import CREEPING, NAMES, unwrap
from .transport import jump_heights, measure

CRITICAL_SHIELDS = 0.035
WAY_SHOWN = 26.0  # of the path in the figure, in D
PAPER = "Vowinckel, Kempe, Fröhlich, Impact of collision models on particle transport in open channel flow"


@dataclass(frozen=True)
class Comparison:
    """What is compared and under which circumstances (date, commit, ranks, hours)."""

    title: str
    cases: Sequence[Case]
    with_paper: bool  # Table 2 has values for these
    circumstances: dict[str, str]


def make_case(model: str, run: Run, flow_throughs: float) -> Case:
    """A run measured from `flow_throughs` L_x/u_b on."""
    since = flow_throughs * run.box[0] / run.bulk_velocity
    return Case(model, run, since, measure(run, since))


def numbers(case: Case) -> dict:
    """Every number of the report for one run, as plain values."""
    run, t = case.run, case.transport
    through = run.box[0] / run.bulk_velocity
    time = np.concatenate(t.time)
    velocity = t.mean("velocity")
    phases = t.phases
    heights = jump_heights(phases, run.diameter)
    creep = phases.complete & (phases.state == CREEPING)
    path_length = float(phases.path[creep].sum())
    friction, source = friction_velocity(run, case.since)
    reynolds = friction * run.depth / run.viscosity
    weight = run.submerged_weight * run.diameter
    y, density = t.height_pdf()
    width = y[1] - y[0]
    mean_y = float((y * density).sum() * width)
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
        "mean_height": mean_y,
        "spread_of_height": float(np.sqrt(((y - mean_y) ** 2 * density).sum() * width)),
        "mean_spin": t.mean("spin").mean,
        "jumps": len(heights),
        "mean_jump_height": float(heights.mean()) if len(heights) else None,
        "creeping_slip": float(phases.slip[creep].sum()) / path_length if path_length else None,
        "u_tau": friction / run.bulk_velocity,
        "u_tau_from": source,
        "re_tau": reynolds,
        "d_plus": reynolds * run.diameter / run.depth,
        "shields": run.value("fluid.density") * friction**2 / weight if weight else None,
    }
    for state, name in enumerate(NAMES):
        share = t.share_of(state)
        found[f"share_{name}"], found[f"share_{name}_interval"] = share.mean, share.half_width
    return found


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

    rows = [row("mean particle velocity / u_b", with_interval("mean_velocity"))]
    if with_paper:
        rows.append(row("the same in the paper", plain("paper_mean_velocity")))
    rows += [
        row(f"time {name}, %", with_interval(f"share_{name}", 1, 100.0)) for name in NAMES
    ]
    rows += [
        row("mean height y / D", plain("mean_height")),
        row("spread of y / D", plain("spread_of_height")),
        row("mean ω₃ D / u_b", plain("mean_spin")),
        row("jumps", plain("jumps", 0)),
        row("mean jump height / D", plain("mean_jump_height")),
        row("L_slip / L while creeping (0 rolls, −1 slides)", plain("creeping_slip")),
        row("u_τ / u_b", plain("u_tau", 4)),
        row("Re_τ", plain("re_tau", 0)),
        row("D⁺", plain("d_plus", 1)),
        row(f"Shields number (critical: {CRITICAL_SHIELDS})", plain("shields", 4)),
        row("flow-throughs measured", plain("flow_throughs", 1)),
        row("flow-throughs discarded before", plain("discarded_flow_throughs", 1)),
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
        if not a["mean_velocity"] - b["mean_velocity"]  # no interval parts nothing
        >= np.hypot(a["mean_velocity_interval"], b["mean_velocity_interval"])
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
    """All figures as PNGs in `folder`; (file, caption) in the report's order."""
    cases = comparison.cases
    figures.mean_velocities(cases, folder / "mean_velocity.png", comparison.with_paper)
    figures.heights(cases, folder / "heights.png")
    figures.jumping(cases, folder / "jumping.png")
    figures.creeping(cases, folder / "creeping.png")
    figures.shares(cases, folder / "shares.png")
    figures.velocity_series(cases, folder / "series.png")
    drawn = [
        (
            "mean_velocity.png",
            "Mean particle velocity" + (" (the paper's Table 2)" if comparison.with_paper else ""),
        ),
        ("heights.png", "PDF of the grains' height, mean spin and mean velocity over height"),
        ("jumping.png", "Jumping grains: spin and height of the jumps"),
        ("creeping.png", "Creeping grains: velocity, spin, slip over the way between collisions"),
        ("shares.png", "Share of time resting, creeping, jumping"),
        ("series.png", "Mean velocity of all grains over time"),
    ]
    flows = _profiles(cases)
    if flows:
        figures.flow(flows, folder / "flow.png")
        drawn.append(("flow.png", "The flow: mean velocity, rms, total shear stress"))
    for case in cases:
        name = f"path-{case.model}" + (f"-{case.density_ratio:g}" if len(case.ratios) > 1 else "")
        tag = path.chosen_grain(case.transport.phases)
        samples = first_way(case.run.samples_of(tag, case.since), case.run)
        path.draw(case.run, case.transport.phases, samples, tag, folder / f"{name}.png", dpi=80)
        drawn.append((f"{name}.png", f"The longest way of a grain, {case.label}"))
    return drawn


def write(comparison: Comparison, folder: Path, remarks: str = "") -> list[dict]:
    """Figures, report.html and numbers.json into `folder`; returns the numbers.

    `remarks`: paragraphs of HTML that stand under the table (what agrees, what does not, and why).
    """
    folder.mkdir(parents=True, exist_ok=True)
    ratios = tuple(sorted({case.density_ratio for case in comparison.cases}))
    cases = [replace(case, ratios=ratios) for case in comparison.cases]
    comparison = replace(comparison, cases=cases)
    values = [numbers(case) for case in cases]
    for value in values if comparison.with_paper else ():
        if value["model"] in MODELS:
            value["paper_mean_velocity"] = MODELS[value["model"]][2]
    drawn = draw_figures(comparison, folder)
    kept = {"circumstances": comparison.circumstances, "runs": values}
    text = json.dumps(kept, indent=1, ensure_ascii=False, default=float)
    (folder / "numbers.json").write_text(text + "\n", encoding="utf-8")
    names = [
        case.model_label + (f", ρp/ρf {case.density_ratio:g}" if len(ratios) > 1 else "")
        for case in cases
    ]
    rows = [["", *names], *_rows(values, comparison.with_paper)]
    facts = [[name, value] for name, value in comparison.circumstances.items()]
    film = folder / "film.mp4"
    body = [
        f"<h1>{html.escape(comparison.title)}</h1>",
        f"<p>{html.escape(order_sentences(values))} The paper: {html.escape(PAPER)}. "
        f"{html.escape(interval_sentence(names, values))}</p>",
        table(rows, ["", *["number"] * len(values)]),
        remarks,
        *(image(folder / file, caption) for file, caption in drawn),
        image(folder / "picture.png", "The scene"),
        '<p>Film of the moving bed: <a href="film.mp4">film.mp4</a></p>' if film.is_file() else "",
        "<h2>Circumstances</h2>" + table(facts, ("", "")),
    ]
    (folder / "report.html").write_text(page(comparison.title, body), encoding="utf-8")
    return values
