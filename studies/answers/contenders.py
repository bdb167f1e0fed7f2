"""Which designs may be the best, given what is unknown about each, and how likely it is that the best is another.

Every amplitude that is judged gets an interval, all of them right at once with the stated confidence (Bonferroni), so
that a design is ruled out only where even its lower limit is above the upper limit of another: multiple comparisons
with the best, J. C. Hsu, Ann. Statist. 12 (1984) 1136.
"""

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
LOOKS = 10
"""Looks at the same designs, ever more exact, among which the confidence is divided."""
NODES = 512
ALIKE = 1e-9
"""Relative difference of two exact values that is rounding: the same response, computed on two ways."""
COMPARED = 2000
"""Most designs in one probability; those whose limits lie highest are left out first."""


class Doubt(NamedTuple):
    """How sure the limits of a ranking are.

    Parameters
    ----------
    confidence : float
        Of all limits at once.
    comparisons : int
        Amplitudes that are judged; 0 for those of the question itself.
    """

    confidence: float = CONFIDENCE
    comparisons: int = 0


DOUBT = Doubt()


def half_width(confidence: float, comparisons: int) -> float:
    """Give the half width of an interval in standard errors, so that all of them are right at once.

    Parameters
    ----------
    confidence : float
        Between 0 and 1.
    comparisons : int
        Amplitudes that are judged; each is looked at `LOOKS` times at most.
    """
    return -NormalDist().inv_cdf((1 - confidence) / (2 * LOOKS * max(1, comparisons)))


def limits(amplitude: Floats, error: Floats, z: float) -> tuple[Floats, Floats]:
    """Give the limits of amplitudes; an unknown error leaves everything from 0 open."""
    unknown = np.isnan(error)
    width = z * np.where(unknown, 0.0, error)
    low = np.where(unknown, 0.0, np.maximum(amplitude - width, 0.0))
    return low, np.where(unknown, np.inf, amplitude + width)


def contend(low: Floats, high: Floats) -> NDArray[np.bool_]:
    """Say which designs may be the best: those that no other is surely better than; an unknown limit is none."""
    return np.asarray(low <= np.nanmin(high, initial=np.inf))


def ties(value: Floats, low: Floats, high: Floats, z: float) -> dict[str, float]:
    """Judge ranked values, the best first, by their limits.

    Parameters
    ----------
    value, low, high : ndarray, (n,)
        Values with their limits; an upper limit that is not known is NaN.
    z : float
        Half width of the limits in standard errors.

    Returns
    -------
    dict
        `confidence`, `as_good` (further values that may be the least) and `chance_of_another`, left out where errors are
        not known; nothing for no values.
    """
    if not value.size:
        return {}
    may_be = contend(low, high)
    said: dict[str, float] = {"confidence": CONFIDENCE, "as_good": int(may_be.sum()) - 1}
    # of a worst case: the error of whatever may exceed it most
    chance = chance_of_another(value[may_be], (high[may_be] - value[may_be]) / z, 0)
    return said if math.isnan(chance) else said | {"chance_of_another": chance}


def chance_of_another(value: Floats, error: Floats, best: int) -> float:
    """Probability that another design has the least value, each of them normal around what was computed.

    Parameters
    ----------
    value, error : ndarray, (n,)
        Values with their standard errors, taken as independent.
    best : int
        The design that is taken for the best.

    Returns
    -------
    float
        NaN where an error is not known. A design that has the value of the best up to rounding is as good, not another.
    """
    if value.size < 2:
        return 0.0
    if np.isnan(error).any():
        return math.nan
    others = np.argsort(value - 4 * error, kind="stable")
    rounding = ALIKE * abs(float(value[best]))
    same = (np.abs(value - value[best]) <= rounding) & (np.maximum(error, error[best]) <= rounding)
    others = others[~same[others] & (others != best)][:COMPARED]
    # the best at equally likely places
    nodes = (np.arange(NODES) + 0.5) / NODES
    if error[best] > 0:
        normal = NormalDist(float(value[best]), float(error[best]))
        at = np.array([normal.inv_cdf(node) for node in nodes])
    else:
        at = np.array([value[best]])
    distance = at[:, None] - value[others]
    doubt = error[others]
    with np.errstate(divide="ignore", invalid="ignore"):
        # what has no error is better or it is not; a tie is not
        scaled = np.where(doubt > 0, distance / doubt, np.where(distance > 0, np.inf, -np.inf))
    below = np.clip(_normal(scaled), 0.0, 1.0)
    return float(1 - np.prod(1 - below, axis=1).mean())


def _normal(z: Floats) -> Floats:
    """The normal distribution function."""
    return np.asarray(0.5 * np.vectorize(math.erfc, otypes=[float])(-z / math.sqrt(2)))
