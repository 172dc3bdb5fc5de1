"""Writes small LIGGGHTS scripts, runs them with our styles, and reads the end state back."""

import csv
import os
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

PROGRAM = os.environ.get("BEDLOAD_LIGGGHTS", "liggghts-with-styles")
MPI_ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    # MPI asks for this machine's own name at each start; a silent name server would cost 20 s.
    "RES_OPTIONS": "timeout:1 attempts:1",
}
COLUMNS = "id type x y z vx vy vz omegax omegay omegaz fx fy fz"


@dataclass
class Sphere:
    """One sphere [SI units]."""

    position: tuple
    velocity: tuple = (0.0, 0.0, 0.0)
    spin: tuple = (0.0, 0.0, 0.0)
    diameter: float = 0.01
    density: float = 2500.0
    type: int = 1

    @property
    def mass(self):
        return self.density * np.pi / 6 * self.diameter**3

    @property
    def inertia(self):
        return 0.1 * self.mass * self.diameter**2


@dataclass
class Scene:
    """A box of spheres and the lines of the script that act on them."""

    spheres: list
    box: tuple = ((-0.1, 0.1), (-0.1, 0.1), (-0.1, 0.1))
    boundary: str = "f f f"
    restitution: object = 0.9  # number, or square matrix over the types
    friction: float = 0.15
    fluid_step: float = 1e-3
    substeps: int = 15
    contact: str = "model actm tangential haff_werner"
    settings: str = ""
    skin: float = 1e-3
    lines: list = field(default_factory=list)  # after the pair style: walls, fixes
    integrate: str = "fix integrate all nve/sphere"
    properties: list = field(default_factory=list)

    @property
    def dt(self):
        return self.fluid_step / self.substeps

    @property
    def types(self):
        return np.shape(self.restitution)[0] if np.ndim(self.restitution) == 2 else 1

    def data_file(self):
        rows = [f"bedload test\n\n{len(self.spheres)} atoms\n{self.types} atom types\n"]
        for axis, (low, high) in zip("xyz", self.box):
            rows.append(f"{low!r} {high!r} {axis}lo {axis}hi")
        rows.append("\nAtoms\n")
        for tag, s in enumerate(self.spheres, 1):
            x = " ".join(repr(float(c)) for c in s.position)
            rows.append(f"{tag} {s.type} {s.diameter!r} {s.density!r} {x}")
        rows.append("\nVelocities\n")
        for tag, s in enumerate(self.spheres, 1):
            numbers = " ".join(repr(float(c)) for c in (*s.velocity, *s.spin))
            rows.append(f"{tag} {numbers}")
        return "\n".join(rows) + "\n"

    def head(self):
        matrix = np.broadcast_to(np.asarray(self.restitution, float), (self.types,) * 2)
        values = " ".join(repr(float(e)) for e in matrix.flat)
        mu = " ".join([repr(float(self.friction))] * self.types**2)
        n = self.types
        return [
            "atom_style granular",
            "atom_modify map array",
            f"boundary {self.boundary}",
            "newton off",
            "communicate single vel yes",
            "units si",
            "read_data spheres.data",
            f"neighbor {self.skin!r} bin",
            "neigh_modify delay 0",
            *self.physics(n, values, mu),
        ]

    def physics(self, n, values, mu):
        return [
            f"fix m1 all property/global coefficientRestitution peratomtypepair {n} {values}",
            f"fix m2 all property/global coefficientFriction peratomtypepair {n} {mu}",
            f"fix m3 all property/global fluidTimeStep scalar {self.fluid_step!r}",
            *self.properties,
            f"pair_style gran {self.contact} {self.settings}",
            "pair_coeff * *",
            *self.lines,
            self.integrate,
            f"timestep {self.dt!r}",
        ]

    def script(self, steps):
        """Lines of a run of `steps` steps (or of the given lines) with the end state dumped."""
        body = [f"run {steps}"] if isinstance(steps, int) else list(steps)
        return [*self.head(), "thermo 1000000", *body, *dump_now("end.dump")]

    def run(self, folder, steps, ranks=1, timeout=600):
        """Runs in `folder`; returns the end state (see read_dump)."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "spheres.data").write_text(self.data_file())
        run_script(folder, self.script(steps), ranks, timeout)
        return read_dump(folder / "end.dump")


def dump_now(name, columns=COLUMNS):
    """Lines that write the state as it is, with all digits."""
    form = " ".join("%d" if c in ("id", "type") else "%.17g" for c in columns.split())
    return [
        f"dump now all custom 1 {name} {columns}",
        f'dump_modify now format "{form}" sort id',
        "run 0",
        "undump now",
    ]


def launch(folder, lines, ranks=1, timeout=600):
    """Runs a script and returns the finished process, whatever its exit code."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "in.liggghts").write_text("\n".join(lines) + "\n")
    command = [PROGRAM, "-in", "in.liggghts", "-log", "none"]
    if ranks > 1:
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-np", str(ranks), *command]
    return subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **MPI_ENVIRONMENT},
        capture_output=True,
        text=True,
        errors="replace",
        timeout=timeout,
        check=False,
    )


def run_script(folder, lines, ranks=1, timeout=600):
    """Runs a script that has to succeed; returns what it printed."""
    done = launch(folder, lines, ranks, timeout)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@dataclass
class State:
    """Spheres in order of their tags; arrays of shape (n,) or (n, 3), SI units."""

    tag: np.ndarray
    x: np.ndarray
    v: np.ndarray
    spin: np.ndarray
    f: np.ndarray


def read_dump(path):
    """Last snapshot of a dump with the columns above."""
    lines = Path(path).read_text().splitlines()
    start = max(n for n, line in enumerate(lines) if line.startswith("ITEM: ATOMS")) + 1
    table = np.array([[float(w) for w in line.split()] for line in lines[start:]])
    table = table[np.argsort(table[:, 0])]
    return State(
        table[:, 0].astype(int), table[:, 2:5], table[:, 5:8], table[:, 8:11], table[:, 11:14]
    )


def read_table(path):
    """The collision table as a dictionary of columns."""
    with open(path, newline="") as source:
        rows = list(csv.DictReader(source))
    return {k: np.array([float(r[k]) for r in rows]) for k in (rows[0] if rows else [])}


def kinetic_energy(spheres, state):
    """Translation and rotation of spheres 1..n [J]."""
    m = np.array([s.mass for s in spheres])
    inertia = np.array([s.inertia for s in spheres])
    return 0.5 * np.sum(m * np.sum(state.v**2, 1)) + 0.5 * np.sum(inertia * np.sum(state.spin**2, 1))
