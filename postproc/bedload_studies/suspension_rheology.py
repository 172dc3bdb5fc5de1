"""What a bed of grains carries in a laminar flow if it is a suspension with the rheology that was measured in shear
cells. A reference for validation_erosion.py and validation_erosion_law.py; no study of its own.

F. Boyer, E. Guazzelli, O. Pouliquen, Phys. Rev. Lett. 107 (2011) 188301: under the grains' pressure P, with the viscous
number J = mu gamma/P (gamma: shear rate),

    stress/P = 0.32 + 0.38/(1 + 0.005/J) + J + 5/2 phi_m sqrt(J),    phi = phi_m/(1 + sqrt(J)),    phi_m = 0.585.

Lengths here are in diameters, stresses in the submerged weight W = (rho_p - rho_f) g D, rates in W/mu, fluxes for a
unit width in Ga^2 nu.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid
from scipy.optimize import brentq

AT_REST, FAST, PACKED = 0.32, 0.7, 0.585
LAYERS = 2000  # of the bed, of equal height


def friction(viscous_number: float) -> float:
    """Stress over the grains' pressure."""
    slow = AT_REST + (FAST - AT_REST) / (1.0 + 0.005 / viscous_number)
    return slow + viscous_number + 2.5 * PACKED * math.sqrt(viscous_number)


def viscous_number(ratio: float) -> float:
    """J at which stress over pressure is `ratio`; 0 where friction at rest bears it."""
    if ratio <= AT_REST * (1.0 + 1e-9):
        return 0.0
    return math.exp(brentq(lambda log: friction(math.exp(log)) - ratio, -40.0, math.log(10.0 + 2.0 * ratio)))


@dataclass(frozen=True)
class MovingBed:
    """A bed that flows under a stress: what is there where the clear fluid begins, and what it carries."""

    stress: float  # W
    speed: float  # D W/mu
    flux: float  # Ga^2 nu


def moving_bed(stress: float, force: float, clear: float, depth: float) -> MovingBed:
    """Bed of `depth` under a stress at its upper end that grows by `force` per length downwards, which drives fluid and
    grains; `clear`: grains' share of the volume at which the clear fluid begins."""
    height, pressure = depth / LAYERS, 1e-6
    shares, rates = np.empty(LAYERS + 1), np.empty(LAYERS + 1)
    for k in range(LAYERS + 1):
        number = viscous_number((stress + force * k * height) / pressure)
        shares[k], rates[k] = PACKED / (1.0 + math.sqrt(number)), number * pressure
        pressure += height * shares[k]
    steps = 0.5 * height * (rates[1:] + rates[:-1])
    speed = np.append(np.cumsum(steps[::-1])[::-1], 0.0)  # from the floor up
    top = int(np.argmax(shares >= clear))
    return MovingBed(stress + force * top * height, float(speed[top]), float(trapezoid(shares * speed, dx=height)))


@dataclass(frozen=True)
class BedUnderFlow:
    """What a plane laminar flow makes of a bed."""

    flux: float  # of the grains, Ga^2 nu
    wall_stress: float  # of the wall above, W


def bed_under_flow(fluid_flux: float, height: float, clear: float, depth: float) -> BedUnderFlow:
    """A plane flow of `fluid_flux` [Ga^2 nu] in a clear height [D] below a wall: with the force G and the speed u of
    the bed's top the fluid carries u h/2 + G h^3/12, and the stress is G h/2 - u/h at the bed and G h/2 + u/h at the
    wall."""
    speed, stress = 0.0, 6.0 * fluid_flux / height**2
    for _ in range(60):
        force = 12.0 * (fluid_flux - 0.5 * speed * height) / height**3
        at_bed = 0.5 * force * height - speed / height
        bed = moving_bed(stress, force, clear, depth)
        change = abs(bed.speed - speed)
        stress += at_bed - bed.stress
        speed = 0.5 * (speed + bed.speed)
        if change < 1e-4 * bed.speed and abs(at_bed - bed.stress) < 1e-4 * at_bed:
            break
    return BedUnderFlow(bed.flux, 0.5 * force * height + speed / height)
