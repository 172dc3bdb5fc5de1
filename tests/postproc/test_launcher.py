"""The launcher: names, ranks, output folders, the mpirun line, signals and status."""

import argparse
import errno
import fcntl
import os
import re
import signal
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import bedload_post
import pytest
from bedload_launcher import build, cli, folders, job, machine, memory, presets, runs, scenes, studies
from bedload_launcher.errors import UserError, refused, unknown
from bedload_launcher.words import plain
from bedload_post import show
from bedload_studies import analysis_speed
from processes import ended, wait_for

ROOT = Path(__file__).resolve().parents[2]


def scene_in(folder, script="variable model index actm_hw\ninclude ${inputs}/models/${model}.liggghts\n"):
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
        (["run", "--steps", "-3"], "--steps: is -3, but must be at least 0"),
        (["film", "runs/bed", "--frames", "0"], "--frames: is 0, but must be at least 1"),
        (["film", "runs/bed", "--frames", "-2"], "--frames: is -2, but must be at least 1"),
        (["film", "runs/bed", "--since", "nan"], "--since: is nan, but must be a finite number"),
        (["run", ""], "SCENE is empty, but must be the name of a scene or a folder with a fluid.toml"),
        (["estimate", ""], "SCENE is empty, but must be"),
        (["run", "--model", ""], "no model ''"),
        (["run", "--ranks", ""], "--ranks is '', but must be FLUID:DEM"),
        (["run", "--out", ""], "--out: is empty, but must be a path"),
        (["run", "--restart", ""], "--restart: is empty, but must be a path"),
        (["show", ""], "OUT: is empty, but must be a path"),
        (["settle", "8x8", "--grains", "9", "--out", "f", "--wet", "inf"], "--wet: is inf, but must be a finite"),
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


@pytest.mark.parametrize("since", ["-1e-5", "-2.5", "3"])
def test_a_film_may_begin_at_any_time(tmp_path, monkeypatch, since):
    """The line for show.py is understood there: what is wrong is the folder."""
    lines = []
    monkeypatch.setattr(job, "run", lambda line, _: lines.append(line) or 0)
    monkeypatch.setattr(sys, "argv", ["bedload", "film", str(tmp_path), f"--since={since}"])
    assert cli.main() == 0
    said = []
    monkeypatch.setattr(show.sys, "argv", lines[0][lines[0].index(str(tmp_path)) - 1 :])
    film = SimpleNamespace(render=lambda _, file, begin, most: said.append((begin, most)))
    monkeypatch.setattr(bedload_post, "film", film, raising=False)
    monkeypatch.setattr(show, "Run", lambda folder: folder)
    assert show.main() == 0 and said == [(float(since), 250)]


def test_what_the_system_refuses_is_one_sentence(tmp_path, started, monkeypatch, capsys):
    """A file where a folder should be, a write that finds no room: file and reason, no trace of the program."""
    file = tmp_path / "notes"
    file.write_text("kept")
    monkeypatch.setattr(cli, "build", lambda _: None)
    bed = ["settle", "8x8", "--grains", "9"]
    for line, out, status, sentence in (
        (["run", "exposed_sphere"], file, 2, f"--out is {file}, which is a file, but has to be a folder"),
        (["run", "exposed_sphere"], file / "x", 1, f"{file}/x: Not a directory"),
        (bed, file / "bed.data", 1, f"{file}"), (bed, file / "x" / "bed.data", 1, f"{file}"),
    ):  # fmt: skip
        monkeypatch.setattr(sys, "argv", ["bedload", *line, "--out", str(out)])
        assert cli.main() == status
        said = capsys.readouterr().err
        assert said.startswith(f"bedload: {sentence}") and said.count("\n") == 1
    assert file.read_text() == "kept" and not started
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # of a write, which does not know its file
    assert refused(full, Path("out")) == "out: No space left on device"
    assert refused(OSError("Unable to create file")) == "Unable to create file"


@pytest.mark.parametrize("found", ["foo", "/nonexist", "nix"])
def test_no_far_name_is_offered(found):
    names = ["rpm_hw", "channel180", "box"]
    assert str(unknown("name", found, names)) == f"there is no name '{found}'; there are: box, channel180, rpm_hw."
    assert "the nearest is 'rpm_hw'" in str(unknown("name", "rpmhw", names))


@pytest.mark.parametrize("line", [[], ["run"]])
def test_help_may_be_a_command(line):
    """As for git, apt or cargo."""
    def spoken(*words):
        return subprocess.run(["/usr/bin/python3", "-I", "-B", ROOT / "postproc" / "launch.py", *words],
                              check=True, capture_output=True, text=True).stdout  # fmt: skip

    assert spoken("help", *line) == spoken(*line, "--help") != ""


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
    unread = scene_in(tmp_path / "unread", script="variable model index actm_hw\n")
    assert scenes.choose_model(unread, "actm_hw") == "actm_hw"
    with pytest.raises(UserError, match=r"no line reads \$\{model\}, so --model rpm says nothing"):
        scenes.choose_model(unread, "rpm")
    fixed = scene_in(tmp_path / "fixed", script="# variable model index rpm\n")
    assert scenes.choose_model(fixed, None) is None
    with pytest.raises(UserError, match="variable model index"):
        scenes.choose_model(fixed, "rpm")


@pytest.mark.parametrize(
    ("script", "model"),
    [
        ("variable model index actm-soft\n", "actm-soft"),  # not actm, which is another one
        ("variable model index rpm actm\n", "rpm"),  # LIGGGHTS begins with the first
        ("include part\nvariable model index rpm\n", "actm_hw"),
        ("variable model string rpm\n", None),  # which no -var of the command line may precede
        ("variable model index\n", None),
    ],
)
def test_the_model_of_a_script_is_what_liggghts_reads(tmp_path, script, model):
    scene = scene_in(tmp_path / "s", script)
    (scene.folder / "part").write_text("variable model index actm_hw\n")
    assert scene.default_model() == scenes.choose_model(scene, None) == model


def test_settings_with_a_mark_in_front(tmp_path):
    """Some editors write one, bedload-fluid reads it, and so do estimates and studies."""
    scene = scene_in(tmp_path / "s")
    (scene.folder / "fluid.toml").write_text("[grid]\ncells = [8, 9, 10]\n", encoding="utf-8-sig")
    assert scene.cells() == (8, 9, 10)


def test_every_shipped_scene_has_its_files():
    for scene in scenes.all_scenes().values():
        assert scene.summary().endswith("."), f"{scene.folder}/README.md has no first sentence"
        assert scene.default_model() in [None, *scenes.models()]


def test_bytes_that_are_not_utf_8(tmp_path):
    """In a script and a README, most likely in a comment, they hinder nothing; in fluid.toml the line is named."""
    scene = scene_in(tmp_path / "s")
    comment = "variable model index rpm\n# grain de 2 \xb5m\ninclude more\n".encode("latin-1")
    (scene.folder / "in.liggghts").write_bytes(comment)
    (scene.folder / "more").write_bytes(b"# \xe9\nvariable density index 2\n")
    (scene.folder / "README.md").write_bytes("# T\n\nGrains de 2 \xb5m.\n".encode("latin-1"))
    assert scene.default_model() == "rpm"
    assert scene.variables() == {"model": "rpm", "density": "2"}
    assert scene.summary() == "Grains de 2 \ufffdm."
    (scene.folder / "in.liggghts").unlink()
    (scene.folder / "fluid.toml").write_bytes(b'[grid]\ncells = [8, 8, 8]\n# 2 \xb5m\n')
    for read in (scene.cells, scene.has_spheres, lambda: presets.settings_of("draft", scene, [])):
        with pytest.raises(UserError, match="fluid.toml: line 3 has the byte 0xb5, but the file must be UTF-8."):
            read()


def test_a_script_that_includes_itself_is_refused(tmp_path):
    """At once or by others in between; one that is included twice, one time after the other, is none."""
    scene = scene_in(tmp_path / "s", "variable other index b\ninclude ${other}\n")
    (scene.folder / "b").write_text("include in.liggghts\n")
    with pytest.raises(UserError, match=r"in.liggghts includes itself \(in.liggghts -> b -> in.liggghts\)."):
        scene.variables()
    (scene.folder / "b").write_text(f"include {scene.folder}/b\n")
    with pytest.raises(UserError, match=r"b includes itself \(b -> b\)."):
        scene.variables()
    scene.script.write_text("include b\ninclude b\n")
    (scene.folder / "b").write_text("run 0\n")
    assert list(scene.script_lines()) == ["run 0", "run 0"]


def test_ranks():
    assert job.Ranks.parse("4:2") == job.Ranks(4, 2)
    assert job.Ranks.parse("3") == job.Ranks(3, 1)
    assert job.Ranks.parse(None) == job.Ranks(machine.cores(), 1)
    for text in ("²:1", "1:2:3", "-1", ":1", ""):
        with pytest.raises(UserError, match=f"--ranks is '{text}', but must be FLUID:DEM"):
            job.Ranks.parse(text)


@pytest.mark.parametrize("share, grains, ranks, advised", [
    (0.39, 9400, job.Ranks(4, 1), "--ranks 4:4 "), (0.39, 5000, job.Ranks(2, 1), "--ranks 2:2 "),
    (0.15, 9400, job.Ranks(4, 1), None), (0.39, 3900, job.Ranks(4, 1), None), (0.39, 9400, job.Ranks(4, 4), None),
])  # fmt: skip
def test_long_waits_for_liggghts_advise_more_of_its_ranks(tmp_path, monkeypatch, share, grains, ranks, advised):
    monkeypatch.setattr(job, "cores", lambda: 4)
    (tmp_path / "timing.csv").write_text(f"part,share\nmarkers,0.5\nwaiting for LIGGGHTS,{share}\n")
    (tmp_path / "history.csv").write_text(f"step,mobile_spheres\n0,1\n10,{grains}\n")
    said = job.advice_on_ranks(tmp_path, ranks)
    assert said is None if advised is None else said is not None and advised in said


def test_without_whole_times_nothing_is_advised(tmp_path):
    assert job.advice_on_ranks(tmp_path, job.Ranks(1, 1)) is None
    (tmp_path / "timing.csv").write_text("part,share\nwaiting for LIGGGHTS,0.39\n")
    for broken in ("", "step,mobile_spheres\n1\n", "step,mobile_spheres\n1,9400\n\0\0"):
        (tmp_path / "history.csv").write_text(broken)
        assert job.advice_on_ranks(tmp_path, job.Ranks(1, 1)) is None


def test_ranks_of_liggghts_are_for_a_scene_with_grains(tmp_path, started, monkeypatch):
    monkeypatch.setattr(cli, "build", lambda _: None)
    for name in ("run", "estimate"):
        options = cli.parse([name, "channel180", "--ranks", "2:2"])
        with pytest.raises(UserError, match="--ranks is '2:2', but scene 'channel180' has no in.liggghts"):
            options.action(options)
    cli.run(cli.parse(["run", "channel180", "--ranks", "2", "--out", str(tmp_path / "out")]))
    assert "2" in started[0]


def test_the_watch_over_memory_outlives_a_process_that_ends_meanwhile(monkeypatch):
    with subprocess.Popen(["sleep", "10"]) as child:
        assert child.pid in memory._descendants(os.getpid())
        listed = os.listdir

        def gone(folder):
            if folder == f"/proc/{child.pid}/task":
                raise FileNotFoundError(folder)
            return listed(folder)

        monkeypatch.setattr(memory.os, "listdir", gone)
        assert child.pid in memory._descendants(os.getpid())
        child.kill()


def test_memory_of_runs_that_follow_each_other_does_not_add_up():
    def peak(runs, side_by_side):
        hold = [sys.executable, "-c", "import time; kept = b'x' * 30_000_000; time.sleep(0.5)"]
        with memory.MemoryWatch(os.getpid()) as watch:
            for _ in range(runs):
                for child in [subprocess.Popen(hold) for _ in range(side_by_side)]:
                    child.wait()
        return watch.bytes_of(Path(sys.executable).name)

    one = peak(1, 1)
    assert one > 30e6
    assert peak(3, 1) < 1.5 * one < peak(1, 3)


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


def claimed(out):
    """Takes the folder, makes room, and gives it up."""
    with folders.Folder(out) as folder:
        return folder.make_room()


def test_an_earlier_run_moves_aside_and_nothing_is_removed(tmp_path):
    out = tmp_path / "runs" / "bed"
    assert claimed(out) is None  # not there: nothing to do
    names = ["bed.previous", "bed.previous2", "bed.previous3"]
    for mark, name in enumerate(names):
        (out / "settings.toml").write_text(str(mark))
        (out / "history.csv").write_text("step,time\n1,0.1\n")
        assert claimed(out) == out.with_name(name)
        assert [file.name for file in out.iterdir()] == [folders.LAUNCH]
    assert [(out.with_name(n) / "settings.toml").read_text() for n in names] == ["0", "1", "2"]
    (out / "thesis.tex").touch()
    with pytest.raises(UserError, match="holds no earlier run"):
        claimed(out)
    assert (out / "thesis.tex").exists()
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.tex").touch()
    with pytest.raises(UserError, match="holds no earlier run"):
        claimed(foreign)
    assert [file.name for file in foreign.iterdir()] == ["thesis.tex"]  # as it was


def test_a_start_that_failed_is_taken_over(tmp_path):
    (tmp_path / "settings.toml").touch()
    (tmp_path / "log.liggghts").touch()
    (tmp_path / "history.csv").write_text("step,time\n")  # its head, no row
    assert claimed(tmp_path) is None
    (tmp_path / "profile.txt").touch()  # of the script's own fix ave/time
    assert claimed(tmp_path) is None
    (tmp_path / "checkpoint_00000010").mkdir()
    assert claimed(tmp_path) == tmp_path.with_name(tmp_path.name + ".previous")


def test_a_folder_in_use_is_refused_with_the_name_of_who_has_it(tmp_path):
    out = tmp_path / "bed"
    with folders.Folder(out) as folder:
        folder.note(folders.Launch("/scenes/bed", began="noon", host="here", process=17))
        with pytest.raises(UserError, match="process 17 on here, since noon; wait"):
            claimed(out)
    assert claimed(out) is None  # given up
    # The programs' own lock, whoever started them.
    (out / "run.lock").write_text("host = far\nprocess = 5\njob = SLURM_JOB_ID 3\n")
    assert claimed(out) is None  # a file that nobody holds
    with (out / "run.lock").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(UserError, match="process 5 on far, job SLURM_JOB_ID 3; wait"):
            claimed(out)


def test_a_second_run_of_a_scene_leaves_the_first_alone(tmp_path, started, monkeypatch):
    out, errors = tmp_path / "out", []

    def second(line, folder):
        if not errors:
            errors.append("")
            with pytest.raises(UserError, match="another `./bedload run` writes") as refused:
                cli.run(cli.parse(["run", "exposed_sphere", "--out", str(out)]))
            errors.append(str(refused.value))
        return 3

    monkeypatch.setattr(job, "run", second)
    (tmp_path / "out").mkdir()
    assert cli.run(cli.parse(["run", "exposed_sphere", "--out", str(out)])) == 3
    assert str(os.getpid()) in errors[1]
    assert not out.with_name("out.previous").exists()


@pytest.mark.parametrize("began", [False, True])
def test_a_refused_run_gives_its_place_back(tmp_path, started, monkeypatch, capsys, began):
    """Settings and script are judged by the programs, when the earlier run has made room already."""
    out, previous = tmp_path / "out", tmp_path / "out.previous"
    out.mkdir()
    (out / "settings.toml").write_text("good")
    (out / "history.csv").write_text("step,time\n1,0.1\n")

    def programs(line, folder):
        assert (previous / "settings.toml").read_text() == "good"
        for name in ["run.lock", "log.liggghts", "profile.txt", *(["settings.toml"] if began else [])]:
            (out / name).write_text("bad")
        (out / "post").mkdir()  # of the script's own dump
        return 1

    monkeypatch.setattr(job, "run", programs)
    assert cli.run(cli.parse(["run", "exposed_sphere", "--out", str(out)])) == 1
    said = capsys.readouterr().err
    kept = previous if began else out
    assert (kept / "settings.toml").read_text() == "good"
    assert sorted(f.name for f in tmp_path.iterdir()) == (["out", "out.previous"] if began else ["out"])
    assert ("the earlier run is" in said) != began
    assert claimed(out) == (None if began else previous)  # the folder is free


def test_a_refused_run_moves_nothing_that_another_command_holds(tmp_path):
    out = tmp_path / "out"
    (out / "checkpoint_00000010").mkdir(parents=True)
    with folders.Folder(out) as folder:
        aside = folder.make_room()
        folder.note(folders.Launch("/scenes/bed"))
        with folders.Folder(aside):  # ./bedload run --restart out.previous, meanwhile
            assert not folder.take_back(aside)
            assert is_dir_with(aside, "checkpoint_00000010") and is_dir_with(out, folders.LAUNCH)
        with (out / "run.lock").open("w") as held:  # bedload-fluid, started by hand
            fcntl.flock(held, fcntl.LOCK_EX)
            assert not folder.take_back(aside)
        assert folder.take_back(aside)
    assert is_dir_with(out, "checkpoint_00000010") and not aside.exists()


def test_a_folder_that_moves_while_it_is_taken_is_not_taken(tmp_path, monkeypatch):
    """Two commands at once: the file that the second one opened went aside with the earlier run."""
    out, lock = tmp_path / "out", folders._flock

    def late(file):
        if out.exists():
            out.rename(tmp_path / "out.previous")
        return lock(file)

    monkeypatch.setattr(folders, "_flock", late)
    with pytest.raises(UserError, match="another `./bedload run` writes"), folders.Folder(out):
        pass


def is_dir_with(folder, name):
    return folder.is_dir() and (folder / name).exists()


def test_a_restart_never_removes_or_invents_the_run_that_it_names(tmp_path):
    previous = tmp_path / "bed.previous"
    checkpoint = previous / "checkpoint_00000100"
    checkpoint.mkdir(parents=True)
    for restart in (previous, checkpoint):
        runs.check_restart(restart)
    for wrong in (tmp_path / "bed.pervious", tmp_path, previous / "checkpoint_00000200"):
        with pytest.raises(UserError, match="neither a checkpoint nor a run"):
            runs.check_restart(wrong)
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
    """The mpirun lines that `./bedload run` would have started, each of which ends with status 3; those that go on
    open their output as bedload-fluid does."""
    lines = []

    def programs(line, folder):
        lines.append(line)
        if "--restart" in line:
            out = Path(line[line.index("--out") + 1])
            (out / "new").write_text("")
            (out / "new").rename(out / "settings.toml")
        return 3

    monkeypatch.setattr(runs, "build", lambda _: None)
    monkeypatch.setattr(job, "run", programs)
    return lines


def values_of(line, option):
    return [line[n + 1] for n, word in enumerate(line) if word == option]


def test_a_restart_is_told_what_the_run_was_told(tmp_path, started, capsys):
    out = tmp_path / "out"
    told = ["--accuracy", "draft", "--var", "density=1.3", "--var", "hold=1",
            "--set", "time.end=7", "--set", "checkpoint.every=2", "--ranks", "1:3"]  # fmt: skip
    first = ["run", "setup2_small", "--model", "rpm", *told, "--out", str(out)]
    for _ in range(2):  # the first one never began: nothing moves aside, nothing is in the way
        cli.run(cli.parse(first))
    assert "go on with" not in capsys.readouterr().err  # no checkpoint yet
    last = out / "checkpoint_00000100"
    last.mkdir()
    for more, where in ((["--set", "time.end=9", "--var", "hold=0"], out), ([], last), (["--model", "rpm"], out)):
        cli.run(cli.parse(["run", "--restart", str(where), *more]))
        line = started[-1]
        assert values_of(line, "-np") == ["1", "3"]
        assert line[line.index("model") + 1] == "rpm"
        assert "time.end=9" in line and "time.end=7" not in line  # the second time from the first restart
        assert "checkpoint.every=2" in line and "spheres.forcing_loops=1" in line
        assert line[line.index("hold") + 1] == "0" and line[line.index("density") + 1] == "1.3"
        said = capsys.readouterr()
        assert "with --accuracy draft --set checkpoint.every=2 --set time.end=9 --var density=1.3" in said.out
        assert f"go on with --restart {last}" in said.err
    (out / folders.LAUNCH).unlink()  # of a run that was not started here: the script's own
    with pytest.raises(UserError, match="name it: ./bedload run SCENE --restart"):
        runs.start(runs.Ask(restart=out))
    assert not (out / folders.LAUNCH).exists()  # no scene was made up for it
    cli.run(cli.parse(["run", "setup2_small", "--restart", str(out)]))
    assert started[-1][started[-1].index("model") + 1] == "actm_hw"
    assert "time.end=9" not in started[-1]


def first_part(folder):
    """The output folder of a run that has come to step 100, and what its launch.json says."""
    out = folder / "out"
    cli.run(cli.parse(["run", "setup2_small", "--model", "rpm", "--out", str(out)]))
    (out / "checkpoint_00000100").mkdir()
    for name in ("settings.toml", "timing.csv", "log.liggghts"):
        (out / name).write_text("of the first part")
    return out, (out / folders.LAUNCH).read_text()


@pytest.mark.parametrize("steps", [0, 20])
def test_a_restart_with_nothing_to_do_leaves_the_folder_as_it_was(tmp_path, started, monkeypatch, steps):
    """Times of a run that made no step are no times, and a time.end that lies behind is none to go on with."""
    out, before = first_part(tmp_path)

    def programs(line, folder):
        if line[0] != "mpirun":  # the pictures
            return 0
        for name in ("settings.toml", "timing.csv", "log.liggghts"):
            (out / name).write_text("of the second part")
        if steps:
            (out / f"checkpoint_{100 + steps:08d}").mkdir()
        return 0

    monkeypatch.setattr(job, "run", programs)
    assert cli.run(cli.parse(["run", "--restart", str(out), "--set", "time.end=1"])) == 0
    kept = "first" if steps == 0 else "second"
    assert (out / "timing.csv").read_text() == (out / "log.liggghts").read_text() == f"of the {kept} part"
    assert ((out / folders.LAUNCH).read_text() == before) == (steps == 0)


@pytest.mark.parametrize("began", [False, True])
def test_a_refused_restart_leaves_the_folder_as_it_was(tmp_path, started, monkeypatch, capsys, began):
    """A mistake is not remembered, and the run's log and times keep their names; once bedload-fluid has opened its
    output the next part has begun. Nobody is told to go on from a checkpoint that was refused."""
    out, before = first_part(tmp_path)
    (out / "checkpoint_00000100").mkdir(exist_ok=True)

    def programs(line, folder):
        assert "time.edn=120" in line and (out / "timing.part1.csv").is_file()
        for name in ["log.liggghts", *(["settings.toml"] if began else [])]:
            (out / "new").write_text("of the second part")
            (out / "new").rename(out / name)
        return 1

    monkeypatch.setattr(job, "run", programs)
    assert cli.run(cli.parse(["run", "--restart", str(out), "--set", "time.edn=120"])) == 1
    assert ((out / folders.LAUNCH).read_text() == before) != began
    assert (out / "timing.part1.csv").is_file() == began
    assert ((out / "log.liggghts").read_text() == "of the first part") != began
    said = capsys.readouterr().err
    assert ("go on with" in said) == began and (f"{out} is as it was" in said) != began


def test_what_is_wrong_with_the_grid_is_said_before_anything_moves(tmp_path, started):
    out = tmp_path / "out"
    out.mkdir()
    (out / "history.csv").write_text("step,time\n1,0.1\n")
    for setting, why in (
        ("grid.cells=[160,90,80", "--set grid.cells=[160,90,80: Unclosed array"),
        ("grid.cells=[160,90]", "--set grid.cells=[160,90]: grid.cells must be three numbers"),
    ):
        with pytest.raises(UserError, match=re.escape(why)):
            runs.start(runs.Ask(scene="exposed_sphere", sets=[setting], out=out))
    assert not started and [f.name for f in tmp_path.iterdir()] == ["out"]


def test_a_restart_keeps_its_model(tmp_path, started, monkeypatch):
    """bedload-dem would refuse the other one, by the names of fixes."""
    out = tmp_path / "out"
    cli.run(cli.parse(["run", "setup2_small", "--model", "rpm", "--out", str(out)]))
    (out / "checkpoint_00000100").mkdir()
    for where in (out, out / "checkpoint_00000100"):
        with pytest.raises(UserError, match="the model 'rpm', and its contacts cannot go on with 'actm'") as refused:
            cli.run(cli.parse(["run", "--restart", str(where), "--model", "actm", "--out", str(tmp_path / "new")]))
        assert f"--model actm --set start.from=state --set start.file={out / 'state.h5'}" in str(refused.value)
    assert len(started) == 1 and not (tmp_path / "new").exists()
    monkeypatch.setattr(runs, "models", lambda: ["rpm"])  # actm a scene's own, which may keep the same
    cli.run(cli.parse(["run", "--restart", str(out), "--model", "actm"]))
    assert started[-1][started[-1].index("model") + 1] == "actm"


def test_a_run_with_grains_does_not_go_on_in_a_scene_without(tmp_path, started):
    """The sentence is of --restart, which was given, not of --model, which the run remembers."""
    out = tmp_path / "out"
    cli.run(cli.parse(["run", "setup2_small", "--var", "hold=1", "--out", str(out)]))
    (out / "checkpoint_00000100").mkdir()
    with pytest.raises(UserError, match="the run has grains, but scene 'channel180' has no in.liggghts; begin"):
        cli.run(cli.parse(["run", "channel180", "--restart", str(out)]))
    assert len(started) == 1


def test_blanks_in_a_path_do_not_reach_the_script(tmp_path):
    scene = scene_in(tmp_path / "my scenes" / "bed")
    inside = job.script_path(tmp_path / "my scenes" / "out", scene.folder)
    assert inside == "../out"
    outside = job.script_path(tmp_path / "new\nline 2", scene.folder)
    assert job.readable(outside) and Path(outside).is_symlink()
    assert os.readlink(outside) == str(tmp_path / "new\nline 2")
    assert job.script_path(tmp_path / "plain", scene.folder) == str(tmp_path / "plain")
    line = job.Job(scene, None, job.Ranks(1, 1), tmp_path / "my scenes" / "out").command()
    assert line[line.index("out") + 1] == "../out"
    assert line[line.index("--out") + 1] == str(tmp_path / "my scenes" / "out")


def test_names_do_not_command_the_terminal():
    assert plain("bed \x1b[31mred\x07\n") == "bed ?[31mred??"
    assert plain("Re_τ of 5 m³") == "Re_τ of 5 m³"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGQUIT])
def test_nothing_runs_on_when_the_launcher_is_killed(tmp_path, number):
    """A job that notes its number and would sleep for a minute; SIGTERM ends it, as it does mpirun."""
    code = (
        f"import sys; sys.path.insert(0, {str(ROOT / 'postproc')!r})\n"
        "from pathlib import Path\n"
        "from bedload_launcher import job\n"
        f"job.run(['sh', '-c', 'echo $$ > pid; exec sleep 60'], Path({str(tmp_path)!r}))\n"
    )
    launcher = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.DEVNULL)
    pid = tmp_path / "pid"
    wait_for(lambda: pid.exists() and pid.read_text().strip())
    running = Path("/proc") / pid.read_text().strip()
    wait_for(lambda: b"sleep" in (running / "cmdline").read_bytes())
    launcher.send_signal(number)
    launcher.wait()
    wait_for(lambda: ended(running))


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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_all_that_a_command_has_started(tmp_path, number):
    """A shell that waits for its program keeps SIGINT for later; what stands behind & is not to hear of it at all."""
    code = "sleep 60 & echo $! > pid; mv pid ready; sleep 60; touch went_on"

    def send():
        wait_for((tmp_path / "ready").exists)
        os.kill(os.getpid(), number)

    threading.Thread(target=send, daemon=True).start()
    begin = time.monotonic()
    assert job.run(["sh", "-c", code], tmp_path) == 128 + number
    assert time.monotonic() - begin < 30.0 and not (tmp_path / "went_on").exists()
    assert ended(Path("/proc") / (tmp_path / "ready").read_text().strip())


def test_an_end_that_is_asked_for_before_mpirun_listens(tmp_path, monkeypatch):
    """mpirun dies of the signal for its programs; what the shell is told is the user's."""
    mpirun = tmp_path / "mpirun"
    mpirun.write_text("#!/bin/sh\necho $$ > here\nmv here ready\nexec sleep 60\n")
    mpirun.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)

    def send():
        while not (tmp_path / "ready").exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=send, daemon=True).start()
    assert job.run(["mpirun"], tmp_path) == 130


def bare_system(tmp_path, installed, arguments=("run",)):
    """What apt-get is called with by a copy of the launcher in a tree of its own, with stand-ins for dpkg-query,
    id and apt-get."""
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
    (house / "postproc" / "launch.py").write_text(
        "import os, sys\n"
        "known = sys.argv[1] == 'run'\n"
        "if 'BEDLOAD_ONLY_READ' in os.environ: sys.exit(10 if known else 2)\n"
        "print('handed over')\n"
    )
    text = (ROOT / "bedload").read_text()
    # The launcher puts the system's folders first; here the stand-ins come before them.
    text = text.replace('export PATH="', f'export PATH="{programs}:')
    (house / "bedload").write_text(text)
    done = subprocess.run(["bash", house / "bedload", *arguments], capture_output=True, text=True)
    assert (done.stdout == "handed over\n") == (done.returncode == 0)
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


def test_nothing_is_installed_for_a_line_that_is_not_understood(tmp_path):
    assert bare_system(tmp_path, [], ["rnu"]) == []


def test_nothing_is_asked_of_apt_when_all_is_there(tmp_path):
    assert bare_system(tmp_path, listed_packages()) == []


def test_a_study_is_a_module_with_run_and_its_first_sentence(tmp_path, monkeypatch):
    assert "accuracy" in studies.all_studies()
    assert "accuracy_scene" not in studies.all_studies()  # which has no options of its own
    both = "def add_options(p): ...\ndef run(o): ...\n"
    (tmp_path / "drag.py").write_text('"""How drag converges\nwith D/h.\n\nMore."""\n' + both)
    (tmp_path / "helper.py").write_text('"""No study."""\n')
    (tmp_path / "other.py").write_text('"""Part of a study."""\ndef run(o): ...\n')
    monkeypatch.setattr(studies, "FOLDER", tmp_path)
    assert studies.all_studies() == {"drag": "How drag converges with D/h."}
    with pytest.raises(UserError, match="no study 'darg'; the nearest is 'drag'"):
        studies.run_study("darg", [], None, None)


def test_nothing_is_built_for_a_line_that_is_not_understood(monkeypatch):
    built = []
    monkeypatch.setattr(cli, "build", lambda: built.append(True))
    for line in (["models", "--nonsense"], ["modles"]):
        with pytest.raises(UserError):
            cli.study(cli.parse(["study", *line]))
    with pytest.raises(SystemExit):
        cli.study(cli.parse(["study", "models", "--help"]))
    with pytest.raises(UserError, match="no benchmark 'fliud'; the nearest is 'fluid'"):
        cli.bench(cli.parse(["bench", "fliud"]))
    assert not built


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        (["turbulence", "FOLDER"], "FOLDER has no settings.toml, so it is no output of a run."),
        (["channel180", "--from", "FOLDER"], "FOLDER has no settings.toml, so it is no output of a run."),
        (["threshold", "--report-only", "--out", "FOLDER"], "FOLDER/bed is not there."),
        (["analysis_speed", "--smaples=2000"], "bedload study analysis_speed has no '--smaples=2000'; did you mean --"),
        (["analysis_speed", "--samp", "2000"], "has no '--samp'; did you mean --samples?"),
        (["analysis_speed", "--nonsense"], "bedload study analysis_speed has no '--nonsense'"),
        (["analysis_speed", "--samples", "0"], "--samples: is 0, but must be at least 1000"),
        (["analysis_speed", "--collisions", "0.5"], "--collisions: invalid int value: '0.5'"),
        (["models", "--cells", "0"], "--cells: is 0, but must be at least 1"),
        (["models", "--flow-throughs", "-1"], "--flow-throughs is -1, but must be above 0."),
        (["models", "--flow-throughs", "nan"], "--flow-throughs: is nan, but must be a finite number"),
        (["models", "--discard", "-1"], "--discard is -1, but must be at least 0."),
        (["models", "--densities", "inf"], "--densities: is inf, but must be a finite number"),
        (["models", "--scene", "exposed_sphere", "--densities", "2"], "no line 'variable density index VALUE'"),
        (["models", "--scene", "exposed_sphere", "--gravity", "2"], "no line 'variable gravity index VALUE'"),
        (["threshold", "--shields", "inf"], "--shields: is inf, but must be a finite number"),
        (["threshold", "--scene", "exposed_sphere"], "no line 'variable placing index NAME'"),
        (["models", "--rewrite", "FOLDER"], "FOLDER/numbers.json is of no report of this study: it has no 'runs'."),
        (["threshold", "--rewrite", "FOLDER"], "FOLDER/numbers.json is of no report of this study: it has no 'scene'."),
        (["models", "--rewrite", "FOLDER", "--cells", "6"], "--cells changes nothing in a report made anew"),
        (["threshold", "--rewrite", "FOLDER", "--report-only"], "--report-only changes nothing in a report made anew"),
    ],
)  # fmt: skip
def test_mistakes_of_a_study_get_one_sentence(line, sentence, tmp_path, started, monkeypatch, capsys):
    (tmp_path / "numbers.json").write_text("{}")
    monkeypatch.setattr(cli, "build", lambda: None)
    monkeypatch.setattr(sys, "argv", ["bedload", "study", *(w.replace("FOLDER", str(tmp_path)) for w in line)])
    assert cli.main() == 2
    said = capsys.readouterr().err
    assert sentence.replace("FOLDER", str(tmp_path)) in said and said.count("\n") == 1
    assert not started


def test_the_speed_of_the_analysis_is_measured_from_two_instants_on(capsys):
    parser = argparse.ArgumentParser()
    analysis_speed.add_options(parser)
    assert analysis_speed.run(parser.parse_args(["--samples", "1e3", "--collisions", "0"])) == 0
    assert '"samples": 1000, "collisions": 0,' in capsys.readouterr().out


def test_a_preset_keeps_proportions_and_courant_number(tmp_path):
    scene = scene_in(tmp_path / "s", "variable model index rpm\nvariable cell index 0.1\n")
    (scene.folder / "fluid.toml").write_text(
        "[grid]\ncells = [160, 90, 80]\nlength = [16.0, 9.0, 8.0]\n[time]\nstep = 0.04\n"
    )
    settings = presets.settings_of("draft", scene, ["time.end=1"])
    assert settings == [
        'accuracy.precision="single"', "spheres.forcing_loops=1", "grid.cells=[128, 72, 64]",
        "time.step=0.05", "time.end=1",
    ]  # fmt: skip
    # The script hears of the new cell, else rpm would start its grain at the wrong height.
    line = job.Job(scene, "rpm", job.Ranks(1, 1), tmp_path / "o", settings).command()
    assert line[line.index("cell") - 1 : line.index("cell") + 2] == ["-var", "cell", "0.125"]
    assert presets.settings_of("standard", scene, []) == ['accuracy.precision="double"']
    assert presets.settings_of(None, scene, ["a=1"]) == ["a=1"]
    with pytest.raises(UserError, match="no accuracy 'fin'; the nearest is 'fine'"):
        presets.settings_of("fin", scene, [])


def test_steps_that_a_script_counts_are_warned_of_where_their_length_changes(tmp_path, capsys):
    for script, warned in (("coupled_run\n", False), ("coupled_run steps 20\ncreate_atoms 1\ncoupled_run\n", True)):
        scene = scene_in(tmp_path / f"{warned}", "variable model index rpm\n" + script)
        (scene.folder / "fluid.toml").write_text(
            "[grid]\ncells = [160, 90, 80]\nlength = [16.0, 9.0, 8.0]\n[time]\nstep = 0.04\n"
        )
        presets.settings_of("standard", scene, [])
        assert capsys.readouterr().err == ""
        presets.settings_of("fine", scene, [], "rpm")
        said = capsys.readouterr().err
        assert ("in.liggghts counts fluid steps (coupled_run steps): with another time step" in said) == warned


@pytest.mark.parametrize("time", ["", '[time]\nstep = "a"\n', "[time]\nstep = true\n", "[time]\nend = 1\n"])
def test_a_preset_leaves_a_step_that_is_no_number_to_bedload_fluid(tmp_path, time):
    scene = scene_in(tmp_path / "s", None)
    grid = ["grid.cells=[160, 90, 80]", "grid.length=[16, 9, 8]"]
    (scene.folder / "fluid.toml").write_text("\n".join(grid) + "\n" + time)
    assert presets.settings_of("draft", scene, [])[-1] == "grid.cells=[128, 72, 64]"


def test_a_grid_that_no_other_matches_has_no_preset(tmp_path):
    scene = scene_in(tmp_path / "s")
    (scene.folder / "fluid.toml").write_text("[grid]\ncells = [97, 53, 31]\nlength = [97, 53, 31]\n")
    with pytest.raises(UserError, match="97 x 53 x 31 cells, which no grid near 0.8"):
        presets.settings_of("draft", scene, [])


def test_variables_of_included_scripts_may_be_set():
    scene = scenes.find_scene("setup2_small")
    given = ["density=1.3", "lubrication_settings=gapMin 0.002"]
    assert scenes.read_variables(scene, "actm_hw", given) == {
        "density": "1.3",
        "lubrication_settings": "gapMin 0.002",
    }
    # rpm has no lubrication: LIGGGHTS itself would take the variable and forget it.
    for unread in ("lubrication_settings=gapMin 0.002", "film_range=0.1", "collision_time=0.35"):
        with pytest.raises(UserError, match="no line of setup2_small's script reads .* with model rpm"):
            scenes.read_variables(scene, "rpm", [unread])
    scenes.read_variables(scene, "rpm", ["repulsion_range=0.1", "friction=0.2", "hold=1"])
    with pytest.raises(UserError, match="nearest is 'density'"):
        scenes.read_variables(scene, "rpm", ["densty=1.3"])
    with pytest.raises(UserError, match="must be NAME=VALUE"):
        scenes.read_variables(scene, "rpm", ["density"])
    with pytest.raises(UserError, match="by --model"):
        scenes.read_variables(scene, "rpm", ["model=actm"])
    with pytest.raises(UserError, match="chosen by --out"):
        scenes.read_variables(scene, "rpm", ["out=elsewhere"])
    with pytest.raises(UserError, match="scene 'channel180' has no in.liggghts, so --var density=2 says nothing."):
        scenes.read_variables(scenes.find_scene("channel180"), None, ["density=2"])


PART = {"part.liggghts": "run ${a}\n", "other.liggghts": "run 0\n"}


@pytest.mark.parametrize(
    "script",
    [
        "run ${a}", "run $a", "fix f all heat v_a", "variable c equal 2*v_a", "next b a", 'if "1 == 1" then "next a"',
        "variable b index ${a}\nrun ${b}",
        "variable k index a\nvariable c equal v_${k}",
        'print "grain # ${a}"',
        'print "grain # &\n${a}"',
        "include part.liggghts",
        'include "part.liggghts"',
        "variable p string part.liggghts\ninclude ${p}",
        "variable p index part\nvariable q string ${p}.liggghts\ninclude $q",
        "jump part.liggghts here",
        'if "1 == 1" then "include other.liggghts" &\n  else "jump part.liggghts"',
    ],
)  # fmt: skip
def test_what_liggghts_reads_may_be_set(tmp_path, script):
    scene = scene_in(tmp_path / "s", f"variable a index 1\n{script}\n")
    for name, text in PART.items():
        (scene.folder / name).write_text(text)
    assert scenes.read_variables(scene, None, ["a=3"]) == {"a": "3"}


@pytest.mark.parametrize(
    "script",
    [
        "jump ${unknown}", "jump elsewhere.liggghts", "include ${unknown}other.liggghts",
        "variable p loop 3\ninclude part${p}",
        'if "1 == 1" then "variable p index part.liggghts"\nvariable p index other.liggghts\ninclude ${p}',
    ],
)  # fmt: skip
def test_nothing_is_refused_where_a_part_is_not_known(tmp_path, script):
    """Only LIGGGHTS knows then whether that part reads the variable."""
    scene = scene_in(tmp_path / "s", f"variable range index 1\n{script}\n")
    (scene.folder / "other.liggghts").write_text("run 0\n")
    assert scenes.read_variables(scene, None, ["range=3"]) == {"range": "3"}
    with pytest.raises(UserError, match="nearest is 'range'"):
        scenes.read_variables(scene, None, ["rnge=3"])


@pytest.mark.parametrize(
    ("name", "script"),
    [
        ("gravity", "fix weight all gravity 1.1 vector 0 -1 0"),
        ("range", "run ${film_range}"), ("range", "fix f all heat v_film_range"), ("film", "run ${film_range}"),
        ("a", "run 0 # ${a}"), ("a", 'print "#" # ${a}'), ("a", 'print "next a"'), ("a", "variable v_a equal 1"),
        ("a", "jump SELF here"), ("a", "jump in.liggghts"), ("a", "jump back.liggghts"),
        ("a", "include other.liggghts"),
    ],
)  # fmt: skip
def test_what_nothing_reads_is_refused(tmp_path, name, script):
    scene = scene_in(tmp_path / "s", f"variable {name} index 1\n{script}\n")
    (scene.folder / "other.liggghts").write_text("run 0\n")
    (scene.folder / "back.liggghts").write_text("jump in.liggghts\n")
    with pytest.raises(UserError, match=f"no line of s's script reads {name}."):
        scenes.read_variables(scene, None, [f"{name}=3"])


@pytest.mark.parametrize("name", ["setup1", "setup1_small", "setup2", "setup2_small"])
def test_variables_of_the_scenes_pages_may_be_set(name):
    """Those of the collision models' table, each with the models that have it."""
    scene = scenes.find_scene(name)
    actm, rpm, hw = ["film_range", "collision_time", "enduring"], ["repulsion_range", "repulsion_time"], ["slip_time"]
    for model, own in {"actm": actm, "actm_hw": actm + hw, "rpm": rpm, "rpm_hw": rpm + hw}.items():
        given = [f"{word}=0.1" for word in (*own, "friction", "grains", "density", "gravity")]
        assert len(scenes.read_variables(scene, model, given)) == len(given)
        for other in {*actm, *rpm, *hw} - {*own}:
            if (other, scene.variables()["placing"]) != ("repulsion_range", "pocket"):  # where rpm's grains lie
                with pytest.raises(UserError, match=f"reads {other} with model {model}"):
                    scenes.read_variables(scene, model, [f"{other}=0.1"])


def test_a_checkout_that_may_only_be_read_is_not_built(tmp_path, monkeypatch):
    monkeypatch.setattr(build, "FOLDER", tmp_path)
    monkeypatch.setattr(build, "_build", lambda *_: pytest.fail("builds"))
    monkeypatch.setattr(os, "access", lambda path, _: path != tmp_path)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "bedload-fluid").touch()
    build.build(["bedload-fluid"])
    with pytest.raises(pytest.fail.Exception, match="builds"):
        build.build(["bedload-fluid", "bedload-dem"])


def test_another_processor_builds_anew(tmp_path, monkeypatch, capsys):
    """Where it lacks what the programs may use; programs for all and one that can do more stay as they are."""
    commands = []
    monkeypatch.setattr(build.subprocess, "run", lambda line, **_: commands.append(line))
    monkeypatch.setattr(build, "_ninja", lambda *_: [])
    cache, kept = tmp_path / "CMakeCache.txt", tmp_path / build.PROCESSOR

    def configure(_, *options):
        cache.write_text(f"BEDLOAD_NATIVE:BOOL={'OFF' if options else 'ON'}\n")

    monkeypatch.setattr(build, "_configure", configure)
    for sets, configured, portable, stays, noted in (
        ("avx2 fma", True, False, True, "avx2 fma"), ("avx2 fma avx512f", False, False, True, "avx2 fma"),
        ("avx2 sse2", False, False, False, "avx2 sse2"), ("sse2 avx2", True, True, True, ""),
        ("sse2", False, False, True, ""), ("fma", True, False, True, "fma"), ("avx2", True, False, False, "avx2"),
    ):  # fmt: skip
        monkeypatch.setattr(build, "instruction_sets", lambda own=sets: frozenset(own.split()))
        monkeypatch.setattr(build, "_must_configure", lambda _, anew=configured: anew)
        build.build(["bedload-fluid"], portable, folder=tmp_path)
        said = capsys.readouterr().err
        assert ("built for another processor" in said, commands != []) == (not stays, not stays), sets
        assert all(line == ["ninja", "-C", str(tmp_path), "-t", "clean"] for line in commands)
        assert kept.read_text() == noted + "\n"
        commands.clear()
    kept.write_text("avx512f fma\n")
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "bedload-fluid").touch()
    monkeypatch.setattr(os, "access", lambda path, _: path != tmp_path)
    with pytest.raises(UserError, match="may only be read and was built for another processor .with avx512f"):
        build.build(["bedload-fluid"], folder=tmp_path)


def test_only_one_command_builds_at_a_time(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(build, "FOLDER", tmp_path / "release")
    entered = threading.Event()

    def second():
        with build.one_at_a_time(build.FOLDER):
            entered.set()

    other = threading.Thread(target=second)
    with build.one_at_a_time(build.FOLDER):
        other.start()
        assert not entered.wait(0.2)
    assert entered.wait(10)
    other.join()
    assert "another command is building here" in capsys.readouterr().err


@pytest.mark.parametrize("ranks, nodes, warned", [("40:1", "1", True), ("2:3", "1", False), ("40:1", "20", False)])
def test_more_fluid_ranks_than_processors_are_warned_of(tmp_path, started, monkeypatch, capsys, ranks, nodes, warned):
    """On one machine: what several offer the launcher does not know. A LIGGGHTS rank sleeps while it waits."""
    monkeypatch.setattr(job, "processors", lambda: 2)
    monkeypatch.setattr(job, "cores", lambda: 2)
    monkeypatch.setenv("SLURM_JOB_NUM_NODES", nodes)
    cli.run(cli.parse(["run", "setup2_small", "--ranks", ranks, "--out", str(tmp_path / "out")]))
    assert len(started) == 1  # it runs all the same
    said = [line for line in capsys.readouterr().err.splitlines() if "WARNING" in line]
    assert len(said) == int(warned)
    if warned:
        assert "40 fluid ranks on 2 processors" in said[0] and "--ranks 2:1 is the most that pays here" in said[0]
