"""Sentences of the report of a model comparison, each made from the numbers of its runs."""

from collections.abc import Callable, Sequence

from .batches import HIGHEST_MEMORY
from .model_figures import MODELS
from .paper_statements import told_apart
from .states import RESTING_SPEED

AT_REST = 0.0005  # u_b
PAPER_RECORD, PAPER_GRAINS = 30 * 52, 500  # D/u_b at least, and grains, of Setup II


def names_of(values: Sequence[dict]) -> list[str]:
    """Names of the runs: the model, and the density ratio where there are several."""
    several = len({v["density_ratio"] for v in values}) > 1
    return [
        MODELS.get(v["model"], (v["model"],))[0] + (f", ρp/ρf {v['density_ratio']:g}" if several else "")
        for v in values
    ]


def rests(v: dict) -> bool:
    """Whether the grains of a run hardly move: below that, numbers are their trembling in the pockets."""
    return abs(v["mean_velocity"]) < AT_REST


def answer(values: Sequence[dict], with_paper: bool) -> str:
    """Mean velocity and share in motion of each run, and how its model is asked for: what a reader comes for."""
    def velocity(v: dict) -> str:
        paper = f" (the paper {MODELS[v['model']][2]:g})" if with_paper and v["model"] in MODELS else ""
        return f"{v['mean_velocity']:.3f} ± {v['mean_velocity_interval']:.3f}{paper}"

    def moving(v: dict) -> str:
        return f"{100 * v['share_moving']:.0f} ± {100 * v['share_moving_interval']:.0f} %"

    text = f"**Mean velocity of the grains over u_b: {_by_ratio(values, velocity)}.**"
    if all(v.get("share_moving") is not None for v in values):
        text += f" Of the grains move (faster than {RESTING_SPEED:g} u_b): {_by_ratio(values, moving)}."
    rough = sorted({v["model"] for v in values if v["model"].endswith("_hw")}, reverse=True)
    if rough:
        text += f" HW is the friction of Haff and Werner: `--model {'`, `'.join(rough)}`."
    return text


def _by_ratio(values: Sequence[dict], told: Callable[[dict], str]) -> str:
    """What is told of each run, those of one density ratio together."""
    ratios = sorted({v["density_ratio"] for v in values})
    groups = [", ".join(f"{names_of([v])[0]} {told(v)}" for v in values if v["density_ratio"] == r) for r in ratios]
    if len(ratios) == 1:
        return groups[0]
    return "; ".join(f"at ρp/ρf {r:g} {group}" for r, group in zip(ratios, groups, strict=True))


def order_sentences(values: Sequence[dict], with_paper: bool) -> str:
    """A sentence on the models' order for each density ratio that has two of them; beside the paper's where that has
    velocities."""
    ratios = sorted({v["density_ratio"] for v in values})
    found = []
    for ratio in ratios:
        known = [v for v in values if v["density_ratio"] == ratio and v["model"] in MODELS]
        if len(known) > 1:
            text = order_sentence(known, with_paper)
            found.append(
                text if len(ratios) == 1 else f"At ρp/ρf {ratio:g}: {text[0].lower()}{text[1:]}"
            )
    return " ".join(found)


def order_sentence(known: Sequence[dict], with_paper: bool) -> str:
    """The models' order, whether it is the paper's, and which neighbours the intervals do not part."""
    order = sorted((v for v in known if not rests(v)), key=lambda v: -v["mean_velocity"])
    names = [MODELS[v["model"]][0] for v in order]
    expected = [MODELS[m][0] for m in MODELS if m in {v["model"] for v in known}]
    text = f"Mean velocity falls in the order {' > '.join(names)}" if len(names) > 1 else (
        f"Only {names[0]} moves grains" if names else "No model moves grains"
    )  # fmt: skip
    resting = [MODELS[v["model"]][0] for v in known if rests(v)]
    if resting and names:
        text += f"; with {', '.join(resting)} they hardly move (below {AT_REST:g} u_b)"
    if not with_paper:
        text += "."
    else:
        text += ", the paper's." if names == expected else f"; the paper's is {' > '.join(expected)}."
    close = [
        f"{MODELS[a['model']][0]} and {MODELS[b['model']][0]}"
        for a, b in zip(order, order[1:], strict=False)
        if not told_apart(a, b)
    ]
    if close:
        text += f" The intervals do not part {'; '.join(close)}."
    return text


def interval_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """What ± is, and for which of the runs, by their `names`, it promises too much."""
    text = "± is a 95 % confidence interval from batches, wider where neighbouring ones are correlated."
    narrow = [name for name, v in zip(names, values, strict=True) if v["interval_too_narrow"]]
    if narrow:
        text += (
            f" It is still too narrow for {'; '.join(narrow)}: batches shorter than a flow-through, "
            f"or correlated by more than {HIGHEST_MEMORY:g}."
        )
    return text


def caution(values: Sequence[dict]) -> str:
    """Behind the statements of the paper: how many of the runs have intervals that promise too much."""
    narrow = sum(bool(v["interval_too_narrow"]) for v in values)
    if not narrow:
        return ""
    return f" Intervals of {narrow} of {len(values)} runs are too narrow (below): a statement on these may be open."


def drift_sentence(names: Sequence[str], values: Sequence[dict]) -> str:
    """Whether first and second half of the records differ."""
    told = {"velocity": "mean velocity", "resting": "time resting"}
    drifting = [
        f"{what} of {name}" for key, what in told.items()
        for name, v in zip(names, values, strict=True) if v[f"{key}_drifts"]
    ]  # fmt: skip
    if drifting:
        return "Drift: first and second half differ by more than their intervals in " + (
            "; ".join(drifting) + ", so these records are too short or began too early."
        )
    if any(v[f"{key}_drifts"] is None for key in told for v in values):
        return "Drift: some records are too short to compare their halves."
    return "No record drifts: first and second half agree within their intervals."


def collision_lines(names: Sequence[str], values: Sequence[dict]) -> list[str]:
    """How many collisions each rule for slow impacts reaches, and how long they last in T_c; a line a run."""
    lines = []
    for name, v in zip(names, values, strict=True):
        low, middle, high = v["duration_quantiles"]
        if v["collisions"] and middle is not None:
            lines.append(
                f"{name}: {100 * v['collisions_below_stokes_1']:.0f} % of {v['collisions']} collisions are "
                f"below St = 1, {100 * v['collisions_below_stokes_5']:.0f} % below 5; nine of ten last "
                f"{low:.2g} to {high:.2g} T_c, half of them less than {middle:.2g} T_c."
            )
    return lines


def neighbour_lines(names: Sequence[str], values: Sequence[dict]) -> list[str]:
    """Whether several grains in one box are as good as several runs; a line a run."""
    return [f"{name}: {v['neighbours']}." for name, v in zip(names, values, strict=True) if "neighbours" in v]


def record_sentence(setup: int, values: Sequence[dict]) -> str:
    """How long the records are beside the paper's of Setup II."""
    known = [v for v in values if "box_length" in v]
    if setup != 2 or not known:
        return ""
    times = [v["flow_throughs"] * v["box_length"] for v in known]
    grains = [v["grains"] for v in known]
    amounts = [t * n / (PAPER_RECORD * PAPER_GRAINS) for t, n in zip(times, grains, strict=True)]
    low, high = f"{min(amounts):.2g}", f"{max(amounts):.2g}"
    return (
        f"Records are {_range(times)} D/u_b long with {_range(grains)} grains, the paper's more than "
        f"{PAPER_RECORD} D/u_b with {PAPER_GRAINS}: {low if low == high else f'{low} to {high}'} times as many grains "
        "times time, or less."
    )


def _range(values: Sequence[float]) -> str:
    low, high = round(min(values)), round(max(values))
    return f"{low}" if low == high else f"{low} to {high}"
