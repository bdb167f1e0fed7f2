"""The known response of a damper over the frequency, under one amplitude, and its mean square over the band.

Every frequency in hertz has the same weight. So the root of the mean square is the rms over time during a slow sweep
through the band at a constant rate.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import trapezoid
from damperlab.studies.design.frequencies import DIGITS, NARROW
from damperlab.studies.specification.measure import ACCELERATIONS, Measure

MOST = 12
"""Largest number of intervals halved in one step."""


@dataclass(frozen=True)
class Curve:
    """The response of a build over the frequency. Values are infinite where the response failed.

    Parameters
    ----------
    r : ndarray, (n,)
        Frequencies relative to the build's own natural frequency, ascending.
    base_m : ndarray, (n,)
        Base amplitude Z; 1 under a record, whose results are already in SI units.
    columns : dict of ndarray, (n,)
        Values of the variables of `Book.variables` or `RECORD_VARIABLES`. The first variable is infinite where the
        response failed.
    measure : Measure
        The measure to minimise, computed from these variables.
    rate : float
        ω_n of the structure, with which ratios are converted into velocities and accelerations.
    """

    r: NDArray[np.float64]
    base_m: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    measure: Measure
    rate: float = 1.0

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a variable, shape (n,). Failed responses are infinite, but have an `amplitude_error` of 0."""
        failed = np.isinf(next(iter(self.columns.values())))
        if name == "amplitude_error":  # results under a record have no statistical error
            column = self.columns.get(name, np.zeros(self.r.size))
            return np.where(failed, 0.0, column)
        return np.where(failed, np.inf, self.columns[name])

    @property
    def measured(self) -> NDArray[np.float64]:
        """The measure, shape (n,), in its unit."""
        return self._scale * self[self.measure.variable]

    @property
    def errors(self) -> NDArray[np.float64]:
        """Standard error of the measure, shape (n,), in its unit."""
        return self._scale * self.errors_of(self.measure.variable)

    @property
    def judged(self) -> float:
        """The judged value: the largest value of the measure, or the rms of the measure over the band."""
        values = self.measured
        return band_mean(self.r, values, self.errors).value if self.measure.mean else float(values.max())

    def errors_of(self, variable: str) -> NDArray[np.float64]:
        """Return the standard error of a variable, shape (n,).

        An acceleration has the same relative error as the amplitude; any other variable has the same absolute
        error as the amplitude.
        """
        errors: NDArray[np.float64] = np.nan_to_num(self["amplitude_error"])
        if variable not in ACCELERATIONS:
            return errors
        amplitude, value = self["amplitude_ratio"], self[variable]
        known = np.isfinite(amplitude) & (amplitude > 0.0)
        share: NDArray[np.float64] = np.divide(value, amplitude, out=np.zeros_like(value), where=known)
        return errors * share

    @property
    def _scale(self) -> NDArray[np.float64]:
        """Factor that converts the variable of the measure into the measure, shape (n,)."""
        scale: NDArray[np.float64] = self.measure.factor * self.base_m
        return scale * self.rate**self.measure.order if self.measure.order else scale


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
