"""Mean, rms and a quantile of a result over records, with errors.

The records are assumed to be samples of one random motion.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BEYOND = 0.025
"""Probability that the quantile lies beyond one end of the 95 % interval."""


class OverRecords(NamedTuple):
    """Statistics of a result over records.

    Attributes
    ----------
    mean, mean_error : float
        Mean, and its standard error.
    rms, rms_error : float
        Root mean square, and its standard error.
    quantile, quantile_low, quantile_high : float
        The requested quantile, and the ends of its 95 % interval. An end is NaN if there are too few records.
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
        Probability of the quantile: the share of records with results below the quantile.

    Notes
    -----
    The ends of the interval are order statistics. The interval is valid for any distribution of the results, since the
    number of results below the quantile has a binomial distribution. H. A. David, H. N. Nagaraja, Order Statistics
    (2003), section 7.1.
    """
    from scipy.special import bdtr

    known = np.sort(values[~np.isnan(values)])
    n = known.size
    if not n:
        return OverRecords(*[np.nan] * len(OverRecords._fields))
    mean, rms = float(known.mean()), float(np.sqrt(np.mean(known**2)))
    spread = [float(each.std(ddof=1)) if n > 1 else np.nan for each in (known, known**2)]
    # entry k is the probability that at most k of the n results are below the quantile
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
    """Return the smallest number of records for which the 95 % interval of the quantile is bounded on both sides."""
    return int(np.ceil(np.log(BEYOND) / np.log(max(share, 1.0 - share))))
