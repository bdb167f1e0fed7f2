"""Mean and standard error of correlated series: overlapping batch means, correlation time, test of stationarity."""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel

FEWEST = 80
"""Least number of samples for an estimate of the correlation."""

# Numbers of adjacent batches. Batches of whole periods have equal means and so understate the error.
# The two numbers have no common factor, so that both rarely give batches of whole periods.
_BATCHES = (61, 19)
# Ratio of the 97.5 % quantile of Student's t to 1.96.
# Overlapping batches have one and a half times the degrees of freedom of adjacent batches.
_STUDENT = (1.014, 1.047)
# Ratio of errors above which longer batches replace shorter batches; a smaller ratio is considered chance.
_LONGER = 1.15

_GROUP = 16  # Number of samples in a group; MSER is more reliable for groups than for single samples.
_DIFFERENT = 3.0  # Least difference of the means, in standard errors, at which the initial part is dropped.
# The mean increases twice over the three thirds of a series. If the second increase is at least this fraction
# of the first increase, the growth has no visible end.
_STEADY_TREND = 0.9
_TREND_BATCHES = 19
_ALL_RISE = _TREND_BATCHES * (_TREND_BATCHES - 1) // 2
_GROWN = 0.1  # Least relative increase of the mean from the first to the last third of an unbounded series.
# Relative error of the mean up to which a series is considered constant.
# Differences between samples are then rounding errors, without a meaningful correlation or trend.
_ROUNDING = 1e-12
# 19 batches form 171 pairs. Up to this difference, the numbers of rising and falling pairs differ only by chance.
# Without a trend, the difference exceeds this value three times in 1,000.
_TREND = 86


class Estimate(NamedTuple):
    """Estimate of the mean from a series.

    Attributes
    ----------
    first, last : int
        Range of the samples that are used.
    mean, error : float
        The mean and its standard error.
    correlation : float
        Integrated correlation time [samples]: the number of samples that are equivalent to one independent sample.
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
    """Mean of samples[first:last], and the standard error of this mean.

    The samples are a stationary series, and are correlated.

    The error comes from batches with 1/61 of the samples, or with 1/19 of the samples if the longer batches
    give a significantly larger error. Batches shorter than the correlation time understate the error, but an
    error from few batches is less certain. 1.96 times the error is the half width of a 95 % interval. For
    fewer than 80 samples, the correlation cannot be estimated, and the error is the largest sample minus the
    smallest.

    Notes
    -----
    A batch begins at every sample (Meketon and Schmeiser 1984). Such overlapping batches have one and a half times the
    degrees of freedom of adjacent batches, so the error is more accurate, and a run ends sooner with the same coverage.
    """
    count = last - first
    mean = _mean(samples, first, last)
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
    """Standard error of the mean of a range, from overlapping batches of a given length."""
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
    """Estimate the mean of the correlated samples[first:last] without their initial transient.

    Notes
    -----
    By the marginal standard error rule (MSER, White 1997), the transient is the initial part whose omission
    minimises Σ(xᵢ − x̄)²/n² of the rest. The transient consists of groups of 16 samples and is at most half
    of the range. The transient is omitted only if its mean differs from the mean of the rest by three
    standard errors. The rule alone would select a part of little variation from a correlated series, and so
    understate the error. Batch means alone would treat a trend as noise. So the series is considered
    stationary only if the remaining batches do not rise or fall more often than by chance (Mann 1945, Kendall
    1975). If a trend remains, the future change of the mean is added to the error. The future change is
    estimated as the remainder of a geometric series through the means of three thirds of the range.
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
def _means_of_thirds(samples: NDArray[np.float64], first: int, last: int) -> tuple[float, float, float]:
    third = (last - first) // 3
    return (
        _mean(samples, first, first + third),
        _mean(samples, first + third, first + 2 * third),
        _mean(samples, first + 2 * third, first + 3 * third),
    )


@kernel
def _rises(samples: NDArray[np.float64], first: int, last: int) -> int:
    """Sum over all pairs of batches: 1 if the later mean is larger, −1 if the later mean is smaller."""
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
    """Estimate how far the mean of a series with a trend is from the limit of the series."""
    one, two, three = _means_of_thirds(samples, first, last)
    step = three - two
    before = two - one
    rate = 1.0
    if before != 0.0:
        rate = min(max(step / before, 0.0), 1.0)
    left = step * rate / (1.0 - rate) if rate < _STEADY_TREND else 10.0 * step
    return max(abs(three + left - mean), abs(three - one))


@kernel
def grows(samples: NDArray[np.float64], first: int, last: int) -> bool:
    """Whether samples[first:last] grow to the end without approaching a limit.

    Every batch must be higher than all earlier batches, and the growth must hardly slow down over the three thirds of
    the series. The result is False for fewer than 80 samples.
    """
    if last - first < FEWEST or _rises(samples, first, last) < _ALL_RISE:
        return False
    one, two, three = _means_of_thirds(samples, first, last)
    return three - two >= _STEADY_TREND * (two - one) and three - one >= _GROWN * one


@kernel
def _transient(samples: NDArray[np.float64], first: int, last: int) -> int:
    """End of the transient at the beginning of a series; `first` if the data show no transient."""
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
