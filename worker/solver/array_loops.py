"""Array operations for kernels, written as loops over the elements.

NumPy's functions would add shape checks and error messages to every kernel. To copy a single array with
NumPy, numba would compile a hundred functions.
"""

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel

Array = NDArray[np.float64]


@kernel
def filled(size: int, value: float) -> Array:
    """Array of shape (size,), filled with one value."""
    array = np.empty(size)
    for i in range(size):
        array[i] = value
    return array


@kernel
def zero_matrix(rows: int, columns: int) -> Array:
    """Matrix of zeros, shape (rows, columns)."""
    matrix = np.empty((rows, columns))
    for i in range(rows):
        for j in range(columns):
            matrix[i, j] = 0.0
    return matrix


@kernel
def zero_counts(size: int) -> NDArray[np.int64]:
    """Array of integer zeros, shape (size,)."""
    counts = np.empty(size, np.int64)
    for i in range(size):
        counts[i] = 0
    return counts


@kernel
def unit_matrix(size: int) -> Array:
    """Identity matrix, shape (size, size)."""
    matrix = zero_matrix(size, size)
    for i in range(size):
        matrix[i, i] = 1.0
    return matrix


@kernel
def copy_matrix(source: Array, out: Array) -> None:
    """Copy a matrix into the leading rows and columns of `out`."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, j] = source[i, j]


@kernel
def add_product(sign: float, left: Array, right: Array, out: Array) -> None:
    """Add sign · left · right to the leading rows and columns of `out`."""
    for i in range(left.shape[0]):
        for j in range(right.shape[1]):
            for k in range(right.shape[0]):
                out[i, j] += sign * left[i, k] * right[k, j]


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
