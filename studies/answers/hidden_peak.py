"""Whether a peak may lie between the frequencies at which a response was computed."""

import numpy as np
from numpy.typing import NDArray


def may_hide(r: NDArray[np.float64], values: NDArray[np.float64], peak: float, mass_ratio: float) -> bool:
    """Whether a resonance of the structure may be as high as `peak` between two of the frequencies.

    Beside a resonance at r₀ that is P high, X = 1/√((1 + β)² (r² − r₀²)² + 1/P²), where the particle's mass β moves with the
    structure; without it the factor is 1. In the middle of an interval the resonance is seen least: at both ends X is that of
    half its width in r². So where both ends are lower, no resonance as high lies between them. What is narrower than a
    resonance of the structure, such as a response of its own beside a jump, is not excluded.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequencies and the amplitude ratio there.
    peak : float
        Amplitude ratio.
    mass_ratio : float
        β.
    """
    half = 0.5 * (1.0 + mass_ratio) * np.diff(r * r)
    return bool((np.maximum(values[:-1], values[1:]) >= 1.0 / np.sqrt(half**2 + peak**-2.0)).any())
