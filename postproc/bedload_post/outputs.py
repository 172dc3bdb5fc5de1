"""The files of a run's output folder, read as arrays. The one place that knows their names."""

import csv
import math
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np

COLLISIONS, OPEN_CONTACTS = "collisions.csv", "collisions_open.csv"
BLOCK_ROWS = 1_000_000  # sphere samples held in memory at a time (about 150 MB)


class MissingOutput(Exception):
    """A file or value that the run did not write; one sentence."""


class UnknownContacts(MissingOutput):
    """Which grains touched, and so every state, cannot be told of the run; one sentence."""


@dataclass(frozen=True)
class Motion:
    """Where grains are and how they move, at instants; what shape the arrays have, each kind says."""

    time: np.ndarray  # [T]
    tag: np.ndarray
    position: np.ndarray  # [L]
    velocity: np.ndarray  # [L/T]
    angular_velocity: np.ndarray  # [1/T]
    radius: np.ndarray  # [L]


PER_GRAIN = tuple(Motion.__dataclass_fields__)[2:]


class Samples(Motion):
    """Rows of the mobile spheres' table, in the order of time: (n), vectors (n, 3)."""

    def __len__(self) -> int:
        return len(self.time)

    def rows(self, which) -> "Samples":
        """The rows that an index array, mask or slice picks."""
        return Samples(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True)
class Collisions:
    """Finished collisions: tags of both partners (-1: a wall), first and last instant [T]."""

    tag_i: np.ndarray
    tag_j: np.ndarray
    start: np.ndarray
    end: np.ndarray

    def __len__(self) -> int:
        return len(self.start)


@dataclass(frozen=True)
class Snapshot:
    """Cell-centred fields at one instant; each of shape (nz, ny, nx)."""

    step: int
    time: float
    x: np.ndarray  # cell faces, n+1 values
    y: np.ndarray
    z: np.ndarray
    u: np.ndarray
    v: np.ndarray
    w: np.ndarray


class Run:
    """One output folder. Arrays are read when asked for."""

    def __init__(self, folder: Path):
        self.folder = Path(folder)
        if not (self.folder / "settings.toml").is_file():
            if (self.folder / "fluid.toml").is_file():
                raise MissingOutput(f"{self.folder} is a scene; the output of its runs is another folder, "
                                    "runs/SCENE-MODEL where none was named.")  # fmt: skip
            if not self.folder.exists():
                raise MissingOutput(f"{self.folder} is not there.")
            raise MissingOutput(f"{self.folder} has no settings.toml, so it is no output of a run.")

    @property
    def name(self) -> str:
        return self.folder.resolve().name

    @cached_property
    def settings(self) -> dict:
        """Every value in force, as nested tables."""
        path = self.folder / "settings.toml"
        try:
            return tomllib.loads(path.read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise MissingOutput(f"{path} is not whole: {error}.") from error

    def value(self, key: str):
        """One value by its dotted name, as fluid.toml has it."""
        node = self.settings
        for part in key.split("."):
            if not isinstance(node, dict) or part not in node:
                raise MissingOutput(f"settings.toml of {self.folder} has no '{key}'.")
            node = node[part]
        return node

    @property
    def bulk_velocity(self) -> float:
        return self.value("reference.velocity")

    @property
    def depth(self) -> float:
        return self.value("reference.height")

    @property
    def diameter(self) -> float:
        return self.value("reference.diameter")

    @property
    def viscosity(self) -> float:
        return self.value("fluid.kinematic_viscosity")

    @property
    def submerged_weight(self) -> float:
        """(rho_p - rho_f) g of the mobile spheres [M/(L^2 T^2)], 0 where none are meant."""
        gravity = math.hypot(*self.value("fluid.gravity"))
        density = self.value("reference.sphere_density")
        return (density - self.value("fluid.density")) * gravity if density > 0 else 0.0

    @cached_property
    def box(self) -> np.ndarray:
        """Edge lengths, shape (3)."""
        return np.array(self.value("grid.length"), dtype=float)

    @cached_property
    def periods(self) -> np.ndarray:
        """Edge length where the direction is periodic, infinity where it has walls, shape (3)."""
        ends = [self.value(f"boundary.{axis}") for axis in "xyz"]
        periodic = ["periodic" in (end if isinstance(end, list) else [end]) for end in ends]
        return np.where(periodic, self.box, np.inf)

    def table(self, file: str) -> dict[str, np.ndarray]:
        """A CSV file by columns, a row broken off left out; columns without numbers come as text."""
        path = self.folder / file
        if not path.is_file():
            raise MissingOutput(f"{self.folder} has no {file}.")
        with path.open(newline="", encoding="utf-8") as stream:
            rows = csv.reader(_whole(stream))
            header: list[str] = next(rows, [])
            if not header:
                raise MissingOutput(f"{path} is empty.")
            columns = list(zip(*(row for row in rows if len(row) == len(header)), strict=True))
        if not columns:
            return {name.strip(): np.array([]) for name in header}
        return {
            name.strip(): _numbers_or_text(column)
            for name, column in zip(header, columns, strict=True)
        }

    def history(self) -> dict[str, np.ndarray]:
        return self.table("history.csv")

    def timings(self) -> tuple[list[dict[str, np.ndarray]], bool]:
        """Times of each part of a run that was restarted, and whether all parts have told theirs: one that was killed
        has not."""
        earlier = sorted(file.name for file in self.folder.glob("timing.part*.csv"))
        tables = [self.table(file) for file in (*earlier, "timing.csv")]
        return tables, len(tables) > len(list(self.folder.glob("log.part*.liggghts")))

    @property
    def has_collisions(self) -> bool:
        """Whether the run wrote of collisions; the table is there from the start, if a script asks for it."""
        return (self.folder / COLLISIONS).is_file()

    def collisions(self) -> Collisions:
        """The collision table; empty where no collision has finished."""
        return self._contacts(COLLISIONS)

    def contacts(self) -> Collisions:
        """All contacts; those that were under way at the end of the run end beyond it, at infinity.

        Raises UnknownContacts where these have no table: a run writes it at its end and takes it away where it goes on.
        """
        if not self.has_collisions:
            raise UnknownContacts(f"{self.folder} has no {COLLISIONS}, without which no state of a grain can be told.")
        if not (self.folder / OPEN_CONTACTS).is_file():
            raise UnknownContacts(f"{self.folder} has no {OPEN_CONTACTS}, so the run has not come to an end (or is of "
                                  "a version without this file), and no state of a grain can be told; --restart goes "
                                  "on from its checkpoint.")  # fmt: skip
        finished, under_way = self.collisions(), self._contacts(OPEN_CONTACTS)
        under_way.end[:] = np.inf
        names = Collisions.__dataclass_fields__
        return Collisions(*(np.concatenate([getattr(c, name) for c in (finished, under_way)]) for name in names))

    def _contacts(self, table: str) -> Collisions:
        columns = self.collision_columns("tag_i", "tag_j", "time_start", "time_end", needed=True, table=table)
        return Collisions(columns[0].astype(int), columns[1].astype(int), columns[2], columns[3])

    def collision_columns(self, *names: str, needed: bool = False, table: str = COLLISIONS) -> np.ndarray:
        """Columns of the collision table by name, shape (number of names, collisions).

        A column that the table lacks is nan, or `needed`: raises MissingOutput.
        """
        path = self.folder / table
        with path.open(encoding="utf-8") if path.is_file() else open("/dev/null") as stream:
            header = [name.strip() for name in stream.readline().split(",")]
            if header == [""]:
                header = list(names)
            there = [name for name in names if name in header]
            if needed and len(there) < len(names):
                missing = next(name for name in names if name not in header)
                raise MissingOutput(f"{path} has no column '{missing}'.")
            lines = (line for line in _whole(stream) if line.count(",") + 1 == len(header))
            first = next(lines, None)
            if first is None or not there:
                return np.empty((len(names), 0))
            # loadtxt parses in C: a million rows in about two seconds.
            data = np.loadtxt(
                _chain(first, lines), delimiter=",", usecols=[header.index(n) for n in there], ndmin=2
            )
        columns = np.full((len(names), len(data)), np.nan)
        for name, values in zip(there, data.T, strict=True):
            columns[names.index(name)] = values
        return columns

    def _row_ranges(
        self, time: h5py.Dataset, rows: int, since: float
    ) -> Iterator[tuple[slice, np.ndarray]]:
        """Rows of whole instants from `since` on, about `rows` at a time, with their times."""
        count = time.shape[0]
        first = _first_row(time, since)
        while first < count:
            end = min(first + rows, count)
            times = time[first:end]
            whole = len(times)
            if end < count and time[end] == times[-1]:
                whole = int(np.searchsorted(times, times[-1]))
                if whole == 0:  # one instant has more rows than asked for
                    times = time[first : _first_row(time, np.nextafter(times[-1], np.inf))]
                    whole = len(times)
            yield slice(first, first + whole), times[:whole]
            first += whole

    def sample_blocks(self, rows: int = BLOCK_ROWS, since: float = -math.inf) -> Iterator[Samples]:
        """The mobile spheres' samples, about `rows` at a time, in the order of time.

        Only those from the time `since` on; an instant is never divided.
        """
        names = list(Samples.__dataclass_fields__)[1:]
        with self._mobile() as group:
            if group is not None:
                for part, time in self._row_ranges(group["time"], rows, since):
                    yield Samples(time, *(group[name][part] for name in names))

    def instants(
        self, rows: int = BLOCK_ROWS, since: float = -math.inf
    ) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Times and tags of the samples alone, in the same blocks."""
        with self._mobile() as group:
            if group is not None:
                for part, time in self._row_ranges(group["time"], rows, since):
                    yield time, group["tag"][part]

    def sample_times(self, rows: int = BLOCK_ROWS, since: float = -math.inf) -> np.ndarray:
        """The instants at which mobile spheres were sampled, in their order."""
        parts = [np.empty(0)]
        with self._mobile() as group:
            if group is not None:
                for _, time in self._row_ranges(group["time"], rows, since):
                    parts.append(time[np.diff(time, prepend=-math.inf) > 0])
        return np.concatenate(parts)

    @contextmanager
    def _mobile(self) -> Iterator[h5py.Group | None]:
        path = self.folder / "spheres.h5"
        if not path.is_file():
            if path.with_name("spheres.h5.part").is_file():
                raise MissingOutput(f"{path}.part is of a run that goes on or was cut off: its samples can be read "
                                    "when it has come to an end, if need be by --restart.")  # fmt: skip
            yield None
            return
        with open_hdf5(path) as file:
            yield file.get("mobile")

    def samples_of(self, tag: int, since: float = -math.inf) -> Samples:
        """All samples of one sphere."""
        parts = [block.rows(block.tag == tag) for block in self.sample_blocks(since=since)]
        if not sum(map(len, parts)):
            raise MissingOutput(f"{self.folder} has no samples of sphere {tag}.")
        names = Samples.__dataclass_fields__
        return Samples(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))

    def fixed_spheres(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres (n, 3) and radii (n) of the bed; empty where there is none."""
        path = self.folder / "spheres.h5"
        if path.is_file():
            with open_hdf5(path) as file:
                if "fixed" in file:
                    return file["fixed/position"][:].reshape(-1, 3), file["fixed/radius"][:]
        return np.empty((0, 3)), np.empty(0)

    def last_snapshot(self) -> Snapshot:
        """The fields of the latest snapshot."""
        path = self.folder / "fields.h5"
        if not path.is_file():
            raise MissingOutput(f"{self.folder} has no fields.h5.")
        with open_hdf5(path) as file:
            steps = sorted(name for name in file if name.startswith("step_"))
            if not steps:
                raise MissingOutput(f"{path} holds no snapshot.")
            group = file[steps[-1]]
            return Snapshot(
                int(group.attrs["step"]), float(group.attrs["time"]),
                *(file[f"grid/{axis}"][:] for axis in "xyz"),
                *(group[name][:] for name in "uvw"),
            )  # fmt: skip


@contextmanager
def open_hdf5(path: Path) -> Iterator[h5py.File]:
    """The file, to be read; raises MissingOutput where it or a part of it cannot be."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except OSError as error:
        raise MissingOutput(f"{path} cannot be read: {error}.") from error


def _whole(lines: Iterable[str]) -> Iterator[str]:
    """Lines without one that was broken off while it was written."""
    return (line for line in lines if line.endswith("\n"))


def _first_row(time: h5py.Dataset, since: float) -> int:
    """The first row at or after `since` in a table ordered by time (bisection on the disk)."""
    low, high = 0, time.shape[0]
    while low < high:
        middle = (low + high) // 2
        if time[middle] < since:
            low = middle + 1
        else:
            high = middle
    return low


def _numbers_or_text(column: tuple[str, ...]) -> np.ndarray:
    try:
        return np.array(column, dtype=float)
    except ValueError:
        return np.array(column, dtype=str)


def _chain(first: str, rest: Iterator[str]) -> Iterator[str]:
    yield first
    yield from rest
