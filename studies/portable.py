"""Arithmetic that has the same bits on every processor.

On processors with AVX-512 numpy uses its own code for exponentials, logarithms, sines and powers. It passes products of
matrices to OpenBLAS, which has different code for each family of processors. The last bits differ. Records generated
from a seed would differ too, and so would a fit, whose search through chaotic responses amplifies them. Here the C
library computes each value, and the products of every row are summed in the same order.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_POWER = np.frompyfunc(math.pow, 2, 1)


def exp(x: ArrayLike) -> Floats:
    """Exponential of each element; an OverflowError if it exceeds the largest number."""
    return _each(math.exp, x)


def expm1(x: ArrayLike) -> Floats:
    """Exponential minus 1 of each element; an OverflowError if it exceeds the largest number."""
    return _each(math.expm1, x)


def log(x: ArrayLike) -> Floats:
    """Logarithm of each element: -inf of 0, NaN of negative numbers and NaN."""
    values = np.asarray(x, np.float64)
    return _each(math.log if (values > 0.0).all() else _log, values)


def log1p(x: ArrayLike) -> Floats:
    """Logarithm of 1 plus each element; a ValueError if one is -1 or less."""
    return _each(math.log1p, x)


def sin(x: ArrayLike) -> Floats:
    """Sine of each element [rad]; a ValueError if one is infinite."""
    return _each(math.sin, x)


def cos(x: ArrayLike) -> Floats:
    """Cosine of each element [rad]; a ValueError if one is infinite."""
    return _each(math.cos, x)


def acos(x: ArrayLike) -> Floats:
    """Arc cosine of each element [rad]; a ValueError if one is beyond ±1."""
    return _each(math.acos, x)


def power(base: ArrayLike, exponent: ArrayLike) -> Floats:
    """Powers, element by element; an OverflowError above the largest number, a ValueError if a power is not defined."""
    return np.asarray(_POWER(base, exponent), np.float64)


def product(a: ArrayLike, b: ArrayLike) -> Floats:
    """Product of a matrix or vector with another, as by `a @ b`.

    Parameters
    ----------
    a : array, shape (..., k)
        Equal rows give equal sums, which a library that computes several rows together does not guarantee.
    b : array, shape (k,) or (k, m)
    """
    subscripts = "...i,i->..." if np.ndim(b) == 1 else "...i,ij->...j"
    return np.asarray(np.einsum(subscripts, np.asarray(a, np.float64), np.asarray(b, np.float64)))


def _each(function: Callable[[float], float], x: ArrayLike) -> Floats:
    values = np.asarray(x, np.float64)
    found = np.fromiter(map(function, values.ravel().tolist()), np.float64, values.size)
    return found.reshape(values.shape)


def _log(x: float) -> float:
    if x > 0.0:
        return math.log(x)
    return -math.inf if x == 0.0 else math.nan
