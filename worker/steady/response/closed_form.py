"""Steady response of a structure without damper, in closed form."""

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.portable import exp
from damperlab.studies.variables import ResponseClass, Status

Values = NDArray[np.float64]


def linear_response(
    damping_ratio: Values, frequency_ratio: Values, forced: bool = False
) -> dict[str, np.ndarray]:
    """Return all result variables of points without a damper, at which neither friction nor a particle acts.

    Parameters
    ----------
    damping_ratio, frequency_ratio : ndarray, shape (N,)
        ζ and r.
    forced : bool
        Whether the excitation is a force on the structure instead of a shaken base. Lengths are then relative to F₀/k.

    Returns
    -------
    dict of ndarray, shape (N,)
        All variables except run_time and the variables of an ensemble. For ζ = 0 at r = 1, the status is UNBOUNDED and
        the values are NaN.

    Notes
    -----
    Let H = r²/(1 − r² + 2iζr). The relative amplitude is |H|, and the absolute amplitude is |1 + H| =
    √[(1+(2ζr)²)/((1−r²)²+(2ζr)²)]. Input work and viscous loss per cycle, over k Z², are computed separately, and the
    residual compares the two. Under a force, the numerator of H is 1, and both amplitudes are |H|. An amplitude from
    the closed form is accurate to a few rounding errors.
    """
    r = frequency_ratio
    loss = 2.0 * damping_ratio * r
    detuning = (1.0 - r) * (1.0 + r)  # accurate near r = 1
    bottom = np.hypot(detuning, loss)
    bounded = bottom > 0.0
    bottom = np.where(bounded, bottom, np.nan)
    if forced:
        relative = 1.0 / bottom
        amplitude = relative
        work_in = np.pi * loss / bottom**2
    else:
        relative = r * r / bottom
        amplitude = np.hypot(1.0, loss) / bottom
        # the force that the base transmits is −(2ζv' + v); its component in phase with s' does the work
        work_in = np.pi * loss * (r * r) ** 2 / bottom**2
    viscous = np.pi * loss * relative**2
    stored = 0.5 * (relative**2 + (r * amplitude) ** 2)
    residual = np.abs(work_in - viscous) / np.maximum(work_in, stored)
    zero = np.where(bounded, 0.0, np.nan)
    count = r.shape
    return {
        "amplitude_ratio": amplitude,
        "amplitude_ratio_max": amplitude.copy(),
        "amplitude_ratio_rms": amplitude.copy(),
        "relative_amplitude_ratio": relative.copy(),
        "acceleration_ratio": r * r * amplitude,
        "acceleration_ratio_rms": r * r * amplitude,
        "amplitude_error": 8.0 * np.finfo(float).eps * amplitude,
        "energy_residual": residual,
        "response_class": np.where(bounded, ResponseClass.LINEAR, ResponseClass.UNKNOWN).astype(np.int8),
        "period": np.where(bounded, 1, 0).astype(np.int32),
        "floquet_multiplier": np.where(bounded, exp(-2.0 * np.pi * damping_ratio / r), np.nan),
        "impacts_per_cycle": zero,
        "impacts_error": zero.copy(),
        "impact_speed_max": zero.copy(),
        "stick_fraction": zero.copy(),
        "dissipation_per_cycle": viscous,
        "dissipation_viscous": np.where(bounded & (damping_ratio > 0.0), 1.0, zero),
        "dissipation_friction": zero.copy(),
        "dissipation_impact": zero.copy(),
        "dissipation_particle": zero.copy(),
        "dissipation_error": zero.copy(),
        "cycles": np.zeros(count, np.int32),
        "status": np.where(bounded, Status.CONVERGED, Status.UNBOUNDED).astype(np.int8),
    }
