"""How an amplitude rises from rest and falls back: smoothly enough that the acceleration of the base has no kink."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def ramps(time_s: Floats, duration_s: float, rise_s: float, fall_s: float) -> tuple[Floats, Floats, Floats]:
    """Give w and its first two derivatives in time: it rises from 0 to 1, stays, and falls back.

    Parameters
    ----------
    time_s : ndarray
        Times from 0 to the end [s].
    duration_s, rise_s, fall_s : float
        The whole, and both ramps, which do not overlap [s].
    """
    rise, rise_1, rise_2 = _step(time_s / rise_s)
    fall, fall_1, fall_2 = _step((duration_s - time_s) / fall_s)
    return (
        rise * fall,
        rise_1 / rise_s * fall - rise * fall_1 / fall_s,
        rise_2 / rise_s**2 * fall + rise * fall_2 / fall_s**2,
    )


def _step(share: Floats) -> tuple[Floats, Floats, Floats]:
    """Give a smooth step from 0 at 0 to 1 at 1 and its first two derivatives; the first three vanish at both ends."""
    s = np.clip(share, 0.0, 1.0)
    rest = 1.0 - s
    square, both = s * s, s * rest
    return (
        square * square * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s))),
        140.0 * both * both * both,
        420.0 * both * both * (1.0 - 2.0 * s),
    )
