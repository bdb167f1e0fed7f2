"""The exact map across a panel without events."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.worker.jit import kernel
from damperlab.worker.solver.excitation.excitation import amplitudes
from damperlab.worker.solver.motion.quadratic_forms import motion_forms
from damperlab.worker.solver.motion.taylor import TERMS, motion_rows, slope, value


class LinearMotion(NamedTuple):
    """The linear motion of the primary mass, alone or with the particle in sustained contact.

    Attributes
    ----------
    compliance : float
        κ, the inverse of the inertia.
    xx … wc : float
        Coefficients of the map from (x, w, sin φ, cos φ) at the start of a panel to x and w at its end.
    relative_rows, absolute_rows : array, shape (4 · TERMS,)
        Taylor coefficients of x and of x + s: one row each for unit x₀, w₀, sin φ and cos φ.
    forms : array, shape (3 · PAIRS + 4,), or None
        Integrals over a panel (`quadratic_forms.motion_forms`); None if no meter needs energies.
    """

    compliance: float
    xx: float
    xw: float
    xs: float
    xc: float
    wx: float
    ww: float
    ws: float
    wc: float
    relative_rows: NDArray[np.float64]
    absolute_rows: NDArray[np.float64]
    forms: NDArray[np.float64] | None


@kernel
def make_linear_motion(base: Any, inertia: float, energies: bool | None) -> LinearMotion:
    """Make the linear motion with a given inertia; `forms` is None if `energies` is None."""
    h, two_zeta = base.window, base.two_zeta
    displacement, force = amplitudes(base)
    relative, absolute = motion_rows(two_zeta, 1.0 / inertia, base.rows, displacement, force)
    forms = None
    if energies is not None:
        forms = motion_forms(two_zeta, base.rows, displacement, force, relative, absolute, h)
    return LinearMotion(
        1.0 / inertia,
        value(relative[0 * TERMS : 1 * TERMS], h),
        value(relative[1 * TERMS : 2 * TERMS], h),
        value(relative[2 * TERMS : 3 * TERMS], h),
        value(relative[3 * TERMS : 4 * TERMS], h),
        slope(relative[0 * TERMS : 1 * TERMS], h),
        slope(relative[1 * TERMS : 2 * TERMS], h),
        slope(relative[2 * TERMS : 3 * TERMS], h),
        slope(relative[3 * TERMS : 4 * TERMS], h),
        relative,
        absolute,
        forms,
    )
