"""Reads the example that fluid_output_tests left behind the way a user and postproc do."""

import csv
import sys
import tomllib
import unittest
import xml.etree.ElementTree as xml
from pathlib import Path

import h5py
import numpy as np

FOLDER = Path(sys.argv.pop())
CELLS = (8, 4, 8)  # nz, ny, nx of the example


UNITS = {"u": "L/T", "v": "L/T", "w": "L/T", "p": "L^2/T^2"}


def linear(c, x, y, z):
    return c + 2 * x - 3 * y + 5 * z


def item_array(item):
    """The numbers that an XDMF DataItem stands for, its declared shape and type checked."""
    shape = tuple(map(int, item.get("Dimensions").split()))
    if item.get("ItemType") == "HyperSlab":
        corner, source = item.findall("DataItem")
        start, stride, count = np.array(corner.text.split(), int).reshape(3, -1)
        select = tuple(slice(a, a + s * n, s) for a, s, n in zip(start, stride, count))
        values = item_array(source)[select]
    else:
        file, _, path = item.text.strip().partition(":")
        with h5py.File(FOLDER / file) as opened:
            values = opened[path][()]
        assert values.itemsize == int(item.get("Precision")), item.text
        kind = {"Float": "f", "Int": "i"}[item.get("NumberType")]
        assert values.dtype.kind == kind, item.text
    assert values.shape == shape, (values.shape, shape, item.text)
    return values


class Layout(unittest.TestCase):
    def test_fields(self):
        with h5py.File(FOLDER / "fields.h5") as file:
            steps = sorted(name for name in file if name.startswith("step_"))
            self.assertEqual(steps, ["step_00000001", "step_00000002", "step_00000003"])
            faces = [file[f"grid/{axis}"][:] for axis in "xyz"]
            x, y, z = ((f[1:] + f[:-1]) / 2 for f in faces)
            group = file[steps[-1]]
            self.assertEqual((int(group.attrs["step"]), float(group.attrs["time"])), (3, 0.1 * 3))
            z, y, x = np.meshgrid(z, y, x, indexing="ij")
            for c, name in enumerate("uvwp"):
                values = group[name][:]
                self.assertEqual((values.shape, values.dtype), (CELLS, np.float32))
                self.assertEqual(group[name].attrs["unit"].decode(), UNITS[name])
                inner = (slice(1, None),) * 3
                np.testing.assert_allclose(values[inner], linear(c, x, y, z)[inner], atol=1e-5)

    def test_field_xdmf(self):
        grids = xml.parse(FOLDER / "fields.xdmf").findall(".//Grid[@GridType='Uniform']")
        self.assertEqual([float(g.find("Time").get("Value")) for g in grids], [0.1, 0.2, 0.1 * 3])
        for grid in grids:
            nodes = tuple(map(int, grid.find("Topology").get("Dimensions").split()))
            self.assertEqual(nodes, tuple(n + 1 for n in CELLS))
            axes = [item_array(item) for item in grid.find("Geometry")]
            self.assertEqual(tuple(len(a) for a in axes), nodes[::-1])
            names = [a.get("Name") for a in grid.findall("Attribute")]
            self.assertEqual(names, list("uvwp"))
            for attribute in grid.findall("Attribute"):
                self.assertEqual(attribute.get("Center"), "Cell")
                self.assertEqual(item_array(attribute.find("DataItem")).shape, CELLS)

    def test_spheres(self):
        with h5py.File(FOLDER / "spheres.h5") as file:
            fixed = {name: data[:] for name, data in file["fixed"].items()}
            mobile = {name: data[:] for name, data in file["mobile"].items()}
        self.assertEqual(set(fixed), {"tag", "position", "radius", "force", "force_step", "force_time"})
        self.assertEqual(fixed["force_step"].tolist(), [3])
        self.assertEqual(fixed["force"].tolist(), [[0.5, 0, 2]])
        self.assertEqual(fixed["position"].tolist(), [[1, 0.5, 2]])
        vectors = {"position", "velocity", "angular_velocity", "force", "torque"}
        self.assertEqual(set(mobile), vectors | {"step", "time", "tag", "radius"})
        for name, values in mobile.items():
            self.assertEqual(values.shape, (3, 3) if name in vectors else (3,))
        np.testing.assert_array_equal(mobile["step"], [1, 2, 3])
        np.testing.assert_allclose(mobile["force"][:, 0], [0.1, 0.2, 0.3])

    def test_sphere_xdmf(self):
        domain = xml.parse(FOLDER / "spheres.xdmf").find("Domain")
        fixed, mobile = domain.findall("Grid")
        self.assertEqual(item_array(fixed.find("Geometry/DataItem")).tolist(), [[1, 0.5, 2]])
        for n, grid in enumerate(mobile.findall("Grid"), start=1):
            position = item_array(grid.find("Geometry/DataItem"))
            np.testing.assert_allclose(position, [[0.1 * n, 1, 2]])
            for attribute in grid.findall("Attribute"):
                item_array(attribute.find("DataItem"))
        self.assertEqual(n, 3)

    def test_state(self):
        with h5py.File(FOLDER / "state.h5") as file:
            self.assertEqual(file["u"].shape, (4, 8, 8))  # (ny, nz, nx)
            self.assertEqual(file["p"].dtype, np.float32)
            self.assertEqual({name: file[name].attrs["unit"].decode() for name in "uvwp"}, UNITS)
            self.assertEqual(file.attrs["cells"].tolist(), [8, 4, 8])
            self.assertAlmostEqual(file["u"][1, 2, 3], linear(0, 0.5, 1.5 / 8, 2.5 / 8), places=6)
        with h5py.File(FOLDER / "start.h5") as file:
            self.assertEqual((file["u"].shape, file["u"].dtype), ((2, 4, 4), np.int16))
            value = file["u"][1, 2, 1] * file["u"].attrs["scale"]
            self.assertAlmostEqual(value, linear(0, 0.5, 3 / 8, 5 / 8), places=3)

    def test_statistics(self):
        """Each list under its own name: entry n of the k-th one is 100 k + n."""
        names = (
            "y y_face fluid fluid_face u v w p uu vv ww uv uw vw pp grains mobile grain_u grain_v grain_w grain_spin "
            "viscous turbulent acceleration spheres"
        ).split()
        with h5py.File(FOLDER / "statistics.h5") as file:
            self.assertEqual(set(file["profiles"]), set(names))
            for k, name in enumerate(names):
                self.assertEqual(file["profiles"][name][:].tolist(), [100 * k, 100 * k + 1, 100 * k + 2], name)
            found = {name: file.attrs[name] for name in ("samples", "begin", "end", "driving", "u_tau", "re_tau")}
            wanted = {"samples": 7, "begin": 0.1, "end": 0.2, "driving": 0.3, "u_tau": 0.4, "re_tau": 0.5}
            self.assertEqual(found, wanted)
            self.assertEqual(file.attrs["stress_defect"], 0.6)
            self.assertEqual(file.attrs["wall_stress"].tolist(), [0.7, 0.8])
            self.assertEqual(file["spectra"].attrs["wavenumber_step"].tolist(), [0.9, 1.1])
            self.assertEqual(file["spectra/height_0"].attrs["height"], 1.2)
            last = 100 * len(names)
            for c, component in enumerate("uvw"):
                self.assertEqual(file[f"spectra/height_0/{component}_along_x"][:].tolist(), [last + c])
                self.assertEqual(file[f"spectra/height_0/{component}_along_z"][:].tolist(), [last + 10 + c])

    def test_text_files(self):
        with (FOLDER / "settings.toml").open("rb") as file:
            self.assertEqual(tomllib.load(file)["grid"]["cells"], [16, 8, 8])
        needed = {
            "history.csv": {"step", "time", "dt", "driving", "slip_rms", "momentum_residual"},
            "timing.csv": {"part", "seconds_mean_over_ranks", "calls"},
        }
        for name, columns in needed.items():
            with (FOLDER / name).open(newline="") as file:
                head, *rows = csv.reader(file)
            self.assertLessEqual(columns, set(head))
            self.assertTrue(rows and all(len(row) == len(head) for row in rows), name)

    def test_nothing_half_written_is_left(self):
        self.assertEqual(list(FOLDER.glob("*.part")) + list(FOLDER.glob("*.space")), [])


if __name__ == "__main__":
    unittest.main()
