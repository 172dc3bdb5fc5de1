"""profiles.png: mean velocity, fluctuations, stress balance and spectra of a flow."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)
import numpy as np  # noqa: E402

from .flow_statistics import FlowStatistics, WallProfiles  # noqa: E402

COLOURS = {"u": "#1b7fbd", "v": "#e08214", "w": "#2a9d5c", "uv": "#7a3b8f"}


def draw(s: FlowStatistics, file: Path) -> None:
    """The profiles of any flow over y, in u_tau, into `file`; in the scene's units where there is none."""
    of_flow = s.u_tau > 0
    unit = s.u_tau if of_flow else 1.0
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4.6), layout="constrained")
    left.plot(s["u"] / unit, s["y"], color=COLOURS["u"], label="fluid's points")
    if s["fluid"].min() < 1.0:
        left.plot(s["fluid"] * s["u"] / unit, s["y"], "--", color=COLOURS["u"], label="all")
        left.plot(s["fluid"], s["y"], ":", color="0.4", label="share of fluid")
        left.legend(frameon=False)
    left.set(xlabel="<u> / u_tau" if of_flow else "<u>", ylabel="y", title="mean velocity")
    for q in "uvw":
        rms = np.sqrt(np.maximum(s.at_centres(q + q), 0)) / unit
        middle.plot(rms, s["y"], color=COLOURS[q], label=f"{q}' rms")
    middle.plot(-s.at_centres("uv") / unit**2, s["y"], color=COLOURS["uv"], label="-<u'v'>")
    middle.set(xlabel="in u_tau, u_tau²" if of_flow else "in the scene's units", title="fluctuations")
    middle.legend(frameon=False)
    scale = s.density * unit**2
    for name, style in (("viscous", "--"), ("turbulent", "-.")):
        right.plot(s[name] / scale, s["y_face"], style, color="0.4", label=name)
    right.plot(s.total_stress / scale, s["y_face"], color=COLOURS["u"], label="total")
    right.set(xlabel="stress / (rho u_tau²)" if of_flow else "stress / rho", title="stress balance")
    right.legend(frameon=False)
    for axes in (left, middle, right):
        axes.set_ylim(0, s["y_face"][-1])
    figure.savefig(file, dpi=120)
    plt.close(figure)


def draw_against(p: WallProfiles, mean: dict, rms: dict, s: FlowStatistics, file: Path) -> None:
    """A channel in wall units beside reference data; `mean` and `rms` hold columns by name."""
    figure, axes = plt.subplots(2, 2, figsize=(11, 8.4), layout="constrained")
    dots = {"marker": "o", "ms": 3.5, "mfc": "none", "ls": "none"}
    top_left, top_right, low_left, low_right = axes.flat
    top_left.semilogx(p.y, p.u, color=COLOURS["u"], label="bedload")
    top_left.semilogx(mean["yplus"], mean["Uplus"], color="0.2", label="Moser, Kim & Mansour", **dots)
    top_left.set(xlim=(0.5, 200), xlabel="y⁺", ylabel="U⁺", title=f"mean velocity, Re_τ = {p.reynolds:.1f}")
    top_left.legend(frameon=False)
    for q in "uvw":
        top_right.plot(p.y, p.rms[q], color=COLOURS[q], label=f"{q}' rms")
        top_right.plot(rms["yplus"], rms[f"{q}rms"], color=COLOURS[q], **dots)
    top_right.plot(p.y, -p.uv, color=COLOURS["uv"], label="−⟨u'v'⟩")
    top_right.plot(rms["yplus"], -rms["uv"], color=COLOURS["uv"], **dots)
    top_right.set(xlim=(0, p.reynolds), xlabel="y⁺", ylabel="in u_τ, u_τ²",
                  title="fluctuations (dots: del Álamo & Jiménez)")  # fmt: skip
    top_right.legend(frameon=False)
    scale = s.density * s.u_tau**2
    low_left.plot(s["y_face"], s["viscous"] / scale, "--", color="0.5", label="viscous")
    low_left.plot(s["y_face"], s["turbulent"] / scale, "-.", color="0.5", label="turbulent")
    low_left.plot(s["y_face"], s.total_stress / scale, color=COLOURS["u"], label="total")
    low_left.plot([0, s["y_face"][-1]], [1, -1], ":", color="0.2", label="straight line")
    low_left.set(xlabel="y/δ", ylabel="stress / (ρ u_τ²)", title="stress balance")
    low_left.legend(frameon=False)
    length = s.viscosity / s.u_tau
    for at, style in zip(s.spectra, ("-", "--"), strict=False):
        for d, colour in (("x", COLOURS["u"]), ("z", COLOURS["v"])):
            low_right.loglog(
                at.k[d] * length, at.along[f"u_{d}"] / (s.u_tau**2 * length), style, color=colour,
                label=f"along {d}, y⁺ = {at.height / length:.0f}",
            )  # fmt: skip
    low_right.set(xlabel="k⁺", ylabel="E⁺", title="spectra of u'", ylim=(1e-7, None))
    if s.spectra:
        low_right.legend(frameon=False)
    figure.savefig(file, dpi=110)
    plt.close(figure)
