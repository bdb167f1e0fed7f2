"""The known response of a damper over the frequency, under one amplitude."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.design.band_mean import band_mean
from damperlab.studies.specification.measure import ACCELERATIONS, Measure


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
