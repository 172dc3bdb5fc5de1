"""The paper's figures for several runs side by side, one curve a collision model.

A result is a Case: a run, its label and colour, and its Transport after the start-up.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402

from .flow_statistics import FlowStatistics  # noqa: E402
from .outputs import Run  # noqa: E402
from .path import COLOURS as STATE_COLOURS  # noqa: E402
from .states import CREEPING, JUMPING, NAMES  # noqa: E402
from .transport import Transport, creeping_slip, jump_heights  # noqa: E402

# Name of the model file, what the figures call it, its colour, and the paper's Table 2: mean
# particle velocity over u_b in Setup II.
MODELS = {
    "rpm": ("rpm", "#b2182b", 0.247),
    "rpm_hw": ("rpm + HW", "#ef8a62", 0.181),
    "actm": ("actm", "#2166ac", 0.121),
    "actm_hw": ("actm + HW", "#1b7837", 0.093),
}
SLIP_LENGTHS = np.concatenate([[0.0], np.geomspace(0.02, 2.0, 16)])  # of creeping phases, in D
PNG = {"dpi": 110}
LINES = ("-", "--", ":", "-.")


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
    def dashes(self) -> str:
        """Style of its lines: by density ratio, as the colour is by model."""
        return LINES[self.ratios.index(self.density_ratio) % len(LINES)] if self.ratios else "-"

    @property
    def colour(self) -> str:
        return MODELS.get(self.model, ("", "#555555"))[1]

    @property
    def density_ratio(self) -> float:
        return self.run.value("reference.sphere_density") / self.run.value("fluid.density")


def _save(figure, file: Path) -> None:
    figure.savefig(file, **PNG)
    plt.close(figure)


def _smooth(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean over `width` bins: histograms of a short record are ragged."""
    return np.convolve(values, np.full(width, 1.0 / width), mode="same")


def _legend(axis, cases: Sequence[Case], **more) -> None:
    """Names of the cases, small where they are many."""
    axis.legend(frameon=False, fontsize=None if len(cases) <= len(MODELS) else 6, **more)


def heights(cases: Sequence[Case], file: Path) -> None:
    """PDF of y, mean omega_3(y) and mean u_p(y)."""
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.2), sharey=True, layout="constrained")
    for case in cases:
        y, density = case.transport.height_pdf()
        shown = np.where(density > 0, density, np.nan)
        axes[0].plot(shown, y, case.dashes, color=case.colour, label=case.label)
        for row, panel in ((1, axes[1]), (2, axes[2])):
            y, mean = case.transport.over_height(row)
            panel.plot(mean, y, case.dashes, color=case.colour)
    axes[0].set(xlabel="PDF of y/D", ylabel="y / D", xscale="log", ylim=(1.1, 3.5), xlim=(1e-3, 30))
    axes[1].set(xlabel="mean ω₃ D / u_b")
    axes[2].set(xlabel="mean u_p / u_b")
    axes[1].axvline(0, color="#bbbbbb", lw=0.8, zorder=0)
    _legend(axes[0], cases)
    figure.suptitle("Grains over height (bed top at y = D, a grain in a pocket at 1.32 D)", fontsize=11)
    _save(figure, file)


def jumping(cases: Sequence[Case], file: Path) -> None:
    """PDFs of omega_3 while jumping and of the jumps' heights."""
    figure, (spin, height) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
    edges = np.linspace(0, 1.5, 31)
    for case in cases:
        x, density = case.transport.spin_pdf(JUMPING)
        spin.plot(x, _smooth(density, 5), case.dashes, color=case.colour, label=case.label)
        values = jump_heights(case.transport.phases, case.run.diameter)
        if len(values):
            counts = np.histogram(values, edges)[0] / (len(values) * np.diff(edges))
            label = f"{case.label}: {len(values)} jumps, mean {values.mean():.3f} D"
            height.stairs(
                np.where(counts > 0, counts, np.nan), edges,
                color=case.colour, ls=case.dashes, label=label,
            )  # fmt: skip
    spin.set(xlabel="ω₃ D / u_b while jumping", ylabel="PDF", xlim=(-1, 0.5))
    height.set(xlabel="jump height / D", ylabel="PDF", yscale="log")
    _legend(spin, cases)
    height.legend(frameon=False, fontsize=8 if len(cases) <= len(MODELS) else 6)
    _save(figure, file)


def creeping(cases: Sequence[Case], file: Path) -> None:
    """PDFs of u_p and omega_3 while creeping, and L_slip over L."""
    figure, (speed, spin, slip) = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
    for case in cases:
        x, density = case.transport.velocity_pdf(CREEPING)
        speed.plot(x, _smooth(density, 3), case.dashes, color=case.colour, label=case.label)
        x, density = case.transport.spin_pdf(CREEPING)
        spin.plot(x, _smooth(density, 3), case.dashes, color=case.colour)
        length, mean, error = creeping_slip(case.transport.phases, case.run.diameter, SLIP_LENGTHS)
        slip.errorbar(length, mean, error, color=case.colour, ls=case.dashes, marker=".", lw=1)
    longest = float(slip.get_xlim()[1])
    slip.plot([0, longest], [0, -longest], "--", color="#999999", lw=1, label="slides: −L")
    slip.axhline(0, color="#999999", lw=0.8, label="rolls: 0")
    speed.set(xlabel="u_p / u_b while creeping", ylabel="PDF", xlim=(-0.2, 0.8))
    spin.set(xlabel="ω₃ D / u_b while creeping", xlim=(-1, 0.5))
    slip.set(xlabel="L / D", ylabel="mean L_slip / D", xlim=(0, longest))
    _legend(speed, cases)
    slip.legend(frameon=False, fontsize=8)
    _save(figure, file)


def shares(cases: Sequence[Case], file: Path) -> None:
    """Share of time in each state: over the density ratio, or side by side where there is one."""
    ratios = sorted({case.density_ratio for case in cases})
    models = list(dict.fromkeys(case.model for case in cases))
    if len(ratios) == 1:
        figure, axis = plt.subplots(figsize=(6, 3.6), layout="constrained")
        for state, (name, colour) in enumerate(zip(NAMES, STATE_COLOURS, strict=True)):
            values = [case.transport.share_of(state) for case in cases]
            axis.bar(
                np.arange(len(cases)) + 0.27 * (state - 1), [v.mean for v in values], 0.25,
                yerr=[v.half_width for v in values], color=colour, label=name, capsize=2,
            )  # fmt: skip
        axis.set_xticks(range(len(cases)), [case.label for case in cases])
        axis.set(ylabel="share of time", title=f"ρp/ρf = {ratios[0]:g}", ylim=(0, None))
        axis.legend(frameon=False)
    else:
        figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), sharey=True, layout="constrained")
        for state, (name, axis) in enumerate(zip(NAMES, axes, strict=True)):
            for model in models:
                own = sorted((c for c in cases if c.model == model), key=lambda c: c.density_ratio)
                values = [c.transport.share_of(state) for c in own]
                axis.errorbar(
                    [c.density_ratio for c in own], [v.mean for v in values],
                    [v.half_width for v in values], color=own[0].colour, marker="o", capsize=3,
                    label=own[0].model_label,
                )  # fmt: skip
            axis.set(title=name, xlabel="ρp / ρf", ylim=(-0.02, 1.02))
        axes[0].set(ylabel="share of time")
        axes[0].legend(frameon=False)
    _save(figure, file)


def mean_velocities(cases: Sequence[Case], file: Path, with_paper: bool) -> None:
    """Table 2 as a figure: our means with their intervals, the paper's beside them."""
    figure, axis = plt.subplots(figsize=(6, 3.6), layout="constrained")
    for place, case in enumerate(cases):
        mean = case.transport.mean("velocity")
        axis.errorbar(
            place, mean.mean, mean.half_width, color=case.colour, marker="o", capsize=4,
            label="here, 95 % interval" if place == 0 else None,
        )  # fmt: skip
        if with_paper and case.model in MODELS:
            paper = MODELS[case.model][2]
            axis.plot(place, paper, "k_", ms=22, label="paper" if place == 0 else None)
    axis.set_xticks(
        range(len(cases)), [case.label for case in cases],
        rotation=0 if len(cases) <= len(MODELS) else 60,
    )  # fmt: skip
    axis.set(ylabel="mean particle velocity / u_b", ylim=(0, None), xlim=(-0.5, len(cases) - 0.5))
    axis.legend(frameon=False)
    _save(figure, file)


def velocity_series(cases: Sequence[Case], file: Path) -> None:
    """Mean velocity of all grains over time, averaged over one flow-through time."""
    figure, axis = plt.subplots(figsize=(9, 3.2), layout="constrained")
    for case in cases:
        through = case.run.box[0] / case.run.bulk_velocity
        time = np.concatenate(case.transport.time)
        values = case.transport.series("velocity")
        width = max(1, int(np.searchsorted(time, time[0] + through)))
        if len(values) > 2 * width:
            axis.plot(
                np.convolve(time, np.full(width, 1 / width), mode="valid") / through,
                np.convolve(values, np.full(width, 1 / width), mode="valid"),
                case.dashes, color=case.colour, label=case.label,
            )  # fmt: skip
        estimate = case.transport.mean("velocity")
        axis.axhline(estimate.mean, color=case.colour, lw=0.6, ls=":")
    axis.set(xlabel="time in flow-throughs L_x/u_b", ylabel="u_p / u_b, running mean", ylim=(0, None))
    _legend(axis, cases, ncol=4)
    _save(figure, file)


def flow(profiles: Sequence[tuple[Case, FlowStatistics]], file: Path) -> None:
    """Mean velocity, rms and shear stress over height; averages over the fluid alone (intrinsic)."""
    figure, axes = plt.subplots(1, 3, figsize=(12, 4), sharey=True, layout="constrained")
    for case, p in profiles:
        scale, length = case.run.bulk_velocity, case.run.diameter
        y, face = p["y"] / length, p["y_face"] / length
        axes[0].plot(p["u"] / scale, y, case.dashes, color=case.colour, label=case.label)
        for name, at, style in (("uu", y, "-"), ("vv", face, "--"), ("ww", y, ":")):
            axes[1].plot(np.sqrt(np.maximum(p[name], 0)) / scale, at, style, color=case.colour, lw=1)
        density = case.run.value("fluid.density")
        axes[2].plot(p.total_stress / (density * scale**2), face, color=case.colour)
        line = p.driving * (p["y_face"][-1] - p["y_face"]) / (density * scale**2)
        axes[2].plot(line, face, "--", color=case.colour, lw=0.6)
    axes[0].set(xlabel="mean u / u_b (intrinsic)", ylabel="y / D")
    axes[1].set(xlabel="rms of u (—), v (- -), w (···) / u_b")
    axes[2].set(xlabel="total shear stress / ρ u_b² (- -: driving force)")
    _legend(axes[0], [case for case, _ in profiles])
    _save(figure, file)
