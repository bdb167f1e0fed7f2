"""Largest magnitude of a smooth function over an interval."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq  # type: ignore[import-untyped]

Curve = Callable[[np.ndarray], np.ndarray]


def zeros(function: Curve, start: float, end: float, samples: int = 4001) -> list[float]:
    """Return the simple zeros of `function` on (start, end), bracketed by equally spaced samples."""
    x = np.linspace(start, end, samples)
    y = function(x)
    return [
        float(brentq(lambda t: float(function(np.asarray(t))), x[i], x[i + 1], xtol=1e-15 * (1 + abs(end))))
        for i in np.flatnonzero((y[:-1] > 0) != (y[1:] > 0))
    ]


def largest_magnitude(function: Curve, slope: Curve, start: float, end: float) -> float:
    """Return max |function| over [start, end], evaluated at the zeros of `slope` and at both ends."""
    places = np.array([start, end, *zeros(slope, start, end)])
    return float(np.max(np.abs(function(places))))
