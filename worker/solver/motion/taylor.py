"""Taylor polynomials of the motion between events.

Every regime is linear, so its solution is an entire function. The Taylor coefficients follow from a two-term recurrence
without transcendental functions. Unlike the textbook form (particular plus homogeneous solution), the recurrence has no
cancellation near resonance or at ζ = 0, r = 1. Panels are short enough for the remainder to lie below rounding:
0.4^16/16! ≈ 2e-20.

The coefficients are linear in (x, w, sin φ, cos φ) at the start of a segment. The recurrence is therefore
evaluated only once per motion, in turn for a unit value of x, w, sin φ and cos φ. The coefficients of a
segment are a weighted sum of the four rows that result; the processor computes this sum with vector
instructions.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.array_loops import filled, zero_matrix

ORDER = 15
"""Degree of the polynomials; sixteen coefficients fill vector registers of any width."""

TERMS = ORDER + 1

LARGEST_WINDOW = 0.4
"""Longest panel for which the Taylor remainder is below rounding, for ζ → 0. The unit of time is 1 over the higher of
the frequencies of structure and excitation.
"""


@kernel
def base_rows(frequency_ratio: float) -> NDArray[np.float64]:
    """Taylor coefficients of cos(r t) and sin(r t), the factors of sin φ and cos φ in sin(φ + r t)."""
    rows = filled(2 * TERMS, 0.0)
    rows[0] = 1.0
    rows[TERMS + 1] = frequency_ratio
    for n in range(TERMS - 2):
        factor = -frequency_ratio * frequency_ratio / ((n + 1) * (n + 2))
        rows[n + 2] = factor * rows[n]
        rows[TERMS + n + 2] = factor * rows[TERMS + n]
    return rows


@kernel
def motion_rows(
    two_zeta: float, compliance: float, excitation: Floats, displacement: float, force: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coefficients of the slipping motion for a unit value of each of x, w, sin φ and cos φ at the start.

    Parameters
    ----------
    two_zeta : float
        2ζ.
    compliance : float
        κ, 1 over the inertia: 1 for the primary mass alone, 1/(1 + β) with the particle attached.
    excitation : array, shape (2 · TERMS,)
        Taylor coefficients of the excitation.
    displacement, force : float
        Ratios of s, and of the force g on the structure, to the excitation.

    Returns
    -------
    relative, absolute : arrays, shape (4 · TERMS,)
        `relative` is for x = v + σγ_F, the displacement from the shifted spring centre, with x'' = −s'' + κ(g − 2ζ x' −
        x). `absolute` is for x + s. The acceleration κ(g − 2ζ x' − x) of x + s is computed directly, because for r ≫ 1
        the accelerations of x and s would cancel.
    """
    relative = zero_matrix(4, TERMS)
    absolute = zero_matrix(4, TERMS)
    relative[0, 0] = 1.0
    relative[1, 1] = 1.0
    for row in range(4):
        absolute[row, 0] = relative[row, 0]
        absolute[row, 1] = relative[row, 1]
        for n in range(TERMS):
            of_base = displacement * excitation[(row - 2) * TERMS + n] if row >= 2 else 0.0
            if n < 2:
                absolute[row, n] += of_base
            else:
                of_force = force * excitation[(row - 2) * TERMS + n - 2] if row >= 2 else 0.0
                absolute[row, n] = -compliance * (
                    two_zeta * relative[row, n - 1] / n + (relative[row, n - 2] - of_force) / (n * (n - 1))
                )
                relative[row, n] = absolute[row, n] - of_base
    return relative.reshape(-1), absolute.reshape(-1)


@inlined
def combine(x: float, w: float, sine: float, cosine: float, rows: Floats, out: Floats) -> None:
    """Write the coefficients of a segment, a weighted sum of the four rows of its motion."""
    for n in range(TERMS):
        out[n] = (x * rows[n] + w * rows[TERMS + n]) + (
            sine * rows[2 * TERMS + n] + cosine * rows[3 * TERMS + n]
        )


@inlined
def stick(v: float, relative: Floats, absolute: Floats) -> None:
    """Write the coefficients of the motion of a mass that friction holds at a constant v.

    On entry, `absolute` contains the coefficients of s.
    """
    for n in range(TERMS):
        relative[n] = 0.0
    relative[0] = v
    absolute[0] += v


@inlined
def value(p: Floats, t: float) -> float:
    """Value of a polynomial at t, by Estrin's scheme, which shortens the chain of dependent operations."""
    t2 = t * t
    t4 = t2 * t2
    a = (p[0] + p[1] * t) + (p[2] + p[3] * t) * t2
    b = (p[4] + p[5] * t) + (p[6] + p[7] * t) * t2
    c = (p[8] + p[9] * t) + (p[10] + p[11] * t) * t2
    d = (p[12] + p[13] * t) + (p[14] + p[15] * t) * t2
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def change(p: Floats, t: float) -> float:
    """Value of a polynomial at t minus its value at 0, computed without cancellation."""
    t2 = t * t
    t4 = t2 * t2
    a = p[1] * t + (p[2] + p[3] * t) * t2
    b = (p[4] + p[5] * t) + (p[6] + p[7] * t) * t2
    c = (p[8] + p[9] * t) + (p[10] + p[11] * t) * t2
    d = (p[12] + p[13] * t) + (p[14] + p[15] * t) * t2
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def beyond_tangent(p: Floats, t: float) -> float:
    """Value of a polynomial at t minus the tangent at 0, computed without cancellation."""
    t2 = t * t
    t4 = t2 * t2
    a = (p[2] + p[3] * t) * t2
    b = (p[4] + p[5] * t) + (p[6] + p[7] * t) * t2
    c = (p[8] + p[9] * t) + (p[10] + p[11] * t) * t2
    d = (p[12] + p[13] * t) + (p[14] + p[15] * t) * t2
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def curvature_bound(p: Floats, t: float) -> float:
    """Bound on the second derivative of a polynomial over [0, t]: Σ n (n − 1) |pₙ| tⁿ⁻²."""
    t2 = t * t
    t4 = t2 * t2
    a = (2.0 * abs(p[2]) + 6.0 * abs(p[3]) * t) + (12.0 * abs(p[4]) + 20.0 * abs(p[5]) * t) * t2
    b = (30.0 * abs(p[6]) + 42.0 * abs(p[7]) * t) + (56.0 * abs(p[8]) + 72.0 * abs(p[9]) * t) * t2
    c = (90.0 * abs(p[10]) + 110.0 * abs(p[11]) * t) + (132.0 * abs(p[12]) + 156.0 * abs(p[13]) * t) * t2
    d = 182.0 * abs(p[14]) + 210.0 * abs(p[15]) * t
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def slope(p: Floats, t: float) -> float:
    """First derivative of a polynomial at t."""
    t2 = t * t
    t4 = t2 * t2
    a = (p[1] + 2.0 * p[2] * t) + (3.0 * p[3] + 4.0 * p[4] * t) * t2
    b = (5.0 * p[5] + 6.0 * p[6] * t) + (7.0 * p[7] + 8.0 * p[8] * t) * t2
    c = (9.0 * p[9] + 10.0 * p[10] * t) + (11.0 * p[11] + 12.0 * p[12] * t) * t2
    d = (13.0 * p[13] + 14.0 * p[14] * t) + 15.0 * p[15] * t2
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def curvature(p: Floats, t: float) -> float:
    """Second derivative of a polynomial at t."""
    t2 = t * t
    t4 = t2 * t2
    a = (2.0 * p[2] + 6.0 * p[3] * t) + (12.0 * p[4] + 20.0 * p[5] * t) * t2
    b = (30.0 * p[6] + 42.0 * p[7] * t) + (56.0 * p[8] + 72.0 * p[9] * t) * t2
    c = (90.0 * p[10] + 110.0 * p[11] * t) + (132.0 * p[12] + 156.0 * p[13] * t) * t2
    d = 182.0 * p[14] + 210.0 * p[15] * t
    return (a + b * t4) + (c + d * t4) * (t4 * t4)


@inlined
def rate_into(p: Floats, dropped: int, out: Floats) -> None:
    """Write the coefficients of the first derivative of a polynomial, divided by t^dropped.

    The `dropped` lowest coefficients are left out.
    """
    if dropped == 0:  # the common case, in which the compiler knows the length of the loop
        for i in range(ORDER):
            out[i] = (i + 1) * p[i + 1]
        out[ORDER] = 0.0
        return
    for i in range(ORDER - dropped):
        out[i] = (i + dropped + 1) * p[i + dropped + 1]
    for i in range(ORDER - dropped, TERMS):
        out[i] = 0.0


@inlined
def acceleration_into(p: Floats, out: Floats) -> None:
    """Write the coefficients of the second derivative of a polynomial."""
    for i in range(ORDER - 1):
        out[i] = (i + 1) * (i + 2) * p[i + 2]
    out[ORDER - 1] = 0.0
    out[ORDER] = 0.0
