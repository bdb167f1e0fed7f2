"""Mean and standard error of correlated cycle peaks: batch means."""

from math import sqrt

from damperlab.worker.jit import kernel

# Odd and without a common factor: batches of a whole number of periods would see no spread at all.
_BATCHES = (9, 19, 37)
# Student's t at 97.5 % over 1.96, for batches − 1 degrees of freedom: ±1.96 standard errors are a 95 % interval.
_STUDENT = (1.177, 1.072, 1.035)


@kernel
def mean_and_error(samples, first, last):
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
        The error is the largest of those by 9, 19 and 37 batches: batches shorter than the correlation time
        understate it, and which are too short is not known beforehand. 1.96 times it is the half width of a 95 %
        interval. Fewer than 80 samples say nothing of their correlation: the whole spread then.
    """
    count = last - first
    total = 0.0
    for i in range(first, last):
        total += samples[i]
    mean = total / count
    if count < 80:
        lowest = samples[first]
        highest = samples[first]
        for i in range(first, last):
            lowest = min(lowest, samples[i])
            highest = max(highest, samples[i])
        return mean, highest - lowest
    worst = 0.0
    for j in range(3):
        batches = _BATCHES[j]
        length = count // batches
        start = last - batches * length
        square = 0.0
        centre = 0.0
        for b in range(batches):
            batch = 0.0
            for i in range(start + b * length, start + (b + 1) * length):
                batch += samples[i]
            batch = batch / length - mean
            centre += batch
            square += batch * batch
        variance = max(square / batches - (centre / batches) ** 2, 0.0)
        worst = max(worst, _STUDENT[j] * sqrt(variance / (batches - 1)))
    return mean, worst
