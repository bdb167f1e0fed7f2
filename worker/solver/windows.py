"""The half cycle cut into equal windows, and the exact map across a window in which nothing happens.

Half a cycle is enough: mirrored (every sign of the mechanics flipped), the second half is the first. So the phase starts
at 0 again and again, and no digit is ever lost in sin(rτ) for large τ.
"""

from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from worker.jit import kernel
from worker.solver.memory import address
from worker.solver.taylor import TERMS, base_rows, motion_rows, slope, value

LARGEST_WINDOW = 0.4
"""Longest window in units of the faster of structure and excitation, for ζ → 0: keeps the Taylor remainder below rounding."""

# Gauss–Legendre on [0, 1], 5 points: exact to degree 9, error below 1e-13 of the integrand on the longest window.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
GAUSS_NODES: NDArray[np.float64] = 0.5 * (_NODES + 1.0)
GAUSS_WEIGHTS: NDArray[np.float64] = 0.5 * _WEIGHTS
GAUSS = 5


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
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of s for sin φ = 1 and for cos φ = 1.
    gauss : array, shape (GAUSS · 4,)
        s (0, 1) and s' (2, 3) at each quadrature point of a window, for sin φ = 1 and for cos φ = 1.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    gauss: NDArray[np.float64]


class Medium(NamedTuple):
    """The linear motion with one inertia: the primary mass alone, or with the particle riding on it.

    Attributes
    ----------
    compliance : float
        κ = 1 over the inertia.
    xx … wc : float
        Map of (x, w, sin φ, cos φ) at the start of a window to x and w at its end.
    relative, absolute : array, shape (4 · TERMS,)
        Taylor coefficients of x and of x + s for each unit start.
    gauss : array, shape (GAUSS · 8,)
        x (0 to 3) and w (4 to 7) at each quadrature point of a window for each unit start.
    """

    compliance: float
    xx: float
    xw: float
    xs: float
    xc: float
    wx: float
    ww: float
    ws: float
    wc: float
    relative: NDArray[np.float64]
    absolute: NDArray[np.float64]
    gauss: NDArray[np.float64]


@kernel
def make_base(damping_ratio, frequency_ratio):
    """Windows of half a cycle for ζ and r; window · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW."""
    half = pi / frequency_ratio
    count = ceil(half * (1.0 + damping_ratio) * max(1.0, frequency_ratio) / LARGEST_WINDOW)
    sine = np.empty(count + 1)
    cosine = np.empty(count + 1)
    for k in range(count + 1):
        sine[k] = sin(pi * (k / count))
        cosine[k] = cos(pi * (k / count))
    sine[count] = 0.0
    cosine[count] = -1.0
    window = half / count
    rows = base_rows(frequency_ratio)
    gauss = np.empty(GAUSS * 4)
    for i in range(GAUSS):
        for j in range(2):
            row = rows[j * TERMS : (j + 1) * TERMS]
            gauss[4 * i + j] = value(row, GAUSS_NODES[i] * window)
            gauss[4 * i + 2 + j] = slope(row, GAUSS_NODES[i] * window)
    return Base(frequency_ratio, 2.0 * damping_ratio, window, count, sine, cosine, rows, gauss)


@kernel
def make_medium(base, inertia):
    """Motion with one inertia, from the Taylor polynomials themselves."""
    relative, absolute = motion_rows(base.two_zeta, 1.0 / inertia, base.rows)
    h = base.window
    gauss = np.empty(GAUSS * 8)
    for i in range(GAUSS):
        for j in range(4):
            row = relative[j * TERMS : (j + 1) * TERMS]
            gauss[8 * i + j] = value(row, GAUSS_NODES[i] * h)
            gauss[8 * i + 4 + j] = slope(row, GAUSS_NODES[i] * h)
    return Medium(
        1.0 / inertia,
        value(relative[0 * TERMS : 1 * TERMS], h),
        value(relative[1 * TERMS : 2 * TERMS], h),
        value(relative[2 * TERMS : 3 * TERMS], h),
        value(relative[3 * TERMS : 4 * TERMS], h),
        slope(relative[0 * TERMS : 1 * TERMS], h),
        slope(relative[1 * TERMS : 2 * TERMS], h),
        slope(relative[2 * TERMS : 3 * TERMS], h),
        slope(relative[3 * TERMS : 4 * TERMS], h),
        relative,
        absolute,
        gauss,
    )


@kernel
def point_base(base):
    """The same base with addresses for arrays; the arrays must outlive it."""
    return Base(
        base.frequency_ratio,
        base.two_zeta,
        base.window,
        base.windows,
        address(base.sine, 0),
        address(base.cosine, 0),
        address(base.rows, 0),
        address(base.gauss, 0),
    )


@kernel
def point_medium(medium):
    """The same medium with addresses for arrays; the arrays must outlive it."""
    return Medium(
        medium.compliance,
        medium.xx,
        medium.xw,
        medium.xs,
        medium.xc,
        medium.wx,
        medium.ww,
        medium.ws,
        medium.wc,
        address(medium.relative, 0),
        address(medium.absolute, 0),
        address(medium.gauss, 0),
    )
