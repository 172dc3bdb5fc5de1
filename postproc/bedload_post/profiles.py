"""Profiles of the flow over height, as statistics.h5 holds them."""

import math
from dataclasses import dataclass
from functools import cached_property

import h5py
import numpy as np

from .outputs import MissingOutput, Run


@dataclass(frozen=True)
class Profiles:
    """Averages over x, z and time: `columns` by the names of statistics.h5, `facts` its attributes.

    Lists at cell centres have as many entries as `y`, those at faces as many as `y_face`.
    """

    columns: dict[str, np.ndarray]
    facts: dict[str, float]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.columns[name]

    @cached_property
    def total_stress(self) -> np.ndarray:
        """Viscous and turbulent shear stress on the faces [M/(L T^2)]."""
        return self["viscous"] + self["turbulent"]

    def bed_stress(self, bed_top: float, clear: float) -> float:
        """tau at `bed_top`, extrapolated from above `clear`, where no sphere takes part in it.

        There the balance is tau = f (top - y) with f the driving force; f by least squares.
        """
        depth = self["y_face"][-1] - self["y_face"]
        rows = self["y_face"] >= clear
        if rows.sum() < 3:
            raise MissingOutput("statistics.h5 has no heights above the grains.")
        force = (self.total_stress[rows] * depth[rows]).sum() / (depth[rows] ** 2).sum()
        return force * (self["y_face"][-1] - bed_top)


def read_profiles(run: Run) -> Profiles:
    """Raises MissingOutput where the run kept no statistics."""
    path = run.folder / "statistics.h5"
    if not path.is_file():
        raise MissingOutput(f"{run.folder} has no statistics.h5 (statistics.every is 0).")
    with h5py.File(path, "r") as file:
        columns = {name: values[:] for name, values in file["profiles"].items()}
        facts = {name: value for name, value in file.attrs.items() if np.ndim(value) == 0}
    if facts.get("samples", 0) == 0:
        raise MissingOutput(f"{path} holds no samples yet.")
    return Profiles(columns, facts)


def friction_velocity(run: Run, since: float) -> tuple[float, str]:
    """u_tau [L/T] and where it is from: total stress at the bed's top, else the driving force.

    In the mean both are the same number: the driving force times the depth is what the bed with its
    grains takes up.
    """
    bed_top = run.box[1] - run.depth
    density = run.value("fluid.density")
    try:
        stress = read_profiles(run).bed_stress(bed_top, bed_top + 0.4 * run.depth)
        if stress > 0:
            return math.sqrt(stress / density), "total stress extrapolated to the bed's top"
    except MissingOutput:
        pass
    history = run.history()
    driving = history["driving"][history["time"] >= since]
    if len(driving) == 0 or driving.mean() <= 0:
        raise MissingOutput(f"history.csv of {run.folder} has no driving force after t = {since:g}.")
    return math.sqrt(driving.mean() * run.depth / density), "driving force times depth"
