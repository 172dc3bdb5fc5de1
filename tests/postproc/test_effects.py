"""`./bedload study effects`: that a scene without lubrication has none, wherever its models stand."""

import copy
import shutil
import tomllib

import numpy as np
import pytest
from bedload_launcher import job
from bedload_launcher.scenes import INPUTS, Scene, find_scene
from bedload_studies import effects, scene_answers


def own_scene(folder, model="actm_hw"):
    """A scene as the tutorial makes it: the models are its own."""
    shutil.copytree(INPUTS / "models", folder / "models")
    (folder / "fluid.toml").write_text("")
    script = [f"variable model index {model}", "include models/${model}.liggghts", "coupled_run"]
    (folder / "in.liggghts").write_text("\n".join(script) + "\n")
    return Scene(folder)


def shipped(name):
    scene = find_scene(name)
    return lambda _: scene


@pytest.mark.parametrize(
    "make", [own_scene, *map(shipped, ("exposed_sphere", "setup2_small", "validation/box",
                                       "validation/rebound", "validation/kissing"))]
)  # fmt: skip
def test_lubrication_is_taken_off_before_the_grains_move(make, tmp_path):
    scene = make(tmp_path)
    model = scene.default_model()
    off = effects.without_lubrication(scene, model, tmp_path)
    lines = off.script.read_text().splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("coupled_run"))
    assert lines[first - 1] == "unfix lubrication"
    # The model stands in the script, and its lubrication, which unfix needs, with it.
    assert any(line.startswith("pair_style gran ${contact}") for line in lines[:first])
    assert any(line.startswith("fix lubrication all") for line in lines[:first])
    assert not any(line.startswith("include") for line in lines)
    # It runs where the scene stands, so that its other files are found.
    command = job.Job(off, model, job.Ranks(1, 1), tmp_path / "out").command()
    assert command[command.index("-in") + 1] == str(off.script)
    assert off.folder == scene.folder


SIZES = {"grid": {"cells": [80, 40, 40], "length": [8.0, 4.0, 4.0]}, "reference": {"diameter": 1.0}}
SPHERES = {"forcing_loops": 1, "pressure_share": 0.0} | dict.fromkeys(("interior_term", "rigid_core", "buoyancy"), "on")


def test_lubrication_is_offered_where_there_is_some(tmp_path):
    spheres = dict(SPHERES)
    settings = {**copy.deepcopy(SIZES), "fluid": {"gravity": [0.0, -1.0, 0.0]}, "spheres": spheres,
                "time": {"cfl": 0.0},
                "accuracy": {"precision": "double"}, "statistics": {"every": 0},
                "coupling": {"dem_steps": 15, "exchange": "stage"}}  # fmt: skip
    scene = own_scene(tmp_path, "mine")
    text = (scene.folder / "models" / "rpm.liggghts").read_text()
    mine = scene.folder / "models" / "mine.liggghts"
    for line, offered in (("", False), ("fix film all lubrication every 2", True)):
        mine.write_text(text + line + "\n")
        found = [v.effect for v in effects.variants(scene, "mine", settings)]
        assert ("lubrication" in found) == offered
    assert {"interior term", "rigid core", "buoyancy"} <= set(found)
    settings["fluid"]["gravity"] = [0.0, 0.0, 0.0]
    spheres["interior_term"] = spheres["rigid_core"] = "off"
    assert "rigid core" not in {v.effect for v in effects.variants(scene, "mine", settings)}
    settings["reference"]["diameter"] = 0.6  # six cells: no core to leave out
    spheres["rigid_core"] = "on"
    left = {v.effect for v in effects.variants(scene, "mine", settings)}
    assert not {"interior term", "rigid core", "buoyancy"} & left
    assert effects.lubrication_fixes(effects.scene_script(scene, "mine")) == ["film"]
    mine.write_text(text + line + "\nunfix film\n")
    assert effects.lubrication_fixes(effects.scene_script(scene, "mine")) == []


def test_moving_boundaries_are_priced_where_the_script_can_hold_its_grains(tmp_path):
    settings = {**SIZES, "fluid": {"gravity": [0.0, -1.0, 0.0]}, "time": {"cfl": 0.0}, "statistics": {"every": 0},
                "spheres": SPHERES,
                "accuracy": {"precision": "double"}, "coupling": {"dem_steps": 15, "exchange": "stage"}}  # fmt: skip
    found = effects.variants(find_scene("setup2_small"), "actm_hw", settings)
    by_variable = {v.effect: v for v in found if v.variables}
    held, films = by_variable["moving boundary"], by_variable["films against sliding and rolling"]
    assert (held.variables, held.turned_off) == ((("hold", "1"),), True)
    assert (films.variables, films.turned_off) == ((("lubrication_settings", "tangential on"),), False)
    assert len(by_variable) == 2
    # A scene without that variable, and one whose script says itself what its films do.
    mine = own_scene(tmp_path)
    left_out, = [v for v in effects.variants(mine, "actm_hw", settings) if v.variables]
    assert (left_out.effect, left_out.turned_off) == (films.effect, True)
    assert left_out.variables == (("lubrication_settings", "tangential off"),)
    text = mine.script.read_text()
    mine.script.write_text(text.replace("include", 'variable lubrication_settings string "law published"\ninclude', 1))
    assert not any(v.variables for v in effects.variants(mine, "actm_hw", settings))


def test_without_the_answer_itself_an_effect_is_needed():
    """Grains that are held have no velocity; its row keeps the price."""
    series = scene_answers.Series(np.linspace(0.0, 1.0, 11), np.ones(11))
    base = scene_answers.Priced([2.0], 100.0, {"grain velocity": series})
    held = scene_answers.Priced([1.5], 90.0, {"driving force": series})
    variant = effects.Variant("moving boundary", "grains held", turned_off=True)
    row = effects.compare(variant, held, base, "grain velocity", 0.5)
    assert (row.verdict, row.time, row.memory) == ("needed", 0.75, 0.9)
    assert "no such answer" in effects.table_text([row])


def test_what_else_grains_do_has_to_stay_too():
    """Without buoyancy a grain goes on along x as before and sinks faster: nothing to be left out by itself."""
    time = np.linspace(0.0, 10.0, 101)
    same, sunk = (scene_answers.Series(time, np.full(101, level)) for level in (1.0, 0.9))
    variant = effects.Variant("buoyancy", "off", ('spheres.buoyancy="off"',), turned_off=True)
    for height, long, verdict, words in ((same, True, "leave it out", ""), (sunk, True, "open", "grain height -10.00"),
                                         (same, False, "open", "too short to tell")):  # fmt: skip
        seconds = [20.0, 20.0, 20.0] if long else [0.2]
        base = scene_answers.Priced(seconds, 100.0, {"grain velocity": same, "grain height": same})
        run = scene_answers.Priced([0.5 * s for s in seconds], 90.0, {"grain velocity": same, "grain height": height})
        row = effects.compare(variant, run, base, "grain velocity", 5.0)
        assert row.verdict == verdict and row.words.startswith(words)
        assert f"{verdict} ({words}" in effects.table_text([row]) or not words
        assert row.keys == 'spheres.buoyancy="off"'


def test_the_second_half_is_that_of_the_time_that_was_run():
    """With time.cfl the steps are shorter than time.step says."""
    series = scene_answers.Series(np.linspace(0.5, 1.5, 11), np.linspace(1.0, 2.0, 11))
    run = scene_answers.Priced([2.0], 100.0, {"driving force": series})
    assert effects.half_way(run) == pytest.approx(1.0)
    assert effects.moves(run, None, effects.half_way(run)) == "driving force"


def test_convection_goes_with_its_limit_for_the_step():
    """time.cfl without convection is refused."""
    scene = find_scene("channel180")
    settings = tomllib.loads((scene.folder / "fluid.toml").read_text()) | {"spheres": {}}
    for cfl, keys in ((1.6, ('fluid.convection="off"', "time.cfl=0.0")), (0.0, ('fluid.convection="off"',))):
        settings["time"]["cfl"] = cfl
        assert [v.keys for v in effects.variants(scene, None, settings) if v.effect == "convection"] == [keys]


def test_statistics_go_with_their_spectra():
    """Spectra without statistics are refused."""
    scene = find_scene("channel180")
    settings = tomllib.loads((scene.folder / "fluid.toml").read_text()) | {"spheres": {}}
    found = [v.keys for v in effects.variants(scene, None, settings) if v.effect == "statistics"]
    assert settings["statistics"]["spectra_heights"]
    assert found == [("statistics.every=0", "statistics.spectra_heights=[]")]


def test_without_lubrication_grains_still_begin_where_they_are_put(tmp_path):
    """The includes that the script ends up with are those of the variables that the job is given."""
    scene = find_scene("setup2_small")
    off = effects.without_lubrication(scene, "actm_hw", tmp_path, {"placing": "placed"})
    lines = off.script.read_text().splitlines()
    assert any(line.split() == ["include", "${out}/grains.liggghts"] for line in lines)
    assert not any("insert/pack" in line for line in lines)
