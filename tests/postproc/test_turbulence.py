"""Two-point correlations of fields whose correlation is known."""

import argparse
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from bedload_launcher.errors import UserError
from bedload_post.outputs import Run
from bedload_studies import models, turbulence
from bedload_studies.turbulence import correlation
from synthetic import wandering_story, write_run


def test_a_wave_correlates_as_a_cosine():
    x = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    field = 3.0 + np.sin(2 * x)[None, :] * np.ones((16, 1))
    # <sin(2x) sin(2x + 2r)> = cos(2r)/2; along the other axis the field does not change.
    assert correlation(field, 1) == pytest.approx(0.5 * np.cos(2 * x[:25]), abs=1e-12)
    assert correlation(field, 0) == pytest.approx(0.5, abs=1e-12)


def test_noise_correlates_with_itself_alone():
    field = np.random.default_rng(5).normal(size=(200, 300))
    found = correlation(field, 1)
    # Variance 1; at any distance the mean of 6e4 products: 1/sqrt(6e4) = 0.004, five times that.
    assert found[0] == pytest.approx(1.0, abs=0.03)
    assert np.abs(found[1:]).max() < 0.021


def test_snapshots_count_by_their_variance(monkeypatch):
    """R is the mean covariance over the mean variance: of a wave and of one three times as high and half as long."""
    x = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    waves = [np.sin(x)[None, :] * np.ones((16, 1)), 3.0 * np.sin(2 * x)[None, :] * np.ones((16, 1))]
    monkeypatch.setattr(turbulence, "planes", lambda run, heights, since: (wave[None] for wave in waves))
    along_x, along_z, count = turbulence.correlations(SimpleNamespace(periods=np.ones(3)), [1.0], 0.0)
    assert count == 2
    assert along_x == pytest.approx(((np.cos(x[:25]) + 9.0 * np.cos(2 * x[:25])) / 10.0)[None], abs=1e-12)
    assert along_z == pytest.approx(np.ones((1, 9)))


def test_heights_outside_the_box_are_refused(tmp_path):
    write_run(tmp_path, wandering_story())
    for height in ("-1", "99"):
        parser = argparse.ArgumentParser()
        turbulence.add_options(parser)
        with pytest.raises(UserError, match=f"--heights has {height}, but the box"):
            turbulence.run(parser.parse_args([str(tmp_path), "--heights", height]))


def study(*line):
    parser = argparse.ArgumentParser()
    turbulence.add_options(parser)
    return turbulence.run(parser.parse_args(list(map(str, line))))


@pytest.mark.filterwarnings("error")
def test_a_laminar_flow_has_no_correlations(tmp_path, capsys):
    """One line for the heights without fluctuations; those of single precision are none."""
    folder = write_run(tmp_path, wandering_story())
    noise = np.random.default_rng(5).normal(size=(40, 45, 80))
    for moving in (False, True):
        with h5py.File(folder / "fields.h5", "a") as file:
            del file["step_00002000/u"]
            upper = moving * (np.arange(45) > 22)[:, None]
            file["step_00002000/u"] = (1.0 + 1e-7 * noise + upper * noise).astype(np.float32)
        assert study(folder, "--heights", "2", "3", "7", "--figure", tmp_path / "r.png") == 0
        said = capsys.readouterr().out
        assert "nan" not in said and ("height / D" in said) == moving
        assert ("at y = 2, 3: the flow is laminar\n" if moving else "at y = 2, 3, 7: the flow is laminar, so") in said
        assert (tmp_path / "r.png").is_file() == moving


def test_a_figure_s_name_is_checked_before_the_work(tmp_path, monkeypatch):
    folder = write_run(tmp_path, wandering_story())
    monkeypatch.setattr(turbulence, "correlations", None)
    with pytest.raises(UserError, match="no ending of --figure .*r.pgn 'pgn'; the nearest is 'png'"):
        study(folder, "--figure", tmp_path / "r.pgn")
    with pytest.raises(UserError, match="but there is no folder .*/nowhere"):
        study(folder, "--figure", tmp_path / "nowhere" / "r.png")


def odd_box(folder):
    """15 cells along z with a wave of two lengths in 8, and 16 along x; u is all there is to correlate."""
    write_run(folder, wandering_story(), cells=(16, 9, 15))
    z = (np.arange(15) + 0.5) / 15
    with h5py.File(folder / "fields.h5", "a") as file:
        del file["step_00002000/u"]
        file["step_00002000/u"] = np.cos(4 * np.pi * z)[:, None, None] * np.ones((15, 9, 16))
    return folder


def walls_along(folder, axis):
    text = (folder / "settings.toml").read_text()
    old = f'boundary.{axis} = ["periodic", "periodic"]'
    assert old in text
    (folder / "settings.toml").write_text(text.replace(old, f'boundary.{axis} = ["no_slip", "no_slip"]'))


def test_separations_are_whole_cells(tmp_path, capsys):
    """cos(4 pi z/8) is least at 2 D, which is no whole number of the 15 cells: 4 of them, 2.13 D, are next; of an odd
    number the half of the box is none."""
    run = Run(odd_box(tmp_path / "run"))
    apart = turbulence.separations(run, 2)
    assert apart == pytest.approx(np.arange(8) * 8.0 / 15)
    _, along_z, _ = turbulence.correlations(run, [5.0], 0.0)
    assert along_z[0] == pytest.approx(np.cos(4 * np.pi * apart / 8.0), abs=1e-6)
    assert turbulence.separations(run, 0) == pytest.approx(np.arange(9))
    assert study(run.folder, "--heights", "5", "--figure", tmp_path / "r.png") == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["5.00", "1.000", "0.914", "-0.978", "at", "2.1"]


def test_the_figure_holds_all_correlations(tmp_path, monkeypatch):
    """A wave's goes down to -1; -0.6 suffices for others."""
    run, figures = Run(odd_box(tmp_path / "run")), []
    monkeypatch.setattr(turbulence.plt, "close", figures.append)
    along_x, along_z, _ = turbulence.correlations(run, [5.0], 0.0)
    for factor in (1.0, 0.5):
        turbulence.draw(run, [5.0], along_x, factor * along_z, tmp_path / "r.png")
    assert along_z.min() < -0.97
    drawn = [figure for figure in figures if not isinstance(figure, str)]  # pyplot itself closes "all" of no figures
    assert [figure.axes[0].get_ylim()[0] for figure in drawn] == pytest.approx([along_z.min(), -0.6])


@pytest.mark.filterwarnings("error")
def test_no_correlations_where_a_box_is_not_periodic(tmp_path, capsys):
    run = Run(odd_box(tmp_path / "run"))
    walls_along(run.folder, "x")
    along_x, along_z, _ = turbulence.correlations(Run(run.folder), [5.0], 0.0)
    assert np.isnan(along_x).all() and np.isfinite(along_z).all()
    assert study(run.folder, "--heights", "5", "--figure", tmp_path / "r.png") == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["5.00", "-", "0.914", "-0.978", "at", "2.1"]
    assert (tmp_path / "r.png").is_file()
    left = models.keep_correlations(Run(run.folder), 0.0, tmp_path)["correlation of u left at half the box"]
    assert left.startswith("along z 0.91, 0.91, 0.91 at y")
    walls_along(run.folder, "z")
    with pytest.raises(UserError, match="is periodic along neither x nor z"):
        study(run.folder)
    assert models.keep_correlations(Run(run.folder), 0.0, tmp_path) == {}


def test_flow_between_walls_that_slide_has_correlations(tmp_path, capsys):
    """Nothing else drives it, so that no friction velocity follows from a driving force."""
    folder = odd_box(tmp_path / "run")
    history = (folder / "history.csv").read_text().splitlines()
    place = history[0].split(",").index("driving")
    rows = [",".join("0" if n == place else word for n, word in enumerate(row.split(","))) for row in history[1:]]
    (folder / "history.csv").write_text("\n".join([history[0], *rows]) + "\n")
    assert study(folder, "--heights", "5") == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("u_tau            unknown: history.csv of") and "no driving force" in said[0]
    assert said[-1].split()[:2] == ["5.00", "1.000"]


@pytest.mark.filterwarnings("error")
def test_no_correlations_across_a_duct(tmp_path, capsys):
    run = Run(odd_box(tmp_path / "run"))
    walls_along(run.folder, "z")
    assert study(run.folder, "--heights", "5", "--figure", tmp_path / "r.png") == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["5.00", "1.000", "-", "-"]
