"""Points that fill a box evenly, always the same ones."""

import numpy as np
from numpy.typing import NDArray

PRIMES = (2, 3, 5, 7, 11, 13)


def halton(count: int, dimensions: int, first: int = 1) -> NDArray[np.float64]:
    """Give points of Halton's sequence (1960): radical inverses in the first prime bases.

    Parameters
    ----------
    count, dimensions : int
        Points, and numbers of each; at most six dimensions.
    first : int
        Index of the first point.

    Returns
    -------
    ndarray, shape (count, dimensions)
        Within (0, 1).
    """
    index = np.arange(first, first + count)
    found = np.zeros((count, dimensions))
    for column, base in enumerate(PRIMES[:dimensions]):
        left, weight = index.copy(), 1.0 / base
        while left.any():
            found[:, column] += weight * (left % base)
            left //= base
            weight /= base
    return found
