"""Scenes (folders with a fluid.toml) and collision models (inputs/models/*.liggghts)."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .build import ROOT
from .errors import UserError, unknown
from .override import override_table
from .script import Line, walk

INPUTS = ROOT / "inputs"
DEFAULT = "exposed_sphere"


@dataclass(frozen=True)
class Scene:
    """One scene: its folder, and what the folder says about it."""

    folder: Path
    other_script: Path | None = None  # run in the folder in place of its in.liggghts

    @property
    def name(self) -> str:
        """The folder's path under inputs/, or its own name where it stands elsewhere."""
        inside = self.folder.is_relative_to(INPUTS)
        return self.folder.relative_to(INPUTS).as_posix() if inside else self.folder.name

    @property
    def script(self) -> Path:
        return self.other_script or self.folder / "in.liggghts"

    @property
    def moves_grains(self) -> bool:
        """Without a LIGGGHTS script no LIGGGHTS is started."""
        return self.script.is_file()

    def has_spheres(self, overrides: Sequence[str] = ()) -> bool:
        """LIGGGHTS' or those of a file."""
        return self.moves_grains or bool(self.value("spheres", "file", overrides))

    def settings_text(self) -> str:
        """fluid.toml as it stands; raises UserError with the line where it is not UTF-8."""
        file = self.folder / "fluid.toml"
        try:
            return file.read_text(encoding="utf-8-sig")  # editors may put a mark in front, which TOML does not know
        except UnicodeDecodeError as error:
            line = error.object.count(b"\n", 0, error.start) + 1
            raise UserError(
                f"{file}: line {line} has the byte 0x{error.object[error.start]:02x}, but the file must be UTF-8."
            ) from error

    def settings(self) -> dict:
        """fluid.toml as nested tables; raises UserError where it is no TOML."""
        try:
            return tomllib.loads(self.settings_text())
        except tomllib.TOMLDecodeError as error:
            raise UserError(f"{self.folder / 'fluid.toml'}: {error}.") from error

    def value(self, table: str, key: str, overrides: Sequence[str] = ()):
        """One value of fluid.toml, or of the last of `overrides` that says otherwise.

        None where there is none; whether it is allowed, bedload-fluid says.
        """
        tables = [override_table(line) for line in reversed(overrides)] + [self.settings()]
        return next((found[table][key] for found in tables if key in within(found, table)), None)

    def default_model(self) -> str | None:
        """The model that the script, or a part that it includes, sets (`variable model index NAME`), if any."""
        settings = filter(None, (line.index_variable for line in self._lines(None)))
        return next((names.split()[0] for name, names in settings if name == "model" and names), None)

    def cells(self, overrides: Sequence[str] = ()) -> tuple[int, int, int]:
        """Cells along x, y and z, the last of `overrides` that says otherwise included."""
        nx, ny, nz = (int(n) for n in self._grid("cells", overrides))
        return nx, ny, nz

    def cell_size(self, overrides: Sequence[str] = ()) -> float:
        """h along x [L]."""
        return self._grid("length", overrides)[0] / self._grid("cells", overrides)[0]

    def lengths(self, overrides: Sequence[str] = ()) -> tuple[float, float, float]:
        """Lengths of the box along x, y and z [L]."""
        x, y, z = (float(length) for length in self._grid("length", overrides))
        return x, y, z

    def _grid(self, key: str, overrides: Sequence[str]) -> list[float]:
        said = [line for line in overrides if key in within(override_table(line), "grid")]
        values = self.value("grid", key, said)
        try:
            if len(values) == 3 and all(value > 0 for value in values):
                return values
        except TypeError:
            pass
        where = f"--set {said[-1]}" if said else str(self.folder / "fluid.toml")
        raise UserError(f"{where}: grid.{key} must be three numbers above 0.")

    def variables(self, given: Mapping[str, str] | None = None) -> dict[str, str]:
        """All `variable NAME index VALUE` of the script and of what it includes or jumps to, with their values.

        `given`: what the command line sets.
        """
        found = dict(given or {})
        settings = (line.index_variable for line in self._lines(given, jumps=True))
        return {name: found.setdefault(name, value) for name, value in filter(None, settings)}

    def reads(self, name: str, given: Mapping[str, str] | None = None) -> bool:
        """Whether LIGGGHTS may read the variable: a line of the script, or of what it includes or jumps to, has
        ${name}, v_name or `next name`, or leads to a file that is not known before the run.

        `given`: what the command line sets.
        """
        return any(line.lost or line.reads(name) for line in self._lines(given, jumps=True))

    def script_lines(self, given: Mapping[str, str] | None = None) -> Iterator[str]:
        """The script, with the lines of what it includes in the include's place.

        `given`: what the command line sets. An include that leads to no file, for its name holds an unknown
        variable, say, stays as it is. Raises UserError where a script includes itself.
        """
        return (line.text for line in self._lines(given) if not line.replaced)

    def counts_steps(self, model: str | None) -> bool:
        """Whether the script says how many fluid steps a coupled run has."""
        lines = self.script_lines({"model": model} if model else None)
        return any(line.split()[:2] == ["coupled_run", "steps"] for line in lines)

    def _lines(self, given: Mapping[str, str] | None, jumps: bool = False) -> Iterator[Line]:
        known = {"inputs": str(INPUTS)} | dict(given or {})
        return walk(self.script, self.folder, known, jumps) if self.moves_grains else iter(())

    def summary(self) -> str:
        """The first sentence of the scene's README, or what it says before a colon; its title left out."""
        readme = self.folder / "README.md"
        if not readme.is_file():
            return ""
        text = readme.read_text(encoding="utf-8", errors="replace")
        body = [part for part in re.split(r"\n\s*\n", text) if part.strip()[:1] not in ("#", "")]
        sentence = re.match(r".*?[.:](?=\s|$)", " ".join(body[0].split())) if body else None
        return sentence[0].rstrip(".:") + "." if sentence else ""


def within(settings: dict, table: str) -> dict:
    """A table of settings, empty where it is none."""
    found = settings.get(table)
    return found if isinstance(found, dict) else {}


def all_scenes() -> dict[str, Scene]:
    """The scenes under inputs/, those of inputs/validation included, by name."""
    files = [*sorted(INPUTS.glob("*/fluid.toml")), *sorted(INPUTS.glob("*/*/fluid.toml"))]
    return {scene.name: scene for scene in (Scene(file.parent) for file in files)}


def find_scene(name: str) -> Scene:
    """A scene by its name under inputs/, or any folder with a fluid.toml by its path."""
    if not name:
        raise UserError("SCENE is empty, but must be the name of a scene or a folder with a fluid.toml.")
    shipped = all_scenes()
    if name in shipped:
        return shipped[name]
    folder = Path(name)
    if (folder / "fluid.toml").is_file():
        return Scene(folder.resolve())
    if folder.is_dir():
        raise UserError(f"the folder {name} has no fluid.toml, so it is no scene.")
    raise unknown("scene", name, shipped)


def models() -> list[str]:
    return sorted(file.stem for file in (INPUTS / "models").glob("*.liggghts"))


def choose_model(scene: Scene, asked: str | None) -> str | None:
    """The model's name, or None where the scene has none to choose."""
    if asked is None:
        return scene.default_model()
    if not scene.moves_grains:
        raise UserError(
            f"scene '{scene.name}' has no in.liggghts, so --model {asked} says nothing."
        )
    if scene.default_model() is None:
        raise UserError(
            f"{scene.script} has no line 'variable model index NAME', so --model cannot change it."
        )
    own = sorted(file.stem for file in scene.folder.glob("models/*.liggghts"))
    if asked not in models() + own:
        raise unknown("model", asked, models() + own)
    if asked != scene.default_model() and not scene.reads("model", {"model": asked}):
        raise UserError(f"{scene.script} sets 'model' but no line reads ${{model}}, so --model {asked} says nothing.")
    return asked


def read_variables(scene: Scene, model: str | None, settings: Sequence[str]) -> dict[str, str]:
    """NAME=VALUE of --var, for a script that declares and reads NAME; LIGGGHTS would not miss the others."""
    given = {}
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise UserError(f"--var is '{text}', but must be NAME=VALUE.")
        given[name.strip()] = value.strip()
    if given and not scene.moves_grains:
        raise UserError(f"scene '{scene.name}' has no in.liggghts, so --var {settings[-1]} says nothing.")
    known = scene.variables(given | ({"model": model} if model else {}))
    if "model" in given:
        raise UserError(f"--var model={given['model']}: the model is chosen by --model.")
    if "out" in given:
        raise UserError(f"--var out={given['out']}: the folder is chosen by --out.")
    for name in given:
        if name not in known:
            raise unknown(f"variable of {scene.name}'s in.liggghts", name, known)
        if not scene.reads(name, given | ({"model": model} if model else {})):
            with_model = f" with model {model}" if model else ""
            raise UserError(f"--var {name}={given[name]} says nothing: no line of {scene.name}'s script reads "
                            f"{name}{with_model}.")  # fmt: skip
    return given
