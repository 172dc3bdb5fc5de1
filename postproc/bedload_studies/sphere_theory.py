"""What theory says of one sphere in fluid at rest, in D = U = rho_f = 1. No study of its own.

Formulas that the hard cases and the accuracy study compare with; radius 1/2, `density` is rho_p/rho_f,
`viscosity` nu = 1/Re.
"""

import math

import numpy as np
from scipy.special import erfcx, wofz

RADIUS = 0.5
VOLUME = math.pi / 6.0


def standard_drag_coefficient(reynolds: float) -> float:
    """Schiller and Naumann (1933), Re < 800, within 5 %."""
    return 24.0 / reynolds * (1.0 + 0.15 * reynolds**0.687)


def random_array_drag(fraction: float, reynolds: float) -> float:
    """Drag K over 3 pi mu D U of a sphere among others at random places, pressure gradient included, U the superficial
    velocity, Re = U D/nu up to 1000.

    Beetstra, van der Hoef and Kuipers (AIChE J. 53, 2007) fitted this to their simulations, within 8 %, for the part
    (1 - phi) K that the mean pressure gradient has no share in.
    """
    fluid = 1.0 - fraction
    viscous = 10.0 * fraction / fluid**2 + fluid**2 * (1.0 + 1.5 * math.sqrt(fraction))
    if reynolds == 0.0:
        return viscous / fluid
    share = (1.0 / fluid + 3.0 * fraction * fluid + 8.4 * reynolds**-0.343) / (
        1.0 + 10.0 ** (3.0 * fraction) * reynolds ** (-0.5 - 2.0 * fraction)
    )
    return (viscous + 0.413 * reynolds / (24.0 * fluid**2) * share) / fluid


def random_array_drag_tenneti(fraction: float, reynolds: float) -> float:
    """The same by Tenneti, Garg and Subramaniam (Int. J. Multiphase Flow 37, 2011), fraction 0.1 to 0.5, Re up to
    300."""
    fluid = 1.0 - fraction
    alone = 1.0 + 0.15 * reynolds**0.687
    viscous = 5.81 * fraction / fluid**3 + 0.48 * fraction ** (1.0 / 3.0) / fluid**4
    return alone / fluid**3 + viscous + fraction**3 * reynolds * (0.95 + 0.61 * fraction**3 / fluid**2)


def square_duct_drag(ratio: float) -> float:
    """Drag over Stokes's of a sphere on the axis of an infinite square duct, without inertia, for `ratio` of
    radius to half the width up to 0.2.

    First term: Happel and Brenner (1983), ch. 7; the next is that of a round tube (Haberman and Sayre 1958),
    worth 1 % at 0.15. Inertia can only add to it: of all flows with the same motion of the walls Stokes flow
    dissipates least (Helmholtz).
    """
    return 1.0 / (1.0 - 1.903 * ratio + 2.087 * ratio**3)


def kicked_speed(density: float, viscosity: float, time: float, history: bool, steps: int = 400) -> float:
    """Speed at `time` of a sphere that is suddenly given the speed 1 in fluid at rest.

        (rho_p + 1/2) V dU/dt = -F_drag(U) - 6 R^2 sqrt(pi nu) int_0^t U'(s)/sqrt(t - s) ds,

    with the jump to its share rho_p/(rho_p + 1/2) at t = 0 (added mass) in the integral. Without the
    integral the drag of the steady boundary layer alone; with it that of a layer that only diffuses
    (Basset), which at Re > 0 is too much: the truth lies between.
    """
    dt = time / steps
    speed = density / (density + 0.5)
    jumps, instants = np.zeros(steps + 1), np.zeros(steps + 1)
    jumps[0] = speed
    basset = 6.0 * RADIUS**2 * math.sqrt(math.pi * viscosity)
    for n in range(steps):
        now = (n + 0.5) * dt
        reynolds = max(speed / viscosity, 1e-12)
        force = 0.125 * math.pi * speed**2 * standard_drag_coefficient(reynolds)
        if history:
            force += basset * float(np.sum(jumps[: n + 1] / np.sqrt(now - instants[: n + 1])))
        change = -force * dt / ((density + 0.5) * VOLUME)
        jumps[n + 1], instants[n + 1] = change, now
        speed += change
    return speed


def spin_left(density: float, viscosity: float, times: np.ndarray) -> np.ndarray:
    """Share of its spin that a sphere has left at `times` after it was suddenly given in fluid at rest.

        I w' = -8 pi mu R^3 (w + 1/3 int_0^t w'(s) K(t - s) ds),
        K(s) = R/sqrt(pi nu s) - exp(nu s/R^2) erfc(sqrt(nu s)/R),

    unsteady Stokes flow (Feuillebois and Lasek, Q. J. Mech. Appl. Math. 31 (1978) 435), the jump at t = 0 in the
    integral. The Laplace transform in nu t/R^2 is, with q^2 its variable and a = 5/density,

        (1 + q)/(q^3 + (1 + a) q^2 + 3 a q + 3 a) = sum A/(q - r) over the roots r,

    and A/(q - r) is that of A r exp(r^2 t) erfc(-r sqrt(t)), as sum A = 0.
    """
    a = 5.0 / density
    roots = np.roots([1.0, 1.0 + a, 3.0 * a, 3.0 * a])
    shares = (1.0 + roots) / (3.0 * roots**2 + 2.0 * (1.0 + a) * roots + 3.0 * a)
    root_time = np.sqrt(viscosity * np.asarray(times)) / RADIUS
    # exp(z^2) erfc(z) = wofz(i z), z = -r sqrt(t).
    return np.real(wofz(-1j * np.multiply.outer(root_time, roots)) @ (shares * roots))


def spun_up_torque(viscosity: float, times: np.ndarray) -> np.ndarray:
    """Torque over 8 pi mu R^3 omega on a sphere that turns at omega from t = 0 on, in fluid at rest before:
    1 + K/3 of `spin_left`."""
    root_time = np.sqrt(viscosity * np.asarray(times)) / RADIUS
    return 1.0 + (1.0 / (math.sqrt(math.pi) * root_time) - erfcx(root_time)) / 3.0


def wet_restitution(stokes: float, dry: float = 0.97) -> float:
    """Rebound speed over impact speed on a wall, St = (rho_p + 1/2) u D/(9 nu): exp(-35/St) times the dry
    value (Legendre, Daniel, Guiraud, Phys. Fluids 17 (2005) 097105); experiments scatter by 0.1."""
    return dry * math.exp(-35.0 / stokes)


def film_speed(weight: float, gap: float, viscosity: float, least_gap: float = 1e-3 * RADIUS) -> float:
    """Speed at which a sphere under `weight` closes a small gap to a wall: W = 6 pi mu R^2 u/gap, the
    gap taken as at least `least_gap` (gapMin of fix lubrication)."""
    return weight * max(gap, least_gap) / (6.0 * math.pi * viscosity * RADIUS**2)
