"""The table of all numbers of a model comparison."""

from collections.abc import Callable, Sequence

from .paper_statements import CRITICAL_SHIELDS
from .states import NAMES

NOTHING = "–"  # a run that has no such number
Cell = Callable[[dict], str]


def plain(name: str, digits: int = 3, scale: float = 1.0) -> Cell:
    """A number of a run, by its name there."""
    return lambda v: NOTHING if v.get(name) is None else f"{scale * v[name]:.{digits}f}"


def with_interval(name: str, digits: int = 3, scale: float = 1.0) -> Cell:
    """The same with the half width of its interval, where it is known."""
    def cell(v: dict) -> str:
        half = v.get(f"{name}_interval")
        return plain(name, digits, scale)(v) + ("" if half is None else f" ± {scale * half:.{digits}f}")

    return cell


def quantiles(name: str) -> Cell:
    """Quantiles of the collisions, as far as these have them."""
    def cell(v: dict) -> str:
        known = any(q is not None for q in v[name])
        return ", ".join("–" if q is None else f"{q:.2g}" for q in v[name]) if known else NOTHING

    return cell


def halves(name: str, scale: float = 1.0) -> Cell:
    """Means of the first and the second half of the record, and whether it drifts."""
    return lambda v: " and ".join(f"{scale * half:.3g}" for half in v[f"{name}_halves"]) + (
        ": drifts" if v[f"{name}_drifts"] else ""
    )


ROWS: tuple[tuple[str, Cell], ...] = (
    ("mean particle velocity / u_b", with_interval("mean_velocity")),
    ("the same in the paper", plain("paper_mean_velocity")),
    *((f"time {name}, %", with_interval(f"share_{name}", 1, 100.0)) for name in NAMES),
    ("grains faster than 0.01 u_b, %", with_interval("share_moving", 1, 100.0)),
    ("mean height y / D", with_interval("mean_height")),
    ("spread of y / D", with_interval("spread_of_height")),
    ("mean ω₃ D / u_b", plain("mean_spin")),
    ("height below which a twentieth of the grains is, y / D", with_interval("low_height")),
    ("mean ω₃ D / u_b up to a diameter over the bed, largest", with_interval("spin_peak")),
    ("the same of grains that do not rest", with_interval("moving_spin_peak")),
    ("mean ω₃ D / u_b up to y = 1.55 D, largest", plain("spin_next_to_bed")),
    ("mean |ω₃| D / u_b while jumping", with_interval("jumping_spin")),
    ("jumps", plain("jumps", 0)),
    ("mean jump height / D", with_interval("mean_jump_height")),
    ("L_slip / L while creeping (0 rolls, −1 slides)", with_interval("creeping_slip")),
    ("Re_τ of the bed without mobile grains", with_interval("bed_re_tau", 0)),
    (f"Shields number of that bed (critical: {CRITICAL_SHIELDS})", with_interval("bed_shields", 4)),
    ("u_τ / u_b, the grains' drag included", plain("u_tau", 4)),
    ("Re_τ, the grains' drag included", plain("re_tau", 0)),
    ("D⁺, the grains' drag included", plain("d_plus", 1)),
    ("Shields number, the grains' drag included", plain("shields", 4)),
    ("flow-throughs measured", plain("flow_throughs", 1)),
    ("flow-throughs discarded before", plain("discarded_flow_throughs", 1)),
    ("collisions", plain("collisions", 0)),
    ("of them below St = 1, %", plain("collisions_below_stokes_1", 0, 100.0)),
    ("of them below St = 5, %", plain("collisions_below_stokes_5", 0, 100.0)),
    ("T / T_c: 5 %, median, 95 %", quantiles("duration_quantiles")),
    ("overlap / D: 5 %, median, 95 %", quantiles("overlap_quantiles")),
    ("mean velocity, first and second half", halves("velocity")),
    ("time resting, first and second half, %", halves("resting", 100.0)),
    ("cells to a diameter", plain("cells_per_diameter", 1)),
    ("batches", plain("batches", 0)),
    ("correlation of neighbouring batches", plain("batch_memory", 2)),
)


def number_rows(values: Sequence[dict]) -> list[list[str]]:
    """The table of numbers: a row a quantity that some run has, a column a run."""
    rows = [[what, *(cell(v) for v in values)] for what, cell in ROWS]
    return [row for row in rows if any(text != NOTHING for text in row[1:])]
