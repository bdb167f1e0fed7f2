"""All sets of parameters that a fit has computed, and their responses."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.portable import log, log1p
from damperlab.worker.fit.model import Responses, responses_at

Matrix = NDArray[np.float64]
Progress = Callable[[int], None]

COARSE = 0.1
"""Relative difference of amplitudes below which a coarse point counts as near the measurement."""


class Archive:
    """Parameter sets, as fractions of the ranges, and their computed values, which are compared with the measurement.

    Parameters
    ----------
    question : FitQuestion
        The question.
    progress : callable, optional
        Called with the number of computed places.

    Attributes
    ----------
    places : ndarray, shape (n, parameters)
    amplitude, error : ndarray, shape (n, rows)
        Amplitude and its error. If deviations are relative, the logarithm of the amplitude and the error of that
        logarithm.
    measured : ndarray, shape (rows,)
        The measured values in the same form.
    responses : list of Responses
    """

    def __init__(self, question: FitQuestion, progress: Progress | None) -> None:
        self.question = question
        # if deviations are relative to the amplitudes, differences must be relative too, so logarithms are compared
        self.logarithmic = question.in_shares
        self.measured = self._compared(question.measured.amplitude)
        self.count = len(question.free)
        self.places = np.empty((0, self.count))
        self.amplitude, self.error = (np.empty((0, self.measured.size)) for _ in range(2))
        self.responses: list[Responses] = []
        self.generator = np.random.default_rng(question.seed)
        self._progress = progress

    def add(self, places: Matrix) -> None:
        """Compute the responses at places of shape (n, parameters)."""
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
        """Distance of each place from the measurement: rows that are far off have little weight (Cauchy)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            off = self.amplitude - self.measured
            if not self.logarithmic:
                off = log(self.amplitude / self.measured)
            off = off / COARSE
        missed = log1p(np.where(np.isfinite(off), off, 100.0) ** 2)
        return np.asarray(missed.sum(axis=1))
