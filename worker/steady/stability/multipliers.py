"""The spectral radius of a small matrix."""

from math import exp, log

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.array_loops import largest_element


@kernel
def spectral_radius(matrix: NDArray[np.float64], size: int) -> float:
    """Largest modulus of the eigenvalues of the leading block, from ‖Mᴺ‖^(1/N) for N = 2⁴⁰ (Gelfand's formula)."""
    a = np.empty((size, size))
    square = np.empty((size, size))
    for i in range(size):
        for j in range(size):
            a[i, j] = matrix[i, j]
    exponent = 0.0
    weight = 1.0
    for _ in range(40):
        norm = largest_element(a)
        if norm == 0.0:
            return 0.0
        for i in range(size):
            for j in range(size):
                a[i, j] /= norm
        exponent += weight * log(norm)
        weight *= 0.5
        for i in range(size):
            for j in range(size):
                total = 0.0
                for k in range(size):
                    total += a[i, k] * a[k, j]
                square[i, j] = total
        a, square = square, a
    return exp(exponent)
