"""From a made-up output folder to numbers, pictures and report."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from bedload_post import film, kept_page, overlap, path, picture, show, states, summary, transport
from bedload_post.frames import time_ranges
from bedload_post.outputs import MissingOutput, Run
from processes import ended, wait_for
from rich.console import Console
from synthetic import wandering_story, write_run, write_samples

SHOW = Path(__file__).resolve().parents[2] / "postproc" / "show.py"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("run") / "made_up-actm", wandering_story())


def phases_of(run):
    return states.analyse(
        run.contacts(), time_ranges(run.instants()), run.sample_blocks(), run.periods,
        run.bulk_velocity, run.diameter,
    )


def values(lines):
    return {line.what: line.value for line in lines}


def test_flow_numbers_follow_from_their_definitions(folder):
    found = values(summary.flow_lines(Run(folder)))
    # f = 0.004, u_tau^2 = f H: Re_tau = u_tau H / nu, D+ = u_tau D / nu, S = u_tau^2 / ((1.25 - 1) 0.99).
    assert found["Re_tau"] == f"{0.032**0.5 * 8 / 2.6578e-3:.0f}"
    assert found["D+"] == f"{0.032**0.5 / 2.6578e-3:.1f}"
    assert found["Shields number"] == f"{0.032 / (0.25 * 0.99):.4f}"
    assert found["momentum residual"] == "3.0e-15"
    assert found["slip at markers, largest"] == "2.00e-02 u_b"
    notes = {line.what: line.note for line in summary.flow_lines(Run(folder))}
    assert all(notes[f"slip at markers, {what}"] == "second half" for what in ("rms", "largest"))


def test_a_flow_without_spheres_has_no_numbers_of_theirs(folder, tmp_path):
    alone = shutil.copytree(folder, tmp_path / "alone")
    (alone / "spheres.h5").unlink()
    header, *rows = (alone / "history.csv").read_text().splitlines()
    columns = header.split(",")
    theirs = {columns.index(name) for name in ("slip_max", "slip_rms")}
    rows = [",".join("0" if n in theirs else word for n, word in enumerate(row.split(","))) for row in rows]
    (alone / "history.csv").write_text("\n".join([header, *rows]) + "\n")
    found = values(summary.flow_lines(Run(alone)))
    assert found["Re_tau"] == values(summary.flow_lines(Run(folder)))["Re_tau"]
    assert not {"D+", "Shields number", "slip at markers, rms", "slip at markers, largest"} & set(found)


def test_grain_numbers_of_the_story(folder):
    run = Run(folder)
    found = values(summary.grain_lines(run, phases_of(run)))
    assert found["jumps"] == "3"
    assert found["jump height, highest"] == "0.600 D"
    assert found["jump height, mean"] == f"{(0.35 + 0.6 + 0.25) / 3:.3f} D"
    # 5 D of jumps and 0.32 D of creeping in 21.92 units of time; samples count alike, so within
    # one sample of the pieces' ends.
    mean = float(found["mean grain velocity"].split()[0])
    assert mean == pytest.approx(5.32 / 21.92, abs=2 * 0.5 * 0.04 / 21.92 * 6)
    total = sum(float(found[f"time {name}"].split()[0]) for name in states.NAMES)
    assert total == pytest.approx(100.0, abs=0.15)


def test_times_come_dearest_first(folder):
    rows = summary.time_rows(Run(folder))
    assert rows[0] == ("momentum predictor", 120.5, pytest.approx(120.5 / 300.5))
    assert [row[1] for row in rows] == sorted((row[1] for row in rows), reverse=True)


def test_times_of_a_restarted_run_are_of_all_its_parts(folder, tmp_path, capsys):
    """The table of the last part alone would say what the earlier ones did not take. 300.5 s and 99.5 s are 400."""
    parts = shutil.copytree(folder, tmp_path / "parts")
    (parts / "timing.part1.csv").write_text(
        "part,seconds_mean_over_ranks,seconds_max,share,calls\npressure,59.5,60.0,0.60,9\nsettling,40.0,40.0,0.40,9\n"
    )
    (parts / "log.part1.liggghts").touch()
    rows = {part: (seconds, share) for part, seconds, share in summary.time_rows(Run(parts))}
    assert rows["pressure"] == pytest.approx((149.5, 149.5 / 400.0))
    assert rows["settling"] == pytest.approx((40.0, 0.1))
    assert list(rows)[:2] == ["pressure", "momentum predictor"]
    show.show(parts, pictures=False)
    said = capsys.readouterr().out
    assert "The run was killed" not in said and re.search("pressure +149.5 +37.4 %", said)
    (parts / "log.part2.liggghts").touch()  # of a part that was killed
    show.show(parts, pictures=False)
    told = "The run was killed and went on: what it took until then is not in this table."
    assert told in capsys.readouterr().out and told in (parts / "report.html").read_text()


def test_periods_know_walls(folder):
    assert Run(folder).periods.tolist() == [16.0, np.inf, 8.0]


def test_blocks_are_bounded_and_complete(folder):
    run = Run(folder)
    whole = run.samples_of(1)
    blocks = list(run.sample_blocks(rows=100))
    assert max(map(len, blocks)) == 100
    assert np.concatenate([b.time for b in blocks]).tolist() == whole.time.tolist()


def test_state_along_the_path(folder):
    run = Run(folder)
    phases = phases_of(run)
    found = path.state_at(np.array([3.0, 6.4, 8.0, 20.0]), phases, 1)
    assert found.tolist() == [states.RESTING, states.CREEPING, states.JUMPING, states.RESTING]


def test_the_path_s_legend_counts_what_is_drawn(folder):
    """By time, as the screen does, and not by samples; of a part only what lies in it."""
    run = Run(folder)
    phases, time = phases_of(run), run.samples_of(1).time
    assert path.shares_of(phases, 1, time[0], time[-1]) == pytest.approx(phases.shares(), abs=1e-12)
    assert path.shares_of(phases, 1, 2.0, 3.0).tolist() == [1.0, 0.0, 0.0]
    assert path.shares_of(phases, 1, 7.5, 8.5)[states.JUMPING] == pytest.approx(1.0, abs=0.05)


def test_captions_say_what_is_so(folder, tmp_path):
    wide = np.inf
    assert "cuts the fastest grain" in picture.how_turned(np.array([16.0, wide, 8.0]))
    assert picture.how_turned(np.array([16.0, wide, wide])) == " (periodic box turned)"
    assert picture.how_turned(np.full(3, wide)) == ""
    scaled = tmp_path / "scaled"
    scaled.mkdir()
    (scaled / "settings.toml").write_text("reference.velocity = 3.0\nreference.diameter = 2.0\n")
    assert film.clock(Run(scaled), 5.0) == "t = 7.5 D/u_b"


def test_colours_begin_at_rest_unless_much_of_the_flow_goes_backwards():
    stream, eddy = np.linspace(0.0, 1.0, 1001), np.full(20, -0.1)
    assert picture.shown_range(np.concatenate([stream, eddy])) == pytest.approx((0.0, 1.0), abs=0.01)
    assert picture.shown_range(np.linspace(-2.0, 2.0, 1001)) == pytest.approx((-2.0, 2.0), abs=0.02)


def test_a_grain_that_still_touches_does_not_jump(folder, tmp_path):
    """Its contact, which is under way when the run ends, stands in a table of its own and counts as no collision."""
    run = tmp_path / "rolls"
    shutil.copytree(folder, run)
    table = (run / "collisions.csv").read_text().splitlines()
    (run / "collisions.csv").write_text(table[0] + "\n")
    assert phases_of(Run(run)).shares()[states.JUMPING] > 0.5
    (run / "collisions_open.csv").write_text("\n".join([table[0], "1,-1,-1.0,1e9,0,0,0,0,0,0,0,0"]) + "\n")
    assert phases_of(Run(run)).shares()[states.JUMPING] == 0.0
    assert len(Run(run).collisions()) == 0 and len(Run(run).contacts()) == 1


@pytest.mark.parametrize("until", [-1e-9, 0.0, 1e-9])
def test_a_contact_under_way_ends_no_phase(folder, tmp_path, until):
    """Whether the table's end or the last sample is later is a matter of round-off."""
    run = tmp_path / "rolls"
    shutil.copytree(folder, run)
    header = (run / "collisions.csv").read_text().splitlines()[0]
    (run / "collisions.csv").write_text(header + "\n")
    last = max(time[-1] for time, _ in Run(run).instants())
    row = f"1,-1,{0.5 * last!r},{last + until!r},0,0,0,0,0,0,0,0"
    (run / "collisions_open.csv").write_text(f"{header}\n{row}\n")
    phases = phases_of(Run(run))
    assert phases.end.max() == last and not phases.complete[phases.end == last].any()


def test_a_run_without_collisions_or_grains(folder, tmp_path):
    bare = tmp_path / "bare"
    shutil.copytree(folder, bare)
    (bare / "collisions.csv").write_text("tag_i,tag_j,time_start,time_end\n")
    assert len(Run(bare).collisions()) == 0
    (bare / "collisions.csv").unlink()
    (bare / "spheres.h5").unlink()
    done = subprocess.run(
        [sys.executable, "-I", "-B", SHOW, bare, "--no-pictures"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "Re_tau" in done.stdout
    assert "mobile grains" not in done.stdout


def test_without_a_table_of_collisions_no_states_are_told(folder, tmp_path, monkeypatch):
    """A script without fix collision/table: neither "0 collisions" nor "creeping 100 %" is a fact."""
    bare = shutil.copytree(folder, tmp_path / "bare")
    (bare / "collisions.csv").unlink()
    with pytest.raises(MissingOutput, match=f"{bare} has no collisions.csv, without which no state"):
        transport.measure(Run(bare))
    found = values(summary.grain_lines(Run(bare), None))
    assert found["collisions, states"] == "unknown"
    assert set(found) == {"mobile grains", "mean grain velocity", "collisions, states"}
    assert summary.free_grain_lines(Run(bare))[-1].note == "there is no collisions.csv"
    monkeypatch.setattr(show, "_render", lambda *_: None)
    for run, drawn in ((bare, False), (folder, True)):
        (run / "path.png").unlink(missing_ok=True)
        show.show(run)
        assert (run / "path.png").is_file() == drawn


def test_a_run_that_has_not_come_to_an_end_tells_no_states(folder, tmp_path, monkeypatch, capsys):
    """Contacts under way at a crash stand nowhere: a grain that rests would jump."""
    cut = shutil.copytree(folder, tmp_path / "cut")
    (cut / "collisions_open.csv").unlink()
    sentence = f"{cut} has no collisions_open.csv, so the run has not come to an end"
    for asked in (lambda: Run(cut).contacts(), lambda: transport.measure(Run(cut), 1.0)):
        with pytest.raises(MissingOutput, match=f"{sentence} .*--restart goes on"):
            asked()
    monkeypatch.setattr(show, "_render", lambda *_: None)
    (cut / "path.png").unlink(missing_ok=True)
    show.show(cut)
    said = " ".join(capsys.readouterr().out.split())
    assert said.count(sentence) == 1 and "mean grain velocity" in said and "Re_tau" in said
    assert "states unknown the run has not come to an end" in said
    assert "time jumping" not in said and not (cut / "path.png").exists()
    assert "the run has not come to an end" in (cut / "report.html").read_text()


def test_a_run_that_was_cut_off_says_why_it_shows_no_grains(folder, tmp_path):
    cut = tmp_path / "cut"
    shutil.copytree(folder, cut)
    (cut / "spheres.h5").rename(cut / "spheres.h5.part")
    with pytest.raises(MissingOutput, match="spheres.h5.part is of a run that goes on or was cut off"):
        transport.measure(Run(cut))
    done = subprocess.run(
        [sys.executable, "-I", "-B", SHOW, cut, "--no-pictures"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "cut off" in done.stdout and "Re_tau" in done.stdout


def test_what_is_missing_is_named(tmp_path):
    with pytest.raises(MissingOutput, match="settings.toml"):
        Run(tmp_path)
    (tmp_path / "settings.toml").write_text("reference.velocity = 1.0\n")
    with pytest.raises(MissingOutput, match="reference.height"):
        Run(tmp_path).depth  # noqa: B018


def test_output_broken_off_is_read_as_far_as_it_goes(folder, tmp_path):
    """A full disk or a killed machine ends the last row anywhere."""
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    for name in ("collisions.csv", "history.csv"):
        text = (broken / name).read_text()
        last = text.rstrip("\n").rpartition("\n")[2]
        for end in (0, 3, 12, len(last) - 2, len(last)):
            (broken / name).write_text(text + last[:end])
            assert len(Run(broken).collisions()) == len(Run(folder).collisions())
            assert values(summary.flow_lines(Run(broken))) == values(summary.flow_lines(Run(folder)))


@pytest.mark.parametrize("name", ["spheres.h5", "fields.h5", "settings.toml"])
def test_a_file_that_cannot_be_read_is_named(folder, tmp_path, name):
    broken = tmp_path / "broken"
    shutil.copytree(folder, broken)
    file = broken / name
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2 + 3])
    with pytest.raises(MissingOutput, match=f"{name} (cannot be read|is not whole)"):
        Run(broken).fixed_spheres()
        Run(broken).last_snapshot()
        Run(broken).depth  # noqa: B018
    if name == "spheres.h5":
        with pytest.raises(MissingOutput, match=name):
            list(Run(broken).sample_blocks())


def reddish(image):
    """Share of pixels in the colours of mobile grains."""
    red, green, blue = (image[..., i] for i in range(3))
    return np.mean((red > 0.55) & (blue < 0.45) & (red > green + 0.15))


def test_everything_is_shown(folder):
    done = subprocess.run(
        [sys.executable, "-I", "-B", SHOW, folder], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert "No picture" not in done.stdout
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 2
    assert "reference.sphere_density = 1.25" in page
    scene = matplotlib.image.imread(folder / "picture.png")
    # The velocity planes (blue to green), the bed (grey) and the white around them all have their
    # share; the grain is small and there. The bar of grain speeds is left out below 0.85 of the
    # height.
    upper = scene[: int(0.85 * len(scene))]
    assert 0.2 < np.mean(upper.min(axis=-1) > 0.99) < 0.8
    assert np.mean((upper[..., 2] > upper[..., 0] + 0.15)) > 0.03
    assert 2e-4 < reddish(upper) < 2e-2
    track = matplotlib.image.imread(folder / "path.png")
    assert track.shape[1] > 1200
    assert track.std() > 0.05


def test_pictures_of_before_are_not_shown_as_new(folder, tmp_path, monkeypatch, capsys):
    """A run goes on after it was shown, and then no picture is drawn, or none can be."""
    run = shutil.copytree(folder, tmp_path / "run")
    for name in show.PICTURES:
        (run / name).write_bytes(b"of before")
        os.utime(run / name, (1e9, 1e9))

    def shown(pictures):
        show.show(run, pictures)
        return (run / "report.html").read_text().count("data:image/png;base64,"), capsys.readouterr().out

    os.utime(run / "history.csv", (2e9, 2e9))
    count, said = shown(pictures=False)
    assert count == 0 and ".png" not in said and (run / "picture.png").read_bytes() == b"of before"
    os.utime(run / "picture.png", (2e9, 2e9))  # the run has not gone on since
    count, said = shown(pictures=False)
    assert count == 1 and "picture.png" in said and "path.png" not in said
    monkeypatch.setattr(show, "_render", lambda *_: None)
    count, said = shown(pictures=True)
    assert count == 1 and "path.png" in said and "picture.png" not in said
    assert {name for name in show.PICTURES if (run / name).exists()} == {"path.png"}
    assert (run / "path.png").read_bytes() != b"of before"


@pytest.fixture
def slow_screen(tmp_path, monkeypatch):
    """In xvfb-run's place a shell that never ends; the file with the number of what it has started."""
    program = tmp_path / "bin" / "xvfb-run"
    program.parent.mkdir()
    pid = tmp_path / "pid"
    program.write_text(f"#!/bin/sh\nsleep 60 &\necho $! > {pid}.part\nmv {pid}.part {pid}\nsleep 60\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)
    return pid


def test_a_picture_that_takes_too_long_leaves_nothing_behind(folder, slow_screen, monkeypatch, capsys):
    monkeypatch.setattr(show, "LONGEST", 3.0)
    begin = time.monotonic()
    show._render(Console(width=1000), Run(folder))
    assert "timed out after 3.0 seconds" in capsys.readouterr().out
    wait_for(lambda: ended(Path("/proc") / slow_screen.read_text().strip()))
    assert time.monotonic() - begin < 30.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_show_that_is_ended_ends_its_picture(folder, tmp_path, slow_screen, number):
    run = shutil.copytree(folder, tmp_path / "run")
    line = ["/usr/bin/python3", "-I", "-B", SHOW, run]
    shown = subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(slow_screen.exists)
    shown.send_signal(number)
    assert shown.communicate(timeout=30)[1] == "" and shown.returncode == 128 + number
    wait_for(lambda: ended(Path("/proc") / slow_screen.read_text().strip()))


def test_a_full_disk_is_one_sentence(folder, tmp_path):
    full = shutil.copytree(folder, tmp_path / "full")
    (full / "report.html").unlink(missing_ok=True)
    (full / "report.html").symlink_to("/dev/full")
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", SHOW, full, "--no-pictures"], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (1, f"{full / 'report.html'}: No space left on device\n")


@pytest.mark.parametrize("columns", ["20", "60", "200"])
def test_a_narrow_terminal_loses_no_digit(folder, columns):
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", SHOW, folder, "--no-pictures"], capture_output=True, text=True,
        env=os.environ | {"COLUMNS": columns},
    )  # fmt: skip
    assert done.returncode == 0
    assert re.search(r"^slip at markers, largest +2.00e-02 u_b", done.stdout, re.MULTILINE)
    assert re.search(r"^immersed boundary +60.0 +20.0 %", done.stdout, re.MULTILINE)


def test_a_reader_that_goes_ends_it_without_a_word(folder):
    """As `| head` does, here before the first line; status 141 is that of SIGPIPE."""
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", SHOW, folder, "--no-pictures"], stdout=write, stderr=subprocess.PIPE, text=True
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_film_of_no_grains_leaves_an_earlier_one_as_it_was(folder, tmp_path):
    bare = shutil.copytree(folder, tmp_path / "bare")
    write_samples(bare, {name: rows[:0] for name, rows in wandering_story().arrays(1, 16.0).items()})
    (tmp_path / "film.mp4").write_text("earlier")
    for run, since in ((bare, 0.0), (folder, 1e3)):
        with pytest.raises(MissingOutput, match=f"{run} has no samples of mobile spheres after t = {since:g}."):
            film.render(Run(run), tmp_path / "film.mp4", since)
        assert (tmp_path / "film.mp4").read_text() == "earlier"


@pytest.mark.parametrize("frames", ["0", "-2"])
def test_a_film_has_frames(folder, frames):
    done = subprocess.run(
        ["/usr/bin/python3", "-I", "-B", SHOW, folder, "--film", "0.0", "--frames", frames],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 2
    assert f"--frames is {frames}, but must be at least 1" in done.stderr


def test_a_folder_of_kept_results_becomes_a_page(tmp_path):
    (tmp_path / "README.md").write_text("# Drag <of> spheres\n")
    (tmp_path / "drag.csv").write_text("Re,C_d\n10,4.3\n")
    assert kept_page.is_kept(tmp_path)
    page = kept_page.write(tmp_path).read_text()
    assert "# Drag &lt;of&gt; spheres" in page
    assert '<td class="">4.3</td>' in page
    (tmp_path / "drag.csv").write_text("Re,C_d\n10,4.4\n")
    assert '<td class="">4.4</td>' in kept_page.write(tmp_path).read_text()
    # What a study wrote itself stays.
    (tmp_path / "report.html").write_text("with captions")
    assert kept_page.write(tmp_path).read_text() == "with captions"
    (tmp_path / "drag.csv").unlink()
    assert not kept_page.is_kept(tmp_path)  # text alone is no result
    (tmp_path / "drag.csv").touch()
    (tmp_path / "settings.toml").write_text("")
    assert not kept_page.is_kept(tmp_path)  # a run


def test_a_folder_of_any_tables_is_no_page(tmp_path):
    """/tmp, say, into which a page would be written."""
    (tmp_path / "drag.csv").write_text("Re,C_d\n10,4.3\n")
    (tmp_path / "drag.png").touch()
    done = subprocess.run(["/usr/bin/python3", "-I", "-B", SHOW, tmp_path], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"{tmp_path} has no settings.toml, so it is no output of a run.\n"
    assert not (tmp_path / "report.html").exists()
    (tmp_path / "numbers.json").write_text("{}")
    assert kept_page.is_kept(tmp_path)


def test_all_kept_results_have_a_page():
    kept = {file.parent for ending in ("csv", "png") for file in kept_page.REPORTS.rglob(f"*.{ending}")}
    assert len(kept) > 10 and all(map(kept_page.is_kept, kept))


def test_a_scene_is_no_output(tmp_path):
    """Its README is not taken for a page of results."""
    (tmp_path / "README.md").write_text("A scene.")
    (tmp_path / "fluid.toml").touch()
    assert not kept_page.is_kept(tmp_path)
    with pytest.raises(MissingOutput, match="is a scene; the output of its runs is another folder"):
        Run(tmp_path)


def test_a_run_without_its_settings_is_no_page(tmp_path):
    (tmp_path / "history.csv").write_text("step,time\n1,0.1\n")
    (tmp_path / "launch.json").write_text("{}")
    assert not kept_page.is_kept(tmp_path)


def test_tables_that_were_cut_off(tmp_path):
    """One that is empty, as on a full disk, is said; a last row without its end is left out."""
    (tmp_path / "settings.toml").touch()
    (tmp_path / "history.csv").touch()
    with pytest.raises(MissingOutput, match=r"history.csv is empty\."):
        Run(tmp_path).history()
    rows = "program,part,start,end\nbedload-dem,grain motion,0.0,0.5\nbedload-fluid,pres"
    (tmp_path / "timeline.csv").write_text(rows)
    assert overlap.read(tmp_path) == [("bedload-dem", "grain motion", 0.0, 0.5)]
