"""Other records beside a report's: the trend with resolution, experiments, and pages made anew from kept numbers."""

import json
from types import SimpleNamespace

import h5py
import matplotlib.image
import numpy as np
import pytest
from bedload_launcher.errors import UserError
from bedload_post import bed_friction, model_figures, model_sentences, other_records
from bedload_post.collision_statistics import CollisionStatistics
from bedload_post.other_records import Record
from bedload_post.outputs import Run
from bedload_studies import models
from synthetic import wandering_story, write_run
from test_paper_statements import run_numbers
from test_models_study import options

COMMAND = "./bedload study models --scene setup2_small --cells {} --no-bed --ranks 1:1"


def of_resolution(cells, velocity, half=0.01, model="rpm", throughs=20.0, **more):
    return run_numbers(
        model, cells_per_diameter=cells, mean_velocity=velocity, mean_velocity_interval=half,
        flow_throughs=throughs, **more,
    )  # fmt: skip


def test_experiments_stand_beside_these():
    values = [run_numbers("rpm"), run_numbers("actm", mean_velocity=0.1, mean_velocity_interval=0.03)]
    faster = [run_numbers("rpm", mean_velocity=0.3),
              run_numbers("actm", mean_velocity=0.12, mean_velocity_interval=0.03)]  # fmt: skip
    records = [Record("faster", faster), Record("alone", faster[1:]), Record("same", faster, True)]
    head, these, both, alone = other_records.experiment_rows(values, records)
    assert head == ["record", "cells to D", "rpm", "actm", "beside these"]
    assert these == ["these", "10", "0.247 ± 0.002", "0.100 ± 0.030", ""]
    assert both[-1] == "+21 %; +20 %, not told apart"
    assert alone[2:] == ["–", "0.120 ± 0.030", "+20 %, not told apart"]
    assert other_records.experiment_rows(values, records[2:]) == []


@pytest.mark.parametrize("mean, interval", [(1e-5, 1e-6), (0.02, 0.03)])
def test_a_change_from_rest_is_not_in_per_cent(mean, interval):
    values = [run_numbers("rpm", mean_velocity=mean, mean_velocity_interval=interval)]
    moving = [run_numbers("rpm", mean_velocity=0.3, mean_velocity_interval=0.01)]
    assert other_records.experiment_rows(values, [Record("moving", moving)])[2][-1] == f"{0.3 - mean:+.3f} u_b"


def test_the_trend_has_a_row_a_resolution():
    """Each is compared with the longest record of the next coarser resolution; those of one resolution are listed."""
    values = [of_resolution(10.0, 0.30), of_resolution(10.0, 0.1, model="actm")]
    records = [
        Record("fine", [of_resolution(14.0, 0.26, 0.05)], True),
        Record("short", [of_resolution(6.0, 0.30, 0.02, throughs=5.0)], True),
        Record("long", [of_resolution(6.0, 0.20, throughs=120.0), of_resolution(6.0, 0.095, model="actm")], True),
        Record("experiment", [of_resolution(6.0, 0.5)]),
    ]
    assert other_records.trend_rows(values, records, True) == [
        ["record", "cells to D", "flow-throughs", "rpm", "actm"],
        ["short", "6", "5", "0.300 ± 0.020", "–"],
        ["long", "6", "120", "0.200 ± 0.010", "0.095 ± 0.010"],
        ["these", "10", "20", "0.300 ± 0.010, told apart", "0.100 ± 0.010, not told apart"],
        ["fine", "14", "20", "0.260 ± 0.050, not told apart", "–"],
        ["the paper", "20", "more than 30", "0.247", "0.121"],
    ]
    assert other_records.trend_sentence(values, records, True) == (
        "Trend with resolution: rpm from 6 to 14 cells +30 %, then +5 % from the paper's; "
        "actm from 6 to 10 cells +5 %, not told apart, then -17 % from the paper's."
    )
    assert "paper" not in other_records.trend_sentence(values, records, False)
    told = other_records.repeated_sentence(values, records)
    assert "rpm at 6 cells (short: 0.300 ± 0.020, longest: 0.200 ± 0.010)" in told
    assert "actm" not in told
    wider = [records[0], Record("short", [of_resolution(6.0, 0.3, 0.2, throughs=5.0)], True), *records[2:]]
    assert other_records.repeated_sentence(values, wider) == "Records of one resolution agree within their intervals."
    alone = [Record("experiment", [of_resolution(6.0, 0.5)])]
    assert other_records.trend_rows(values, alone, True) == []
    assert other_records.trend_sentence(values, alone, True) == other_records.repeated_sentence(values, alone) == ""


def test_the_trend_is_drawn_where_there_is_one(tmp_path):
    file = tmp_path / "trend.png"
    coarse, fine = [of_resolution(6.0, 0.2)], [of_resolution(10.0, 0.3)]
    assert not model_figures.trend([coarse, [of_resolution(6.0, 0.21)]], file, True)
    assert not file.exists()
    assert model_figures.trend([coarse, fine], file, True)
    one = matplotlib.image.imread(file).shape
    heavy = [v | {"density_ratio": 2.25} for v in (*coarse, *fine)]
    assert model_figures.trend([coarse, fine, heavy], file, False)
    assert matplotlib.image.imread(file).shape[1] > 1.5 * one[1]  # a panel a density ratio
    longest = model_figures.resolutions([*coarse, of_resolution(6.0, 0.3, throughs=5.0), *fine], "rpm")
    assert {cells: v["mean_velocity"] for cells, v in longest.items()} == {6.0: 0.2, 10.0: 0.3}


def test_records_of_the_same_settings_are_known_by_their_commands():
    own = models.settings_said(COMMAND.format(6))
    for words in ("--flow-throughs 120", "--models rpm", "--set time.step=0.01", "--start-from x", "--densities 2.25"):
        assert models.settings_said(f"{COMMAND.format(10)} {words}") == own
    for words in ("--var friction=0.3", "--gravity 0.6", "--scene setup2", "--set spheres.buoyancy=false"):
        assert models.settings_said(f"{COMMAND.format(6)} {words}") != own
    assert models.settings_said("./bedload run setup2_small") is None
    assert models.settings_said("./bedload study models --no-such-option") is None


def kept_report(folder, cells, velocity, **more):
    folder.mkdir()
    values = [of_resolution(cells, velocity * f, model=m) | whole(m) for m, f in (("actm", 0.5), ("rpm", 1.0))]
    kept = {"circumstances": {"command": COMMAND.format(f"{cells:g}"), "commit": "abc"}, "runs": values} | more
    (folder / "numbers.json").write_text(json.dumps(kept))
    return folder


def whole(model):
    """What the table of numbers has on top of what the statements need."""
    return {
        "discarded_flow_throughs": 3.0, "mean_spin": -0.1, "jumps": 100, "u_tau": 0.1, "d_plus": 30.0, "shields": 0.05,
        "collisions": 0, "collisions_below_stokes_1": None, "collisions_below_stokes_5": None, "batches": 10,
        "duration_quantiles": [None] * 3, "overlap_quantiles": [None] * 3, "batch_memory": 0.1,
        "velocity_halves": [0.1, 0.1], "velocity_drifts": False, "resting_halves": [0.1, 0.1], "resting_drifts": False,
        "interval_too_narrow": model == "rpm",
    }  # fmt: skip


def test_pages_are_made_anew_from_kept_numbers(tmp_path):
    """Models in the paper's order, the trend with the other record, figures of runs that are gone stay."""
    coarse, fine = kept_report(tmp_path / "coarse", 6.0, 0.2), kept_report(tmp_path / "fine", 10.0, 0.24)
    for name in ("heights.png", "shares.png"):
        (fine / name).write_bytes(b"old")
    models.run(options("--rewrite", str(fine), "--beside", str(coarse)))
    text = (fine / "README.md").read_text()
    assert text.split("\n\n")[0] == "# setup2_small: 2 collision models"
    assert text.split("\n\n")[2].startswith("Of ")
    assert "Intervals of 1 of 2 runs are too narrow" in text.split("\n\n")[2]
    assert "|  | rpm | actm |" in text
    assert "| fine | 10 |" not in text
    assert "| these | 10 | 20 | 0.240 ± 0.010, told apart | 0.120 ± 0.010, told apart |" in text
    assert "overlap / D" not in text  # a quantity that no run has
    assert text.index("(trend.png)") < text.index("(shares.png)") < text.index("(heights.png)")
    assert "![PDF of the grains' height, mean spin and mean velocity over height](heights.png)" in text
    assert (fine / "heights.png").read_bytes() == b"old"
    assert (fine / "shares.png").stat().st_size > 1000
    assert not (fine / "report.html").exists()
    kept = json.loads((fine / "numbers.json").read_text())
    assert [record["name"] for record in kept["beside"]] == ["coarse"]
    # Once more without the other report at hand: what was kept of it is enough.
    (coarse / "numbers.json").unlink()
    models.run(options("--rewrite", str(fine)))
    assert (fine / "README.md").read_text() == text  # on the same day
    with pytest.raises(UserError, match="coarse has no numbers.json"):
        models.run(options("--rewrite", str(coarse)))


# Rows: what the three cones of an eye that lacks one kind see of linear red, green, blue (Machado et al. 2009).
LACKING = {
    "none": np.eye(3),
    "long": np.array([[0.1523, 1.0526, -0.2049], [0.1145, 0.7863, 0.0992], [-0.0039, -0.0481, 1.0520]]),
    "middle": np.array([[0.3673, 0.8606, -0.2280], [0.2801, 0.6725, 0.0474], [-0.0118, 0.0429, 0.9689]]),
    "short": np.array([[1.2555, -0.0767, -0.1788], [-0.0784, 0.9308, 0.1476], [0.0047, 0.6914, 0.3039]]),
}  # fmt: skip


def lab(colour, cones):
    """CIE L*a*b* of a colour "#rrggbb" as such an eye sees it."""
    value = np.array([int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5)])
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ np.clip(cones @ linear, 0, 1) / np.array([0.9505, 1.0, 1.089])
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("lacking", LACKING)
def test_models_differ_in_colour_to_every_eye(lacking):
    """Twenty units of L*a*b* are told apart in thin lines at a glance; dark red and dark green are 12 apart to one."""
    colours = [lab(entry[1], LACKING[lacking]) for entry in model_figures.MODELS.values()]
    pairs = [(a, b) for n, a in enumerate(colours) for b in colours[:n]]
    assert min(np.linalg.norm(a - b) for a, b in pairs) > 20


def test_intervals_of_counted_heights():
    """Poisson: of one jump 0.0253 to 5.5716, of ten 4.795 to 18.39; over eleven jumps and bins of 0.1."""
    x, density, low, high = model_figures.counted_pdf(np.array([0.05] * 10 + [0.75]), model_figures.JUMP_EDGES)
    assert x == pytest.approx([0.05, 0.75])
    assert density * 1.1 == pytest.approx([10, 1])
    assert low * 1.1 == pytest.approx([4.7954, 0.025318], rel=1e-4)
    assert high * 1.1 == pytest.approx([18.3904, 5.571643], rel=1e-4)


def test_a_grain_in_a_pocket(tmp_path):
    """Three unit spheres at 0.5 D, a unit apart, carry it at 0.5 + sqrt(2/3); a heap of spheres has no such height."""
    run = Run(write_run(tmp_path / "run", wandering_story()))
    row = np.sqrt(3) / 2
    with h5py.File(run.folder / "spheres.h5", "r+") as file:
        for name in ("position", "radius"):
            del file[f"fixed/{name}"]
        file["fixed/position"] = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 1.5], [0.5 + row, 0.5, 1.0]])
        file["fixed/radius"] = np.full(3, 0.5)
    assert bed_friction.bed_top(run) == 1.0
    assert model_figures.pocket_height(run) == pytest.approx(0.5 + np.sqrt(2 / 3))
    with h5py.File(run.folder / "spheres.h5", "r+") as file:
        file["fixed/position"][0, 1] = 0.6
    assert model_figures.pocket_height(run) is None


def test_runs_stand_in_the_paper_s_order():
    names = ["actm_hw", "mine", "rpm_hw", "actm", "rpm"]
    ordered = sorted(((m, r) for r in (2.25, 1.25) for m in names), key=lambda run: model_figures.in_order(*run))
    assert ordered == [(m, r) for r in (1.25, 2.25) for m in ("rpm", "rpm_hw", "actm", "actm_hw", "mine")]


def test_grains_that_rest_are_not_ranked_by_their_trembling():
    trembling = [of_resolution(10.0, v, 1e-6, model=m) for m, v in (("rpm", 2e-5), ("actm", 1e-5))]
    assert model_sentences.order_sentence(trembling, False) == "No model moves grains."
    one = [of_resolution(10.0, 0.05, model="rpm_hw"), *trembling]
    told = model_sentences.order_sentence(one, False)
    assert told == "Only rpm + HW moves grains; with rpm, actm they hardly move (below 0.0005 u_b)."
    coarse = Record("coarse", [of_resolution(6.0, 3e-5, 1e-6)], True)
    assert other_records.trend_rows(trembling[:1], [coarse], False)[-1][-1] == "0.000 ± 0.000, both below 0.0005 u_b"


def test_velocities_and_shares_in_motion_stand_first():
    values = [run_numbers("rpm", mean_velocity=0.2), run_numbers("rpm_hw", mean_velocity=0.15)]
    text = model_sentences.answer(values, True)
    assert text.startswith("**Mean velocity of the grains over u_b: rpm 0.200 ± ")
    assert " (the paper 0.247), rpm + HW 0.150 ± " in text
    assert text.endswith("HW is the friction of Haff and Werner: `--model rpm_hw`.")
    several = model_sentences.answer([run_numbers("rpm", 1.25), run_numbers("rpm", 2.25)], False)
    assert "u_b: at ρp/ρf 1.25 rpm " in several and "; at ρp/ρf 2.25 rpm " in several and "HW" not in several


def test_a_handful_of_collisions_is_not_drawn_as_a_distribution(tmp_path):
    run = SimpleNamespace(value={"reference.sphere_density": 2.0, "fluid.density": 1.0}.__getitem__)
    case = model_figures.Case("actm", run, 0.0, None)

    def found(number):
        ranges = ((1, 9), (1, 2), (1e-4, 1e-2))
        return case, CollisionStatistics(*(np.geomspace(*ends, number) for ends in ranges))

    file = tmp_path / "collisions.png"
    assert not model_figures.collisions([found(model_figures.FEWEST - 1)], file) and not file.exists()
    assert model_figures.collisions([found(model_figures.FEWEST)], file) and file.exists()
