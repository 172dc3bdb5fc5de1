"""The paper's figures for several runs side by side, one curve a collision model.

A result is a Case: a run, its label and colour, and its Transport after the start-up. A row of panels
belongs to one density ratio, so that no panel has more curves than there are models. Bands and bars are
95 % intervals.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402

from .collision_statistics import (  # noqa: E402
    DURATION_EDGES, OVERLAP_EDGES, STOKES_EDGES, STOKES_LIMITS, CollisionStatistics,
)  # fmt: skip
from .flow_statistics import FlowStatistics  # noqa: E402
from .outputs import Run  # noqa: E402
from .path import COLOURS as STATE_COLOURS  # noqa: E402
from .states import CREEPING, JUMPING, NAMES  # noqa: E402
from .transport import Transport, creeping_slip, jump_heights, smooth  # noqa: E402

# Name of the model file, what the figures call it, its colour, and the paper's Table 2: mean
# particle velocity over u_b in Setup II.
MODELS = {
    "rpm": ("rpm", "#b2182b", 0.247),
    "rpm_hw": ("rpm + HW", "#ef8a62", 0.181),
    "actm": ("actm", "#2166ac", 0.121),
    "actm_hw": ("actm + HW", "#1b7837", 0.093),
}
SLIP_LENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 2.0, 16)])  # of creeping phases, in D
DPI, DPI_OF_TALL, TALL = 110, 80, 6.0  # a figure of several rows [inch] stays a small file
SPIN_BINS, VELOCITY_BINS = 5, 3  # over which PDFs are smoothed


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
        return MODELS.get(self.model, (self.model,))[0]

    @property
    def label(self) -> str:
        """The model, and the density ratio where there are several."""
        return self.model_label + (f", {self.density_ratio:g}" if len(self.ratios) > 1 else "")

    @property
    def colour(self) -> str:
        return MODELS.get(self.model, ("", "#555555"))[1]

    @property
    def density_ratio(self) -> float:
        return self.run.value("reference.sphere_density") / self.run.value("fluid.density")


def _save(figure, file: Path) -> None:
    figure.savefig(file, dpi=DPI if figure.get_figheight() < TALL else DPI_OF_TALL)
    plt.close(figure)


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


def _finish(axes, rows: Sequence[Sequence[Case]]) -> None:
    """Density ratios on the left where there are several, names of the models in the first panel."""
    for row, cases in zip(axes, rows, strict=True):
        if len(rows) > 1:
            row[0].set_ylabel(f"ρp/ρf = {cases[0].density_ratio:g}\n{row[0].get_ylabel()}")
    axes[0, 0].legend(frameon=False, fontsize=9)


def _band(axis, case: Case, x: np.ndarray, y: np.ndarray, half: np.ndarray) -> None:
    """A curve over x with its interval."""
    axis.plot(x, y, color=case.colour, label=case.model_label)
    axis.fill_between(x, y - half, y + half, color=case.colour, alpha=0.2, lw=0)


def _band_sideways(axis, case: Case, x: np.ndarray, y: np.ndarray, half: np.ndarray) -> None:
    """A profile over the height y with its interval."""
    axis.plot(x, y, color=case.colour, label=case.model_label)
    axis.fill_betweenx(y, x - half, x + half, color=case.colour, alpha=0.2, lw=0)


def heights(cases: Sequence[Case], file: Path) -> bool:
    """PDF of y, mean omega_3(y) and mean u_p(y)."""
    rows = rows_of(cases)
    figure, axes = _grid(rows, 3, 11, 4.0, sharey=True)
    for panels, own in zip(axes, rows, strict=True):
        for case in own:
            y, density = case.transport.height_pdf()
            half = case.transport.pdf_interval("height")
            kept = density > 0
            low = np.maximum(density - half, 1e-4)[kept]
            panels[0].plot(density[kept], y[kept], color=case.colour, label=case.model_label)
            panels[0].fill_betweenx(
                y[kept], low, (density + half)[kept], color=case.colour, alpha=0.2, lw=0
            )
            for row, panel in ((1, panels[1]), (2, panels[2])):
                y_mean, mean = case.transport.over_height(row)
                _band_sideways(panel, case, mean, y_mean, case.transport.over_height_interval(row))
        panels[0].set(
            xlabel="PDF of y/D", ylabel="y / D", xscale="log", ylim=(1.1, 3.5), xlim=(1e-3, 30)
        )
        panels[1].set(xlabel="mean ω₃ D / u_b")
        panels[2].set(xlabel="mean u_p / u_b")
        panels[1].axvline(0, color="#bbbbbb", lw=0.8, zorder=0)
    _finish(axes, rows)
    figure.suptitle("Grains over height (bed top at y = D, a grain in a pocket at 1.32 D)", fontsize=11)
    _save(figure, file)
    return True


def _pdfs(axis, cases: Sequence[Case], name: str, state: int, width: int) -> None:
    """Smoothed PDFs of spin or velocity in a state, of the cases that have any."""
    for case in cases:
        measured: Callable = getattr(case.transport, f"{name}_pdf")
        x, density = measured(state)
        if density.any():
            half = case.transport.pdf_interval(name, state, width)
            _band(axis, case, x, smooth(density, width), half)


def jumping(cases: Sequence[Case], file: Path) -> bool:
    """PDFs of omega_3 while jumping and of the jumps' heights; False where nothing jumps."""
    rows = [own for own in rows_of(cases) if any(_jumps(case).size for case in own)]
    if not rows:
        return False
    figure, axes = _grid(rows, 2, 9, 3.6)
    edges = np.linspace(0, 1.5, 31)
    for (spin, height), own in zip(axes, rows, strict=True):
        _pdfs(spin, own, "spin", JUMPING, SPIN_BINS)
        for case in own:
            values = _jumps(case)
            if len(values):
                counts = np.histogram(values, edges)[0] / (len(values) * np.diff(edges))
                height.stairs(
                    np.where(counts > 0, counts, np.nan), edges, color=case.colour,
                    label=f"{case.model_label}: {len(values)} jumps, mean {values.mean():.3f} D",
                )  # fmt: skip
        spin.set(xlabel=f"ω₃ D / u_b while jumping{_smoothed(SPIN_BINS)}", ylabel="PDF", xlim=(-1, 0.5))
        height.set(xlabel="jump height / D", ylabel="PDF", yscale="log")
        height.legend(frameon=False, fontsize=8)
    _finish(axes, rows)
    _save(figure, file)
    return True


def _jumps(case: Case) -> np.ndarray:
    return jump_heights(case.transport.phases, case.run.diameter)


def _smoothed(bins: int) -> str:
    return f"\n(running mean over {bins} bins)"


def creeping(cases: Sequence[Case], file: Path) -> bool:
    """PDFs of u_p and omega_3 while creeping, and L_slip over L; False where nothing creeps."""
    rows = [
        own for own in rows_of(cases)
        if any((c.transport.phases.state == CREEPING).any() for c in own)
    ]  # fmt: skip
    if not rows:
        return False
    figure, axes = _grid(rows, 3, 12, 3.6)
    for (speed, spin, slip), own in zip(axes, rows, strict=True):
        _pdfs(speed, own, "velocity", CREEPING, VELOCITY_BINS)
        _pdfs(spin, own, "spin", CREEPING, VELOCITY_BINS)
        for case in own:
            length, mean, error = creeping_slip(case.transport.phases, case.run.diameter, SLIP_LENGTHS)
            slip.errorbar(length, mean, 1.96 * error, color=case.colour, marker=".", lw=1)
        longest = float(slip.get_xlim()[1])
        slip.plot([0, longest], [0, -longest], "--", color="#999999", lw=1, label="slides: −L")
        slip.axhline(0, color="#999999", lw=0.8, label="rolls: 0")
        note = _smoothed(VELOCITY_BINS)
        speed.set(xlabel=f"u_p / u_b while creeping{note}", ylabel="PDF", xlim=(-0.2, 0.8))
        spin.set(xlabel=f"ω₃ D / u_b while creeping{note}", xlim=(-1, 0.5))
        slip.set(xlabel="L / D", ylabel="mean L_slip / D", xlim=(0, longest))
        slip.legend(frameon=False, fontsize=8)
    _finish(axes, rows)
    _save(figure, file)
    return True


def shares(cases: Sequence[Case], file: Path) -> bool:
    """Share of time in each state, as stacked bars: a group of models for each density ratio.

    Intervals end at 0 and 1."""
    rows = rows_of(cases)
    ordered = [case for own in rows for case in own]
    groups = np.repeat(np.arange(len(rows)), [len(own) for own in rows])
    places = np.arange(len(ordered)) + 0.8 * groups
    figure, axis = plt.subplots(figsize=(2.2 + 0.75 * len(ordered), 3.8), layout="constrained")
    below = np.zeros(len(ordered))
    for state, (name, colour) in enumerate(zip(NAMES, STATE_COLOURS, strict=True)):
        values = [case.transport.share_of(state) for case in ordered]
        top = below + [v.mean for v in values]
        axis.bar(places, top - below, 0.8, bottom=below, color=colour, label=name)
        if state < len(NAMES) - 1:  # the last boundary is 1
            half = [v.half_width for v in values] if state == 0 else [
                case.transport.share_of(len(NAMES) - 1).half_width for case in ordered
            ]  # fmt: skip
            within = [np.minimum(half, top), np.minimum(half, 1.0 - top)]  # no share is less than 0 or more than 1
            axis.errorbar(places, top, np.maximum(within, 0.0), fmt="none", ecolor="#222222", capsize=3, lw=1)
        below = top
    axis.set_xticks(places, [case.model_label for case in ordered], rotation=30, ha="right")
    for n, own in enumerate(rows):
        middle = places[groups == n].mean()
        axis.annotate(f"ρp/ρf = {own[0].density_ratio:g}", (middle, 1.04), ha="center", fontsize=9)
    axis.set(ylabel="share of time", ylim=(0, 1.12))
    axis.legend(frameon=False, bbox_to_anchor=(1.0, 0.5), loc="center left")
    _save(figure, file)
    return True


def mean_velocities(cases: Sequence[Case], file: Path, with_paper: bool) -> bool:
    """Table 2 as a figure: our means with their intervals, the paper's beside them."""
    rows = rows_of(cases)
    figure, axes = _grid([0], len(rows), 2.5 + 3.2 * len(rows), 3.6, sharey=True)
    for axis, own in zip(axes[0], rows, strict=True):
        for place, case in enumerate(own):
            mean = case.transport.mean("velocity")
            axis.errorbar(
                place, mean.mean, mean.half_width, color=case.colour, marker="o", capsize=4,
                label="here, 95 % interval" if place == 0 else None,
            )  # fmt: skip
            if with_paper and case.model in MODELS:
                paper = MODELS[case.model][2]
                axis.plot(place, paper, "k_", ms=22, label="paper" if place == 0 else None)
        axis.set_xticks(range(len(own)), [case.model_label for case in own])
        axis.set(ylim=(0, None), xlim=(-0.5, len(own) - 0.5))
        axis.set_title(f"ρp/ρf = {own[0].density_ratio:g}", fontsize=10)
    axes[0, 0].set_ylabel("mean particle velocity / u_b")
    axes[0, 0].legend(frameon=False)
    _save(figure, file)
    return True


def velocity_series(cases: Sequence[Case], file: Path) -> bool:
    """Mean velocity of all grains over time, averaged over one flow-through time."""
    rows = rows_of(cases)
    figure, axes = _grid(rows, 1, 9, 2.8)
    for (axis,), own in zip(axes, rows, strict=True):
        for case in own:
            through = case.run.box[0] / case.run.bulk_velocity
            time = np.concatenate(case.transport.time)
            values = case.transport.series("velocity")
            width = max(1, int(np.searchsorted(time, time[0] + through)))
            if len(values) <= 2 * width:
                width = 1
            axis.plot(
                smooth_inside(time, width) / through, smooth_inside(values, width),
                color=case.colour, label=case.model_label,
            )  # fmt: skip
            estimate = case.transport.mean("velocity")
            axis.axhline(estimate.mean, color=case.colour, lw=0.6, ls=":")
        axis.set(
            xlabel="time in flow-throughs L_x/u_b",
            ylabel="u_p / u_b, running mean\nover a flow-through", ylim=(0, None),
        )  # fmt: skip
    _finish(axes, rows)
    _save(figure, file)
    return True


def smooth_inside(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean over `width` values, where all of them are."""
    return np.convolve(values, np.full(width, 1.0 / width), mode="valid")


def collisions(measured: Sequence[tuple[Case, CollisionStatistics]], file: Path) -> bool:
    """Histograms of St, T/T_c and overlap of the collisions; False where there are none."""
    of_case = dict((id(case), found) for case, found in measured)
    rows = [
        [case for case in own if len(of_case[id(case)])]
        for own in rows_of([case for case, _ in measured])
    ]
    rows = [own for own in rows if own]
    kinds: tuple[tuple[str, np.ndarray, str], ...] = (
        ("stokes", STOKES_EDGES, "Stokes number of the impact"),
        ("duration", DURATION_EDGES, "duration T / T_c"),
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
                counts = np.histogram(values, edges)[0] / max(len(values), 1)
                axis.stairs(counts, edges, color=case.colour, label=case.model_label)
            axis.set(xscale="log", xlabel=label, ylabel="share of the collisions in a bin")
            for limit in {"stokes": STOKES_LIMITS, "duration": (1.0,)}.get(name, ()):
                axis.axvline(limit, color="#999999", lw=0.8, zorder=0)
    _finish(axes, rows)
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
            panels[0].plot(p["u"] / scale, y, color=case.colour, label=case.model_label)
            for axis, name, at in zip(panels[1:4], ("uu", "vv", "ww"), (y, face, y), strict=True):
                axis.plot(np.sqrt(np.maximum(p[name], 0)) / scale, at, color=case.colour)
            density = case.run.value("fluid.density")
            panels[4].plot(p.total_stress / (density * scale**2), face, color=case.colour)
        panels[0].set(xlabel="mean u / u_b (intrinsic)", ylabel="y / D")
        for axis, name in zip(panels[1:4], "uvw", strict=True):
            axis.set(xlabel=f"rms of {name} / u_b")
        panels[4].set(xlabel="total shear stress / ρ u_b²")
    _finish(axes, rows)
    _save(figure, file)
    return True
