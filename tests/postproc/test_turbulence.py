"""Two-point correlations of fields whose correlation is known."""

import argparse

import h5py
import numpy as np
import pytest
from bedload_launcher.errors import UserError
from bedload_studies import turbulence
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
    along_x, along_z, count = turbulence.correlations(None, [1.0], 0.0)
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
