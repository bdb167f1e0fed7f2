"""Loops over complete arrays in kernels, element by element.

numpy's own functions bring their shape checks and messages into every kernel: a copy alone would compile a hundred
functions.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel

Array = NDArray[np.float64]


@kernel
def filled(size: int, value: float) -> Array:
    """An array of shape (size,) whose elements all have the same value."""
    array = np.empty(size)
    for i in range(size):
        array[i] = value
    return array


@kernel
def zero_matrix(rows: int, columns: int) -> Array:
    """A matrix of zeros, (rows, columns)."""
    matrix = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            matrix[i, j] = 0.0
    return matrix


@kernel
def zero_counts(size: int) -> NDArray[np.int64]:
    """Counters at 0, (size,)."""
    counts = np.empty(size, np.int64)
    for i in range(size):
        counts[i] = 0
    return counts


@kernel
def unit_matrix(size: int) -> Array:
    """Ones on the diagonal of a square matrix of zeros."""
    matrix = zero_matrix(size, size)
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
def largest_element(matrix: Array) -> float:
    """Largest modulus of the elements of a matrix; NaN if an element is NaN."""
    largest = 0.0
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            modulus: float = abs(matrix[i, j])
            if modulus != modulus:
                return modulus
            largest = max(largest, modulus)
    return largest
