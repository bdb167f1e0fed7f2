"""Location of the first zero of a smooth function that starts positive."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from tests.reference.numbers import Real

Triple = tuple[Real, Real, Real]
Function = Callable[[Real], Triple]  # h -> the function and its first two derivatives


def zero_between(
    function: Callable[[Real], tuple[Real, Real]], low: Real, high: Real, positive_low: bool, noise: Real
) -> Real:
    """Return a zero of `function` (value and slope) between `low` and `high`, where its sign differs.

    Newton's steps, each kept inside the bracket; a step that leaves it, or that does not halve the last
    one, is replaced by a bisection. Ends when the value is below `noise`, or the bracket is empty.
    """
    h = (low + high) / 2
    last = high - low
    for _ in range(400):
        value, slope = function(h)
        if abs(value) <= noise:
            return h
        if (value > 0) == positive_low:
            low = h
        else:
            high = h
        step = -value / slope if slope != 0 else high - low
        if not low < h + step < high or 2 * abs(step) > abs(last):
            step = (low + high) / 2 - h
        last = step
        if h + step in (low, high, h):
            return h
        h = h + step
    return h


def first_zero(
    function: Function, start: Real, at_start: Triple, end: Real, at_end: Triple, noise: Triple
) -> Real | None:
    """Return the first zero in (start, end] of a function that is positive at `start`, or None.

    The interval must be short against the function's shortest period. It is split where the second
    derivative changes sign, then where the first does, so that each part is monotone and a touching pair of
    zeros between the ends cannot be missed.
    """
    nodes = [(start, at_start), (end, at_end)]
    for order in (1, 0):  # split at zeros of f'', then at zeros of f'
        split = [nodes[0]]
        for (low, at_low), (high, at_high) in pairwise(nodes):
            if (at_low[order + 1] > 0) != (at_high[order + 1] > 0):
                if order == 1:
                    h = _bisect(
                        lambda x: function(x)[2], low, high, at_low[2] > 0, abs(high - low) / (1 << 40)
                    )
                else:
                    h = zero_between(lambda x: function(x)[1:], low, high, at_low[1] > 0, noise[1])
                split.append((h, function(h)))
            split.append((high, at_high))
        nodes = split
    for (low, at_low), (high, at_high) in pairwise(nodes):
        if at_low[0] > 0 >= at_high[0]:
            return zero_between(lambda x: function(x)[:2], low, high, True, noise[0])
    return None


def _bisect(function: Callable[[Real], Real], low: Real, high: Real, positive_low: bool, width: Real) -> Real:
    """Return where `function` changes sign, to `width`: enough for a point that only splits an interval."""
    while high - low > width:
        middle = (low + high) / 2
        if (function(middle) > 0) == positive_low:
            low = middle
        else:
            high = middle
    return (low + high) / 2
