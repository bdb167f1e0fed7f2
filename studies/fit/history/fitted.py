"""The result of a fit of a time history: parameters with intervals, and the part of the history that was used."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.fitted import Outcome
from damperlab.studies.fit.history.harmonic import harmonic_document
from damperlab.studies.fit.history.question import HistoryQuestion

Column = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class FittedHistory(Outcome):
    """The result of a fit of a time history.

    Parameters
    ----------
    question : HistoryQuestion
        The definition of the fit.
    rows : int
        Number of samples that are used: the longest initial part with a predictable response.
    model_m : ndarray, shape (rows of the measurement,)
        Displacement with the best parameters [m].
    deviation_m : ndarray, shape (rows of the measurement,)
        Standard deviation of the measurement [m]; an estimate if none was given.
    correlated : float
        Upper bound of the factor by which intervals are widened because residuals are correlated from sample to sample.
    """

    question: HistoryQuestion
    rows: int
    model_m: Column = field(repr=False)
    deviation_m: Column = field(repr=False)
    correlated: float = 1.0

    def study(self) -> dict[str, Any]:
        """Write the prototype as a study over a band around the natural frequency; see `harmonic_document`."""
        return harmonic_document(self.question, self.values)

    @property
    def stretch_s(self) -> float:
        """Duration of the part that is used [s]."""
        return (self.rows - 1) * self.question.measured.step_s

    @property
    def whole(self) -> bool:
        """Whether the complete history is used."""
        return self.rows == self.question.measured.rows

    @property
    def residual(self) -> Column:
        """Measured minus computed in standard deviations, for the samples that are used, shape (rows,)."""
        off = self.question.measured.displacement_m - self.model_m
        return np.asarray((off / self.deviation_m)[: self.rows])

    @property
    def probability(self) -> float | None:
        """p-value of the chi-square test; None if the measurement states no standard deviations."""
        if self.question.measured.deviation_m is None:
            return None
        from scipy.special import chdtrc

        return float(chdtrc(self.freedom, self.chi_square))
