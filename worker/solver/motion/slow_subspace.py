"""Separation of the motion in contact into a slow motion, in an invariant subspace, and a fast motion."""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import copy_matrix, largest_element, zero_matrix

Array = NDArray[np.float64]

CENTRE, CENTRE_RATE, BASE_FIRST, BASE_SECOND, Y, Y_RATE = range(6)
"""Indices of the coordinates of a contact (`compliant_motion.py`): X, X', two of the excitation, y, y'."""
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
    p = zero_matrix(fast, n)
    change = 0.0
    g = zero_matrix(n, n)
    inverse = _inverse(a[n:, n:])
    for _ in range(_ITERATIONS):
        for i in range(n):
            for j in range(n):
                g[i, j] = a[i, j]
                for k in range(fast):
                    g[i, j] += a[i, n + k] * p[k, j]
        right = zero_matrix(fast, n)
        for i in range(fast):
            for j in range(n):
                total = -a[n + i, j]
                for k in range(n):
                    total += p[i, k] * g[k, j]
                right[i, j] = total
        change = 0.0
        for i in range(fast):
            for j in range(n):
                total = 0.0
                for k in range(fast):
                    total += inverse[i, k] * right[k, j]
                change = max(change, abs(total - p[i, j]))
                p[i, j] = total
        if change == 0.0:
            break
    converged = change <= _ROUNDING * largest_element(p)
    rates = zero_matrix(fast, fast)
    for i in range(fast):
        for j in range(fast):
            total = a[n + i, n + j]
            for k in range(n):
                total -= p[i, k] * a[k, n + j]
            rates[i, j] = total
    inverse = _inverse(rates)
    b = zero_matrix(n, fast)
    for _ in range(_ITERATIONS):
        right = zero_matrix(n, fast)
        for i in range(n):
            for j in range(fast):
                right[i, j] = a[i, n + j]
                for k in range(n):
                    right[i, j] += g[i, k] * b[k, j]
        change = 0.0
        for i in range(n):
            for j in range(fast):
                total = 0.0
                for k in range(fast):
                    total += right[i, k] * inverse[k, j]
                change = max(change, abs(total - b[i, j]))
                b[i, j] = total
        if change == 0.0:
            break
    converged = converged and change <= _ROUNDING * largest_element(b)
    # a single fast coordinate takes the second of two places, so that the same code handles one or two coordinates
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
