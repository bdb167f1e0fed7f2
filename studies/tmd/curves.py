"""Exact frequency responses, sampled so closely that lines between their points look like the curves."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.transfer import amplitude_ratio, peaks, without_absorber
from damperlab.studies.vocabulary import Excitation

BEND = 0.01
"""Largest relative deviation of a curve from the lines between its points. This deviation is too small to be seen."""
LEAST_SHARE = 1e-5
"""Intervals of at most this share of the band are not divided. Otherwise the division would not end near an infinite
peak.
"""


def exact_curves(
    frequency_ratio: ArrayLike,
    absorber: Absorber,
    structural_damping: float = 0.0,
    excitation: Excitation = "base",
) -> dict[str, list[float]]:
    """Return the amplitude ratio with a tuned mass damper and without a damper over a band.

    Intervals are divided until lines on a logarithmic amplitude scale follow both curves to within `BEND`.

    Parameters
    ----------
    frequency_ratio : array_like, (n,)
        Ascending frequency ratios, all of which are kept. Further frequency ratios are added between the first and the
        last frequency ratio.
    absorber, structural_damping, excitation
        As in `amplitude_ratio`.

    Returns
    -------
    dict of list
        `frequency_ratio`, and the amplitude ratios `tmd` and `no_damper` at these frequency ratios. An amplitude ratio
        is infinite at an undamped resonance.
    """
    given = np.asarray(frequency_ratio, dtype=float)
    places = [peak.frequency_ratio for peak in peaks(absorber, structural_damping, excitation)] + [1.0]
    r = np.union1d(given, [each for each in places if given[0] < each < given[-1]])
    curves = _both(r, absorber, structural_damping, excitation)
    narrow = LEAST_SHARE * (r[-1] - r[0])
    split = np.flatnonzero(np.diff(r) > narrow)
    while split.size:
        # an interval is tested at both thirds, because the line around an inflection may meet the curve in the middle
        step = np.diff(r)[split] / 3
        thirds = np.stack([r[split] + step, r[split] + 2 * step])
        between = _both(thirds, absorber, structural_damping, excitation)
        with np.errstate(divide="ignore", invalid="ignore"):
            left, right = np.log(curves[:, split]), np.log(curves[:, split + 1])
            line = np.stack([left + (right - left) / 3, left + 2 * (right - left) / 3], axis=1)
            bend = np.abs(np.log(between) - line)
        at = np.repeat(split + 1, 2)
        r = np.insert(r, at, thirds.T.ravel())
        curves = np.insert(curves, at, between.transpose(0, 2, 1).reshape(2, -1), axis=1)
        bent = ~(bend < math.log1p(BEND)).all(axis=(0, 1))
        first = (split + 2 * np.arange(split.size))[bent]
        split = np.sort(np.concatenate([first, first + 1, first + 2]))
        split = split[np.diff(r)[split] > narrow]
    tmd, no_damper = curves
    return {"frequency_ratio": r.tolist(), "tmd": tmd.tolist(), "no_damper": no_damper.tolist()}


def _both(
    r: NDArray[np.float64], absorber: Absorber, structural_damping: float, excitation: Excitation
) -> NDArray[np.float64]:
    beside = amplitude_ratio(r, absorber, structural_damping, excitation)
    return np.stack([beside, without_absorber(r, structural_damping, excitation)])
