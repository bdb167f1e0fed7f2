"""The result of a fit: parameters with intervals and correlations, and the agreement with the measurement."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.fit.columns import CONDITIONS
from damperlab.studies.fit.question import RATIO_OF, FitQuestion, Free
from damperlab.studies.portable import log
from damperlab.studies.variables import ResponseClass
from damperlab.studies.vocabulary import OF_PARTICLE

UNDETERMINED = 0.8
"""The data do not determine a parameter whose confidence interval is wider than this share of the range."""
AT_END = 0.05
"""An interval reaches an end of the range only if its distance from that end is at most this share of the range."""
NEAR_END = 0.25
"""An interval reaches an end of the range only if its distance from that end is at most this share of its own width.

If all values in a range agree equally well, the interval for the confidence c covers the share c of the
range, and ends (1 − c)/2 of the range before either end. For c ≥ 2/3, the distance (1 − c)/2 is at most a
quarter of the interval's width.
"""
ALIKE = 0.95
"""Absolute correlation above which the data do not separate two parameters, unless both have narrow intervals."""
NARROW = 0.1
"""Width of an interval, relative to the value, up to which a parameter counts as known.

The limit is a tenth, because a design counts as equally good if its value is at most a tenth worse. The
interval of a parameter allows for every value of the other parameters. So a parameter with a narrow
interval is known, even if it is correlated with another parameter.
"""
BARELY = 0.99
"""Limit that replaces `ALIKE` for a pair with a parameter that the data do not determine."""
DOUBTED = 0.01
"""p-value of the chi-square test below which the model and the stated deviations are reported to disagree."""
OUTLIER = 0.01
"""Probability that any row of a measurement without outliers is called an outlier."""
IRREGULAR = (int(ResponseClass.MODULATED), int(ResponseClass.CHAOTIC))
"""Classes of responses that do not repeat."""
CURVE_VALUES = 101
"""Number of frequencies in the study that a fit writes."""


@dataclass(frozen=True)
class Estimate:
    """One estimated parameter.

    Parameters
    ----------
    name : str
        Name in a study.
    value : float
        The best value.
    low, high : float
        Ends of the confidence interval, for which all other parameters are free.
    spread : float
        Standard deviation of the estimate.
    lowest, highest : float
        Ends of the range that was searched.
    share_low, share_high : float
        Ends of the interval as fractions of the range, on the linear or logarithmic scale of the search.
    """

    name: str
    value: float
    low: float
    high: float
    spread: float
    lowest: float
    highest: float
    share_low: float
    share_high: float

    @classmethod
    def of(cls, free: Free, share: float, interval: tuple[float, float], spread: float) -> "Estimate":
        """Make the estimate of a parameter from the best value and the interval, as fractions of the range."""
        value, low, high = (float(each) for each in free.values(np.array([share, *interval])))
        return cls(free.name, value, low, high, spread, free.low, free.high, *map(float, interval))

    @property
    def determined(self) -> bool:
        """Whether the data narrow the range of the parameter."""
        return self.share_high - self.share_low < UNDETERMINED

    @property
    def narrow(self) -> bool:
        """Whether the interval is narrow relative to the value."""
        return self.high - self.low <= NARROW * abs(self.value)

    @property
    def bounded_below(self) -> bool:
        """Whether the data exclude the low end of the range."""
        return self.share_low > self._near_end

    @property
    def bounded_above(self) -> bool:
        """Whether the data exclude the high end of the range."""
        return self.share_high < 1.0 - self._near_end

    @property
    def _near_end(self) -> float:
        """Largest distance at which an interval still reaches an end of the range, as a fraction of the range."""
        return min(AT_END, NEAR_END * (self.share_high - self.share_low))

    @property
    def digits(self) -> int:
        """Number of significant digits to write, 4 or more: enough for 2 digits of the interval's half-width."""
        half = 0.5 * (self.high - self.low)
        largest = max(abs(self.low), abs(self.high))
        if not 0.0 < half < largest:
            return 4
        return max(4, math.floor(math.log10(largest)) - math.floor(math.log10(half)) + 2)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Results that the fits of a frequency response and of a time history have in common.

    Parameters
    ----------
    estimates : tuple of Estimate
        The estimated parameters, in the order in which the fit defines them.
    correlation : ndarray, shape (parameters, parameters)
        Correlations of the parameters.
    evaluations : int
        Number of computed sets of parameters.
    widening : float
        Factor by which the intervals are widened if the model agrees worse than the stated deviations allow; otherwise
        1.
    others : tuple of dict
        Other sets of parameters that agree with the measurement about as well.
    """

    estimates: tuple[Estimate, ...]
    correlation: NDArray[np.float64]
    evaluations: int
    widening: float = 1.0
    others: tuple[Mapping[str, float], ...] = ()

    @property
    def residual(self) -> NDArray[np.float64]:
        """Measured minus computed, in standard deviations, for the rows that are used; NaN if a response failed."""
        raise NotImplementedError

    @property
    def freedom(self) -> int:
        """Degrees of freedom: rows with a residual, minus parameters that the data determine."""
        return int(np.isfinite(self.residual).sum()) - sum(each.determined for each in self.estimates)

    @property
    def values(self) -> dict[str, float]:
        """The best parameters."""
        return {each.name: each.value for each in self.estimates}

    @property
    def chosen(self) -> str:
        """Sentence about the values in `study` that were neither given nor measured; empty if there are none."""
        return ""

    @property
    def chi_square(self) -> float:
        """Sum of the squared residuals."""
        return float(np.nansum(self.residual**2))

    @property
    def alike(self) -> list[tuple[str, str, float]]:
        """Pairs of parameters that the data cannot separate, with the correlation of each pair."""
        found = []
        for j, second in enumerate(self.estimates):
            for i, first in enumerate(self.estimates[:j]):
                both = first.determined and second.determined
                if first.narrow and second.narrow:
                    continue
                if abs(self.correlation[i, j]) > (ALIKE if both else BARELY):
                    found.append((first.name, second.name, float(self.correlation[i, j])))
        return found


@dataclass(frozen=True, kw_only=True)
class Fitted(Outcome):
    """The result of a fit of a frequency response. Arrays have the shape (rows,) and the units of the measurement.

    Parameters
    ----------
    question : FitQuestion
        The definition of the fit.
    model, model_error : ndarray
        The response with the best parameters, and the uncertainty due to chaos and to jumps of the response within the
        uncertainty of the parameters. NaN if a response failed.
    deviation : ndarray
        Standard deviation of the measurement; an estimate if none was given.
    impacts_per_cycle, stick_fraction, response_class : ndarray
        Results of the responses with the best parameters.
    """

    question: FitQuestion
    model: NDArray[np.float64]
    model_error: NDArray[np.float64]
    deviation: NDArray[np.float64]
    impacts_per_cycle: NDArray[np.float64]
    stick_fraction: NDArray[np.float64]
    response_class: NDArray[np.int64]

    @property
    def residual(self) -> NDArray[np.float64]:
        """Measured minus computed, in standard deviations of measurement and model together; NaN if a response failed.

        If the deviations are relative to the amplitudes, the logarithms of the amplitudes are compared.
        """
        measured = self.question.measured.amplitude
        if self.question.in_shares:
            both = np.hypot(self.deviation / measured, self.model_error / self.model)
            return log(measured / self.model) / both
        return np.asarray((measured - self.model) / np.hypot(self.deviation, self.model_error))

    @property
    def probability(self) -> float | None:
        """p-value of the chi-square test; None if no deviations are stated, or if no degree of freedom is left."""
        if self.question.deviation is None or self.freedom < 1:
            return None
        from scipy.special import chdtrc

        return float(chdtrc(self.freedom, self.chi_square))

    @property
    def outliers(self) -> list[int]:
        """Indices of the rows that deviate more than chance allows (Bonferroni), the largest deviation first."""
        limit = outlier_limit(self.question.measured.rows)
        off = np.nan_to_num(np.abs(self.residual))
        return [int(row) for row in np.argsort(-off, kind="stable") if off[row] > limit]

    @property
    def irregular(self) -> int:
        """Number of rows whose response does not repeat. For these rows, the model has a statistical error."""
        return int(np.isin(self.response_class, IRREGULAR).sum())

    @property
    def never_strikes(self) -> bool:
        """Whether there is a particle that strikes no wall in any response."""
        particle = self.question.settings.get("particle", True) is not False
        return particle and bool(np.nanmax(self.impacts_per_cycle, initial=0.0) == 0.0)

    @property
    def always_sticks(self) -> bool:
        """Whether friction locks the structure in all of the responses."""
        return bool(np.nanmin(self.stick_fraction, initial=1.0) > 1.0 - 1e-6)

    def study(self) -> dict[str, Any]:
        """Write the prototype as a study.

        Returns
        -------
        dict
            The definition of the study with the estimated numbers, over the measured band. A condition that differs
            between rows becomes an axis, except for the base amplitude, which is taken from the first row.
        """
        measured = self.question.measured
        every = [
            self.question.given(self.values, conditions) for conditions, _ in self.question.configurations
        ]
        given: dict[str, Any] = dict(every[0])
        for name in CONDITIONS:
            several = sorted({one[name] for one in every if name in one})
            if len(several) > 1 and name != "base_amplitude_m":
                given[name] = several
        ratios = [
            self.question.ratios(one, rows)
            for one, (_, rows) in zip(every, self.question.configurations, strict=True)
        ]
        low, high = min(float(r.min()) for r in ratios), max(float(r.max()) for r in ratios)
        band: Any = {"start": low, "stop": high, "num": CURVE_VALUES} if low < high else low
        document = self.question.document(given, band)
        document["name"] = f"{measured.name}, fitted"
        return document

    @property
    def of_no_effect(self) -> list[str]:
        """Estimated parameters without effect on any response, because the particle never strikes a wall."""
        if not self.never_strikes:
            return []
        names = (each.name for each in self.estimates)
        return [name for name in names if RATIO_OF.get(name, name) in OF_PARTICLE]


def outlier_limit(rows: int) -> float:
    """Return the number of standard deviations that any residual exceeds with probability `OUTLIER`."""
    from scipy.special import chdtri

    return math.sqrt(chdtri(1.0, OUTLIER / rows))
