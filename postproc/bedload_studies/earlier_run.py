"""Where an earlier run ended, as the start of the next one: its flow, at any resolution, and its grains."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from bedload_launcher.errors import UserError
from bedload_launcher.scenes import Scene
from bedload_post.outputs import MissingOutput, Run

from .grains_file import write_grains

GRAINS = "grains.liggghts"  # in the new run's folder, where inputs/beds/placed.liggghts looks for it


@dataclass(frozen=True)
class EarlierRun:
    """A run's folder in which the flow of its end was kept.

    Raises UserError for a folder without it, and for grains that the new scene's script cannot place.
    """

    folder: Path

    @classmethod
    def of(cls, folder: Path) -> "EarlierRun":
        if not (folder / "state.h5").is_file():
            raise UserError(f"--start-from: {folder} has no state.h5, the flow at a run's end.")
        return cls(folder.resolve())

    def keys(self) -> list[str]:
        """Of fluid.toml, for its flow."""
        return ['start.from="state"', f'start.file="{self.folder / "state.h5"}"']

    def variables(self, scene: Scene) -> dict[str, str]:
        """Of in.liggghts, for its grains."""
        if not scene.moves_grains:
            return {}
        if "placing" not in scene.variables():
            raise UserError(f"--start-from: {scene.script} has no line 'variable placing index NAME', as "
                            "inputs/beds/open_channel.liggghts needs it, so its grains cannot begin where a run "
                            "left them.")  # fmt: skip
        return {"placing": "placed"}

    def place(self, out: Path) -> None:
        """Writes the grains into the new run's folder, unless they are there."""
        file = out / GRAINS
        if file.is_file():
            return
        try:
            write_grains(Run(self.folder), file)
        except MissingOutput as missing:
            raise UserError(f"--start-from: {missing}") from missing


def add_start_from(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--start-from", type=Path, metavar="RUN",
        help="a run of this scene, at any resolution: flow and grains of all runs begin as it ended",
    )  # fmt: skip
