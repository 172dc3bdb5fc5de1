"""`./bedload bench fluid --table`: the rows of the READMEs, from the records of one run."""

from collections.abc import Iterable

CASE = ("grid", "y", "spheres", "diffusion")
FIRST = "128x128x128"


def fluid(records: Iterable[dict]) -> str:
    """A table in Markdown: a row for each case, both precisions in it.

    Rates in million cell-steps per second; ns of all ranks per cell and step without the spheres' own
    work, and in brackets over those of the same precision on 128^3 cubes, explicit, without spheres.
    """
    cases: dict[tuple, dict[str, dict]] = {}
    for record in records:
        case = tuple(record[key] for key in CASE)
        cases.setdefault(case, {})[record["precision"]] = record
    plain = cases.get((FIRST, "cubes", "none", "explicit"), {})
    lines = [
        "| cells | y | spheres | diffusion | double | single | single : double | ns, double | ns, single |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for case, found in cases.items():
        cells = [*case, *(_rate(found.get(precision)) for precision in ("double", "single"))]
        cells.append(_ratio(found))
        cells += [_cost(found.get(p), plain.get(p)) for p in ("double", "single")]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _rate(record: dict | None) -> str:
    if record is None:
        return ""
    low, high = record["mcells_per_s_range"]
    return f"{record['mcells_per_s']:.1f} ({low:.1f}–{high:.1f})"


def _ratio(found: dict[str, dict]) -> str:
    if len(found) < 2:
        return ""
    return f"{found['single']['mcells_per_s'] / found['double']['mcells_per_s']:.2f}"


def _cost(record: dict | None, plain: dict | None) -> str:
    if record is None:
        return ""
    text = f"{record['fluid_ns']:.1f}"
    return f"{text} ({record['fluid_ns'] / plain['fluid_ns']:.2f})" if plain else text
