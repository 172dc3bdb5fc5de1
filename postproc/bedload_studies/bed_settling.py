"""`./bedload settle`: a bed of grains that fell as a rain, as a file that LIGGGHTS scripts read. No study of its own.

Dry first, by LIGGGHTS alone (inputs/beds/settle.liggghts): spheres fall at random places, and friction decides how
densely they pack. One number s orders the ways to fall from dense to loose,

    s in [0, 1]: friction s^2, no rolling friction;     s in [1, 2]: friction 1, rolling friction 0.3 (s - 1),

and the wanted packing is looked for by falls with other s, from a table of what was found before. Then, where asked,
wet: the scene itself runs for a while without a flow.
"""

import argparse
import os
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bedload_launcher import job
from bedload_launcher.bed_options import REACHABLE, TOLERANCE
from bedload_launcher.build import BIN
from bedload_launcher.errors import UserError
from bedload_launcher.folders import next_previous
from bedload_launcher.scenes import INPUTS, Scene, find_scene, read_variables
from bedload_launcher.words import plain, say
from bedload_post.outputs import Run

from .grains_file import last_grains
from .packing import Bed
from .rain import diameters, height_of_rain, rain, read_sizes

# Packing over s of 1000 spheres of one size, `./bedload settle 10x8 --grains 1000 --packing ...`: the first guess.
S_FOUND = (0.0, 0.35, 0.52, 0.68, 0.82, 1.1, 1.24, 1.6, 2.0)
PACKING_FOUND = (0.620, 0.605, 0.585, 0.565, 0.556, 0.545, 0.536, 0.524, 0.515)
FALLS = 8  # at most
OVERLAP = 0.005  # largest one that is accepted, over the largest diameter; a scene accepts 0.25 (fluid/validation)
SOFT, SOFT_STEP, DRAG = 2.5e4, 2.5e-3, 0.2
STIFF_STEPS, STIFF_DEPTH = 10000, 3.3  # steps of the second part for each so many diameters of depth


@dataclass(frozen=True)
class Wish:
    """What is asked for; lengths in the scene's unit.

    box: lengths along x and z; height: of the box, inf where there is none; base: what the grains fall on;
    fixed: grains with centres below it are fixed ones.
    """

    box: tuple[float, float]
    height: float
    diameter: np.ndarray
    seed: int
    packing: float | None
    tolerance: float
    base: str
    fixed: float

    @property
    def unit(self) -> float:
        """The largest diameter, the length unit of the dry fall."""
        return float(self.diameter.max())

    def floor(self) -> float:
        """Where the layer begins whose packing is measured [largest diameter]: the floor, or half of a close-packed
        layer above the base's centres, for the lower half is the base's own."""
        return 0.5 + 0.5 * np.sqrt(2.0 / 3.0) if self.base == "hexagonal" else 0.0

    def base_spheres(self) -> int:
        """How many spheres inputs/beds/hexagonal.liggghts makes."""
        if self.base != "hexagonal":
            return 0
        return 2 * int(self.box[0] / np.sqrt(3.0) + 1e-9) * int(self.box[1] + 1e-9)


def friction_of(s: float) -> tuple[float, float]:
    """Friction and rolling friction of a way to fall."""
    return min(1.0, s) ** 2, 0.3 * max(0.0, s - 1.0)


def wish(options: argparse.Namespace) -> tuple[Wish, Scene | None]:
    """What the options ask for; refuses what makes no bed."""
    if options.grains < 1:
        raise UserError(f"--grains is {options.grains}, but must be at least 1.")
    if options.packing is not None and not 0.4 <= options.packing <= 0.74:
        raise UserError(
            f"--packing is {options.packing:g}, but spheres that fall pack between {REACHABLE[0]} and {REACHABLE[1]}."
        )
    if options.tolerance is not None and not options.tolerance > 0.0:
        raise UserError(f"--tolerance is {options.tolerance:g}, but must be above 0.")
    if options.tolerance is not None and options.packing is None:
        raise UserError(f"--tolerance is {options.tolerance:g}, but no --packing is asked for whose tolerance it is.")
    if options.fixed < 0.0:
        raise UserError(f"--fixed is {options.fixed:g}, but must be at least 0.")
    if options.seed < 0:
        raise UserError(f"--seed is {options.seed}, but must be at least 0.")
    if not 2 <= options.digits <= 12:
        raise UserError(f"--digits is {options.digits}, but must be from 2 to 12.")
    diameter = diameters(read_sizes(sizes_of(options)), options.grains)
    if options.base == "hexagonal" and diameter.max() != 1.0:
        raise UserError(
            f"the largest diameter of --sizes is {diameter.max():g}, but with the hexagonal base, whose spheres have "
            "1, it must be 1."
        )
    scene = None
    try:
        x, z = (float(part) for part in options.where.split("x"))
        box, height = (x, z), np.inf
    except ValueError:
        scene = find_scene(options.where)
        x, height, z = scene.lengths()
        for axis in "xz":
            if (ends := scene.value("boundary", axis)) not in (None, "periodic", ["periodic", "periodic"]):
                raise UserError(f"{scene.folder / 'fluid.toml'}: 'boundary.{axis}' is {ends}, but a bed settles in a "
                                "box that is periodic along x and z: its grains would stand in walls.")  # fmt: skip
        box = (x, z)
    if not np.isfinite(box).all():
        raise UserError(f"the box is '{options.where}', but must be two lengths, as 26x13.")
    if options.wet < 0.0:
        raise UserError(f"--wet is {options.wet:g}, but must be at least 0.")
    if options.wet > 0.0 and scene is None:
        raise UserError(f"--wet runs a scene, but {options.where} is a box.")
    if options.wet > 0.0 and scene is not None and not scene.moves_grains:
        raise UserError(f"--wet runs a scene with the bed's grains, but '{scene.name}' has no in.liggghts.")
    if min(box) < 3.0 * diameter.max():
        raise UserError(f"the box is {min(box):g} wide, but a bed needs three diameters, "
                        f"{3.0 * diameter.max():g} (--sizes {sizes_of(options)}).")
    tolerance = TOLERANCE if options.tolerance is None else options.tolerance
    return Wish(box, height, diameter, options.seed, options.packing, tolerance, options.base, options.fixed), scene


def fall(want: Wish, s: float, folder: Path) -> Bed:
    """One dry fall; lengths in the largest diameter."""
    box = (want.box[0] / want.unit, want.box[1] / want.unit)
    diameter = want.diameter / want.unit
    bottom = 2.0 if want.base == "hexagonal" else 1.0
    rain_height = height_of_rain(diameter, box) + bottom
    spheres = rain(diameter, box, bottom, want.seed)
    lengths = (box[0], rain_height + 1.0, box[1])
    write_bed(folder / "rain", Bed(spheres, 0.5 * diameter, box), 2, lengths, 9, want.base_spheres() + 1)
    friction, rolling = friction_of(s)
    # The highest has come down at the speed m/drag, twice that for the way, and 8 to come to rest.
    speed = np.pi / 6.0 * float(diameter.min()) ** 3 / DRAG
    time = 8.0 + 1.3 * rain_height / min(speed, np.sqrt(2.0 * rain_height))
    depth = float(np.sum(np.pi / 6.0 * diameter**3)) / (PACKING_FOUND[0] * box[0] * box[1])
    given = {
        "length_x": repr(box[0]), "length_y": repr(rain_height + 1.0), "length_z": repr(box[1]),
        "rain": "rain", "end": "end", "base": "none" if want.base == "floor" else want.base,
        "friction": repr(friction), "rolling": repr(rolling), "drag": repr(DRAG), "soft": repr(SOFT),
        "soft_step": repr(SOFT_STEP), "soft_steps": str(round(time / SOFT_STEP)),
        "stiff_steps": str(STIFF_STEPS * int(np.ceil(depth / STIFF_DEPTH))),
        "inputs": job.script_path(INPUTS, folder),
    }  # fmt: skip
    line = [str(BIN / "bedload-dem"), "-in", job.script_path(INPUTS / "beds" / "settle.liggghts", folder),
            "-log", "none"]  # fmt: skip
    for name, value in given.items():
        line += ["-var", name, value]
    done = subprocess.run(
        line, cwd=folder, env=job.environment(), stdin=subprocess.DEVNULL, capture_output=True, text=True,
        errors="replace", check=False, preexec_fn=job.dies_with_us(),
    )  # fmt: skip
    if done.returncode != 0:
        said = [text for text in (done.stdout + done.stderr).splitlines() if "ERROR" in text]
        raise UserError(f"LIGGGHTS ended with status {done.returncode}: {' '.join(said[:1]) or 'it said nothing'}")
    rows = np.loadtxt(folder / "end", skiprows=9, ndmin=2)
    return Bed(rows[:, 1:4], rows[:, 4], box)


def search(want: Wish, drop: Callable[[float], Bed]) -> tuple[Bed, float]:
    """The bed with the wanted packing, and its packing: falls with other s between two that lie on both sides.

    Packing falls with s. Raises UserError when no s gives the packing within the tolerance.
    """
    if want.packing is None:
        bed = drop(0.55)
        return bed, bed.packing(want.floor())
    low, high = (0.0, PACKING_FOUND[0]), (2.0, PACKING_FOUND[-1])  # expected there, until seen
    s = float(np.interp(-want.packing, [-p for p in PACKING_FOUND], S_FOUND))
    best: tuple[Bed, float] | None = None
    for _ in range(FALLS):
        bed = drop(s)
        found = bed.packing(want.floor())
        say(f"bedload: dry fall with friction {friction_of(s)[0]:.3f} and rolling friction "
            f"{friction_of(s)[1]:.3f}: packing {found:.4f}")  # fmt: skip
        if best is None or abs(found - want.packing) < abs(best[1] - want.packing):
            best = bed, found
        if abs(found - want.packing) <= want.tolerance:
            return best
        if found > want.packing:
            low = (s, found)
        else:
            high = (s, found)
        if high[0] - low[0] < 1e-3:
            break
        part = (low[1] - want.packing) / max(low[1] - high[1], 1e-6)
        s = low[0] + (high[0] - low[0]) * min(0.9, max(0.1, part))
        if s < 0.02 or s > 1.98:  # the end has not been seen
            s = round(s)
    assert best is not None
    raise UserError(
        f"--packing {want.packing:g} was not reached within {want.tolerance:g}: the nearest of these falls is "
        f"{best[1]:.4f} (reachable with one size: {REACHABLE[0]} to {REACHABLE[1]}; --tolerance accepts more)."
    )


def write_bed(
    file: Path, bed: Bed, kind: int | np.ndarray, lengths: tuple[float, float, float], digits: int, first_tag: int = 1,
    head: str = "spheres",
) -> None:  # fmt: skip
    """A file of LIGGGHTS' read_data: tag, type, diameter, density, centre; `kind`: 1 fixed, 2 mobile."""
    kinds = np.broadcast_to(kind, len(bed.radius))
    lines = [head, "", f"{len(kinds)} atoms", "2 atom types"]
    lines += [f"0 {length!r} {axis}lo {axis}hi" for axis, length in zip("xyz", lengths, strict=True)]
    lines += ["", "Atoms", ""]
    x = np.round(bed.position, digits)
    for axis, length in ((0, lengths[0]), (2, lengths[2])):
        x[:, axis] = np.where(x[:, axis] >= length, x[:, axis] - length, x[:, axis])
    for n in range(len(kinds)):
        place = " ".join(f"{c:.{digits}f}".rstrip("0").rstrip(".") for c in np.maximum(x[n], 0.0))
        lines.append(f"{first_tag + n} {kinds[n]} {2.0 * bed.radius[n]:.7g} 1 {place}")
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def wet(scene: Scene, want: Wish, file: Path, bed: Bed, kinds: np.ndarray, time: float, folder: Path) -> Bed:
    """The bed after `time` in the scene without a flow; fixed grains stay where they are."""
    name = job.script_path(file.resolve(), scene.folder)
    variables = read_variables(scene, scene.default_model(), [f"bed_file={name}"])
    settings = [f"time.end={time!r}", 'flow.driving="none"', "flow.bulk_velocity=0.0", "flow.pressure_gradient=0.0",
                'start.from="rest"', f"output.spheres_every={time!r}", "output.fields_every=0.0",
                "statistics.every=0"]  # fmt: skip
    work = job.Job(scene, scene.default_model(), job.Ranks(1, 1), folder / "wet", settings, variables=variables)
    with (folder / "wet.txt").open("w") as words:
        status = subprocess.run(
            work.command(), cwd=scene.folder, env=job.environment(), stdin=subprocess.DEVNULL, stdout=words,
            stderr=subprocess.STDOUT, check=False, preexec_fn=job.dies_with_us(),
        ).returncode  # fmt: skip
    if status != 0:
        said = (folder / "wet.txt").read_text(encoding="utf-8", errors="replace").strip().splitlines()
        raise UserError(f"{scene.name} with the dry bed ended with status {status}: {said[-1] if said else ''}")
    position = bed.position.copy()
    _, moved, velocity, _ = last_grains(Run(folder / "wet"))
    if len(moved) != int(np.sum(kinds == 2)):
        raise UserError(f"{scene.name} has {len(moved)} mobile grains, but the bed {int(np.sum(kinds == 2))}.")
    position[kinds == 2] = moved
    say(f"bedload: wet, after {time:g}: fastest grain {np.linalg.norm(velocity, axis=1).max():.2g}")
    return Bed(position, bed.radius, bed.box)


def settle(options: argparse.Namespace) -> int:
    """Makes the bed, writes it, says what it is. An earlier file in its place moves aside once the bed is made."""
    want, scene = wish(options)
    if options.out.is_dir():
        raise UserError(f"--out is the folder {options.out}, but must be a file.")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="bedload-settle-") as name:
        folder = Path(name)
        dry, _ = search(want, lambda s: fall(want, s, folder))
        bed = Bed(dry.position * want.unit, dry.radius * want.unit, want.box)
        wrapped = np.mod(bed.position, (want.box[0], np.inf, want.box[1]))
        bed = Bed(wrapped, bed.radius, want.box)
        top = float((bed.position[:, 1] + bed.radius).max())
        if top > want.height:
            raise UserError(f"the bed is {top:.4g} high, but the box of {options.where} {want.height:g}.")
        kinds = np.where(bed.position[:, 1] < want.fixed, 1, 2)
        lengths = (want.box[0], want.height if np.isfinite(want.height) else float(np.ceil(top + 1.0)), want.box[1])
        head = f"bed of {len(kinds)} grains, ./bedload settle {words_of(options)}"

        def write(made: Bed, file: Path) -> None:
            write_bed(file, made, kinds, lengths, options.digits, want.base_spheres() + 1, head)

        if options.wet > 0.0 and scene is not None:
            write(bed, folder / "dry.data")
            bed = wet(scene, want, folder / "dry.data", bed, kinds, options.wet, folder)
    overlap = Bed(np.round(bed.position, options.digits), bed.radius, want.box).overlap() / want.unit
    if overlap > OVERLAP:
        raise UserError(f"grains overlap by {overlap:.4f} D, more than {OVERLAP:g}; the bed is not at rest.")
    if options.out.is_file():
        aside = next_previous(options.out)
        options.out.rename(aside)
        print(f"bedload: the earlier file there is now {plain(str(aside))}", flush=True)
    write(bed, options.out)
    describe(bed, kinds, want, overlap, options.out)
    return 0


def sizes_of(options: argparse.Namespace) -> str:
    """--sizes in one line, whether given as several words or as one in quotes."""
    return " ".join(options.sizes)


def words_of(options: argparse.Namespace) -> str:
    """The command's words again, the output file left out."""
    words = [os.path.basename(options.where), f"--grains {options.grains}", f"--seed {options.seed}"]
    words += [f"--packing {options.packing:g}"] if options.packing is not None else []
    words += [f"--sizes {sizes_of(options)}", f"--base {options.base}"]
    words += [f"--fixed {options.fixed:g}"] if options.fixed else []
    words += [f"--wet {options.wet:g}"] if options.wet else []
    return " ".join(words)


def describe(bed: Bed, kinds: np.ndarray, want: Wish, overlap: float, out: Path) -> None:
    fixed = int(np.sum(kinds == 1))
    floor = want.floor() * want.unit
    print(f"packing        {bed.packing(floor):.4f}" + (f" (asked for {want.packing:g})" if want.packing else ""))
    held = f", {fixed} fixed (centres below {want.fixed:g})" if fixed else ""
    print(f"grains         {len(kinds) - fixed} mobile{held}")
    for size in np.unique(want.diameter)[::-1]:
        number = int(np.sum(np.isclose(2.0 * bed.radius, size, rtol=1e-6)))
        print(f"  diameter {size:<6g} {number} ({number / len(kinds):.3f})")
    print(f"surface        y = {bed.surface(floor):.4g}, highest point {(bed.position[:, 1] + bed.radius).max():.4g}")
    print(f"largest overlap {overlap:.1e} of the largest diameter")
    print(f"bedload: bed in {out}")
