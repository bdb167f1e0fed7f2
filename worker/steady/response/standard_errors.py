"""Mean and standard error of correlated series: overlapping batch means, correlation time, test of stationarity."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel

FEWEST = 80
"""Samples below which correlation cannot be estimated."""

# Numbers of adjacent batches. They have no common factor, because batches of a whole number of periods would have no
# spread.
_BATCHES = (61, 19)
# Student's t at 97.5 % over 1.96, for the degrees of freedom of overlapping batches, which are one and a half times
# those of adjacent ones.
_STUDENT = (1.014, 1.047)
_LONGER = 1.15  # ratio above which the error by longer batches replaces that by shorter ones; less is chance

_GROUP = 16  # samples in a group of the truncation rule; MSER is misled less by groups than by single samples
_DIFFERENT = 3.0  # standard errors by which a beginning must differ from the rest to be left out
_STEADY_TREND = 0.9  # ratio of a third's increase to the previous one above which there is no sign of an end
_TREND_BATCHES = 19
_ALL_RISE = _TREND_BATCHES * (_TREND_BATCHES - 1) // 2
_GROWN = 0.1  # share by which the last third of a series without a bound exceeds the first
# Relative error of a constant. The differences of its samples are rounding, which has its own correlation and trend.
_ROUNDING = 1e-12
# Largest difference between the numbers of rising and of falling pairs, among the 171 pairs of 19 batches, that counts
# as chance. Batches without a trend exceed it, in either direction, three times in 1,000.
_TREND = 86


class Estimate(NamedTuple):
    """Estimate of the mean from a series.

    Attributes
    ----------
    first, last : int
        Range used.
    mean, error : float
        The mean and its standard error.
    correlation : float
        Integrated correlation time [samples]: the number of samples that are worth one independent sample.
    stationary : bool
        Whether the range shows no trend.
    """

    first: int
    last: int
    mean: float
    error: float
    correlation: float
    stationary: bool


@kernel
def mean_and_error(samples: NDArray[np.float64], first: int, last: int) -> tuple[float, float]:
    """Mean of samples[first:last] and its standard error.

    Parameters
    ----------
    samples : array
        Correlated, stationary.
    first, last : int
        Range used.

    Returns
    -------
    mean, error : float
        The error comes from batches of 1/61 of the range, unless batches of 1/19 give a significantly larger one.
        Batches shorter than the correlation time understate the error, but an error from few batches is less certain.
        1.96 times the error is the half width of a 95 % interval. The correlation of fewer than 80 samples cannot be
        estimated, so the error is then the largest sample minus the smallest.

    Notes
    -----
    A batch begins at every sample (Meketon and Schmeiser 1984). Such overlapping batches have one and a half times the
    degrees of freedom of adjacent ones, so the error is more accurate, and a run ends sooner with the same coverage.
    """
    count = last - first
    total = 0.0
    for i in range(first, last):
        total += samples[i]
    mean = total / count
    if count < FEWEST:
        lowest = samples[first]
        highest = samples[first]
        for i in range(first, last):
            lowest = min(lowest, samples[i])
            highest = max(highest, samples[i])
        return mean, highest - lowest
    error = _STUDENT[0] * _error_by_batches(samples, first, last, mean, count // _BATCHES[0])
    by_longer = _STUDENT[1] * _error_by_batches(samples, first, last, mean, count // _BATCHES[1])
    return mean, by_longer if by_longer > _LONGER * error else error


@kernel
def _error_by_batches(samples: NDArray[np.float64], first: int, last: int, mean: float, length: int) -> float:
    """Standard error of the mean of a range, by the means of batches of a given length, one of which begins at every
    sample.
    """
    total = 0.0
    for i in range(first, first + length):
        total += samples[i]
    square = (total / length - mean) ** 2
    for i in range(first + length, last):
        total += samples[i] - samples[i - length]
        square += (total / length - mean) ** 2
    count = last - first
    return sqrt(length * square / (float(count - length + 1) * (count - length)))


@kernel
def estimate(samples: NDArray[np.float64], first: int, last: int) -> Estimate:
    """Estimate the mean of samples[first:last], without the transient at the beginning if the data show one.

    Parameters
    ----------
    samples : array
        Correlated.
    first, last : int
        Range given.

    Returns
    -------
    Estimate

    Notes
    -----
    The transient is that of the marginal standard error rule (MSER, White 1997). It is the beginning, in groups of 16
    and at most the first half, whose omission minimises Σ(xᵢ − x̄)²/n² of the rest. It is left out only if its mean
    differs from that of the rest by three standard errors. The rule alone would prefer a part of a correlated series
    with little variation, and so understate the error. Batch means alone would treat a trend as noise. So the mean
    counts as stationary only if the remaining batches do not rise or fall more often than by chance (Mann 1945, Kendall
    1975). The remainder of a trend is added to the error; it follows from the geometric series through the means of its
    thirds.
    """
    cut = _transient(samples, first, last)
    mean, error = mean_and_error(samples, cut, last)
    count = last - cut
    variance = 0.0
    for i in range(cut, last):
        variance += (samples[i] - mean) ** 2
    variance /= count
    correlation = error * error * count / variance if variance > 0.0 else 0.0
    stationary = False
    if count >= FEWEST:
        stationary = abs(_rises(samples, cut, last)) <= _TREND
        if not stationary:
            error += _to_come(samples, cut, last, mean)
        if error <= _ROUNDING * abs(mean):
            correlation, stationary = 0.0, True
    return Estimate(cut, last, mean, error, correlation, stationary)


@kernel
def _mean(samples: NDArray[np.float64], first: int, last: int) -> float:
    total = 0.0
    for i in range(first, last):
        total += samples[i]
    return total / (last - first)


@kernel
def _rises(samples: NDArray[np.float64], first: int, last: int) -> int:
    """Number of pairs of batches whose later one is higher, minus the number of pairs whose later one is lower."""
    length = (last - first) // _TREND_BATCHES
    means = np.empty(_TREND_BATCHES)
    for b in range(_TREND_BATCHES):
        means[b] = _mean(samples, first + b * length, first + (b + 1) * length)
    rises = 0
    for b in range(_TREND_BATCHES):
        for a in range(b):
            rises += int(means[b] > means[a]) - int(means[b] < means[a])
    return rises


@kernel
def _to_come(samples: NDArray[np.float64], first: int, last: int, mean: float) -> float:
    """Distance from the mean of a series with a trend to its possible limit."""
    third = (last - first) // 3
    one = _mean(samples, first, first + third)
    two = _mean(samples, first + third, first + 2 * third)
    three = _mean(samples, first + 2 * third, first + 3 * third)
    step = three - two
    before = two - one
    rate = 1.0
    if before != 0.0:
        rate = min(max(step / before, 0.0), 1.0)
    left = step * rate / (1.0 - rate) if rate < _STEADY_TREND else 10.0 * step
    return max(abs(three + left - mean), abs(three - one))


@kernel
def grows(samples: NDArray[np.float64], first: int, last: int) -> bool:
    """Whether samples[first:last] grow to their end and show no bound: every batch is higher than all before it, and
    the increase of the last third is hardly smaller than the previous one. Fewer than 80 samples are inconclusive.
    """
    if last - first < FEWEST or _rises(samples, first, last) < _ALL_RISE:
        return False
    third = (last - first) // 3
    one = _mean(samples, first, first + third)
    two = _mean(samples, first + third, first + 2 * third)
    three = _mean(samples, first + 2 * third, first + 3 * third)
    return three - two >= _STEADY_TREND * (two - one) and three - one >= _GROWN * one


@kernel
def _transient(samples: NDArray[np.float64], first: int, last: int) -> int:
    """End of the transient at the beginning of a series; `first` if the data show none."""
    groups = (last - first) // _GROUP
    if last - first < 2 * FEWEST:
        return first
    means = np.empty(groups)
    for g in range(groups):
        end = last - (groups - 1 - g) * _GROUP
        means[g] = _mean(samples, end - _GROUP, end)
    total = 0.0
    square = 0.0
    least = -1.0
    cut = 0
    centre = _mean(samples, first, last)
    for g in range(groups - 1, -1, -1):
        total += means[g] - centre
        square += (means[g] - centre) ** 2
        n = groups - g
        if 2 * n >= groups:
            marginal = (square - total * total / n) / (float(n) * n)
            if least < 0.0 or marginal <= least:
                least = marginal
                cut = g
    if cut == 0:
        return first
    start = last - (groups - cut) * _GROUP
    rest, error = mean_and_error(samples, start, last)
    ratio = float(last - start) / (start - first)
    apart = abs(_mean(samples, first, start) - rest)
    return start if apart > _DIFFERENT * error * sqrt(1.0 + ratio) else first
