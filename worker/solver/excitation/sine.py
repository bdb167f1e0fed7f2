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


class Sine(NamedTuple):
    """A harmonic excitation over half a cycle: a base displacement s or a force, equal to sin φ.

    Lengths are divided by the amplitude Z of the base or, under a force of amplitude F₀, by F₀/k. A force and
    a shaken base differ only in their amplitudes, so one kernel serves both.

    Attributes
    ----------
    frequency_ratio, two_zeta : float
        r and 2ζ.
    displacement, velocity, acceleration : float
        Amplitudes of s, s' and s'': 1, r and r², or 0 under a force.
    force : float
        Amplitude of the force: 1, or 0 on a shaken base.
    window : float
        Length of a panel [1/ω_n].
    windows : int
        Panels per half cycle.
    sine, cosine : array, shape (windows + 1,)
        sin φ and cos φ at the panel ends.
    rows : array, shape (2 · TERMS,)
        Taylor coefficients of cos(r t) and sin(r t), the factors of sin φ and cos φ in sin(φ + r t).
    forms : array, shape (5,), or None
        Integrals of the sine over a panel (`quadratic_forms.base_forms`); None if no meter needs energies.
    """

    frequency_ratio: float
    two_zeta: float
    displacement: float
    velocity: float
    acceleration: float
    force: float
    window: float
    windows: int
    sine: NDArray[np.float64]
    cosine: NDArray[np.float64]
    rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


@inlined
def base_rate_at_phase_zero(frequency_ratio: float, forced: bool) -> float:
    """s' at phase 0; 0 under a force, because the base is at rest."""
    return 0.0 if forced else frequency_ratio


@kernel
def make_sine(
    damping_ratio: float, frequency_ratio: float, energies: bool | None, forced: bool = False
) -> Sine:
    """Divide half a cycle into the fewest panels of a length h with h · (1 + ζ) · max(1, r) ≤ LARGEST_WINDOW.

    The arguments are those of `scene.make_scene`.
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
    forms = None
    if energies is not None:
        forms = base_forms(rows, window)
    displacement, force = (0.0, 1.0) if forced else (1.0, 0.0)
    r, two_zeta = frequency_ratio, 2.0 * damping_ratio
    velocity = displacement * r
    acceleration = velocity * r
    return Sine(
        r, two_zeta, displacement, velocity, acceleration, force, window, count, sine, cosine, rows, forms
    )
