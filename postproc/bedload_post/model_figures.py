"""The paper's figures for several runs side by side, one curve a collision model.

A result is a Case: a run, its label and colour, and its Transport after the start-up. A row of panels
belongs to one density ratio, so that no panel has more curves than there are models. Bands and bars are
95 % intervals; a curve that is too short of samples for one is drawn thin. Models with friction are dashed.
"""

import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402
from scipy.stats import chi2  # noqa: E402

from .collision_statistics import (  # noqa: E402
    DURATION_EDGES, OVERLAP_EDGES, STOKES_EDGES, STOKES_LIMITS, CollisionStatistics,
)  # fmt: skip
from .bed_friction import bed_top as top_of_bed  # noqa: E402
from .flow_statistics import FlowStatistics  # noqa: E402
from .outputs import Run  # noqa: E402
from .path import COLOURS as STATE_COLOURS  # noqa: E402
from .states import CREEPING, JUMPING, NAMES  # noqa: E402
from .transport import (  # noqa: E402
    SPIN_EDGES, VELOCITY_EDGES, Transport, creeping_slip, jump_heights, smooth,
)  # fmt: skip

# Name of the model file, what the figures call it, its colour, and the paper's Table 2: mean
# particle velocity over u_b in Setup II. Colours differ also to eyes that lack one kind of cones.
MODELS = {
    "rpm": ("rpm", "#a50f15", 0.247),
    "rpm_hw": ("rpm + HW", "#ef8a62", 0.181),
    "actm": ("actm", "#2166ac", 0.121),
    "actm_hw": ("actm + HW", "#41ae9f", 0.093),
}
PAPER_CELLS = 20  # to a diameter, of the paper's Setup II
JUMP_EDGES = np.linspace(0.0, 1.5, 16)  # heights of jumps, in D
FEWEST = 10  # jumps, creeping phases or collisions of a model that is drawn
SLIP_LENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 2.0, 16)])  # of creeping phases, in D
DPI = 110
LEGEND = 0.32  # height of the row of names over a figure [inch]
SPIN_BINS, VELOCITY_BINS = 5, 3  # over which PDFs are smoothed


def model_label(model: str) -> str:
    return MODELS.get(model, (model,))[0]


def model_colour(model: str) -> str:
    return MODELS.get(model, ("", "#555555"))[1]


def model_line(model: str) -> dict:
    """Colour, name and kind of a model's line: with friction dashed."""
    return {"color": model_colour(model), "label": model_label(model), "ls": (0, (5, 1.2)) if "_hw" in model else "-"}


def in_order(model: str, ratio: float) -> tuple[float, int, str]:
    """Sorts runs by density ratio and then as the paper's Table 2 has the models."""
    names = list(MODELS)
    return ratio, names.index(model) if model in names else len(names), model


@dataclass(frozen=True)
class Case:
    """One run of a comparison."""

    model: str
    run: Run
    since: float  # end of the start-up [T]
    transport: Transport
    ratios: tuple[float, ...] = ()  # density ratios of all cases beside which this one stands

    @property
    def model_label(self) -> str:
        return model_label(self.model)

    @property
    def label(self) -> str:
        """The model, and the density ratio where there are several."""
        return self.model_label + (f", {self.density_ratio:g}" if len(self.ratios) > 1 else "")

    @property
    def colour(self) -> str:
        return model_colour(self.model)

    @property
    def line(self) -> dict:
        """How its curves are drawn."""
        return model_line(self.model)

    @property
    def density_ratio(self) -> float:
        return self.run.value("reference.sphere_density") / self.run.value("fluid.density")


def _save(figure, file: Path) -> None:
    """In 256 colours: a third of the bytes, so that a figure of several rows stays a small file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=DPI)
    plt.close(figure)
    with Image.open(buffer) as picture:
        picture.convert("RGB").quantize(256).save(file, optimize=True)


def rows_of(cases: Sequence[Case]) -> list[list[Case]]:
    """The cases of each density ratio, the smallest first."""
    ratios = sorted({case.density_ratio for case in cases})
    return [[case for case in cases if case.density_ratio == ratio] for ratio in ratios]


def _grid(rows: Sequence, panels: int, width: float, height: float, **more):
    """A figure with a row of `panels` for each of `rows`."""
    return plt.subplots(
        len(rows), panels, figsize=(width, height * len(rows)), squeeze=False,
        layout="constrained", **more,
    )  # fmt: skip


def _finish(figure, axes, rows: Sequence[Sequence[Case]]) -> None:
    """Density ratios on the left where there are several, names of the models in a row over the panels."""
    for row, cases in zip(axes, rows, strict=True):
        if len(rows) > 1:
            row[0].set_ylabel(f"ρp/ρf = {cases[0].density_ratio:g}\n{row[0].get_ylabel()}")
    name_models(figure, (case.model for cases in rows for case in cases))


def name_models(figure, models: Iterable[str]) -> None:
    """A row of the models' names over the panels, where it hides nothing."""
    names = sorted(set(models), key=lambda model: in_order(model, 0.0))
    handles = [plt.Line2D([], [], **model_line(model)) for model in names]
    figure.legend(handles=handles, loc="upper center", ncol=len(handles), frameon=False, fontsize=9)
    share = LEGEND / figure.get_figheight()
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - share))


def _band(axis, case: Case, x: np.ndarray, y: np.ndarray, half: np.ndarray) -> None:
    """A density over x with its interval, which ends at zero."""
    axis.plot(x, y, **_thin_without(case, half))
    axis.fill_between(x, np.maximum(y - half, 0.0), y + half, color=case.colour, alpha=0.2, lw=0)


def _band_sideways(axis, case: Case, x: np.ndarray, y: np.ndarray, half: np.ndarray) -> None:
    """A profile over the height y with its interval."""
    axis.plot(x, y, **_thin_without(case, half))
    axis.fill_betweenx(y, x - half, x + half, color=case.colour, alpha=0.2, lw=0)


def _thin_without(case: Case, half: np.ndarray) -> dict:
    """The line of a case, thin where there is no interval."""
    return case.line | ({} if np.isfinite(half).any() else {"lw": 0.7})


def heights(cases: Sequence[Case], file: Path) -> bool:
    """PDF of y, mean omega_3(y) and mean u_p(y); False where no height has enough samples for a mean."""
    cases = [case for case in cases if len(case.transport.over_height(1)[0])]
    rows = rows_of(cases)
    if not rows:
        return False
    figure, axes = _grid(rows, 3, 11, 4.0, sharey=True)
    bed_top, pocket = top_of_bed(cases[0].run) / cases[0].run.diameter, pocket_height(cases[0].run)
    top = bed_top
    for panels, own in zip(axes, rows, strict=True):
        for case in own:
            y, density = case.transport.height_pdf()
            half = case.transport.pdf_interval("height")
            kept = density > 0
            low = np.maximum(density - half, 1e-4)[kept]
            panels[0].plot(density[kept], y[kept], **_thin_without(case, half))
            panels[0].fill_betweenx(
                y[kept], low, (density + half)[kept], color=case.colour, alpha=0.2, lw=0
            )
            top = max(top, float(case.transport.over_height(1)[0].max(initial=bed_top)))
            for row, panel in ((1, panels[1]), (2, panels[2])):
                y_mean, mean = case.transport.over_height(row)
                _band_sideways(panel, case, mean, y_mean, case.transport.over_height_interval(row))
        panels[0].set(xlabel="PDF of y / D", xscale="log", xlim=(1e-3, None))
        panels[0].set_ylabel(f"y / D (bed's top at {bed_top:g})")
        panels[1].set(xlabel="mean $\\omega_3 D / u_b$ of all grains at y")
        panels[2].set(xlabel="mean $u_p / u_b$ of all grains at y")
        panels[1].locator_params(axis="x", nbins=5)  # room for two digits behind the point
        panels[1].axvline(0, color="#bbbbbb", lw=0.8, zorder=0)
        for panel in panels if pocket else ():
            panel.axhline(pocket, color="#bbbbbb", lw=0.8, ls=":", zorder=0)
            panel.annotate("in a pocket", (0.98, pocket), xycoords=("axes fraction", "data"), ha="right", va="top",
                           fontsize=8, color="#777777")  # fmt: skip
    axes[0, 0].set_ylim(bed_top + 0.1, top + 0.2)
    _finish(figure, axes, rows)
    _save(figure, file)
    return True


def pocket_height(run: Run) -> float | None:
    """y/D of the centre of a grain on three neighbours of a bed of one layer; None without such a bed."""
    position, radius = run.fixed_spheres()
    if len(position) < 3 or np.ptp(position[:, 1]) > 1e-6 or np.ptp(radius) > 1e-6:
        return None
    first = np.linalg.norm(position[1:] - position[0], axis=1).min()
    reach = (radius[0] + 0.5 * run.diameter) ** 2 - first**2 / 3.0
    return float((position[0, 1] + np.sqrt(reach)) / run.diameter) if reach > 0 else None


def _pdfs(axis, cases: Sequence[Case], name: str, state: int, width: int) -> None:
    """Smoothed PDFs of spin or velocity in a state, of the cases that have any; the axes show where they are not
    next to nothing, and intervals by up to half of the highest curve."""
    shown = []
    for case in cases:
        measured: Callable = getattr(case.transport, f"{name}_pdf")
        x, density = measured(state)
        if density.any():
            half = case.transport.pdf_interval(name, state, width)
            smoothed = smooth(density, width)
            _band(axis, case, x, smoothed, half)
            upper = np.nanmax(smoothed + half, initial=0.0)
            shown.append((x[smoothed > 0.003 * smoothed.max()], smoothed.max(), upper))
    if shown:
        low, high = min(x.min() for x, _, _ in shown), max(x.max() for x, _, _ in shown)
        margin = 0.05 * (high - low)
        peak, top = (max(one[n] for one in shown) for n in (1, 2))
        axis.set(xlim=(low - margin, high + margin), ylim=(0, 1.05 * max(peak, min(top, 1.5 * peak))), ylabel="PDF")


def jumping(cases: Sequence[Case], file: Path) -> bool:
    """PDFs of omega_3 while jumping and of the jumps' heights; a density ratio has a row where a model jumps
    FEWEST times, and False is returned where none has. Intervals of the heights: of the counts, by Poisson."""
    kept = [case for case in cases if len(_jumps(case)) >= FEWEST]
    rows = rows_of(kept)
    if not rows:
        return False
    figure, axes = _grid(rows, 2, 9, 3.6)
    for (spin, height), own in zip(axes, rows, strict=True):
        _pdfs(spin, own, "spin", JUMPING, SPIN_BINS)
        for place, case in enumerate(own):
            x, density, low, high = counted_pdf(_jumps(case), JUMP_EDGES)
            aside = x + 0.012 * (place - 0.5 * (len(own) - 1))
            height.errorbar(aside, density, (density - low, high - density), **case.line, marker=".", capsize=2, lw=1)
        spin.set_xlabel(f"$\\omega_3 D / u_b$ while jumping{_smoothed(SPIN_BINS, SPIN_EDGES)}")
        height.set(xlabel="jump height / D (bins of 0.1)", ylabel="PDF", yscale="log")
    _finish(figure, axes, rows)
    _save(figure, file)
    return True


def counted_pdf(values: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(centre, density, lower and upper end of its 95 % interval) of the bins that hold something; the interval is
    Poisson's for the count, so values have to be independent."""
    counts = np.histogram(values, edges)[0]
    kept = counts > 0
    n, area = counts[kept], len(values) * np.diff(edges)[kept]
    low, high = 0.5 * chi2.ppf(0.025, 2 * n), 0.5 * chi2.ppf(0.975, 2 * n + 2)
    return 0.5 * (edges[1:] + edges[:-1])[kept], n / area, low / area, high / area


def _jumps(case: Case) -> np.ndarray:
    return jump_heights(case.transport.phases, case.run.diameter)


def _creeping_phases(case: Case) -> int:
    phases = case.transport.phases
    return int((phases.complete & (phases.state == CREEPING)).sum())


def _smoothed(bins: int, edges: np.ndarray) -> str:
    return f"\n(running mean over {bins} bins of {edges[1] - edges[0]:.3g})"


def creeping(cases: Sequence[Case], file: Path) -> bool:
    """PDFs of u_p and omega_3 while creeping, and L_slip over L; False where hardly anything creeps."""
    rows = rows_of([case for case in cases if _creeping_phases(case) >= FEWEST])
    if not rows:
        return False
    figure, axes = _grid(rows, 3, 12, 3.6)
    for (speed, spin, slip), own in zip(axes, rows, strict=True):
        _pdfs(speed, own, "velocity", CREEPING, VELOCITY_BINS)
        _pdfs(spin, own, "spin", CREEPING, SPIN_BINS)
        longest = 0.0
        for case in own:
            length, mean, half = creeping_slip(case.transport.phases, case.run.diameter, SLIP_LENGTHS)
            slip.errorbar(length, mean, half, **case.line, marker=".", lw=1)
            longest = max(longest, float(length.max(initial=0.0)))
        longest = 1.05 * longest or 1.0
        slip.plot([0, longest], [0, -longest], ":", color="#777777", lw=1)
        slip.axhline(0, color="#777777", lw=0.8)
        for text, x, y in (("rolls: 0", 0.45, 0.06), ("slides: −L", 0.7, -0.88)):
            slip.annotate(text, (x * longest, y * longest), ha="center", va="center", fontsize=8, color="#555555")
        speed.set_xlabel(f"$u_p / u_b$ while creeping{_smoothed(VELOCITY_BINS, VELOCITY_EDGES)}")
        spin.set_xlabel(f"$\\omega_3 D / u_b$ while creeping{_smoothed(SPIN_BINS, SPIN_EDGES)}")
        slip.set(xlabel="L / D, way between two collisions", ylabel="mean $L_{slip}$ / D", xlim=(0, longest),
                 ylim=(-1.05 * longest, 0.12 * longest))  # fmt: skip
    _finish(figure, axes, rows)
    _save(figure, file)
    return True


def _by_ratio(values: Sequence[dict]) -> list[list[dict]]:
    """Numbers of runs by density ratio, the smallest first, and then as they stand."""
    return [[v for v in values if v["density_ratio"] == r] for r in sorted({v["density_ratio"] for v in values})]


def shares(values: Sequence[dict], file: Path) -> bool:
    """Share of time in each state, as stacked bars: a group of models for each density ratio.

    Intervals end at 0 and 1, and stand beside each other where both boundaries have one."""
    rows = _by_ratio(values)
    ordered = [v for own in rows for v in own]
    groups = np.repeat(np.arange(len(rows)), [len(own) for own in rows])
    places = np.arange(len(ordered)) + 0.8 * groups
    figure, axis = plt.subplots(figsize=(2.2 + 0.75 * len(ordered), 3.8), layout="constrained")
    below = np.zeros(len(ordered))
    # The first boundary is the share of the first state, the second what the last one leaves.
    of_boundary, aside = (NAMES[0], NAMES[-1]), (-0.12, 0.12)
    for state, (name, colour) in enumerate(zip(NAMES, STATE_COLOURS, strict=True)):
        top = below + [v[f"share_{name}"] for v in ordered]
        axis.bar(places, top - below, 0.8, bottom=below, color=colour, label=name)
        if state < len(of_boundary):
            half = np.array([v[f"share_{of_boundary[state]}_interval"] for v in ordered])
            within = np.maximum([np.minimum(half, top), np.minimum(half, 1.0 - top)], 0.0)
            axis.errorbar(places + aside[state], top, within, fmt="none", ecolor="#222222", capsize=3, lw=1)
        below = top
    axis.set_xticks(places, [model_label(v["model"]) for v in ordered], rotation=30, ha="right")
    for n, own in enumerate(rows):
        middle = places[groups == n].mean()
        axis.annotate(f"ρp/ρf = {own[0]['density_ratio']:g}", (middle, 1.04), ha="center", fontsize=9)
    axis.set(ylabel="share of time (bars: 95 % intervals\nof the boundaries)", ylim=(0, 1.12))
    axis.legend(frameon=False, bbox_to_anchor=(1.0, 0.5), loc="center left")
    _save(figure, file)
    return True


def mean_velocities(values: Sequence[dict], file: Path, with_paper: bool) -> bool:
    """Table 2 as a figure: our means with their intervals, the paper's beside them."""
    rows = _by_ratio(values)
    figure, axes = _grid([0], len(rows), 2.5 + 3.2 * len(rows), 3.6, sharey=True)
    for axis, own in zip(axes[0], rows, strict=True):
        for place, v in enumerate(own):
            axis.errorbar(
                place, v["mean_velocity"], v["mean_velocity_interval"], color=model_colour(v["model"]), marker="o",
                capsize=4,
            )  # fmt: skip
            if with_paper and v["model"] in MODELS:
                axis.plot(place, MODELS[v["model"]][2], "k_", ms=22)
        axis.set_xticks(range(len(own)), [model_label(v["model"]) for v in own])
        axis.set(ylim=(-0.02 * axis.get_ylim()[1], None), xlim=(-0.5, len(own) - 0.5))
        axis.set_title(f"ρp/ρf = {own[0]['density_ratio']:g}", fontsize=10)
    axes[0, 0].set_ylabel("mean particle velocity / $u_b$")
    handles = [plt.Line2D([], [], color="#555555", marker="o", label="here, 95 % interval")]
    if with_paper:
        handles.append(plt.Line2D([], [], color="k", marker="_", ms=14, ls="none", label="paper"))
    axes[0, -1].legend(handles=handles, frameon=False, fontsize=9)
    _save(figure, file)
    return True


def trend(records: Sequence[Sequence[dict]], file: Path, with_paper: bool) -> bool:
    """Mean velocity over cells to a diameter with intervals, a panel for each density ratio; a line joins the
    longest record of each resolution, others stand beside it. False where no model has two resolutions."""
    runs = [v for record in records for v in record if "cells_per_diameter" in v]
    rows = [own for own in _by_ratio(runs) if any(len(resolutions(own, m)) > 1 for m in _models(own))]
    if not rows:
        return False
    figure, axes = _grid([0], len(rows), 2.0 + 3.6 * len(rows), 3.6, sharey=True)
    for axis, own in zip(axes[0], rows, strict=True):
        models = _models(own)
        for place, model in enumerate(models):
            # Models, and records of one resolution, stand beside each other: no bar hides another.
            aside = 1.0 + 0.035 * (place - 0.5 * (len(models) - 1))
            style, longest = model_line(model), resolutions(own, model)
            cells = np.array(sorted(longest))
            axis.plot(cells * aside, [longest[c]["mean_velocity"] for c in cells], **style)
            for c in cells:
                others = [v for v in own if v["model"] == model and v is not longest[c] and _cells(v) == c]
                for n, v in enumerate([longest[c], *others]):
                    axis.errorbar(
                        c * (aside + 0.008 * n), v["mean_velocity"], v["mean_velocity_interval"], color=style["color"],
                        marker="o", ms=3 if n else 5, mfc="white" if n else style["color"], capsize=2, lw=1,
                    )  # fmt: skip
            if with_paper and model in MODELS:
                axis.plot(PAPER_CELLS * aside, MODELS[model][2], "D", ms=7, mfc="none", color=style["color"])
        axis.set(xlabel="cells to a diameter (D / h)", ylim=(-0.02 * axis.get_ylim()[1], None), xscale="log")
        ticks = sorted({_cells(v) for v in own} | ({PAPER_CELLS} if with_paper else set()))
        axis.set_xticks(ticks, [f"{c:g}" for c in ticks])
        axis.set_xticks([], minor=True)
        of_paper = ", diamonds: the paper" if with_paper else ""
        axis.set_title(f"ρp/ρf = {own[0]['density_ratio']:g}{of_paper}", fontsize=10)
    axes[0, 0].set_ylabel("mean particle velocity / $u_b$")
    name_models(figure, (v["model"] for own in rows for v in own))
    _save(figure, file)
    return True


def _cells(v: dict) -> float:
    return round(v["cells_per_diameter"], 3)


def _models(runs: Sequence[dict]) -> list[str]:
    return sorted({v["model"] for v in runs}, key=lambda model: in_order(model, 0.0))


def resolutions(runs: Sequence[dict], model: str) -> dict[float, dict]:
    """The longest record of `model` at each number of cells to a diameter, of runs of one density ratio."""
    found: dict[float, dict] = {}
    for v in sorted(runs, key=lambda v: v["flow_throughs"]):
        if v["model"] == model:
            found[_cells(v)] = v
    return found


def velocity_series(cases: Sequence[Case], file: Path) -> bool:
    """Mean velocity of all grains over time, averaged over one flow-through time where the record has more than two;
    means with their intervals stand behind the end."""
    rows = rows_of(cases)
    figure, axes = _grid(rows, 1, 9, 2.8)
    for (axis,), own in zip(axes, rows, strict=True):
        averaged = []
        for place, case in enumerate(own):
            through = case.run.box[0] / case.run.bulk_velocity
            time = np.concatenate(case.transport.time)
            values = case.transport.series("velocity")
            width = max(1, int(np.searchsorted(time, time[0] + through)))
            averaged.append(len(values) > 2 * width)
            if not averaged[-1]:
                width = 1
            axis.plot(smooth_inside(time, width) / through, smooth_inside(values, width), **case.line)
            estimate = case.transport.mean("velocity")
            behind = (time[-1] + (0.02 + 0.015 * place) * (time[-1] - time[0])) / through
            axis.errorbar(behind, estimate.mean, estimate.half_width, color=case.colour, marker="o", ms=4, capsize=3)
        axis.set(
            xlabel="time in flow-throughs $L_x/u_b$; behind the end: means and 95 % intervals",
            ylabel="$u_p / u_b$" + (", running mean\nover a flow-through" if any(averaged) else "")
            + ("\n(not of short records)" if any(averaged) and not all(averaged) else ""), ylim=(0, None),
        )  # fmt: skip
    _finish(figure, axes, rows)
    _save(figure, file)
    return True


def smooth_inside(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean over `width` values, where all of them are."""
    return np.convolve(values, np.full(width, 1.0 / width), mode="valid")


def collisions(measured: Sequence[tuple[Case, CollisionStatistics]], file: Path) -> bool:
    """Histograms of St, T/T_c and overlap of the collisions; False where no case has FEWEST, of which one would fill
    the panel."""
    of_case = dict((id(case), found) for case, found in measured)
    rows = [
        [case for case in own if len(of_case[id(case)]) >= FEWEST]
        for own in rows_of([case for case, _ in measured])
    ]
    rows = [own for own in rows if own]
    kinds: tuple[tuple[str, np.ndarray, str], ...] = (
        ("stokes", STOKES_EDGES, "Stokes number of the impact"),
        ("duration", DURATION_EDGES, "duration $T / T_c$ (actm)"),
        ("overlap", OVERLAP_EDGES, "largest overlap / D"),
    )
    kinds = tuple(
        kind for kind in kinds
        if any(_positive(of_case[id(c)], kind[0]).size for own in rows for c in own)
    )  # fmt: skip
    if not rows or not kinds:
        return False
    figure, axes = _grid(rows, len(kinds), 4 * len(kinds), 3.4)
    for panels, own in zip(axes, rows, strict=True):
        for axis, (name, edges, label) in zip(panels, kinds, strict=True):
            for case in own:
                values = _positive(of_case[id(case)], name)
                if len(values) >= FEWEST:
                    counts = np.histogram(values, edges)[0] / len(values)
                    axis.stairs(counts, edges, **case.line)
            axis.set(xscale="log", xlabel=label, ylabel="share of the collisions in a bin")
            if not axis.patches:
                axis.set(xlim=(edges[0], edges[-1]), yticks=[])
                axis.annotate(f"fewer than {FEWEST} collisions with a value", (0.5, 0.5), xycoords="axes fraction",
                              ha="center", fontsize=9, color="#777777")  # fmt: skip
            for limit in {"stokes": STOKES_LIMITS, "duration": (1.0,)}.get(name, ()):
                axis.axvline(limit, color="#999999", lw=0.8, zorder=0)
                axis.annotate(f"{limit:g}", (limit, 1.0), xycoords=("data", "axes fraction"), ha="center", va="bottom",
                              fontsize=8, color="#777777")  # fmt: skip
    _finish(figure, axes, rows)
    _save(figure, file)
    return True


def _positive(found: CollisionStatistics, name: str) -> np.ndarray:
    values = getattr(found, name)
    return values[np.isfinite(values) & (values > 0)]


def flow(profiles: Sequence[tuple[Case, FlowStatistics]], file: Path) -> bool:
    """Mean velocity, rms and shear stress over height; averages over the fluid alone (intrinsic)."""
    of_case = dict((id(case), p) for case, p in profiles)
    rows = rows_of([case for case, _ in profiles])
    figure, axes = _grid(rows, 5, 15, 3.8, sharey=True)
    for panels, own in zip(axes, rows, strict=True):
        for case in own:
            p = of_case[id(case)]
            scale, length = case.run.bulk_velocity, case.run.diameter
            y, face = p["y"] / length, p["y_face"] / length
            panels[0].plot(p["u"] / scale, y, **case.line)
            for axis, name, at in zip(panels[1:4], ("uu", "vv", "ww"), (y, face, y), strict=True):
                axis.plot(np.sqrt(np.maximum(p[name], 0)) / scale, at, **case.line)
            density = case.run.value("fluid.density")
            panels[4].plot(p.total_stress / (density * scale**2), face, **case.line)
        bed_top = top_of_bed(own[0].run) / own[0].run.diameter
        panels[0].set(xlabel="mean $u / u_b$ (intrinsic)", ylabel=f"y / D (bed's top at {bed_top:g})")
        for axis, name in zip(panels[1:4], "uvw", strict=True):
            axis.set(xlabel=f"rms of ${name} / u_b$")
        panels[4].set(xlabel="total shear stress / $\\rho u_b^2$")
        for axis in panels:
            axis.axhline(bed_top, color="#bbbbbb", lw=0.8, ls=":", zorder=0)
    _finish(figure, axes, rows)
    _save(figure, file)
    return True
