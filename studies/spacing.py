"""Evenly and logarithmically spaced values, each rounded once from its exact value.

Sums and products of doubles depend on the start of a range, on the processor and on the version of the library:
0.7250000000000001 in one range is 0.725 in another. Rounded once from the exact value, a coordinate is the same
double in every range that contains it.
"""

from decimal import Context, Decimal
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

_EXACT = 2**53
"""Below it every whole number is a double."""

_BITS = 256
"""Bits of the logarithmic factor: a million products of it are still exact to some 230 bits."""


def evenly_spaced(start: float, stop: float, num: int) -> NDArray[np.float64]:
    """Give the doubles nearest to ``start + i (stop - start) / (num - 1)``; the ends count as the decimals that they
    print as.

    Parameters
    ----------
    start, stop : float
        The ends, finite.
    num : int
        Number of values; 1 only if the ends are equal.

    Returns
    -------
    ndarray of float64, shape (num,)
        The values, with exact ends.
    """
    first, last = _decimal(start), _decimal(stop)
    step = (last - first) / max(1, num - 1)
    below = first.denominator * step.denominator
    offset, stride = first.numerator * step.denominator, step.numerator * first.denominator
    if max(abs(offset), abs(offset + stride * num), below) < _EXACT:
        # exact whole numbers, divided once
        return (offset + stride * np.arange(num, dtype=np.float64)) / below
    # Python divides whole numbers of any size with one rounding
    return np.array([(offset + stride * place) / below for place in range(num)])


def log_spaced(start: float, stop: float, num: int) -> NDArray[np.float64]:
    """Give the doubles nearest to ``start (stop / start)^(i / (num - 1))``; the ends count as the decimals that they
    print as.

    Parameters
    ----------
    start, stop : float
        The ends, finite and above 0.
    num : int
        Number of values; 1 only if the ends are equal.

    Returns
    -------
    ndarray of float64, shape (num,)
        The values, with exact ends.
    """
    first, last = _decimal(start), _decimal(stop)
    precise = Context(prec=100)
    ratio = precise.divide(_rounded(last, precise), _rounded(first, precise))
    # decimal rounds its logarithm and exponential correctly, on every machine alike
    factor = precise.exp(precise.divide(precise.ln(ratio), Decimal(max(1, num - 1))))
    fixed = int(precise.multiply(factor, precise.power(Decimal(2), Decimal(_BITS))).to_integral_value())
    value, below = (first.numerator << _BITS) // first.denominator, 1 << _BITS
    # small starts keep their leading bits
    shift = max(0, _BITS - value.bit_length())
    value, below = (first.numerator << (_BITS + shift)) // first.denominator, below << shift
    values = np.empty(num)
    for place in range(num):
        values[place] = value / below
        value = (value * fixed) >> _BITS
    values[0], values[-1] = start, stop
    return values


def _decimal(number: float) -> Fraction:
    return Fraction(repr(float(number)))


def _rounded(number: Fraction, context: Context) -> Decimal:
    return context.divide(Decimal(number.numerator), Decimal(number.denominator))
