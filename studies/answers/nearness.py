"""Whether a value that a person wrote is a grid value: 0.7 is 0.7000000000000001."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

SAME = 1e-9
"""Relative difference up to which two values of a parameter are one."""


def same(a: ArrayLike, b: ArrayLike) -> NDArray[np.bool_]:
    """Whether values are one but for rounding, to a relative difference of `SAME`."""
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return np.asarray(np.abs(first - second) <= SAME * np.maximum(np.abs(first), np.abs(second)))


def nearest_place(values: ArrayLike, wanted: float) -> int:
    """Give the place of the grid value nearest to a number, the first of equally near ones."""
    return int(np.abs(np.asarray(values, dtype=float) - wanted).argmin())


def inside(values: ArrayLike, low: float, high: float) -> NDArray[np.bool_]:
    """Whether values are within a range, both ends included, to a relative difference of `SAME`."""
    at = np.asarray(values, dtype=float)
    return np.asarray(((at >= low) & (at <= high)) | same(at, low) | same(at, high))
