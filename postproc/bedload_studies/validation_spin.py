"""Validation of spheres that are spun up, or released with a spin, in fluid at rest. No study of its own."""

import math

import h5py
import numpy as np

from .sphere_theory import RADIUS, spin_left, spun_up_torque
from .validation_runs import DIFFUSION, Curve, Result, Row, Runner, thin

TIMES = np.array([0.1, 0.25, 0.5, 1.0])  # nu t/R^2


def spin(runner: Runner) -> Result:
    """Torque on a sphere that turns at once, and spin of one released with it, rho_p/rho_f 0.5 to 8, in Stokes
    flow."""
    result = Result("A sphere spun up, or released with a spin, in fluid at rest",
                    axes=("nu t / R^2", "spin over that at the start"))  # fmt: skip
    result.remarks.append(
        "Exact: unsteady Stokes flow. The box is 3 D wide, so that later its images count. Errors of the spin are "
        "those of the spin at the start."
    )
    instants = TIMES * RADIUS**2
    for n in (8, 12, 16):
        step = DIFFUSION / n**2
        settings = {"grid.cells": [3 * n] * 3, "time.step": step, "time.end": 1.001 * float(instants[-1])}
        run = runner("rotation", f"spin-{n}-held", settings)
        with h5py.File(run.folder / "spheres.h5") as file:  # the torque is the mean over a step
            middles = file["mobile/time"][:] - 0.5 * step
            torque = -file["mobile/torque"][:, 2] / (16.0 * math.pi * RADIUS**3)
        # At 0.1 the boundary layer sqrt(nu t) is 1.3, 1.9 and 2.5 cells thick, less than the 1.5 cells by which the
        # kernel smears it at D/h = 8, and the torque follows the excess of the markers' spin within h^2/nu (0.06).
        for tau, found, exact in zip(TIMES, np.interp(instants, middles, torque), spun_up_torque(1.0, instants),
                                     strict=True):  # fmt: skip
            result.rows.append(Row(f"torque at nu t/R^2 = {tau:g} of a sphere spun up at once, D/h = {n}", float(found),
                                   float(exact), 0.02 if tau < 0.2 else 0.01, source="exact"))  # fmt: skip
        for density in (0.5, 1.0, 2.5, 8.0):
            run = runner("rotation", f"spin-{n}-{density}", settings, {"density": density, "motion": "nve/sphere"})
            motion = run.samples_of(1)
            time, left = motion.time, motion.angular_velocity[:, 2] / 2.0
            # The markers' layer takes part of the spin at once, and the sphere gets half of what is due a stage late:
            # worth 0.8 % of the start's while the layer is as thin as the kernel, 0.4 % later.
            for tau, found, exact in zip(TIMES, np.interp(instants, time, left), spin_left(density, 1.0, instants),
                                         strict=True):  # fmt: skip
                result.rows.append(Row(f"spin left at nu t/R^2 = {tau:g}, rho_p/rho_f = {density:g}, D/h = {n}",
                                       float(found), float(exact), 0.01 if tau < 0.2 else 0.005, 1.0,
                                       "exact"))  # fmt: skip
            if n == 8:
                points = thin(time / RADIUS**2, left, 40, digits=None)
                result.curves.append(Curve(f"rho_p/rho_f = {density:g}, D/h = 8", *points, points=True))
    across = np.linspace(0.0, 1.0, 200)
    for density in (0.5, 1.0, 2.5, 8.0):
        result.curves.append(Curve(f"exact, {density:g}", across.tolist(),
                                   spin_left(density, 1.0, across * RADIUS**2).tolist()))  # fmt: skip
    return result


CASES = {"spin": spin}
