"""Archive of all parameter sets for which a fit has computed responses."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.portable import log, log1p
from damperlab.worker.fit.model import Responses, responses_at

Matrix = NDArray[np.float64]
Progress = Callable[[int], None]

COARSE = 0.1
"""Relative difference of computed and measured amplitudes that counts as 1 in the coarse misfit."""


class Archive:
    """Parameter sets of a fit, and the responses that were computed with them.

    Parameters
    ----------
    question : FitQuestion
        Measurement, known values and ranges of the fit.
    progress : callable, optional
        Function called with the number of computed parameter sets.

    Attributes
    ----------
    places : ndarray, shape (n, parameters)
        Parameter sets, as fractions of the ranges.
    amplitude, error : ndarray, shape (n, rows)
        Computed amplitudes, or their logarithms if the question states relative deviations, and the errors.
    measured : ndarray, shape (rows,)
        Measured amplitudes, or their logarithms if the question states relative deviations.
    responses : list of Responses
        Response of each parameter set.
    """

    def __init__(self, question: FitQuestion, progress: Progress | None) -> None:
        self.question = question
        # if deviations are relative to the amplitudes, logarithms of amplitudes are compared
        self.logarithmic = question.in_shares
        self.measured = self._compared(question.measured.amplitude)
        self.count = len(question.free)
        self.places = np.empty((0, self.count))
        self.amplitude, self.error = (np.empty((0, self.measured.size)) for _ in range(2))
        self.responses: list[Responses] = []
        self.generator = np.random.default_rng(question.seed)
        self._progress = progress

    def add(self, places: Matrix) -> None:
        """Compute and store the responses of parameter sets, shape (n, parameters)."""
        found = []
        for place in places:
            found.append(responses_at(self.question, self.question.values(place)))
            if self._progress is not None:
                self._progress(len(self.places) + len(found))
        self.places = np.concatenate((self.places, places))
        self.amplitude = np.concatenate((self.amplitude, [self._compared(one.amplitude) for one in found]))
        error = [one.error / one.amplitude if self.logarithmic else one.error for one in found]
        self.error = np.concatenate((self.error, error))
        self.responses += found

    def _compared(self, amplitude: Matrix) -> Matrix:
        return log(amplitude) if self.logarithmic else amplitude

    def coarse_misfit(self) -> Matrix:
        """Return the misfit of each parameter set. Rows with large differences have little weight (Cauchy)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            off = self.amplitude - self.measured
            if not self.logarithmic:
                off = log(self.amplitude / self.measured)
            off = off / COARSE
        missed = log1p(np.where(np.isfinite(off), off, 100.0) ** 2)
        return np.asarray(missed.sum(axis=1))
