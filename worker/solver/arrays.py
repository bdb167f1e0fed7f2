"""Whole arrays in kernels, element by element.

numpy's own forms bring its checks of shapes and their messages into every kernel: a hundred functions to compile for a copy.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel

Array = NDArray[np.float64]


@kernel
def unit_matrix(size: int) -> Array:
    """Ones on the diagonal of a square matrix of zeros."""
    matrix = np.zeros((size, size))
    for i in range(size):
        matrix[i, i] = 1.0
    return matrix


@kernel
def copy_matrix(source: Array, out: Array) -> None:
    """Fill a matrix with another of its shape."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, j] = source[i, j]


@kernel
def largest_modulus(matrix: Array) -> float:
    """The largest modulus of a matrix's elements; NaN where one of them is."""
    largest = 0.0
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            modulus: float = abs(matrix[i, j])
            if modulus != modulus:
                return modulus
            largest = max(largest, modulus)
    return largest
