"""The two kinds of number that the reference simulator can compute with."""

from __future__ import annotations

import math
from typing import Any

import mpmath  # type: ignore[import-untyped]

Real = Any  # an mpmath mpf or a float; both have the arithmetic operators


class ExtendedNumbers:
    """Real numbers with a chosen count of decimal digits, in a context of their own.

    Parameters
    ----------
    digits : int
        Decimal digits carried by every operation.
    """

    def __init__(self, digits: int = 40) -> None:
        self._context = mpmath.mp.clone()
        self._context.dps = digits
        self.digits = digits
        self.rounding = self._context.mpf(10) ** (2 - digits)
        self.pi = +self._context.pi

    def convert(self, value: object) -> Real:
        """Return `value` exactly: a float is the binary number that it holds, a string is read as decimal."""
        return self._context.mpf(value)

    def cos_sin(self, angle: Real) -> tuple[Real, Real]:
        """Return the cosine and the sine of `angle` [rad]."""
        both: tuple[Real, Real] = self._context.cos_sin(angle)
        return both

    def exp(self, value: Real) -> Real:
        """Return e to the power `value`."""
        return self._context.exp(value)

    def sqrt(self, value: Real) -> Real:
        """Return the non-negative square root of `value`."""
        return self._context.sqrt(value)

    def text(self, value: Real) -> str:
        """Return `value` with 25 significant decimal digits, or all it has if those are fewer."""
        return str(self._context.nstr(value, min(25, self.digits), strip_zeros=False))


class DoubleNumbers:
    """IEEE double precision, for long runs where fifteen digits are enough."""

    def __init__(self) -> None:
        self.digits = 16
        self.rounding = 1e-15
        self.pi = math.pi

    def convert(self, value: object) -> Real:
        """Return `value` as a float."""
        return float(str(value)) if isinstance(value, str) else float(value)  # type: ignore[arg-type]

    def cos_sin(self, angle: Real) -> tuple[Real, Real]:
        """Return the cosine and the sine of `angle` [rad]."""
        return math.cos(angle), math.sin(angle)

    def exp(self, value: Real) -> Real:
        """Return e to the power `value`."""
        return math.exp(value)

    def sqrt(self, value: Real) -> Real:
        """Return the non-negative square root of `value`."""
        return math.sqrt(value)


Numbers = ExtendedNumbers | DoubleNumbers
