"""Figures of the validation, one a case, drawn from what CASE.json keeps.

A figure has a panel, or those of PANELS: curves that share axes. Legends stand above the axes, where they hide
nothing; what is computed has colours, what it is compared with is black. Curves that lie on each other are told apart
by their dashes, marks by their shape.
"""

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import matplotlib

from .log_ticks import plain_ticks
from .validation_arrays import OFFSETS
from .validation_runs import Curve, Result

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

COLOURS = ("#2166ac", "#d95f02", "#1b9e77", "#7b3294", "#a6761d")  # told apart by eyes that lack a kind of cones, too
DASHES = ("-", (0, (6, 1.5)), (0, (4, 1.2, 1, 1.2)), (0, (1.2, 1.2)), (0, (8, 1.5, 1, 1.5, 1, 1.5)))
MARKS = ("o", "s", "^", "D", "v")
FEW = 10  # points of a line that are marked
DPI = 110
# Labels of what theory or an experiment says.
REFERENCES = (
    "*measured*", "exact*", "statics*", "exp(-35/St[*])*", "Carty*", "Beetstra*", "Eilers", "Zarraga*", "(1 - phi)*",
    "rheology*",
)  # fmt: skip
# Curves that have the colour of another one, theirs or the theory's for the same case.
LIKE = {
    "exact, 0.5": "rho_p/rho_f = 0.5, D/h = 8", "exact, 1": "rho_p/rho_f = 1, D/h = 8",
    "exact, 2.5": "rho_p/rho_f = 2.5, D/h = 8", "exact, 8": "rho_p/rho_f = 8, D/h = 8",
    "Beetstra et al. 2007, Re = 0": "D/h = 10, Re = 0", "Beetstra et al. 2007, Re = 50": "D/h = 10, Re = 50",
}  # fmt: skip
SYMBOLS = (
    (r"\+-", "±"), (r"\brho_p/rho_f\b", "ρp/ρf"), (r"\bnu\b", "ν"), (r"\bphi\b", "φ"),
    (r"\b(u_g|C_D|C_L|h_f|Re_b)\b", r"$\1$"), (r"\be_dry\b", "$e_{dry}$"), (r"\^(\d[\d.]*)", r"$^{\1}$"),
    (r" = ", "\u00a0=\u00a0"), (r"(Re_b\$) ", "\\1\u00a0"),  # what stands about an equals sign stays together
)  # fmt: skip


@dataclass(frozen=True)
class Panel:
    """Curves that share axes: those whose labels one of `of` matches (as file names are matched). Axes have the
    result's names and the range of the curves where nothing else stands here."""

    of: Sequence[str] = ("*",)
    title: str = ""
    x: str = ""
    y: str = ""
    xlim: tuple[float, float] | None = None
    ylim: tuple[float, float] | None = None
    ticks: Mapping[float, str] = field(default_factory=dict)  # of x

    def holds(self, curve: Curve) -> bool:
        return any(fnmatchcase(curve.label, pattern) for pattern in self.of)


_DOWN_AND_ACROSS = (Panel(("down*",), y="u down / u_g"), Panel(("across*",), y="u across / u_g"))
_BOUNCES: dict = {"xlim": (-0.02, 0.165), "ylim": (-0.15, 3.2)}
PANELS: dict[str, Sequence[Panel]] = {
    "array": (
        Panel(("volume fraction 0.0*", "volume fraction 0.216", "0.216,*"), "loose"),
        Panel(("volume fraction 0.343", "volume fraction 0.4*", "volume fraction 0.5*"), "dense"),
    ),
    "box": (Panel(("E1*",), "E1, Re = 1.5"), Panel(("E4*",), "E4, Re = 31.9")),
    "carried": (Panel(("D/h = 8,*",)), Panel(("D/h = 12,*",))),
    "erosion_choices": (
        Panel(("bed of 9 D", "* friction coefficient"), "friction", ylim=(-4.0, 2.0)),
        Panel(("bed of 9 D", "box *"), "box", ylim=(-4.0, 2.0)),
        Panel(("*bed of*",), "depth of the bed"),
    ),
    "film": (Panel(("*wall*",), "a wall"), Panel(("*of two*", "*pair"), "two spheres")),
    "incipient": (Panel(("statics*", "actm*")), Panel(("statics*", "rpm*"))),
    "kissing": (Panel(("* sphere",)), Panel(("gap / D",), y="gap / D")),
    "mordant15": _DOWN_AND_ACROSS,
    "mordant15_wide": _DOWN_AND_ACROSS,
    "oblique": _DOWN_AND_ACROSS,
    "oblique24": _DOWN_AND_ACROSS,
    "oblique_wide": _DOWN_AND_ACROSS,
    "offsets": (
        Panel(x="the sphere's centre off a corner of the cells / h", y="K, drag over Stokes'", ticks=OFFSETS),
    ),
    "light": (
        Panel(("*ratio 2.56", "*ratio 1.1"), "heavier than the fluid"),
        Panel(("*ratio 0.*",), "lighter than the fluid"),
    ),
    "rebound": (
        Panel(("measured", "D/h = 10", "D/h = 15"), "pushed over 5.5 D, as by default", **_BOUNCES),
        Panel(("measured", "D/h = 10, pushed*"), "pushed over 20 D", **_BOUNCES),
    ),
    "rebound27": (Panel(xlim=(-0.005, 0.06), ylim=(-0.1, 0.6)),),
    "sliding": (
        Panel(("*sliding*",), "sliding: force"),
        Panel(("*turning*", "*rolling"), "turning and rolling: torque"),
    ),
    "stream": (Panel(("Re 20,*",)), Panel(("Re 100,*",)), Panel(("Re 200,*",))),
    "suspension": (
        Panel(("D/h = ?", "Eilers", "Zarraga*"), "smooth spheres"),
        Panel(("D/h = 6,*", "Eilers", "Zarraga*"), "rough spheres, 30 %", xlim=(0.2, 0.325), ylim=(1.5, 5.0)),
    ),
    "wet_restitution": tuple(
        Panel(("exp*", f"density ratio {ratio}, *"), f"density ratio {ratio}") for ratio in ("8", "2.5", "1.25")
    ),
}  # fmt: skip


def panels(name: str) -> Sequence[Panel]:
    """Of a case's figure."""
    return PANELS.get(name, (Panel(),))


def is_reference(curve: Curve) -> bool:
    return any(fnmatchcase(curve.label, pattern) for pattern in REFERENCES)


def in_symbols(text: str) -> str:
    """Names of quantities as a figure writes them."""
    for pattern, sign in SYMBOLS:
        text = re.sub(pattern, sign, text)
    return text


def draw(name: str, result: Result, path: Path) -> None:
    """The figure of a case into `path`."""
    shown = panels(name)
    width = {1: 6.4, 2: 9.2}.get(len(shown), 4.0 * len(shown))
    figure, axes = plt.subplots(1, len(shown), figsize=(width, 4.4), squeeze=False, layout="constrained")
    for axis, panel in zip(axes[0], shown, strict=True):
        _draw_panel(axis, panel, result)
    figure.suptitle(in_symbols(textwrap.fill(result.title.replace(" = ", "\u00a0=\u00a0"), int(10 * width))))
    figure.savefig(path, dpi=DPI)
    plt.close(figure)


def _draw_panel(axis, panel: Panel, result: Result) -> None:
    styles = _styles([curve for curve in result.curves if panel.holds(curve)])
    for curve, style in styles:
        axis.plot(curve.x, curve.y, label=in_symbols(curve.label), **style)
    axis.set(xlabel=in_symbols(panel.x or result.axes[0]), ylabel=in_symbols(panel.y or result.axes[1]))
    if result.logarithmic:
        axis.set(xscale="log", yscale="log")
        plain_ticks(axis.xaxis)
        plain_ticks(axis.yaxis)
    elif "error" in result.axes[1]:
        axis.axhline(0.0, color="#777777", lw=0.8)  # an error's size is seen against none
    axis.set(xlim=panel.xlim, ylim=panel.ylim)
    if panel.ticks:
        axis.set_xticks(list(panel.ticks), list(panel.ticks.values()), fontsize=7)
    axis.grid(alpha=0.3)
    axis.legend(loc="lower left", bbox_to_anchor=(-0.02, 1.0), fontsize=8, frameon=False, borderaxespad=0.2,
                title=panel.title or None, title_fontsize=9, alignment="left",
                ncol=2 if len(styles) > 5 else 1)  # fmt: skip


def _styles(curves: Sequence[Curve]) -> list[tuple[Curve, dict]]:
    """Curves with how they are drawn: what others are like first, for their colours."""
    colours: dict[str, str] = {}
    for curve in curves:
        if curve.label not in LIKE and not is_reference(curve):
            colours[curve.label] = COLOURS[len(colours) % len(COLOURS)]
    found, lines, marks, black = [], 0, 0, 0
    for curve in curves:
        of_theory = is_reference(curve)
        style: dict = {"color": colours.get(LIKE.get(curve.label, curve.label), "black")}
        if curve.points:
            style |= {"ls": "none", "marker": MARKS[marks % len(MARKS)], "ms": 5, "mew": 1.2}
            style["mfc"] = style["color"] if of_theory else "none"
            style["ms"] = 3 if of_theory else 5
            marks += 1
        elif of_theory:
            style |= {"ls": "-" if curve.label in LIKE else DASHES[black % len(DASHES)], "lw": 1.0}
            black += curve.label not in LIKE
        else:
            style |= {"ls": DASHES[lines % len(DASHES)], "marker": "." if len(curve.x) < FEW else None}
            lines += 1
        found.append((curve, style))
    return found
