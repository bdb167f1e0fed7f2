"""The harmonically shaken base over half a cycle, cut into equal windows.

Half a cycle is enough: mirrored (every sign of the mechanics flipped), the second half is the first. So the phase starts
at 0 again and again, and no digit is ever lost in sin(rτ) for large τ.
"""

from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.memory import address, address_if
from damperlab.worker.solver.motion.quadratic_forms import base_forms
from damperlab.worker.solver.motion.taylor import base_rows

LARGEST_WINDOW = 0.4
"""Longest window in units of the faster of structure and excitation, for ζ → 0: keeps the Taylor remainder below rounding."""


class SineBase(NamedTuple):
    """The shaken base over half a cycle.

    Attributes
    ----------
    frequency_ratio, two_zeta : float
        r and 2ζ.
    window : float
        Length of a window [1/ω_n].
    windows : int
        Windows per half cycle.
    sine, cosine : array, shape (windows + 1,)
        sin φ and cos φ at the window ends.
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of s for sin φ = 1 and for cos φ = 1.
    forms : array, shape (5,), or None
        Integrals over a window (`quadratic_forms.base_forms`); None where no meter asks for energies.
    """

    frequency_ratio: float
    two_zeta: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


@kernel
def make_sine_base(damping_ratio: float, frequency_ratio: float, energies: bool | None) -> SineBase:
    """Windows of half a cycle for ζ and r; window · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    energies : True or None
        As of the `state.Meter` of the march.
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


@inlined
def sine_base_on_addresses(base: SineBase) -> SineBase:
    """The same base with addresses for arrays; the arrays must outlive it."""
    return SineBase(
        base.frequency_ratio,
        base.two_zeta,
        base.window,
        base.windows,
        address(base.sine, 0),
        address(base.cosine, 0),
        address(base.rows, 0),
        address_if(base.forms),
    )
