"""Evenly and logarithmically spaced values, each rounded once from the exact value.

If the values were sums and products of doubles, they would depend on the start of a range, on the processor and on the
version of the library. The same coordinate could then be 0.725 in one range and 0.7250000000000001 in another range.
"""

from decimal import Context, Decimal
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

_EXACT = 2**53
"""Bound up to which every whole number is a double."""

_BITS = 256
"""Number of fractional bits in the factor between logarithmically spaced values. After a million products,
about 230 bits are still exact.
"""


def evenly_spaced(start: float, stop: float, num: int) -> NDArray[np.float64]:
    """Return the doubles nearest to ``start + i (stop - start) / (num - 1)``.

    Each end is read as the decimal number that Python prints.

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
        # the numerators are exact whole numbers, and each is divided once
        return (offset + stride * np.arange(num, dtype=np.float64)) / below
    # Python divides whole numbers of any size with one rounding
    return np.array([(offset + stride * place) / below for place in range(num)])


def log_spaced(start: float, stop: float, num: int) -> NDArray[np.float64]:
    """Return the doubles nearest to ``start (stop / start)^(i / (num - 1))``.

    Each end is read as the decimal number that Python prints.

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
    # the decimal module rounds logarithm and exponential correctly, so they are equal on every machine
    factor = precise.exp(precise.divide(precise.ln(ratio), Decimal(max(1, num - 1))))
    fixed = int(precise.multiply(factor, precise.power(Decimal(2), Decimal(_BITS))).to_integral_value())
    value, below = (first.numerator << _BITS) // first.denominator, 1 << _BITS
    # the shift keeps all leading bits of a small start
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
