"""Small scenes written by a program: a box of fluid and a list of spheres, in D = U = rho_f = 1.

The studies vary what a person would edit by hand, so they write both files of a scene themselves.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Ball:
    """One sphere; `mobile` ones move, the others stay for ever."""

    position: Vector
    diameter: float = 1.0
    density: float = 2.5
    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)
    mobile: bool = True


@dataclass(frozen=True)
class SmallScene:
    """A box of `length` with `cells_per_diameter` cells to a unit length and what is in it.

    keys: further values of fluid.toml by dotted name, written as in TOML.
    """

    length: Vector
    cells_per_diameter: int
    viscosity: float
    time_step: float
    end: float
    balls: Sequence[Ball] = ()
    gravity: float = 0.0  # downwards
    y_ends: tuple[str, str] = ("no_slip", "no_slip")
    model: str = "actm_hw"
    restitution: float = 0.97
    friction: float = 0.15
    keys: dict[str, str] = field(default_factory=dict)

    @property
    def cell(self) -> float:
        return 1.0 / self.cells_per_diameter

    def fluid_toml(self) -> str:
        cells = [round(edge * self.cells_per_diameter) for edge in self.length]
        ends = ", ".join(f'"{end}"' for end in self.y_ends)
        lines = [
            f"grid.cells = {cells}",
            f"grid.length = {list(self.length)}",
            f"boundary.y = [{ends}]",
            f"fluid.kinematic_viscosity = {self.viscosity!r}",
            f"fluid.gravity = [0.0, {-self.gravity!r}, 0.0]",
            f"time.step = {self.time_step!r}",
            f"time.end = {self.end!r}",
            "output.history_every = 1",
        ]
        lines += [f"{key} = {value}" for key, value in self.keys.items()]
        return "\n".join(lines) + "\n"

    def in_liggghts(self) -> str:
        x, y, z = self.length
        mobile = [b for b in self.balls if b.mobile]
        fixed = [b for b in self.balls if not b.mobile]
        skin = max(0.8, 4.1 * self.cell)
        lines = [
            "variable out index .",
            f"variable model index {self.model}",
            "units si\natom_style granular\natom_modify map array\nnewton off",
            "communicate single vel yes\nboundary p f p",
            f"region box block 0 {x} 0 {y} 0 {z} units box\ncreate_box 2 box",
            f"neighbor {skin} bin\nneigh_modify delay 0",
        ]
        for kind, balls in ((1, fixed), (2, mobile)):
            lines += [f"create_atoms {kind} single {_words(b.position)} units box" for b in balls]
        for tag, ball in enumerate([*fixed, *mobile], start=1):
            lines.append(f"set atom {tag} diameter {ball.diameter} density {ball.density}")
            values = (*ball.velocity, *ball.spin)
            if any(values):
                names = ("vx", "vy", "vz", "omegax", "omegay", "omegaz")
                pairs = " ".join(f"{n} {v!r}" for n, v in zip(names, values, strict=True))
                lines.append(f"set atom {tag} {pairs}")
        e, mu = self.restitution, self.friction
        lines += [
            "group bed type 1\ngroup grains type 2",
            f"fix e all property/global coefficientRestitution peratomtypepair 2 {e} {e} {e} {e}",
            f"fix mu all property/global coefficientFriction peratomtypepair 2 {mu} {mu} {mu} {mu}",
            f"fix weight all gravity {self.gravity!r} vector 0 -1 0",
            "fix fluid all couple/fluid fixed bed",
            "include ${inputs}/models/${model}.liggghts",
        ]
        for name, height in (("floor", 0.0), ("roof", y)):
            lines.append(
                f"fix {name} all wall/gran ${{contact}} primitive type 1 yplane {height} "
                "${contact_settings}"
            )
        lines += ["fix motion grains nve/sphere", "fix still bed freeze"]
        lines += ["fix collisions all collision/table file ${out}/collisions.csv"]
        lines += ["thermo 1000000", "coupled_run"]
        return "\n".join(lines) + "\n"

    def write(self, folder: Path) -> None:
        """Both files into `folder`; no in.liggghts where there are no spheres."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "fluid.toml").write_text(self.fluid_toml(), encoding="utf-8")
        if self.balls:
            (folder / "in.liggghts").write_text(self.in_liggghts(), encoding="utf-8")


def _words(values: Sequence[float]) -> str:
    return " ".join(repr(float(v)) for v in values)
