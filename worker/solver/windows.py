"""The half cycle cut into equal windows, and the exact map across a window in which nothing happens.

Half a cycle is enough: mirrored (every sign of the mechanics flipped), the second half is the first. So the phase starts
at 0 again and again, and no digit is ever lost in sin(rτ) for large τ.
"""

from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np

from worker.jit import kernel
from worker.solver.taylor import ORDER, expand_base, expand_slip, slope, value

LARGEST_WINDOW = 0.4
"""Longest window in units of the faster of structure and excitation, for ζ → 0: keeps the Taylor remainder below rounding."""


class Base(NamedTuple):
    """The shaken base over half a cycle.

    Attributes
    ----------
    frequency_ratio, two_zeta : float
        r and 2ζ.
    window : float
        Length of a window [1/ω_n].
    windows : int
        Windows per half cycle.
    sine, cosine : array, shape (windows + 1,)
        sin φ and cos φ at the window ends.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: np.ndarray
    cosine: np.ndarray


class Medium(NamedTuple):
    """The linear motion with one inertia: the primary mass alone, or with the particle riding on it.

    Attributes
    ----------
    compliance : float
        κ = 1 over the inertia.
    xx, xw, wx, ww : float
        Map of (x, w) across a window without forcing.
    forced_x, forced_w : array, shape (windows,)
        What the base adds across window k.
    """

    compliance: float
    xx: float
    xw: float
    wx: float
    ww: float
    forced_x: np.ndarray
    forced_w: np.ndarray


@kernel
def make_base(damping_ratio, frequency_ratio):
    """Windows of half a cycle for ζ and r; window · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW."""
    half = pi / frequency_ratio
    count = int(ceil(half * (1.0 + damping_ratio) * max(1.0, frequency_ratio) / LARGEST_WINDOW))
    sine = np.empty(count + 1)
    cosine = np.empty(count + 1)
    for k in range(count + 1):
        sine[k] = sin(pi * (k / count))
        cosine[k] = cos(pi * (k / count))
    sine[count] = 0.0
    cosine[count] = -1.0
    return Base(frequency_ratio, 2.0 * damping_ratio, half / count, count, sine, cosine)


@kernel
def make_medium(base, inertia):
    """Map across each window for one inertia, from the Taylor polynomials themselves."""
    compliance = 1.0 / inertia
    still = np.zeros(ORDER + 1)
    shaken = np.empty(ORDER + 1)
    relative = np.empty(ORDER + 1)
    absolute = np.empty(ORDER + 1)
    h = base.window
    expand_slip(1.0, 0.0, base.two_zeta, compliance, still, relative, absolute)
    xx = value(relative, h)
    wx = slope(relative, h)
    expand_slip(0.0, 1.0, base.two_zeta, compliance, still, relative, absolute)
    xw = value(relative, h)
    ww = slope(relative, h)
    forced_x = np.empty(base.windows)
    forced_w = np.empty(base.windows)
    for k in range(base.windows):
        expand_base(base.sine[k], base.cosine[k], base.frequency_ratio, shaken)
        expand_slip(0.0, 0.0, base.two_zeta, compliance, shaken, relative, absolute)
        forced_x[k] = value(relative, h)
        forced_w[k] = slope(relative, h)
    return Medium(compliance, xx, xw, wx, ww, forced_x, forced_w)
