"""Free decay of an oscillator with Coulomb and viscous damping."""

from __future__ import annotations

import math


def turning_points(zeta: float, gamma: float, start: float) -> list[float]:
    """Return |v| at the turning points of v'' + 2 zeta v' + v + gamma Sgn(v') = 0, from rest at `start` > 0.

    Each half cycle, of duration pi/sqrt(1 - zeta^2), swings about the offset centre gamma:
    x_next = (x - gamma) exp(-zeta pi/sqrt(1 - zeta^2)) - gamma, so for zeta = 0 exactly 2 gamma is lost
    (Lorenz 1924; Den Hartog, Mechanical Vibrations). Ends with the first point inside the dead band,
    |x| <= gamma, where the mass stays. A negative entry means that the mass stops before the middle, on the
    side from which it came. Valid for gamma > 0.
    """
    if gamma <= 0:
        raise ValueError(f"gamma = {gamma} must be > 0: without friction the motion does not end")
    shrink = math.exp(-zeta * half_period(zeta))
    points = [start]
    while points[-1] > gamma:
        points.append((points[-1] - gamma) * shrink - gamma)
    return points


def half_period(zeta: float) -> float:
    """Return the time from one turning point to the next, pi/sqrt(1 - zeta^2), in units of 1/omega_n."""
    return math.pi / math.sqrt(1 - zeta**2)
