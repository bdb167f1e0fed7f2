"""The peaks over a band that a damper is compared with: of a tuned mass damper, and of the structure alone."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.tmd.transfer import highest, without_absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Excitation

UNBOUNDED = "grows without bound"
"""Text for an infinite peak."""


def linear_peaks(
    r: NDArray[np.float64], damping_ratios: Sequence[float], mass_ratio: float, excitation: Excitation
) -> tuple[float, float]:
    """Give the largest peaks with a tuned mass damper and without any damper, over structures of several damping ratios.

    Parameters
    ----------
    r : ndarray, (n,)
        Frequency ratios, rising; the band reaches from the first to the last.
    damping_ratios : sequence of float
        Of the structures.
    mass_ratio : float
        Of the tuned mass damper. It has the least peak over all frequencies for the least damped structure.
    excitation : str
        What moves the structures.

    Returns
    -------
    (float, float)
        Amplitude ratios. Both are NaN for a single frequency. The first is NaN for a mass ratio of 0, or of 1 and more;
        the second is infinite for an undamped structure at resonance.
    """
    if r.size == 1:
        return math.nan, math.nan
    at = np.unique(np.append(r, np.clip(1.0, r[0], r[-1])))
    bare = max(float(without_absorber(at, zeta, excitation).max()) for zeta in damping_ratios)
    if not 0 < mass_ratio < 1:
        return math.nan, bare
    absorber, band = (
        tuned("minimax", mass_ratio, min(damping_ratios), excitation),
        (float(r[0]), float(r[-1])),
    )
    return max(highest(absorber, zeta, excitation, band).value for zeta in damping_ratios), bare
