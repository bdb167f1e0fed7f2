"""Separation of the motion in contact into a slow motion, in an invariant subspace, and a fast motion."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import add_product, copy_matrix, largest_element, zero_matrix

Array = NDArray[np.float64]

CENTRE, CENTRE_RATE, BASE_FIRST, BASE_SECOND, Y, Y_RATE = range(6)
"""Indices of the coordinates of a contact (`compliant_motion.py`): X, X', two coordinates of the excitation, y, y'."""
DIM = 6
"""Number of coordinates."""
_ITERATIONS = 60
# Largest relative change in the last step of a converged iteration.
_ROUNDING = 1e-12


@kernel
def contact_rates(square: float, damping: float) -> tuple[float, float]:
    """Moduli of the two roots of λ² + damping λ + square, the larger first."""
    discriminant = 0.25 * damping * damping - square
    if discriminant <= 0.0:
        return sqrt(square), sqrt(square)
    larger = 0.5 * damping + sqrt(discriminant)
    return larger, square / larger


@kernel
def split(a: Array, fast: int) -> tuple[Array, Array, Array, Array, bool]:
    """Return P, B, Λ and Λ⁻¹ for the last `fast` coordinates, and whether the iterations for P and B converged."""
    n = DIM - fast
    a_rr, a_rq, a_qr, a_qq = a[:n, :n], a[:n, n:], a[n:, :n], a[n:, n:]
    p, b = zero_matrix(fast, n), zero_matrix(n, fast)
    g, rates = zero_matrix(n, n), zero_matrix(fast, fast)
    inverse = _inverse(a_qq)
    change = 0.0
    for _ in range(_ITERATIONS):  # P = −A_qq⁻¹ (A_qr − PG)
        copy_matrix(a_rr, g)
        add_product(1.0, a_rq, p, g)
        rest, following = zero_matrix(fast, n), zero_matrix(fast, n)
        copy_matrix(a_qr, rest)
        add_product(-1.0, p, g, rest)
        add_product(-1.0, inverse, rest, following)
        change = _change(p, following)
        copy_matrix(following, p)
        if change == 0.0:
            break
    converged = change <= _ROUNDING * largest_element(p)
    copy_matrix(a_qq, rates)
    add_product(-1.0, p, a_rq, rates)
    inverse = _inverse(rates)
    for _ in range(_ITERATIONS):  # B = (A_rq + GB) Λ⁻¹
        rest, following = zero_matrix(n, fast), zero_matrix(n, fast)
        copy_matrix(a_rq, rest)
        add_product(1.0, g, b, rest)
        add_product(1.0, rest, inverse, following)
        change = _change(b, following)
        copy_matrix(following, b)
        if change == 0.0:
            break
    converged = converged and change <= _ROUNDING * largest_element(b)
    # a single fast coordinate takes the second of two places, so that the same code handles one or two fast coordinates
    whole = zero_matrix(2, 2)
    whole_inverse = zero_matrix(2, 2)
    for i in range(2):
        whole[i, i] = rates[fast - 1, fast - 1]
        whole_inverse[i, i] = inverse[fast - 1, fast - 1]
    if fast == 2:
        copy_matrix(rates, whole)
        copy_matrix(inverse, whole_inverse)
    return p, b, whole, whole_inverse, converged


@kernel
def _change(before: Array, after: Array) -> float:
    """Largest modulus of the difference of two matrices."""
    largest = 0.0
    for i in range(before.shape[0]):
        for j in range(before.shape[1]):
            largest = max(largest, abs(after[i, j] - before[i, j]))
    return largest


@kernel
def _inverse(matrix: Array) -> Array:
    out = np.empty(matrix.shape)
    if matrix.shape[0] == 1:
        out[0, 0] = 1.0 / matrix[0, 0]
        return out
    determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    out[0, 0] = matrix[1, 1] / determinant
    out[0, 1] = -matrix[0, 1] / determinant
    out[1, 0] = -matrix[1, 0] / determinant
    out[1, 1] = matrix[0, 0] / determinant
    return out
