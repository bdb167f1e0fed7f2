"""What a fit of a time history gives: parameters with intervals, and over which stretch of it they were found."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from damperlab.studies.fit.fitted import Estimate, pairs_alike
from damperlab.studies.fit.history.harmonic import harmonic_document
from damperlab.studies.fit.history.question import HistoryQuestion

Column = NDArray[np.float64]


@dataclass(frozen=True)
class FittedHistory:
    """The outcome of a fit of a time history.

    Parameters
    ----------
    question : HistoryQuestion
        What was asked.
    estimates : tuple of Estimate
        In the question's order.
    correlation : ndarray, shape (parameters, parameters)
        Of the parameters.
    rows : int
        Samples that count: the longest stretch from the start over which the response is predictable.
    model_m : ndarray, shape (rows of the measurement,)
        Displacement with the best parameters [m].
    deviation_m : ndarray, shape (rows of the measurement,)
        Standard deviation of the measurement [m]; as estimated, where none was given.
    evaluations : int
        Histories that were computed.
    widening : float
        By how much the intervals are wider because the model agrees worse than the stated deviations allow.
    correlated : float
        By how much they are wider, at most, because the residuals are correlated from sample to sample.
    others : tuple of dict
        Further sets of parameters that agree about as well.
    """

    question: HistoryQuestion
    estimates: tuple[Estimate, ...]
    correlation: NDArray[np.float64]
    rows: int
    model_m: Column = field(repr=False)
    deviation_m: Column = field(repr=False)
    evaluations: int
    widening: float = 1.0
    correlated: float = 1.0
    others: tuple[Mapping[str, float], ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """The best parameters."""
        return {each.name: each.value for each in self.estimates}

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
    def freedom(self) -> int:
        """Degrees of freedom: samples that count, less parameters that the data determine."""
        return self.rows - sum(each.determined for each in self.estimates)

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals."""
        return float((self.residual**2).sum())

    @property
    def probability(self) -> float | None:
        """Chance of a chi-square as large, if the model is right; None where the deviation was made to agree with it."""
        if self.question.measured.deviation_m is None:
            return None
        return float(chdtrc(self.freedom, self.chi_square))

    @property
    def alike(self) -> list[tuple[str, str, float]]:
        """Pairs of parameters that the data cannot tell apart, with their correlation."""
        return pairs_alike(self.estimates, self.correlation)
