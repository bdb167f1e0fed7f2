"""Functions that return the same bits on every processor.

On processors with AVX-512, numpy uses separate code for exponentials, logarithms, sines and powers. For matrix
products, numpy uses OpenBLAS, which has different code for each family of processors. With numpy, the last bits of
results would depend on the processor. Then the same seed would generate different records on different processors, and
fits of chaotic responses would give different parameters. In this module, the C library computes each value, and the
products in every row are summed in the same order.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_POWER = np.frompyfunc(math.pow, 2, 1)


def exp(x: ArrayLike) -> Floats:
    """Return the exponential of each element. Raise OverflowError if a result exceeds the largest number."""
    return _each(math.exp, x)


def expm1(x: ArrayLike) -> Floats:
    """Return the exponential minus 1 of each element. Raise OverflowError if a result exceeds the largest number."""
    return _each(math.expm1, x)


def log(x: ArrayLike) -> Floats:
    """Return the logarithm of each element: -inf for 0, and NaN for negative numbers and NaN."""
    values = np.asarray(x, np.float64)
    return _each(math.log if (values > 0.0).all() else _log, values)


def log1p(x: ArrayLike) -> Floats:
    """Return the logarithm of 1 plus each element. Raise ValueError if an element is -1 or less."""
    return _each(math.log1p, x)


def sin(x: ArrayLike) -> Floats:
    """Return the sine of each element [rad]. Raise ValueError if an element is infinite."""
    return _each(math.sin, x)


def cos(x: ArrayLike) -> Floats:
    """Return the cosine of each element [rad]. Raise ValueError if an element is infinite."""
    return _each(math.cos, x)


def acos(x: ArrayLike) -> Floats:
    """Return the arc cosine [rad] of each element. Raise ValueError if an element is beyond ±1."""
    return _each(math.acos, x)


def power(base: ArrayLike, exponent: ArrayLike) -> Floats:
    """Return powers, element by element.

    Raises
    ------
    OverflowError
        If a power exceeds the largest number.
    ValueError
        If a power is not defined.
    """
    return np.asarray(_POWER(base, exponent), np.float64)


def product(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the product of two matrices or vectors, like `a @ b`.

    Parameters
    ----------
    a : array, shape (..., k)
        Equal rows of `a` give bitwise equal results. Libraries for matrix products do not ensure this.
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
