"""The launcher: names, ranks, output folders, the mpirun line, signals and status."""

import os
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from bedload_launcher import accuracy, cli, job, machine, scenes, studies
from bedload_launcher.errors import UserError

ROOT = Path(__file__).resolve().parents[2]


def scene_in(folder, script="variable model index actm_hw\n"):
    folder.mkdir(parents=True)
    (folder / "fluid.toml").write_text("")
    if script is not None:
        (folder / "in.liggghts").write_text(script)
    return scenes.Scene(folder)


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        (["rn"], "no command 'rn'; the nearest is 'run'"),
        (["run", "--modle", "rpm"], "no '--modle'; did you mean --model"),
        (["run", "exposed_spere"], "no scene 'exposed_spere'; the nearest is 'exposed_sphere'"),
        (["run", "--ranks", "4:0"], "--ranks is '4:0', but must be FLUID:DEM"),
        (["run", "--steps", "ten"], "--steps: invalid int value: 'ten'"),
    ],
)
def test_mistakes_get_one_sentence(line, sentence):
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", ROOT / "postproc" / "launch.py", *line],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""


def test_a_model_is_looked_up_among_the_files(tmp_path, monkeypatch):
    monkeypatch.setattr(scenes, "INPUTS", tmp_path)
    (tmp_path / "models").mkdir()
    for name in ("rpm", "actm_hw"):
        (tmp_path / "models" / f"{name}.liggghts").touch()
    scene = scene_in(tmp_path / "bed")
    assert scenes.choose_model(scene, None) == "actm_hw"  # the script's own
    assert scenes.choose_model(scene, "rpm") == "rpm"
    with pytest.raises(UserError, match="no model 'actm_wh'; the nearest is 'actm_hw'"):
        scenes.choose_model(scene, "actm_wh")
    fixed = scene_in(tmp_path / "fixed", script="# variable model index rpm\n")
    assert scenes.choose_model(fixed, None) is None
    with pytest.raises(UserError, match="variable model index"):
        scenes.choose_model(fixed, "rpm")


def test_every_shipped_scene_has_its_files():
    for scene in scenes.all_scenes().values():
        assert scene.summary(), f"{scene.folder}/README.md has no first sentence"
        assert scene.default_model() in [None, *scenes.models()]


def test_ranks():
    assert job.Ranks.parse("4:2") == job.Ranks(4, 2)
    assert job.Ranks.parse("3") == job.Ranks(3, 1)
    assert job.Ranks.parse(None) == job.Ranks(machine.cores(), 1)


def test_compilers_fit_the_memory(monkeypatch):
    monkeypatch.setattr(machine, "processors", lambda: 64)
    monkeypatch.setattr(machine, "available_memory", lambda: 7 * machine.GIGABYTE)
    assert machine.compile_jobs() == 4
    monkeypatch.setattr(machine, "available_memory", lambda: 0.2 * machine.GIGABYTE)
    assert machine.compile_jobs() == 1


def test_the_job_starts_both_programs(tmp_path):
    scene = scene_in(tmp_path / "bed")
    line = job.Job(scene, "rpm", job.Ranks(3, 2), tmp_path / "out", ["time.end=2"], 5).command()
    fluid, dem = line[: line.index(":")], line[line.index(":") + 1 :]
    assert fluid[fluid.index("-np") + 1] == "3"
    assert dem[dem.index("-np") + 1] == "2"
    assert fluid[fluid.index("--set") + 1] == "time.end=2"
    assert fluid[fluid.index("--steps") + 1] == "5"
    assert dem[dem.index("model") + 1] == "rpm"
    assert dem[dem.index("out") + 1] == str(tmp_path / "out")


def test_no_liggghts_without_a_script(tmp_path):
    scene = scene_in(tmp_path / "channel", script=None)
    line = job.Job(scene, None, job.Ranks(2, 1), tmp_path / "out").command()
    assert ":" not in line
    assert not any("bedload-dem" in word for word in line)


def test_an_earlier_run_moves_aside_and_nothing_else_is_touched(tmp_path):
    out = tmp_path / "runs" / "bed"
    cli.claim_output(out)  # not there: nothing to do
    for mark in ("first", "second"):
        out.mkdir(parents=True, exist_ok=True)
        (out / "settings.toml").write_text(mark)
        cli.claim_output(out)
        assert not out.exists()
        assert (tmp_path / "runs" / "bed.previous" / "settings.toml").read_text() == mark
    out.mkdir()
    (out / "thesis.tex").touch()
    with pytest.raises(UserError, match="holds no earlier run"):
        cli.claim_output(out)
    assert (out / "thesis.tex").exists()


def test_a_restart_never_removes_or_invents_the_run_that_it_names(tmp_path):
    out, previous = tmp_path / "bed", tmp_path / "bed.previous"
    checkpoint = previous / "checkpoint_00000100"
    checkpoint.mkdir(parents=True)
    for restart in (previous, checkpoint):
        with pytest.raises(UserError, match="go on without --out"):
            cli.check_restart(restart, out)
        cli.check_restart(restart, previous)
        cli.check_restart(restart, tmp_path / "other")
    for wrong in (tmp_path / "bed.pervious", tmp_path, previous / "checkpoint_00000200"):
        with pytest.raises(UserError, match="neither a checkpoint nor a run"):
            cli.check_restart(wrong, out)
    line = ["run", "exposed_sphere", "--restart", tmp_path / "bed.pervious"]
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", ROOT / "postproc" / "launch.py", *line],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert "neither a checkpoint nor a run" in done.stderr
    assert not (tmp_path / "bed.pervious").exists()


@pytest.fixture
def started(monkeypatch):
    """The mpirun lines that `./bedload run` would have started, each of which ends with status 3."""
    lines = []
    monkeypatch.setattr(cli, "build", lambda _: None)
    monkeypatch.setattr(job, "run", lambda line, folder: lines.append(line) or 3)
    return lines


def test_a_restart_takes_the_model_from_the_run(tmp_path, started, capsys):
    out = tmp_path / "out"
    line = ["run", "exposed_sphere", "--var", "hold=1", "--set", "time.end=7"]
    for _ in range(2):  # the first one never began: nothing moves aside, nothing is in the way
        cli.run(cli.parse([*line, "--model", "rpm", "--out", str(out)]))
    assert "go on with" not in capsys.readouterr().err  # no checkpoint yet
    last = out / "checkpoint_00000100"
    last.mkdir()
    for more, model in (([], "rpm"), (["--model", "actm"], "actm"), ([], "actm")):
        cli.run(cli.parse([*line, *more, "--restart", str(last if more else out)]))
        assert started[-1][started[-1].index("model") + 1] == model
        assert f"go on with --set time.end=7 --var hold=1 --restart {last}" in capsys.readouterr().err
    (out / "model.txt").unlink()  # of a run that was not started here: the script's own
    cli.run(cli.parse([*line, "--restart", str(out)]))
    assert started[-1][started[-1].index("model") + 1] == "actm_hw"


def test_status_and_signals_pass_through(tmp_path):
    assert job.run([sys.executable, "-c", "raise SystemExit(7)"], tmp_path) == 7
    assert job.run([sys.executable, "-c", "import os; os.kill(os.getpid(), 9)"], tmp_path) == 137
    # The child says that it listens, and ends with 5 on the signal that only the parent gets.
    code = (
        "import pathlib, signal, sys, time\n"
        "signal.signal(signal.SIGUSR1, lambda *_: sys.exit(5))\n"
        "pathlib.Path('ready').touch()\n"
        "time.sleep(60)\n"
    )

    def send():
        while not (tmp_path / "ready").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGUSR1)

    threading.Thread(target=send, daemon=True).start()
    assert job.run([sys.executable, "-c", code], tmp_path) == 5
    assert signal.getsignal(signal.SIGUSR1) == signal.SIG_DFL


def bare_system(tmp_path, installed):
    """A copy of the launcher in a tree of its own, and stand-ins for dpkg-query, id and apt-get."""
    programs = tmp_path / "programs"
    programs.mkdir()
    log = tmp_path / "apt.log"
    listed = "\n".join(f"installed {name}" for name in installed)
    for name, body in {
        "dpkg-query": f"cat <<'END'\n{listed}\nEND",
        "id": "echo 0",
        "apt-get": f'echo "$@" >> {log}',
    }.items():
        file = programs / name
        file.write_text(f"#!/bin/bash\n{body}\n")
        file.chmod(file.stat().st_mode | stat.S_IXUSR)
    house = tmp_path / "house"
    (house / "postproc").mkdir(parents=True)
    (house / "postproc" / "launch.py").write_text("print('handed over')\n")
    text = (ROOT / "bedload").read_text()
    # The launcher puts the system's folders first; here the stand-ins come before them.
    text = text.replace('export PATH="', f'export PATH="{programs}:')
    (house / "bedload").write_text(text)
    done = subprocess.run(
        ["bash", house / "bedload", "run"], capture_output=True, text=True, check=True
    )
    assert done.stdout == "handed over\n"
    return log.read_text().splitlines() if log.exists() else []


def listed_packages():
    text = (ROOT / "bedload").read_text()
    block = text[text.index("packages=(") + 10 :]
    lines = block[: block.index("\n)")].splitlines()
    return [name for line in lines for name in line.split("#")[0].split()]


def test_only_missing_packages_are_installed(tmp_path):
    packages = listed_packages()
    assert {"liggghts", "clang", "python3-h5py"} <= set(packages)
    calls = bare_system(tmp_path, [name for name in packages if name not in ("clang", "xvfb")])
    assert len(calls) == 2
    assert calls[0].endswith("update")
    assert calls[1].endswith("clang xvfb")


def test_nothing_is_asked_of_apt_when_all_is_there(tmp_path):
    assert bare_system(tmp_path, listed_packages()) == []


def test_a_study_is_a_module_with_run_and_its_first_sentence(tmp_path, monkeypatch):
    (tmp_path / "drag.py").write_text('"""How drag converges\nwith D/h.\n\nMore."""\ndef run(o): ...\n')
    (tmp_path / "helper.py").write_text('"""No study."""\n')
    monkeypatch.setattr(studies, "FOLDER", tmp_path)
    assert studies.all_studies() == {"drag": "How drag converges with D/h."}
    with pytest.raises(UserError, match="no study 'darg'; the nearest is 'drag'"):
        studies.run_study("darg", [], None)


def test_a_preset_keeps_proportions_and_courant_number(tmp_path):
    scene = scene_in(tmp_path / "s", "variable model index rpm\nvariable cell index 0.1\n")
    (scene.folder / "fluid.toml").write_text(
        "[grid]\ncells = [160, 90, 80]\nlength = [16.0, 9.0, 8.0]\n[time]\nstep = 0.04\n"
    )
    settings = accuracy.settings_of("draft", scene, ["time.end=1"])
    assert settings == [
        'accuracy.precision="single"', "spheres.forcing_loops=1", "grid.cells=[128, 72, 64]",
        "time.step=0.05", "time.end=1",
    ]  # fmt: skip
    # The script hears of the new cell, else rpm would start its grain at the wrong height.
    line = job.Job(scene, "rpm", job.Ranks(1, 1), tmp_path / "o", settings).command()
    assert line[line.index("cell") - 1 : line.index("cell") + 2] == ["-var", "cell", "0.125"]
    assert accuracy.settings_of("standard", scene, []) == ['accuracy.precision="double"']
    assert accuracy.settings_of(None, scene, ["a=1"]) == ["a=1"]
    with pytest.raises(UserError, match="no accuracy 'fin'; the nearest is 'fine'"):
        accuracy.settings_of("fin", scene, [])


def test_a_grid_that_no_other_matches_has_no_preset(tmp_path):
    scene = scene_in(tmp_path / "s")
    (scene.folder / "fluid.toml").write_text("[grid]\ncells = [97, 53, 31]\nlength = [97, 53, 31]\n")
    with pytest.raises(UserError, match="97 x 53 x 31 cells, which no grid near 0.8"):
        accuracy.settings_of("draft", scene, [])


def test_variables_of_included_scripts_may_be_set():
    scene = scenes.find_scene("setup2_small")
    given = ["density=1.3", "lubrication_settings=unresolved 0.65"]
    assert scenes.read_variables(scene, "actm_hw", given) == {
        "density": "1.3",
        "lubrication_settings": "unresolved 0.65",
    }
    # rpm has no lubrication: LIGGGHTS itself would take the variable and forget it.
    with pytest.raises(UserError, match="there is no variable of setup2_small.*lubrication_settings"):
        scenes.read_variables(scene, "rpm", given)
    with pytest.raises(UserError, match="nearest is 'density'"):
        scenes.read_variables(scene, "rpm", ["densty=1.3"])
    with pytest.raises(UserError, match="must be NAME=VALUE"):
        scenes.read_variables(scene, "rpm", ["density"])
    with pytest.raises(UserError, match="by --model"):
        scenes.read_variables(scene, "rpm", ["model=actm"])
