"""The peaks over a band that a damper is compared with: of a tuned mass damper, and of the structure alone."""

import math

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.tmd.transfer import highest, without_absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Excitation


def linear_peaks(
    r: NDArray[np.float64], damping_ratio: float, mass_ratio: float, excitation: Excitation
) -> tuple[float, float]:
    """Give the peaks with a tuned mass damper and without any damper.

    Parameters
    ----------
    r : ndarray, (n,)
        Frequency ratios, rising; the band reaches from the first to the last.
    damping_ratio : float
        Of the structure.
    mass_ratio : float
        Of the tuned mass damper, which has the least peak over all frequencies.
    excitation : str
        What moves the structure.

    Returns
    -------
    (float, float)
        Amplitude ratios. Both are NaN for a single frequency. The first is NaN for a mass ratio of 0, or of 1 and more.
    """
    if r.size == 1:
        return math.nan, math.nan
    at = np.unique(np.append(r, np.clip(1.0, r[0], r[-1])))
    bare = float(without_absorber(at, damping_ratio, excitation).max())
    if not 0 < mass_ratio < 1:
        return math.nan, bare
    absorber = tuned("minimax", mass_ratio, damping_ratio, excitation)
    return highest(absorber, damping_ratio, excitation, (float(r[0]), float(r[-1]))).value, bare
