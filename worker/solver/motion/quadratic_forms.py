"""Integrals over a complete panel without events, as quadratic forms of the state at the start of the panel.

Between events, the quantities x, w, s and s' are linear in (x₀, w₀, sin φ, cos φ). So the work done, the loss
in the dashpot and the mean square over a panel of fixed length are quadratic in (x₀, w₀, sin φ, cos φ). Each
integral has ten coefficients, which are the same for every panel.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.array_loops import filled
from damperlab.worker.solver.motion.taylor import TERMS, slope, value

# Gauss–Legendre rule on [0, 1] with 6 points, exact to degree 11.
# On the longest panel, the error is below 1e-16 of the integrand.
# NumPy would compute the nodes from eigenvalues, whose last bits depend on the processor.
NODES: NDArray[np.float64] = np.array(
    [
        0.03376524289842399,
        0.16939530676686773,
        0.38069040695840156,
        0.6193095930415985,
        0.8306046932331322,
        0.966234757101576,
    ]
)
_HALF = [0.08566224618958518, 0.1803807865240693, 0.23395696728634552]
WEIGHTS: NDArray[np.float64] = np.array(_HALF + _HALF[::-1])
_POINTS = 6

PAIRS = 10
"""Number of pairwise products of four numbers, including the squares."""
WORK, LOSS, SQUARED, MEAN = 0, PAIRS, 2 * PAIRS, 3 * PAIRS
"""Offsets of the coefficients of each integral in `motion_forms`."""


@kernel
def base_forms(rows: NDArray[np.float64], window: float) -> NDArray[np.float64]:
    """Integrals of the base over a panel.

    Returns
    -------
    array, shape (5,)
        Coefficients of sin φ and cos φ in ∫s, and of sin²φ, 2 sin φ cos φ and cos²φ in ∫s².
    """
    forms = filled(5, 0.0)
    for i in range(_POINTS):
        weight = WEIGHTS[i] * window
        sine = value(rows[:TERMS], NODES[i] * window)
        cosine = value(rows[TERMS:], NODES[i] * window)
        forms[0] += weight * sine
        forms[1] += weight * cosine
        forms[2] += weight * (sine * sine)
        forms[3] += weight * (sine * cosine)
        forms[4] += weight * (cosine * cosine)
    return forms


@kernel
def motion_forms(
    two_zeta: float,
    excitation: NDArray[np.float64],
    displacement: float,
    force: float,
    relative: NDArray[np.float64],
    absolute: NDArray[np.float64],
    window: float,
) -> NDArray[np.float64]:
    """Integrals over a panel of slip.

    Parameters
    ----------
    two_zeta : float
        2ζ.
    excitation, displacement, force
        Taylor coefficients of the excitation, and the ratios of s and of the force g to the excitation
        (`taylor.motion_rows`).
    relative, absolute : array, shape (4 · TERMS,)
        Taylor coefficients of x and of x + s.
    window : float
        Length of the panel [1/ω_n].

    Returns
    -------
    array, shape (3 · PAIRS + 4,)
        Ten coefficients each of the work ∫ g w − (2ζw + x) s', of ∫2ζw² and of ∫(x + s)², then four
        coefficients of ∫(x + s). The first two integrals are quadratic in (x₀, w₀, sin φ, cos φ), with the
        products in the order 00 01 02 03 11 12 13 22 23 33. The last two integrals use (x₀ + s₀, w₀ + s₀',
        sin φ, cos φ), to avoid cancellation for r ≪ 1 and for r ≫ 1.
    """
    forms = filled(3 * PAIRS + 4, 0.0)
    of_absolute = np.empty((4, TERMS))
    for n in range(TERMS):
        of_absolute[0, n] = absolute[n]
        of_absolute[1, n] = absolute[TERMS + n]
        of_absolute[2, n] = absolute[2 * TERMS + n] - displacement * excitation[0] * absolute[n]
        of_absolute[3, n] = (
            absolute[3 * TERMS + n] - displacement * excitation[TERMS + 1] * absolute[TERMS + n]
        )
    x = np.empty(4)
    w = np.empty(4)
    u = np.empty(4)
    base_rate = filled(4, 0.0)
    given = filled(4, 0.0)
    for i in range(_POINTS):
        at = NODES[i] * window
        weight = WEIGHTS[i] * window
        for j in range(4):
            x[j] = value(relative[j * TERMS : (j + 1) * TERMS], at)
            w[j] = slope(relative[j * TERMS : (j + 1) * TERMS], at)
            u[j] = value(of_absolute[j], at)
            if j >= 2:
                rows = excitation[(j - 2) * TERMS : (j - 1) * TERMS]
                base_rate[j] = displacement * slope(rows, at)
                given[j] = force * value(rows, at)
            forms[MEAN + j] += weight * u[j]
        pair = 0
        for j in range(4):
            for k in range(j, 4):
                both = weight if j == k else 2.0 * weight
                of_force = w[j] * given[k] + w[k] * given[j]
                of_base = (two_zeta * w[j] + x[j]) * base_rate[k] + (two_zeta * w[k] + x[k]) * base_rate[j]
                forms[WORK + pair] += 0.5 * both * (of_force - of_base)
                forms[LOSS + pair] += both * (two_zeta * w[j] * w[k])
                forms[SQUARED + pair] += both * (u[j] * u[k])
                pair += 1
    return forms


@inlined
def products(a: float, b: float, c: float, d: float) -> tuple[float, ...]:
    """The ten pairwise products of four numbers, including the squares."""
    return a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d


@inlined
def quadratic(forms: Floats, start: int, p: tuple[float, ...]) -> float:
    """Evaluate one integral: the sum of ten coefficients times the ten products at the start of the panel."""
    a = (forms[start] * p[0] + forms[start + 1] * p[1]) + (forms[start + 2] * p[2] + forms[start + 3] * p[3])
    b = (forms[start + 4] * p[4] + forms[start + 5] * p[5]) + (
        forms[start + 6] * p[6] + forms[start + 7] * p[7]
    )
    return (a + b) + (forms[start + 8] * p[8] + forms[start + 9] * p[9])
