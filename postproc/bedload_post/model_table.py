"""The table of all numbers of a model comparison."""

from collections.abc import Sequence

from .paper_statements import CRITICAL_SHIELDS
from .states import NAMES

NOTHING = "–"  # a run that has no such number


def number_rows(values: Sequence[dict], with_paper: bool) -> list[list[str]]:
    """The table of numbers: a row a quantity that some run has, a column a run."""

    def row(what: str, form) -> list[str]:
        return [what, *(form(v) for v in values)]

    def plain(name: str, digits: int = 3, scale: float = 1.0):
        return lambda v: NOTHING if v.get(name) is None else f"{scale * v[name]:.{digits}f}"

    def with_interval(name: str, digits: int = 3, scale: float = 1.0):
        def cell(v: dict) -> str:
            half = v.get(f"{name}_interval")
            return plain(name, digits, scale)(v) + ("" if half is None else f" ± {scale * half:.{digits}f}")

        return cell

    def quantiles(name: str):
        def cell(v: dict) -> str:
            known = any(q is not None for q in v[name])
            return ", ".join("–" if q is None else f"{q:.2g}" for q in v[name]) if known else NOTHING

        return cell

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
        row("spread of y / D", with_interval("spread_of_height")),
        row("mean ω₃ D / u_b", plain("mean_spin")),
        row("height below which a twentieth of the grains is, y / D", with_interval("low_height")),
        row("mean ω₃ D / u_b up to a diameter over the bed, largest", with_interval("spin_peak")),
        row("the same of grains that do not rest", with_interval("moving_spin_peak")),
        row("mean ω₃ D / u_b up to y = 1.55 D, largest", plain("spin_next_to_bed")),
        row("mean |ω₃| D / u_b while jumping", with_interval("jumping_spin")),
        row("jumps", plain("jumps", 0)),
        row("mean jump height / D", with_interval("mean_jump_height")),
        row("L_slip / L while creeping (0 rolls, −1 slides)", with_interval("creeping_slip")),
        row("Re_τ of the bed without mobile grains", with_interval("bed_re_tau", 0)),
        row(f"Shields number of that bed (critical: {CRITICAL_SHIELDS})", with_interval("bed_shields", 4)),
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
    return [line for line in rows if any(cell != NOTHING for cell in line[1:])]
