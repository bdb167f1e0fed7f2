"""Scatter of a result over records that are draws of one motion: its rms and a quantile, each with its error."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BEYOND = 0.025
"""Share of the draws that may lie beyond either end of an interval of 95 %."""


class OverRecords(NamedTuple):
    """Statistics of a result over records.

    Attributes
    ----------
    mean, mean_error : float
        Standard error of the mean.
    rms, rms_error : float
        Root of the mean square, and its standard error.
    quantile, quantile_low, quantile_high : float
        The requested quantile, and the ends of its 95 % interval; an end is NaN if there are too few records.
    """

    mean: float
    mean_error: float
    rms: float
    rms_error: float
    quantile: float
    quantile_low: float
    quantile_high: float


def over_records(values: Floats, share: float) -> OverRecords:
    """Compute the statistics of a result over several records.

    Parameters
    ----------
    values : ndarray, (n,)
        One positive value per record; NaN if unknown.
    share : float
        Share of the records that stay below the quantile.

    Notes
    -----
    The ends of the interval are order statistics. They are valid for any distribution, since the number of results
    below the quantile is binomial. H. A. David, H. N. Nagaraja, Order Statistics (2003), section 7.1.
    """
    from scipy.special import bdtr

    known = np.sort(values[~np.isnan(values)])
    n = known.size
    if not n:
        return OverRecords(*[np.nan] * len(OverRecords._fields))
    mean, rms = float(known.mean()), float(np.sqrt(np.mean(known**2)))
    spread = [float(each.std(ddof=1)) if n > 1 else np.nan for each in (known, known**2)]
    # the probability that at most this many of n results are below the quantile
    below = bdtr(np.arange(n), n, share)
    low, high = int((below <= BEYOND).sum()) - 1, int((below < 1.0 - BEYOND).sum())
    return OverRecords(
        mean,
        spread[0] / n**0.5,
        rms,
        spread[1] / n**0.5 / (2.0 * rms) if rms > 0.0 else 0.0,
        float(np.quantile(known, share, method="median_unbiased")),
        float(known[low]) if low >= 0 else np.nan,
        float(known[high]) if high < n else np.nan,
    )


def enough_records(share: float) -> int:
    """Give the least number of records for which the interval of the quantile has both ends."""
    return int(np.ceil(np.log(BEYOND) / np.log(max(share, 1.0 - share))))
