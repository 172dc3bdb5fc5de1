"""What LIGGGHTS users lean on: combinations with shipped models, values of a contact in dumps."""

import numpy as np
import pytest

from liggghts_script import Scene, Sphere

D = 0.01


def pair(gap=1e-5):
    """A sphere that meets another one aslant."""
    return [Sphere((0, 0, 0), (0.1, 0.03, 0)), Sphere((D + gap, 0, 0))]


SHIPPED = [
    "fix m6 all property/global youngsModulus peratomtype 5e6",
    "fix m7 all property/global poissonsRatio peratomtype 0.3",
    "fix m8 all property/global coefficientRollingFriction peratomtypepair 1 0.05",
    "fix m9 all property/global characteristicVelocity scalar 0.1",
]
COMBINATIONS = [
    *(
        f"{normal} tangential haff_werner{rolling}"
        for normal in ("actm", "hertz", "hooke")
        for rolling in ("", " rolling_friction cdt", " rolling_friction epsd2")
    ),
    "actm tangential history",
    "actm tangential off",
    "actm tangential haff_werner cohesion off",
    "rpm tangential haff_werner",
    "rpm tangential off",
]


@pytest.mark.parametrize("combination", COMBINATIONS)
def test_combinations(tmp_path, combination):
    """Each runs, for pairs and walls; spheres rebound, friction turns both of them the same way round
    and leaves the momentum as it was."""
    rpm = "rpm" in combination
    settings = "range 2e-4 strength 1e3" if rpm else ""
    contact = f"model {combination}"
    wall = f"fix floor all wall/gran {contact} primitive type 1 yplane -0.05 {settings}"
    weight = "fix weight none gravity 9.81 vector 0 -1 0"
    scene = Scene(
        pair(3e-4 if rpm else 1e-5),  # rpm: from beyond its range
        restitution=0.8,
        contact=contact,
        settings=settings,
        properties=SHIPPED,
        lines=[wall, *(["group some type 1", "group none subtract all some", weight] if rpm else [])],
    )
    end = scene.run(tmp_path, 800 if rpm else 400)
    assert np.sum(end.v, 0) == pytest.approx([0.1, 0.03, 0], abs=1e-12)
    opening = end.v[1, 0] - end.v[0, 0]
    assert opening == pytest.approx(0.1 if rpm else 0.08, rel=0.03)
    if "off" in combination.split("cohesion")[0]:
        assert np.all(end.spin == 0)
    else:
        assert np.all(end.spin[:, 2] < -0.1)


def test_values_of_a_contact_in_dump_local(tmp_path):
    """compute pair/gran/local shows the contact's history in the order that normal_actm.md and
    tangential_haff_werner.md give; normal and tangential force there make up the force that LIGGGHTS
    shows, the calibration speed is the impact speed, both step numbers are that of the dump."""
    names = ["id1", "id2", "periodic", "fx", "fy", "fz"]
    names += ["k", "d", "birth_overlap", "speed", "force", "step", "settling", "lost"]
    names += ["hw_fx", "hw_fy", "hw_fz", "hw_step"]
    columns = " ".join(f"c_values[{n + 1}]" for n in range(len(names)))
    Scene(pair(), restitution=0.8).run(
        tmp_path,
        [
            "compute values all pair/gran/local id force history",
            f"dump local all local 40 local.dump {columns}",
            "run 40",
            "undump local",
        ],
    )
    row = (tmp_path / "local.dump").read_text().splitlines()[-1]
    value = dict(zip(names, map(float, row.split()), strict=True))
    assert (value["id1"], value["id2"]) == (1, 2)
    assert value["step"] == value["hw_step"] == 40
    # The line of centres has turned by a thousandth at the first touch.
    assert value["speed"] == pytest.approx(0.1, rel=1e-3)
    assert value["k"] > 0 and value["d"] > 0 and value["birth_overlap"] == 0
    friction = np.array([value["hw_fx"], value["hw_fy"], value["hw_fz"]])
    assert friction @ friction <= (0.15 * value["force"]) ** 2 * (1 + 1e-5)
    shown = np.array([value["fx"], value["fy"], value["fz"]])
    assert shown @ shown == pytest.approx(value["force"] ** 2 + friction @ friction, rel=1e-4)
