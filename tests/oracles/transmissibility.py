"""Steady response of the structure without friction and without a particle."""

from __future__ import annotations

import math


def absolute_amplitude(zeta: float, r: float) -> float:
    """Return X/Z of v'' + 2 zeta v' + v = r^2 sin(r tau), u = v + sin(r tau).

    X/Z = sqrt[(1 + (2 zeta r)^2) / ((1 - r^2)^2 + (2 zeta r)^2)], the motion transmissibility of every
    vibration textbook (Den Hartog, Mechanical Vibrations, section 2.12). The formula is valid for any
    zeta > 0, and for zeta = 0 away from r = 1.
    """
    drag = 2 * zeta * r
    return math.sqrt((1 + drag**2) / ((1 - r**2) ** 2 + drag**2))


def relative_amplitude(zeta: float, r: float) -> float:
    """Return |x - z|/Z = r^2 / sqrt[(1 - r^2)^2 + (2 zeta r)^2], valid where `absolute_amplitude` is valid."""
    return r**2 / math.hypot(1 - r**2, 2 * zeta * r)
