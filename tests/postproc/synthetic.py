"""Made-up trajectories with known states, and a made-up output folder in a run's layout."""

from pathlib import Path

import h5py
import numpy as np

SETTINGS = """\
title = "made up"
grid.cells = [{nx}, {ny}, {nz}]
grid.length = [16.0, 9.0, 8.0]
boundary.x = ["periodic", "periodic"]
boundary.y = ["no_slip", "free_slip"]
boundary.z = ["periodic", "periodic"]
fluid.density = 1.0
fluid.kinematic_viscosity = 2.6578e-3
fluid.gravity = [0.0, -0.99, 0.0]
time.step = 0.02
time.end = 40.0
reference.velocity = 1.0
reference.height = 8.0
reference.diameter = 1.0
reference.sphere_density = 1.25
derived.Re_b = 3010.0
"""


class Story:
    """A grain's life told piece by piece; every quantity is linear or quadratic in between."""

    def __init__(self, position=(1.0, 1.5, 4.0), radius=0.5, samples_per_time=400):
        self.rate, self.radius = samples_per_time, radius
        self.time, self.position = [0.0], [np.array(position, float)]
        self.velocity, self.spin = [np.zeros(3)], [np.zeros(3)]
        self.contacts = []

    @property
    def now(self):
        return self.time[-1]

    def piece(
        self, duration, velocity=(0, 0, 0), spin_z=0.0, jump_height=0.0, contact=False, spin_x=0.0
    ):
        """Moves with constant velocity, on a parabola of `jump_height` where it jumps."""
        start, origin = self.now, self.position[-1]
        s = np.linspace(0, 1, max(2, int(duration * self.rate)) + 1)[1:]
        for f in s:
            self.time.append(start + f * duration)
            arc = np.array([0, 4 * jump_height * f * (1 - f), 0])
            rise = np.array([0, 4 * jump_height * (1 - 2 * f) / duration, 0])
            self.position.append(origin + np.array(velocity) * f * duration + arc)
            self.velocity.append(np.array(velocity) + rise)
            self.spin.append(np.array([spin_x, 0, spin_z]))
        if contact:
            self.contacts.append((start, self.now))
        return self

    def touch(self, duration=0.002, velocity=(0, 0, 0)):
        """A short collision."""
        return self.piece(duration, velocity=velocity, contact=True)

    def arrays(self, tag, box):
        n = len(self.time)
        return {
            "time": np.array(self.time),
            "tag": np.full(n, tag),
            "position": np.mod(np.array(self.position), box),
            "velocity": np.array(self.velocity),
            "angular_velocity": np.array(self.spin),
            "radius": np.full(n, self.radius),
        }


def even(story, step=0.01):
    """The story sampled at equal intervals, as a run samples."""
    time = np.arange(0.0, story.now, step)
    for name in ("position", "velocity", "spin"):
        values = np.array(getattr(story, name))
        columns = [np.interp(time, story.time, values[:, d]) for d in range(3)]
        setattr(story, name, list(np.stack(columns, axis=1)))
    story.time = list(time)
    return story


def merge_in_time(*tables):
    """The rows of several grains in the order of time, as a run writes them."""
    joined = {k: np.concatenate([t[k] for t in tables]) for k in tables[0]}
    order = np.argsort(joined["time"], kind="stable")
    return {k: v[order] for k, v in joined.items()}


def hexagonal_bed(length_x=16.0, length_z=8.0):
    """Centres of one layer of unit spheres, rows along z, gaps spread evenly."""
    rows, columns = int(length_x / (np.sqrt(3) / 2)) // 2 * 2, int(length_z)
    dx, dz = length_x / rows, length_z / columns
    i, k = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    z = (k + 0.5 * (i % 2) + 0.25) * dz
    return np.column_stack([(i.ravel() + 0.5) * dx, np.full(i.size, 0.5), z.ravel()])


def write_samples(folder: Path, rows: dict[str, np.ndarray]) -> None:
    """Gives the run in `folder` these samples of mobile spheres."""
    with h5py.File(folder / "spheres.h5", "a") as file:
        file.pop("mobile", None)
        for name, values in rows.items():
            file[f"mobile/{name}"] = values
        file["mobile/step"] = np.arange(len(rows["time"]))
        for name in ("force", "torque"):
            file[f"mobile/{name}"] = np.zeros((len(rows["time"]), 3))


def write_run(folder: Path, story: Story, tag=1, cells=(80, 45, 40)):
    """An output folder as a run leaves it, around one grain's story."""
    folder.mkdir(parents=True, exist_ok=True)
    nx, ny, nz = cells
    (folder / "settings.toml").write_text(SETTINGS.format(nx=nx, ny=ny, nz=nz))
    box = np.array([16.0, 9.0, 8.0])
    bed = hexagonal_bed()
    grain = story.arrays(tag, box)
    with h5py.File(folder / "spheres.h5", "w") as file:
        file["fixed/tag"] = np.arange(len(bed)) + 1000
        file["fixed/position"], file["fixed/radius"] = bed, np.full(len(bed), 0.5)
    write_samples(folder, grain)
    rows = ["tag_i,tag_j,time_start,time_end,x,y,z,impact_speed_normal,impact_speed_tangential,"
            "rebound_speed_normal,impulse_normal,impulse_tangential"]  # fmt: skip
    rows += [f"{tag},1000,{a!r},{b!r},0,0,0,0,0,0,0,0" for a, b in story.contacts]
    (folder / "collisions.csv").write_text("\n".join(rows) + "\n")
    (folder / "collisions_open.csv").write_text(rows[0] + "\n")

    faces = [np.linspace(0, length, n + 1) for length, n in zip(box, cells, strict=True)]
    x, y, z = (0.5 * (f[1:] + f[:-1]) for f in faces)
    zz, yy, xx = np.meshgrid(z, y, x, indexing="ij")
    above = np.maximum(yy - 1.0, 0.0)
    u = np.log1p(30 * above) / np.log1p(30 * 8.0) * 1.15
    u += (above > 0) * 0.12 * np.sin(2.1 * xx + 3 * np.sin(1.57 * zz)) * np.sin(0.78 * zz + yy)
    u += (above > 0) * 0.06 * np.sin(5.1 * xx - 2 * yy) * np.cos(3.93 * zz)
    with h5py.File(folder / "fields.h5", "w") as file:
        for axis, face in zip("xyz", faces, strict=True):
            file[f"grid/{axis}"] = face
        group = file.create_group("step_00002000")
        group.attrs["step"], group.attrs["time"] = 2000, story.now
        for name, field in {"u": u, "v": 0 * u, "w": 0 * u, "p": 0 * u}.items():
            group[name] = field.astype(np.float32)

    time = np.arange(0.2, story.now + 1e-9, 0.2)
    columns = ("step,time,dt,cfl,bulk_velocity,driving,kinetic_energy,u_tau_driving,max_divergence,"
               "slip_max,slip_rms,forcing_loops,mobile_spheres,momentum_residual")  # fmt: skip
    lines = [
        f"{i * 10},{t},0.02,0.5,0.888889,0.004,1.0,0.07,1e-14,0.02,0.004,2,1,3e-15"
        for i, t in enumerate(time, 1)
    ]
    (folder / "history.csv").write_text("\n".join([columns, *lines]) + "\n")
    (folder / "timing.csv").write_text(
        "part,seconds_mean_over_ranks,seconds_max,share,calls\n"
        "momentum predictor,120.5,121.0,0.40,6000\n"
        "pressure,90.0,95.0,0.30,6000\nimmersed boundary,60.0,70.0,0.20,6000\n"
        "waiting for LIGGGHTS,30.0,31.0,0.10,6000\n"
    )
    return folder


def wandering_story():
    """Rests, creeps, jumps three times across the periodic end, and rests again."""
    story = Story(position=(12.0, 1.36, 4.0), samples_per_time=25)
    story.piece(6.0, contact=True)
    story.piece(0.8, velocity=(0.4, 0, 0.1), spin_z=-0.8, contact=True)
    for height, length in ((0.35, 1.5), (0.6, 2.4), (0.25, 1.1)):
        story.piece(length / 0.5, velocity=(0.5, 0, 0.08), spin_z=-1.2, jump_height=height)
        story.touch(0.04)
    return story.piece(5.0, contact=True)
