"""What a fit of a time history gives: parameters with intervals, and over which stretch of it they were found."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from damperlab.studies.fit.fitted import Outcome
from damperlab.studies.fit.history.harmonic import harmonic_document
from damperlab.studies.fit.history.question import HistoryQuestion

Column = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class FittedHistory(Outcome):
    """The outcome of a fit of a time history.

    Parameters
    ----------
    question : HistoryQuestion
        What was asked.
    rows : int
        Samples that count: the longest stretch from the start over which the response is predictable.
    model_m : ndarray, shape (rows of the measurement,)
        Displacement with the best parameters [m].
    deviation_m : ndarray, shape (rows of the measurement,)
        Standard deviation of the measurement [m]; as estimated, where none was given.
    correlated : float
        By how much the intervals are wider, at most, because the residuals are correlated from sample to sample.
    """

    question: HistoryQuestion
    rows: int
    model_m: Column = field(repr=False)
    deviation_m: Column = field(repr=False)
    correlated: float = 1.0

    def study(self) -> dict[str, Any]:
        """Write the prototype as a study over a band around its natural frequency; see `harmonic_document`."""
        return harmonic_document(self.question, self.values)

    @property
    def stretch_s(self) -> float:
        """Time over which the response is predictable [s]."""
        return (self.rows - 1) * self.question.measured.step_s

    @property
    def whole(self) -> bool:
        """Whether that is all of the history."""
        return self.rows == self.question.measured.rows

    @property
    def residual(self) -> Column:
        """Measured less computed in standard deviations, shape (rows,): those that count."""
        off = self.question.measured.displacement_m - self.model_m
        return np.asarray((off / self.deviation_m)[: self.rows])

    @property
    def probability(self) -> float | None:
        """Chance of a chi-square as large, if the model is right; None where the deviation was made to agree with it."""
        if self.question.measured.deviation_m is None:
            return None
        return float(chdtrc(self.freedom, self.chi_square))
