"""Taylor polynomials of the motion between events.

Every regime is linear, so its closed form is an entire function whose Taylor coefficients follow from a two-term
recurrence without any transcendental function. Unlike the textbook form (particular plus homogeneous solution) it has no
cancellation next to resonance and none at ζ = 0, r = 1. Windows are short enough (see `windows.py`) for the remainder to
lie below rounding: 0.4^15/15! ≈ 8e-19.
"""

import numpy as np

from worker.jit import kernel

ORDER = 14
"""Degree of the polynomials of the displacements."""

_RECIPROCAL = 1.0 / np.arange(1, ORDER + 3)  # 1/(n+1)
_RECIPROCAL_PAIR = np.array([1.0 / ((n + 1) * (n + 2)) for n in range(ORDER + 1)])


@kernel
def expand_base(sine, cosine, frequency_ratio, base):
    """Coefficients of the base displacement s = sin(φ + r t) into `base`, from sin φ and cos φ."""
    base[0] = sine
    base[1] = frequency_ratio * cosine
    square = frequency_ratio * frequency_ratio
    for n in range(ORDER - 1):
        base[n + 2] = -square * _RECIPROCAL_PAIR[n] * base[n]


@kernel
def expand_slip(x, w, two_zeta, compliance, base, relative, absolute):
    """Coefficients of the motion in slip.

    Parameters
    ----------
    x, w : float
        Displacement from the centre of the (shifted) spring, v + σγ_F, and velocity, both relative to the base.
    two_zeta : float
        2ζ.
    compliance : float
        1 over the inertia: 1 for the primary mass alone, 1/(1 + β) with the particle attached.
    base : array, shape (ORDER + 1,)
        Coefficients of the base displacement.
    relative : array, shape (ORDER + 1,)
        Filled with the coefficients of x(t): x'' + κ(2ζ x' + x) = r² sin(φ + r t).
    absolute : array, shape (ORDER + 1,)
        Filled from n = 2 with those of the absolute displacement, whose acceleration is −κ(2ζ x' + x); the first two
        hold u + σγ_F and u'.
    """
    relative[0] = x
    relative[1] = w
    absolute[0] = x + base[0]
    absolute[1] = w + base[1]
    for n in range(ORDER - 1):
        absolute[n + 2] = -compliance * (
            two_zeta * _RECIPROCAL[n + 1] * relative[n + 1] + _RECIPROCAL_PAIR[n] * relative[n]
        )
        relative[n + 2] = absolute[n + 2] - base[n + 2]


@kernel
def expand_stick(v, base, relative, absolute):
    """Coefficients of the motion while friction holds the mass: v is constant, u = v + s."""
    relative[0] = v
    absolute[0] = v + base[0]
    absolute[1] = base[1]
    relative[1] = 0.0
    for n in range(2, ORDER + 1):
        relative[n] = 0.0
        absolute[n] = base[n]


@kernel
def value(polynomial, t):
    """Value of a polynomial at t; even and odd powers apart, so that the two chains of products overlap."""
    square = t * t
    even = polynomial[ORDER]
    odd = polynomial[ORDER - 1]
    for i in range(ORDER - 2, 0, -2):
        even = even * square + polynomial[i]
        odd = odd * square + polynomial[i - 1]
    return (even * square + polynomial[0]) + t * odd


@kernel
def slope(polynomial, t):
    """First derivative of a polynomial at t."""
    square = t * t
    even = (ORDER - 1) * polynomial[ORDER - 1]
    odd = ORDER * polynomial[ORDER]
    for i in range(ORDER - 3, 0, -2):
        even = even * square + i * polynomial[i]
        odd = odd * square + (i + 1) * polynomial[i + 1]
    return even + t * odd


@kernel
def derivative_into(polynomial, order, out):
    """Coefficients of the first (order = 1) or second derivative of a polynomial, zero-padded to the same length."""
    if order == 1:
        for i in range(ORDER):
            out[i] = (i + 1) * polynomial[i + 1]
        out[ORDER] = 0.0
    else:
        for i in range(ORDER - 1):
            out[i] = (i + 1) * (i + 2) * polynomial[i + 2]
        out[ORDER - 1] = 0.0
        out[ORDER] = 0.0
