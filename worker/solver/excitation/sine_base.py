"""A harmonic excitation over half a cycle, divided into equal panels: a shaken base, or a force on the structure.

Half a cycle is sufficient, because the second half equals the first with every sign flipped. So the phase restarts at 0
each half cycle, and sin(rτ) loses no digits at large τ.
"""

from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.motion.quadratic_forms import base_forms
from damperlab.worker.solver.motion.taylor import LARGEST_WINDOW, base_rows


class Forced(NamedTuple):
    """Frequency of a force on the structure; the frequency of a shaken base is a plain number.

    Attributes
    ----------
    frequency_ratio : float
        r.
    """

    frequency_ratio: float


class SineBase(NamedTuple):
    """The shaken base over half a cycle.

    Attributes
    ----------
    frequency_ratio, two_zeta : float
        r and 2ζ.
    window : float
        Length of a panel [1/ω_n].
    windows : int
        Panels per half cycle.
    sine, cosine : array, shape (windows + 1,)
        sin φ and cos φ at the panel ends.
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of the factors of sin φ and cos φ in s.
    forms : array, shape (5,), or None
        Integrals over a panel (`quadratic_forms.base_forms`); None if no meter needs energies.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


class SineForce(NamedTuple):
    """A force sin φ on the structure over half a cycle, divided by the amplitude F₀.

    The base is at rest, and lengths are divided by F₀/k. The attributes are those of `SineBase`, with the force instead
    of s.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


@inlined
def base_rate_at_phase_zero(frequency_ratio: float | Forced) -> float:
    """s' at phase 0; 0 under a force, because the base is at rest."""
    if isinstance(frequency_ratio, Forced):
        return 0.0
    return frequency_ratio


@kernel
def make_sine(
    damping_ratio: float, frequency_ratio: float | Forced, energies: bool | None
) -> SineBase | SineForce:
    """Make a shaken base, or a force if the frequency is `Forced`, from the parameters of `make_sine_base`."""
    if isinstance(frequency_ratio, Forced):
        return SineForce(*make_sine_base(damping_ratio, frequency_ratio.frequency_ratio, energies))
    return make_sine_base(damping_ratio, frequency_ratio, energies)


@kernel
def make_sine_base(damping_ratio: float, frequency_ratio: float, energies: bool | None) -> SineBase:
    """Divide half a cycle into the fewest panels of a length h with h · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    energies : True or None
        True if the meter needs integrals (`observe.meter.Meter`), else None.
    """
    half = pi / frequency_ratio
    count = ceil(half * (1.0 + damping_ratio) * max(1.0, frequency_ratio) / LARGEST_WINDOW)
    sine = np.empty(count + 1)
    cosine = np.empty(count + 1)
    for k in range(count + 1):
        sine[k] = sin(pi * (k / count))
        cosine[k] = cos(pi * (k / count))
    sine[count] = 0.0
    cosine[count] = -1.0
    window = half / count
    rows = base_rows(frequency_ratio)
    if energies is None:
        return SineBase(frequency_ratio, 2.0 * damping_ratio, window, count, sine, cosine, rows, None)
    forms = base_forms(rows, window)
    return SineBase(frequency_ratio, 2.0 * damping_ratio, window, count, sine, cosine, rows, forms)
