"""A weightless particle between two walls that move as sin(r tau) +- delta.

The limit of the hybrid damper for a mass that moves with the base (locked by friction) and mass ratio 0.
C. N. Bapat, N. Popplewell and K. McLachlan, Stable periodic motions of an impact-pair, J. Sound and
Vibration 87 (1983). All phases are those of the base, in radians.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq  # type: ignore[import-untyped]


@dataclass(frozen=True)
class BoxOrbit:
    """A symmetric motion with one impact at each wall per period.

    ``phase`` is that of the impact at the wall u - p = +delta; speeds are per unit of tau.
    """

    phase: float
    particle_speed: float
    impact_speed: float
    multipliers: tuple[complex, complex]  # over one period


def plastic_orbit(r: float, delta: float) -> BoxOrbit:
    """Return the motion for restitution 0: the particle rides, leaves at the wall's highest speed, and lands.

    It leaves a wall at phase 0 or pi, where the wall's acceleration changes sign, with speed r, and meets the
    other after the phase x of x - sin x = 2 delta, at the relative speed r (1 - cos x). It stays there until
    that wall lets go. Valid for x <= pi, that is delta <= pi/2. The landing wipes out the past: both
    multipliers are 0.
    """
    if not 0 < delta <= math.pi / 2:
        raise ValueError(
            f"delta = {delta} must be in (0, pi/2]: beyond, the particle lands on a receding wall"
        )
    x = float(brentq(lambda y: y - math.sin(y) - 2 * delta, 0, math.pi + 1e-9, xtol=1e-15))
    return BoxOrbit(math.pi + x, r, r * (1 - math.cos(x)), (0j, 0j))


def rebound_orbits(r: float, delta: float, restitution: float) -> list[BoxOrbit]:
    """Return the symmetric motions that rebound once from each wall in each period (none, one or two).

    With q the particle's speed per radian: q = 2 (delta - sin phi)/pi by the flight, and
    cos phi = q (1 - e)/(1 + e) by restitution. Two such phases, or none. Motions where the particle would
    leave the box between are left out. The multipliers are those of the impact map's square, exact.
    """
    e = restitution
    k = 2 * (1 - e) / (math.pi * (1 + e))
    ratio = k * delta / math.hypot(1, k)
    if abs(ratio) > 1:
        return []
    shift = math.atan2(1, k)
    found = []
    for angle in (math.asin(ratio), math.pi - math.asin(ratio)):
        phi = angle - shift
        q = 2 * (delta - math.sin(phi)) / math.pi
        x = np.linspace(0, math.pi, 4001)[1:-1]
        gap = np.sin(phi + x) - (math.sin(phi) - delta + q * x)
        if q <= 0 or np.any(np.abs(gap) >= delta):
            continue
        wall = math.cos(phi)  # speed of the wall per radian; minus that at the next impact
        # Next impact: (q - wall') dphase' = (q - wall) dphase - pi dq, and q' = e q - (1 + e) wall' with the
        # sign of the second half turned back.
        later = np.array([q - wall, -math.pi]) / (q + wall)
        step = np.array([later, -(1 + e) * math.sin(phi) * later + np.array([0.0, e])])
        multipliers = np.linalg.eigvals(step) ** 2
        first, second = sorted((complex(m) for m in multipliers), key=abs, reverse=True)
        found.append(BoxOrbit(phi % (2 * math.pi), q * r, (q + wall) * r, (first, second)))
    return found
