"""The half cycle cut into equal windows, and the exact map across a window in which nothing happens.

Half a cycle is enough: mirrored (every sign of the mechanics flipped), the second half is the first. So the phase starts
at 0 again and again, and no digit is ever lost in sin(rτ) for large τ.
"""

from math import ceil, cos, pi, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.memory import address
from damperlab.worker.solver.motion.quadratic_forms import base_forms, medium_forms
from damperlab.worker.solver.motion.taylor import TERMS, base_rows, motion_rows, slope, value

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
    forms : array, shape (5,), or None
        Integrals over a window (`quadratic_forms.base_forms`); None where no meter asks for energies.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


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
    forms : array, shape (3 · PAIRS + 4,), or None
        Integrals over a window (`quadratic_forms.medium_forms`); None where no meter asks for energies.
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
    forms: NDArray[np.float64] | None


@kernel
def make_base(damping_ratio: float, frequency_ratio: float, energies: bool | None) -> Base:
    """Windows of half a cycle for ζ and r; window · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    energies : True or None
        As of the `state.Meter` of the march.
    """
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
    if energies is None:
        return Base(frequency_ratio, 2.0 * damping_ratio, window, count, sine, cosine, rows, None)
    forms = base_forms(rows, window)
    return Base(frequency_ratio, 2.0 * damping_ratio, window, count, sine, cosine, rows, forms)


@kernel
def make_medium(base: Any, inertia: float, energies: bool | None) -> Medium:
    """Motion with one inertia, from the Taylor polynomials themselves; `energies` as for `make_base`."""
    relative, absolute = motion_rows(base.two_zeta, 1.0 / inertia, base.rows)
    h = base.window
    if energies is None:
        return _medium(relative, absolute, None, inertia, h)
    forms = medium_forms(base.two_zeta, base.rows, relative, absolute, h)
    return _medium(relative, absolute, forms, inertia, h)


@kernel
def _medium(
    relative: NDArray[np.float64],
    absolute: NDArray[np.float64],
    forms: NDArray[np.float64] | None,
    inertia: float,
    h: float,
) -> Medium:
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
        forms,
    )


@inlined
def _address_if(array: NDArray[np.float64] | None) -> Any:
    """Address of an array that may be absent."""
    if array is None:
        return None
    return address(array, 0)


@inlined
def sine_base_on_addresses(base: Base) -> Base:
    """The same base with addresses for arrays; the arrays must outlive it."""
    return Base(
        base.frequency_ratio,
        base.two_zeta,
        base.window,
        base.windows,
        address(base.sine, 0),
        address(base.cosine, 0),
        address(base.rows, 0),
        _address_if(base.forms),
    )


@inlined
def medium_on_addresses(medium: Medium) -> Medium:
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
        _address_if(medium.forms),
    )
