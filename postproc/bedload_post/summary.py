"""The numbers that a scene promises, and the table of times: computed here, printed by `show`."""

from dataclasses import dataclass

import numpy as np

from . import flow_statistics
from .batches import InstantWeights, mean_over_time, second_half
from .bed_friction import driving_friction, side_walls
from .incipient_motion import diameter_number, shields_curve
from .outputs import MissingOutput, Run
from .states import NAMES, Phases


@dataclass(frozen=True)
class Line:
    """One number with what it is."""

    what: str
    value: str
    note: str = ""


def mean_grain_velocity(run: Run) -> float:
    """Mean streamwise velocity of all mobile grains over the whole record, over u_b."""
    total, count = 0.0, 0.0
    weight = InstantWeights(run.sample_times())
    for block in run.sample_blocks():
        weights = weight(block.time)
        total += float(weights @ block.velocity[:, 0])
        count += float(weights.sum())
    if count == 0.0:
        raise MissingOutput(f"{run.folder} has no samples of mobile spheres.")
    return total / count / run.bulk_velocity


def fixed_point(value: float, digits: int) -> str:
    """With `digits` behind the point, and never "-0.00"."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def lower_wall(run: Run) -> bool:
    """Whether a wall that holds the fluid back bounds the box at y = 0."""
    ends = run.settings.get("boundary", {}).get("y", "periodic")
    return (ends if isinstance(ends, str) else ends[0]) == "no_slip"


def has_bed(run: Run) -> bool:
    """Whether grains lie on a bed under a stream, so that rest, creep and jumps mean something: fixed
    spheres, or a wall below that gravity draws them to."""
    driven = run.settings.get("flow", {}).get("driving", "none") != "none"
    return len(run.fixed_spheres()[0]) > 0 or (
        driven and lower_wall(run) and run.value("fluid.gravity")[1] < 0.0
    )


def has_friction(run: Run) -> bool:
    """Whether the driving force is taken up by a wall or a bed alone, so that there is a friction velocity."""
    if side_walls(run.settings):
        return False
    return lower_wall(run) or (len(run.fixed_spheres()[0]) > 0 and not np.isfinite(run.periods[1]))


def critical_shields(run: Run) -> float:
    """The Shields number at which grains of a level bed begin to move, by Shields' curve."""
    weight = run.submerged_weight / run.value("fluid.density")
    return shields_curve(diameter_number(run.diameter, weight, run.viscosity))


def size_lines(run: Run) -> list[Line]:
    """Where mobile spheres are of other sizes than reference.diameter, which every D is."""
    radius = next(run.sample_blocks(rows=1)).radius
    smallest, largest = (2.0 * float(end) for end in (radius.min(), radius.max()))
    if max(abs(smallest - run.diameter), abs(largest - run.diameter)) <= 1e-3 * run.diameter:
        return []
    sizes = f"{smallest:.4g}" if smallest == largest else f"{smallest:.4g} to {largest:.4g}"
    return [Line("their diameters", sizes, f"D below is reference.diameter, {run.diameter:g}")]


def tags_of(run: Run) -> np.ndarray:
    """Every mobile sphere that the record has, however short."""
    found = [np.unique(tag) for _, tag in run.instants()]
    return np.unique(np.concatenate(found)) if found else np.zeros(0, dtype=int)


def free_grain_lines(run: Run) -> list[Line]:
    """Motion of spheres that lie on no bed: along gravity, their speed, their Reynolds number."""
    instants = run.sample_times()
    begin, end = float(instants[0]), float(instants[-1])
    weight_of = InstantWeights(instants)
    gravity = np.array(run.value("fluid.gravity"), dtype=float)
    weight = float(np.linalg.norm(gravity))
    fall, count, fastest = 0.0, 0.0, 0.0
    last: list[np.ndarray] = []
    for block in run.sample_blocks():
        fastest = max(fastest, float(np.linalg.norm(block.velocity, axis=1).max(initial=0.0)))
        half = block.time >= 0.5 * (begin + end)
        if weight > 0.0:
            fall += float(weight_of(block.time[half]) @ (block.velocity[half] @ gravity)) / weight
        count += float(weight_of(block.time[half]).sum())
        at_end = block.time == end
        last.append(np.linalg.norm(block.velocity[at_end], axis=1) * 2 * block.radius[at_end])
    lines = [
        Line("mobile spheres", f"{len(tags_of(run))}"),
        *size_lines(run),
        Line("largest speed", f"{fastest:.4g}", "in units of the scene"),
    ]
    if weight > 0.0 and count:
        lines.append(Line("mean velocity along gravity", f"{fall / count:.4g}", "second half of the record"))
    reynolds = float(np.mean(np.concatenate(last))) / run.viscosity
    lines.append(Line("Reynolds number at the end", f"{reynolds:.3g}", "2 R u_p / nu, u_p in the frame of the box"))
    return [*lines, collision_line(run)]


def collision_line(run: Run) -> Line:
    """How many collisions have finished, where the run has written of them."""
    if not run.has_collisions:
        return Line("collisions, states", "unknown", "there is no collisions.csv")
    return Line("finished collisions", f"{len(run.collisions())}")


def grain_lines(run: Run, phases: Phases | None) -> list[Line]:
    """Motion of grains on a bed: velocity, states, jumps, slip; without a bed what is left of it. `phases`: None where
    no state can be told."""
    if not has_bed(run):
        return free_grain_lines(run)
    lines = [
        Line("mobile grains", f"{len(tags_of(run))}"),
        *size_lines(run),
        Line("mean grain velocity", f"{fixed_point(mean_grain_velocity(run), 4)} u_b"),
        collision_line(run),
    ]
    if phases is None:
        return [*lines, Line("states", "unknown", "the run has not come to an end")] if run.has_collisions else lines
    if len(phases.tag) == 0:
        return [*lines, Line("states", "none", "the record is too short for them")]
    for name, share in zip(NAMES, phases.shares(), strict=True):
        lines.append(Line(f"time {name}", f"{100 * share:.1f} %"))
    jump = phases.jumps()
    if jump.any():
        mean, highest = phases.height[jump].mean(), phases.height[jump].max()
        diameter = run.diameter
        lines += [
            Line("jumps", f"{jump.sum()}", "that begin and end in the record"),
            Line("jump height, mean", f"{mean / diameter:.3f} D", "highest point over take-off"),
            Line("jump height, highest", f"{highest / diameter:.3f} D"),
        ]
    moving = phases.complete & (phases.state == NAMES.index("creeping"))
    if moving.any() and phases.path[moving].sum() > 0:
        slip = phases.slip[moving].sum() / phases.path[moving].sum()
        lines.append(Line("slip while creeping", f"{slip:+.3f}", "L_slip / L: 0 rolls, -1 slides"))
    return lines


def statistics_lines(run: Run) -> list[Line]:
    """Friction and stress balance from statistics.h5, where a run has taken statistics."""
    if not (run.folder / flow_statistics.FILE).is_file():
        return []
    s = flow_statistics.read(run)
    lines = [Line("statistics over", f"{s.end - s.begin:.4g}", f"{s.samples} samples")]
    if s.u_tau > 0 and (has_friction(run) or s.stress_defect is not None):
        lines += [
            Line("friction velocity there", f"{s.u_tau / run.bulk_velocity:.4f} u_b"),
            Line("Re_tau there", f"{s.u_tau * run.depth / run.viscosity:.1f}", "u_tau H / nu"),
        ]
    if s.stress_defect is not None:
        lines.append(
            Line("stress off a straight line", f"{100 * s.stress_defect:.2f} %", "of rho u_tau^2")
        )
    return lines


def relative_stress(run: Run, whose: str) -> np.ndarray:
    """Stress along x of the "wall" (by the fluid) or the "grain", mean of both y walls, over what the fluid alone gives
    to walls that slide past each other, per row of history.csv."""
    history, boundary = run.history(), run.settings["boundary"]
    sliding = boundary["y_upper_velocity"][0] - boundary["y_lower_velocity"][0]
    alone = run.value("fluid.density") * run.viscosity * sliding / float(run.box[1])
    return (history[f"{whose}_stress_lower"] - history[f"{whose}_stress_upper"]) / (2.0 * alone)


def shear_lines(run: Run, history: dict[str, np.ndarray], since: float) -> list[Line]:
    """Relative viscosity of what lies between y walls that slide past each other, nothing else driving it."""
    boundary = run.settings.get("boundary", {})
    driven = run.settings.get("flow", {}).get("driving", "none") != "none"
    lower, upper = (boundary.get(f"y_{end}_velocity", (0.0,))[0] for end in ("lower", "upper"))
    if driven or boundary.get("y") not in ("no_slip", ["no_slip", "no_slip"]) or lower == upper:
        return []
    if "grain_stress_lower" not in history:  # a run of before
        return []
    by_fluid, by_grains = (
        mean_over_time(history["time"], relative_stress(run, whose), since) for whose in ("wall", "grain")
    )
    meaning = f"second half; {by_fluid:.3f} of it by the fluid, {by_grains:.3f} by grains on walls"
    return [Line("relative viscosity", f"{by_fluid + by_grains:.3f}", meaning)]


def flow_lines(run: Run) -> list[Line]:
    """State of the flow, from the second half of the time of history.csv, and the run's own checks."""
    history = run.history()
    if len(history["time"]) == 0:
        raise MissingOutput(f"history.csv of {run.folder} has no rows.")
    middle = history["time"][second_half(history["time"])]
    lines = [
        Line("fluid steps", f"{int(history['step'][-1])}"),
        Line("time", f"{history['time'][-1]:.4g}", "in units of the scene"),
        Line("CFL number, largest", f"{history['cfl'].max():.3f}"),
    ]
    spheres = (run.folder / "spheres.h5").is_file() or history["slip_max"].any()
    friction = driving_friction(run, middle) if has_friction(run) else 0.0
    if friction > 0:
        reynolds = friction * run.depth / run.viscosity
        lines += [
            Line("friction velocity", f"{friction / run.bulk_velocity:.4f} u_b", "second half"),
            Line("Re_tau", f"{reynolds:.0f}", "u_tau H / nu"),
        ]
    if friction > 0 and spheres:
        lines.append(Line("D+", f"{reynolds * run.diameter / run.depth:.1f}", "D u_tau / nu"))
        if run.submerged_weight > 0:
            shields = run.value("fluid.density") * friction**2
            shields /= run.submerged_weight * run.diameter
            note = f"critical: {critical_shields(run):.3f}, Shields' curve"
            lines.append(Line("Shields number", f"{shields:.4f}", note))
    lines += statistics_lines(run)
    if spheres:
        lines += shear_lines(run, history, middle)
    lines.append(Line("divergence, largest", f"{np.abs(history['max_divergence']).max():.1e}", "1/T"))
    if spheres:
        scale = run.bulk_velocity
        slip = mean_over_time(history["time"], history["slip_rms"], middle)
        largest = history["slip_max"][history["time"] >= middle].max()
        lines += [
            Line("slip at markers, rms", f"{slip / scale:.2e} u_b", "second half"),
            Line("slip at markers, largest", f"{largest / scale:.2e} u_b", "second half"),
        ]
    residual = np.abs(history["momentum_residual"]).max()
    if not np.isnan(residual):  # between x walls nobody follows it
        meaning = "given by the fluid less taken by the grains, relative" if spheres else "relative"
        lines.append(Line("momentum residual", f"{residual:.1e}", meaning))
    return lines


def time_rows(run: Run) -> list[tuple[str, float, float]]:
    """(part, seconds, share of the whole), the dearest first; those of a restarted run over all that it took."""
    seconds: dict[str, float] = {}
    for table in run.timings()[0]:
        for part, spent in zip(table["part"].tolist(), table["seconds_mean_over_ranks"].tolist(), strict=True):
            seconds[part] = seconds.get(part, 0.0) + spent
    whole = sum(seconds.values()) or 1.0
    return sorted(((part, spent, spent / whole) for part, spent in seconds.items()), key=lambda row: -row[1])


def times_note(run: Run) -> str:
    """What time_rows lack, a sentence, or none."""
    return "" if run.timings()[1] else "The run was killed and went on: what it took until then is not in this table."
