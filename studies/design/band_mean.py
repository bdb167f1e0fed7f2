"""Mean square of a response over the band, the error of the mean square, and frequencies that reduce this error.

Every frequency in hertz has the same weight. So the root of the mean square is the rms in time of a slow sweep through
the band at a constant rate.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import trapezoid
from damperlab.studies.design.frequencies import DIGITS, NARROW

MOST = 12
"""Largest number of intervals halved in one step."""


@dataclass(frozen=True)
class BandMean:
    """The root of the mean square over the band.

    Parameters
    ----------
    value : float
        The root of the mean square, in the unit of the response.
    between : float
        Estimated error of `value` between the frequencies at which the response is known.
    error : float
        Standard error of `value`. The errors at different frequencies are independent of each other.
    """

    value: float
    between: float
    error: float


def band_mean(r: NDArray[np.float64], values: NDArray[np.float64], errors: NDArray[np.float64]) -> BandMean:
    """Integrate a response over its frequencies by the trapezoidal rule.

    Parameters
    ----------
    r, values, errors : ndarray, (n,)
        Ascending frequencies, of which the first and the last are the ends of the band; the response at each frequency,
        in any unit; and the standard error of each response.
    """
    if r.size == 1 or not np.isfinite(values).all():
        return BandMean(float(values.max()), 0.0, float(errors[int(values.argmax())]))
    width = float(r[-1] - r[0])
    weights = trapezoid(r) / width
    square = float((weights * values**2).sum())
    if square == 0.0:
        return BandMean(0.0, 0.0, 0.0)
    value = float(np.sqrt(square))
    doubt = float(_doubts(r, values**2).sum()) / width
    spread = float(np.sqrt(((weights * values * errors) ** 2).sum())) / value
    # `between` is the growth of the root if the mean square grows by `doubt`
    return BandMean(value, float(np.sqrt(square + doubt)) - value, spread)


def halved(r: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[float, ...]:
    """Return the midpoints of the intervals with the largest error of the integral.

    Intervals no wider than `NARROW` are left out.
    """
    if r.size < 3 or not np.isfinite(values).all():
        return ()
    doubts = _doubts(r, values**2)
    worst = np.argsort(-doubts, kind="stable")[:MOST]
    return tuple(
        sorted(
            round(float(0.5 * (r[k] + r[k + 1])), DIGITS)
            for k in worst
            if doubts[k] > 0.0 and r[k + 1] - r[k] > NARROW
        )
    )


def _doubts(r: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Estimate the error of the trapezoidal rule on each interval, shape (n - 1,), from the curvature at its ends.

    On an interval of width h the error is h³/12 times the second derivative at some point of the interval.
    """
    steps = np.diff(r)
    if r.size < 3:
        return np.zeros_like(steps)
    slopes = np.diff(values) / steps
    curvatures = np.abs(2.0 * np.diff(slopes) / (steps[:-1] + steps[1:]))
    at_ends = np.pad(curvatures, 1, mode="edge")
    doubts: NDArray[np.float64] = np.maximum(at_ends[:-1], at_ends[1:]) * steps**3 / 12.0
    return doubts
