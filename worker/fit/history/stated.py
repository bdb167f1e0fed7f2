"""Converts a fit of a time history into a result with the names and units of the question."""

from statistics import NormalDist

import numpy as np
from scipy.special import chdtrc, chdtri

from damperlab.studies.fit.fitted import DOUBTED, Estimate
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.portable import product
from damperlab.worker.fit.history.beginning import Beginning
from damperlab.worker.fit.history.march import displacement
from damperlab.worker.fit.history.spread import Spread
from damperlab.worker.fit.history.trials import Matrix, Trials

UNKNOWN = 0.25
"""Standard deviation, as a fraction of a range, above which a parameter is undetermined.

The standard deviation of a uniform density over the range is 0.29.
"""
AS_GOOD = 6.0
"""Difference of chi-square up to which two parameter sets are equally good."""


def stated(trials: Trials, held: Beginning) -> FittedHistory:
    """Return the result of a fit: the best parameters over a beginning, and their uncertainty."""
    question, spread, place = trials.question, held.spread, held.best
    measured = question.measured
    covariance = spread.covariance
    correlated = _correlated(spread, max(1, round(1.0 / (question.frequency_hz * measured.step_s))))
    widening = _widening(trials, spread)
    deviation = np.sqrt(np.diag(covariance)) * correlated * widening
    reach = NormalDist().inv_cdf(0.5 + 0.5 * question.confidence)
    low, high = (np.clip(place.shares + side * reach * deviation, 0.0, 1.0) for side in (-1.0, 1.0))
    # if the data do not determine a parameter, its interval is the whole range
    unknown = np.sqrt(np.diag(covariance)) > UNKNOWN
    low, high = np.where(unknown, 0.0, low), np.where(unknown, 1.0, high)
    # because of impacts, parameter sets far from the best set may agree equally well
    limit = chdtri(1.0, 1.0 - question.confidence) * widening**2
    good = np.stack(
        [each.shares for each in (*held.places, *held.tried) if held.above(each, trials) <= limit]
    )
    low, high = np.minimum(low, good.min(axis=0)), np.maximum(high, good.max(axis=0))
    estimates = []
    for i, each in enumerate(question.free):
        near = np.clip(place.shares[i] + deviation[i] * np.array([-1.0, 1.0]), 0.0, 1.0)
        slope = np.ptp(each.values(near)) / max(float(np.ptp(near)), 1e-300)
        spread_i = float(slope * deviation[i])
        estimates.append(Estimate.of(each, place.shares[i], (low[i], high[i]), spread_i))
    sizes = np.sqrt(np.diag(covariance))
    return FittedHistory(
        question=question,
        estimates=tuple(estimates),
        correlation=covariance / np.outer(sizes, sizes),
        rows=held.rows,
        model_m=displacement(question, question.values(place.shares)),
        deviation_m=np.sqrt(trials.variance(place.squares, held.rows)) * trials.unit,
        evaluations=trials.evaluations,
        widening=widening,
        correlated=float(correlated.max()),
        others=tuple(
            question.values(each.shares)
            for each in held.places[1:]
            if held.above(each, trials) <= AS_GOOD and not _within(each.shares, low, high)
        ),
    )


def _within(shares: Matrix, low: Matrix, high: Matrix) -> bool:
    return bool(((low <= shares) & (shares <= high)).all())


def _correlated(spread: Spread, period: int) -> Matrix:
    """Return the factors by which correlated residuals increase the standard deviations (Newey and West 1987).

    Lags up to one period of the structure, or up to a tenth of the rows if this is less, are included. Each factor is
    at least 1.
    """
    lags = min(period, spread.residual.size // 10)
    pulls = spread.slopes * spread.residual[:, None]
    middle = product(pulls.T, pulls)
    for lag in range(1, lags + 1):
        shifted = product(pulls[lag:].T, pulls[:-lag])
        middle += (1.0 - lag / (lags + 1)) * (shifted + shifted.T)
    covariance = spread.covariance
    found = np.diag(product(product(covariance, middle), covariance)) / np.diag(covariance)
    return np.sqrt(np.maximum(found, 1.0))


def _widening(trials: Trials, spread: Spread) -> float:
    """Return the factor that widens the intervals if residuals exceed the stated deviations (Birge 1932)."""
    freedom = spread.residual.size - spread.centre.size
    squares = float((spread.residual**2).sum())
    given = trials.question.measured.deviation_m is not None
    if not given or chdtrc(freedom, squares) > DOUBTED:
        return 1.0
    return float(np.sqrt(squares / freedom))
