"""Other kept records beside the runs of a report: the trend with resolution, and experiments.

A record with the same scene and settings at another resolution belongs to the trend; any other one (a changed
collision model, another box) is listed with its change. Records of one resolution are listed, not pooled: each
has an interval of its own, and its own start.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from . import least_intervals
from .model_figures import MODELS, PAPER_CELLS, resolutions
from .model_sentences import AT_REST, names_of, rests
from .paper_statements import TABLE_2, told_apart


@dataclass(frozen=True)
class Record:
    """Numbers of the runs of another report."""

    name: str
    runs: Sequence[dict]
    same_settings: bool = False  # but for resolution and length
    commit: str = ""  # by which it was made, where that is known

    def kept(self) -> dict:
        """What numbers.json holds of it: what stands beside the runs of the report."""
        runs = [{name: v[name] for name in NEEDED if name in v} for v in self.runs]
        made = {"commit": self.commit} if self.commit else {}
        return {"name": self.name, "same_settings": self.same_settings, **made, "runs": runs}

    @property
    def label(self) -> str:
        return self.name + (f", commit {self.commit[:7]}" if self.commit else "")


THESE = "these"
NEEDED = ("mean_velocity", *least_intervals.NEEDED)


def change(other: dict, own: dict) -> str:
    """Of the mean velocity: in per cent of its own, or in u_b where that is not told apart from zero."""
    if rests(other) and rests(own):
        return f"both below {AT_REST:g} u_b"
    difference = other["mean_velocity"] - own["mean_velocity"]
    if abs(own["mean_velocity"]) > max(own["mean_velocity_interval"], 0.001):
        text = f"{100.0 * difference / own['mean_velocity']:+.0f} %"
    else:
        text = f"{difference:+.3f} u_b"
    return text if told_apart(other, own) else f"{text}, not told apart"


def _value(v: dict) -> str:
    return f"{v['mean_velocity']:.3f} ± {v['mean_velocity_interval']:.3f}"


def _column(v: dict) -> tuple[str, float]:
    return v["model"], v["density_ratio"]


def _cells(runs: Sequence[dict]) -> str:
    found = sorted({v["cells_per_diameter"] for v in runs if "cells_per_diameter" in v})
    return ", ".join(f"{cells:.3g}" for cells in found) or "–"


def experiment_rows(values: Sequence[dict], records: Sequence[Record]) -> list[list[str]]:
    """Records of other settings beside these: a row a record, a column a model, and whether they differ. The first
    row is the head; none without such records."""
    others = [r for r in records if not r.same_settings]
    if not others:
        return []
    rows = [["record", "cells to D", *names_of(values), "beside these"]]
    for record in [Record(THESE, values), *others]:
        by_column = {_column(v): v for v in record.runs}
        found = [(by_column.get(_column(own)), own) for own in values]
        changes = [change(v, own) for v, own in found if v is not None and v is not own]
        texts = ["–" if v is None else _value(v) for v, _ in found]
        rows.append([record.label, _cells(record.runs), *texts, "; ".join(changes)])
    return rows


def comparable(values: Sequence[dict], records: Sequence[Record]) -> list[Record]:
    """These and the records of the same settings, the coarsest first and the shorter before the longer; none where
    there are no others."""
    same = [r for r in records if r.same_settings and all("cells_per_diameter" in v for v in r.runs)]
    if not same or not all("cells_per_diameter" in v for v in values):
        return []
    return sorted(
        [Record(THESE, values, True), *same],
        key=lambda r: (min(v["cells_per_diameter"] for v in r.runs), max(v["flow_throughs"] for v in r.runs)),
    )


def with_least_intervals(values: Sequence[dict], records: Sequence[Record]) -> tuple[list[dict], list[Record]]:
    """These runs and the records beside them with the intervals that the longest one of the same settings leaves
    them (least_intervals)."""
    runs = [v for record in comparable(values, records) for v in record.runs]
    widened = [least_intervals.widened(v, runs) for v in values]
    beside = [
        replace(r, runs=[least_intervals.widened(v, runs) for v in r.runs]) if r.same_settings else r for r in records
    ]
    return widened, beside


def trend_rows(values: Sequence[dict], records: Sequence[Record], with_paper: bool) -> list[list[str]]:
    """Mean velocity over the resolution: a row a record, a column a model; each value is compared with the longest
    record of the next coarser resolution. The first row is the head, the last one the paper's; none without records
    to compare with."""
    lines = comparable(values, records)
    if not lines:
        return []
    rows = [["record", "cells to D", "flow-throughs", *names_of(values)]]
    by_cells = {_column(own): _longest(own, lines) for own in values}
    for record in lines:
        by_column = {_column(v): v for v in record.runs}
        texts = [_trend_text(by_column.get(column), by_cells[column]) for column in map(_column, values)]
        longest = max(v["flow_throughs"] for v in record.runs)
        rows.append([record.label, _cells(record.runs), f"{longest:.3g}", *texts])
    if with_paper:
        known = ["–" if v["model"] not in TABLE_2 else f"{TABLE_2[v['model']]:.3f}" for v in values]
        rows.append(["the paper", f"{PAPER_CELLS}", "more than 30", *known])
    return rows


def _longest(own: dict, lines: Sequence[Record]) -> dict[float, dict]:
    """The longest record of each resolution of the model and density ratio of `own`."""
    runs = [v for record in lines for v in record.runs]
    return resolutions([v for v in runs if v["density_ratio"] == own["density_ratio"]], own["model"])


def _trend_text(v: dict | None, by_cells: dict[float, dict]) -> str:
    if v is None:
        return "–"
    coarser = [cells for cells in by_cells if cells < v["cells_per_diameter"] - 0.01]
    if not coarser:
        return _value(v)
    if rests(v) and rests(by_cells[max(coarser)]):
        return f"{_value(v)}, both below {AT_REST:g} u_b"
    return f"{_value(v)}, {'' if told_apart(v, by_cells[max(coarser)]) else 'not '}told apart"


def repeated_sentence(values: Sequence[dict], records: Sequence[Record]) -> str:
    """Whether records of one resolution agree with the longest of them, which says how far the intervals can be
    trusted; empty where no resolution has two records."""
    lines = comparable(values, records)
    pairs, apart = 0, []
    for name, own in zip(names_of(values), values, strict=True):
        runs = [(record.name, v) for record in lines for v in record.runs if _column(v) == _column(own)]
        for cells, longest in _longest(own, lines).items():
            for record_name, v in runs:
                if v is not longest and abs(v["cells_per_diameter"] - cells) < 0.01:
                    pairs += 1
                    told = f"{name} at {cells:g} cells ({record_name}: {_value(v)}, longest: {_value(longest)})"
                    apart += [told] if told_apart(v, longest) else []
    if not pairs:
        return ""
    if not apart:
        return "Records of one resolution agree within their intervals."
    return (
        f"Records of one resolution differ by more than their intervals: {'; '.join(apart)}. There an interval is too "
        "narrow, or the records are of different versions."
    )


def trend_sentence(values: Sequence[dict], records: Sequence[Record], with_paper: bool) -> str:
    """How each mean velocity changes from the coarsest to the finest resolution, by the longest record of each, and
    where the finest one stands beside the paper's."""
    lines, parts = comparable(values, records), []
    for name, own in zip(names_of(values), values, strict=True):
        by_cells = _longest(own, lines)
        if len(by_cells) > 1:
            low, high = min(by_cells), max(by_cells)
            text = f"{name} from {low:g} to {high:g} cells {change(by_cells[high], by_cells[low])}"
            if with_paper and own["model"] in MODELS:
                paper = TABLE_2[own["model"]]
                text += f", then {100.0 * (by_cells[high]['mean_velocity'] / paper - 1.0):+.0f} % from the paper's"
            parts.append(text)
    return f"Trend with resolution: {'; '.join(parts)}." if parts else ""
