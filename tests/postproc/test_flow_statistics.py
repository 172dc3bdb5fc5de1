"""Flow statistics: pieces of one flow put together, a channel's halves in wall units, the comparison."""

import argparse
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from bedload_launcher import job
from bedload_launcher.errors import UserError
from bedload_post import flow_statistics, profile_figures
from bedload_post.outputs import MissingOutput, Run
from bedload_studies import channel180

NU, U_TAU, PLANES = 0.01, 0.5, 40
CENTRES = ("y", "fluid", "u", "w", "p", "uu", "ww", "uw", "pp", "acceleration", "spheres")


def write(folder, samples, begin, shift=0.0):
    """A channel of height 2: u is a parabola plus `shift`, uu = 1 + y, uv antisymmetric."""
    folder.mkdir()
    (folder / "settings.toml").write_text(
        f"fluid.kinematic_viscosity = {NU}\nfluid.density = 2.0\nreference.velocity = 1.0\n"
        "reference.height = 1.0\nreference.diameter = 1.0\n"
    )
    face = np.linspace(0.0, 2.0, PLANES + 1)
    y = 0.5 * (face[1:] + face[:-1])
    data = {name: np.zeros(PLANES if name in CENTRES else PLANES + 1) for name in
            (*CENTRES, "y_face", "fluid_face", "v", "vv", "uv", "vw", "viscous", "turbulent")}  # fmt: skip
    data |= {"y": y, "y_face": face, "u": y * (2 - y) + shift, "uu": 1.0 + y * (2 - y)}
    data |= {"uv": -0.1 * (1 - face), "vv": 0.04 + 0 * face, "ww": 0.09 + 0 * y}
    data |= {"fluid": 1 + 0 * y, "turbulent": 0.1 * 2 * (1 - face)}
    data["viscous"] = 2 * U_TAU**2 * (1 - face) - data["turbulent"]
    with h5py.File(folder / "statistics.h5", "w") as file:
        file.attrs.update(
            samples=samples, begin=begin + 1, end=begin + samples, driving=0.5, u_tau=U_TAU,
            wall_stress=[0.5, 0.5], re_tau=U_TAU / NU, stress_defect=0.0,
        )  # fmt: skip
        for name, values in data.items():
            file[f"profiles/{name}"] = values
        group = file.create_group("spectra")
        group.attrs["wavenumber_step"] = [0.5, 2.0]
        at = group.create_group("height_0")
        at.attrs["height"] = 0.3
        for q in "uvw":
            at[f"{q}_along_x"] = np.array([0.0, 3.0, 1.0]) + shift
            at[f"{q}_along_z"] = np.array([0.0, 2.0])
    return folder


def test_pieces_become_one_flow(tmp_path):
    folders = [write(tmp_path / "a", 10, 0.0), write(tmp_path / "b", 30, 10.0, shift=0.4)]  # samples every 1
    s = flow_statistics.read_all(folders)
    assert (s.samples, s.begin, s.end) == (40, 1.0, 40.0)
    np.testing.assert_allclose(s["u"], s["y"] * (2 - s["y"]) + 0.3)
    # The means differ by 0.4, with weights 1/4 and 3/4: 3/16 0.4^2 more variance.
    np.testing.assert_allclose(s["uu"], 1 + s["y"] * (2 - s["y"]) + 3 / 16 * 0.16)
    np.testing.assert_allclose(s["uv"], -0.1 * (1 - s["y_face"]), atol=1e-15)
    np.testing.assert_allclose(s.spectra[0].along["u_x"], [3.3, 1.3])
    np.testing.assert_allclose(s.spectra[0].k["x"], [0.5, 1.0])
    assert s.stress_defect < 1e-12


def test_pieces_count_by_their_time(tmp_path):
    """41 samples 0.25 apart stand for 10.25, 3 samples 10 apart for 30, one alone for as long as the others on
    average."""
    one = flow_statistics.read(Run(write(tmp_path / "a", 1, 0.0)))
    other = flow_statistics.read(Run(write(tmp_path / "b", 1, 0.0, shift=0.4)))
    one, other = replace(one, samples=41, begin=0.0, end=10.0), replace(other, samples=3, begin=20.0, end=40.0)
    found = flow_statistics.combine([one, other])
    np.testing.assert_allclose(found["u"], one["u"] + 0.4 * 30 / 40.25)
    assert found.samples == 44
    short = replace(other, samples=1, end=20.0)
    np.testing.assert_allclose(flow_statistics.combine([one, short])["u"], one["u"] + 0.4 / 42)
    np.testing.assert_allclose(flow_statistics.combine([short, replace(one, samples=1, end=0.0)])["u"], one["u"] + 0.2)


def test_pieces_with_spheres_have_no_straight_line_to_be_off(tmp_path):
    one = flow_statistics.read(Run(write(tmp_path / "a", 10, 0.0)))
    assert flow_statistics.combine([one, one]).stress_defect < 1e-12
    assert flow_statistics.combine([one, replace(one, stress_defect=None)]).stress_defect is None


def test_the_channel_s_comparison_takes_no_other_flow(tmp_path):
    folder = write(tmp_path / "a", 10, 0.0)
    with h5py.File(folder / "statistics.h5", "a") as file:
        del file.attrs["stress_defect"]
    parser = argparse.ArgumentParser()
    channel180.add_options(parser)
    with pytest.raises(UserError, match=f"{folder} is of no plain channel"):
        channel180.run(parser.parse_args(["--from", str(folder), str(folder), "--report", str(tmp_path / "report")]))


def test_halves_are_averaged_in_wall_units(tmp_path):
    p = flow_statistics.wall_profiles(flow_statistics.read(Run(write(tmp_path / "a", 10, 0.0))))
    assert p.reynolds == pytest.approx(50.0)
    assert len(p.y) == PLANES // 2
    y = p.y * NU / U_TAU
    np.testing.assert_allclose(p.u, y * (2 - y) / U_TAU)
    np.testing.assert_allclose(p.rms["w"], 0.3 / U_TAU)
    np.testing.assert_allclose(p.rms["v"], 0.2 / U_TAU)
    np.testing.assert_allclose(p.uv, -0.1 * (1 - y) / U_TAU**2)
    np.testing.assert_allclose(p.stress, 1 - p.y_face * NU / U_TAU, atol=1e-12)


def test_a_run_without_statistics_says_so(tmp_path):
    folder = write(tmp_path / "a", 1, 0.0)
    (folder / "statistics.h5").unlink()
    with pytest.raises(MissingOutput, match="statistics.every"):
        flow_statistics.read(Run(folder))


def test_the_comparison_knows_the_reference_and_a_difference(tmp_path):
    s = flow_statistics.read(Run(write(tmp_path / "a", 10, 0.0)))
    numbers, p = channel180.compare(s)
    # Published: u' 2.66 at y+ 14 to 15, v' 0.85, w' 1.09, -uv 0.73.
    wanted = {"u": 2.66, "v": 0.85, "w": 1.09, "uv": 0.73}
    for name, value in wanted.items():
        assert numbers["peaks"][name]["reference"] == pytest.approx(value, abs=0.006)
    assert 14 < numbers["peaks"]["u"]["reference_at"] < 15
    assert not numbers["holds"]["mean within 2 %"]
    assert numbers["holds"]["total stress a straight line"]
    mean, rms = (channel180.columns(channel180.REFERENCE / name)
                 for name in ("mkm180_mean.csv", "channel180_rms.csv"))  # fmt: skip
    assert channel180.largest_difference(
        mean["yplus"], 1.03 * mean["Uplus"], mean["yplus"], mean["Uplus"], 1, 170
    ) == pytest.approx(0.03)
    profile_figures.draw_against(p, mean, rms, s, tmp_path / "against.png")
    profile_figures.draw(s, tmp_path / "profiles.png")
    assert (tmp_path / "against.png").stat().st_size > 10_000


def test_stress_less_what_planes_speed_up_by_is_a_straight_line(tmp_path):
    """rho d<u>/dt = f + d tau/dy: a plane that speeds up bends the stress upwards."""
    s = flow_statistics.read(Run(write(tmp_path / "a", 10, 0.0)))
    y, face = s["y"], s["y_face"]
    bent = s["viscous"] + 0.5 * (face**2 - 2 * face)  # int (y - 1) dy from the floor
    s = replace(s, profiles=s.profiles | {"acceleration": y - 1.0, "viscous": bent})
    assert channel180.steady_defect(s) == pytest.approx(0.0, abs=1e-9)


def ended(line, _):
    """Leaves in the folder of an mpirun line what such a run does that has reached its end."""
    said = dict(word.split("=", 1) for before, word in zip(line, line[1:], strict=False) if before == "--set")
    out = Path(line[line.index("--out") + 1])
    (out / "settings.toml").write_text("".join(f"{key} = {value}\n" for key, value in said.items()))
    (out / "history.csv").write_text(f"step,time,dt\n1,{said['time.end']},0.02\n")
    (out / "timing.csv").write_text("part,seconds_mean_over_ranks\n")
    (out / "state.h5").touch()
    (out / "checkpoint_00000001").mkdir(exist_ok=True)
    return 0


def test_the_study_of_the_channel_may_be_given_again(tmp_path, monkeypatch):
    """What is done is left alone, what is not over goes on, other settings are refused."""
    lines = []
    monkeypatch.setattr(job, "run", lambda line, folder: lines.append(line) or ended(line, folder))

    def study(*words):
        lines.clear()
        parser = argparse.ArgumentParser()
        channel180.add_options(parser)
        fine = channel180.compute(parser.parse_args(["--out", str(tmp_path), "--time", "100", *words]))
        assert fine == tmp_path / "fine"
        return [(Path(line[line.index("--out") + 1]).name, "--restart" in line) for line in lines]

    assert study() == [("coarse", False), ("fine", False)]
    assert study() == []
    assert study("--time", "200") == [("fine", True)]
    assert lines[0][lines[0].index("--restart") + 1] == str(tmp_path / "fine") and "time.end=215.0" in lines[0]
    (tmp_path / "coarse" / "timing.csv").unlink()  # was interrupted
    assert study() == [("coarse", True)]
    (tmp_path / "coarse" / "state.h5").unlink()
    (tmp_path / "coarse" / "checkpoint_00000001").rmdir()
    assert study() == [("coarse", False)]
    assert (tmp_path / "coarse.cut1" / "settings.toml").is_file()
    settings = tmp_path / "coarse" / "settings.toml"
    settings.write_text(settings.read_text().replace("time.step = 0.12", "time.step = 0.11"))
    with pytest.raises(UserError, match="coarse holds a run without time.step=0.12"):
        study()
