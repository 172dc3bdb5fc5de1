"""`--accuracy auto` follows what a study of effects found certain, and nothing else."""

import pytest
from bedload_launcher import presets, verdicts
from bedload_launcher.errors import UserError
from bedload_launcher.scenes import Scene, find_scene

SINGLE = 'accuracy.precision="single"'


def row(effect="precision", time=0.6, change=0.001, interval=0.002, verdict="leave it out", keys=SINGLE):
    numbers = {"time": time, "change": change, "interval": interval}
    return {"effect": effect, "verdict": verdict, "keys": keys} | {k: str(v) for k, v in numbers.items()}


@pytest.mark.parametrize(
    "passed_over",
    [
        row(verdict="open"), row(verdict="needed"), row(verdict="no matter"),
        row(time=1.8),  # an effect that the scene has not, and should not get
        row(keys=""),  # another model, or no lubrication: the script's
        row(effect="output", keys="output.fields_every=0.0"), row(effect="statistics"),
        row(interval=0.03),
    ],
)  # fmt: skip
def test_only_what_is_certain_and_cheaper_is_left_out(passed_over):
    assert verdicts.followed([passed_over]) == []
    assert [one.keys for one in verdicts.followed([passed_over, row()])] == [[SINGLE]]


def test_changes_add_up_to_two_per_cent_at_most():
    loops = row("forcing loops", 0.8, -0.009, 0.003, keys="spheres.forcing_loops=1")
    pressure = row("old pressure", 0.9, 0.008, 0.002, keys="spheres.pressure_share=0.0; a=1")
    taken = verdicts.followed([pressure, loops, row()])
    assert [one.effect for one in taken] == ["precision", "forcing loops"]  # 0.003 + 0.012, and 0.010 is too much
    assert [one.effect for one in verdicts.followed([pressure, row()])] == ["precision", "old pressure"]
    assert verdicts.followed([pressure])[0].keys == ["spheres.pressure_share=0.0", "a=1"]


def test_settings_say_why(tmp_path, monkeypatch):
    scene = Scene(tmp_path / "mine")
    monkeypatch.setattr(verdicts, "KEPT", tmp_path)
    monkeypatch.setattr(verdicts, "INPUTS", tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match="study effects mine"):
        presets.settings_of("auto", scene, [])
    lines = [",".join(row()), ",".join(row().values())]
    (tmp_path / "mine.csv").write_text("\n".join(lines) + "\n")
    own, told, last = presets.settings_of("auto", scene, ["time.end=2"])
    assert (own, last) == (SINGLE, "time.end=2")
    assert told == ('accuracy.verdicts="single precision: study effects: 0.60 of the time, answer +0.10 +- 0.20 %"')
    # A table of one's own goes before the kept one.
    (tmp_path / "runs" / "effects-mine").mkdir(parents=True)
    (tmp_path / "runs" / "effects-mine" / "effects.csv").write_text(lines[0] + "\n")
    assert presets.settings_of("auto", scene, []) == []
    # A study with --set is of what was set; how long it went and what it wrote do not count.
    own_folder = tmp_path / "runs" / "effects-mine"
    verdicts.note(own_folder, scene, None, ["fluid.gravity=[0,-1,0]", "time.end=9", "output.fields_every=0"])
    (tmp_path / "runs" / "effects-mine" / "effects.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(UserError, match=r"is of runs with --set 'fluid.gravity=\[0,-1,0\]', unlike this one"):
        presets.settings_of("auto", scene, ["time.end=2"])
    same = presets.settings_of("auto", scene, ["time.end=2", "fluid.gravity=[0,-1,0]"])
    assert same == [SINGLE, told, "time.end=2", "fluid.gravity=[0,-1,0]"]
    verdicts.note(own_folder, scene, "actm", [])
    with pytest.raises(UserError, match="is of runs with no --set, unlike this one"):
        presets.settings_of("auto", scene, ["fluid.gravity=[0,-1,0]"], "actm")
    with pytest.raises(UserError, match="is of runs with model actm, unlike this one"):
        presets.settings_of("auto", scene, [], "rpm")
    with pytest.raises(UserError, match="is of runs with the scene .*/mine, unlike this one"):
        presets.settings_of("auto", Scene(tmp_path / "other" / "mine"), [], "actm")


def test_a_kept_table_is_of_a_shipped_scene_and_its_own_model(tmp_path, monkeypatch):
    """Not of one of one's own that has its name."""
    monkeypatch.chdir(tmp_path)
    shipped = find_scene("exposed_sphere")
    assert verdicts.table(shipped) is not None and verdicts.settings_of(shipped, [], shipped.default_model())
    with pytest.raises(UserError, match="is of runs with model actm_hw, unlike this one"):
        presets.settings_of("auto", shipped, [], "rpm")
    with pytest.raises(UserError, match="neither in runs"):
        presets.settings_of("auto", Scene(tmp_path / "exposed_sphere"), [])
