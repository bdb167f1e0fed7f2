"""Response of a structure with a tuned mass damper to a ground motion, integrated exactly from sample to sample."""

import math

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.absorber import Absorber

STEPS = 40
"""Smallest number of steps per period of the structure. A peak is then at most (π/40)²/2 = 0.3 % above the samples."""
STROKE = "peak_stroke_m"
"""Name of the largest displacement of the absorber relative to the structure. Suites have no such variable."""


def measures_under(
    absorber: Absorber,
    damping_ratio: float,
    angular_frequency: float,
    motion: GroundMotion,
    scale: float,
    tail_s: float,
) -> dict[str, float]:
    """Compute peaks and rms values of the response to a record.

    Parameters
    ----------
    absorber : Absorber
        The tuned mass damper. An absorber without mass has no effect.
    damping_ratio, angular_frequency : float
        ζ and ω_n [rad/s] of the structure.
    motion : GroundMotion
        Motion of the base, whose acceleration is linear between samples.
    scale, tail_s : float
        Factor by which the record is multiplied, and duration of the free vibration after the record [s].

    Returns
    -------
    dict of float
        Results in SI units, by the names of a ground-motion suite's variables and `STROKE`.
    """
    from scipy.linalg import expm  # the light client imports this module, and has no scipy

    ground = scale * motion.acceleration_m_s2
    parts = max(1, math.ceil(motion.step_s * angular_frequency * STEPS / (2.0 * math.pi)))
    step = motion.step_s / parts
    places = np.arange((ground.size - 1) * parts + 1) / parts
    base = np.interp(places, np.arange(ground.size), ground)
    # after the record the base moves at constant velocity
    base = np.concatenate([base, np.zeros(round(tail_s / step))])
    system, row = linear_system(absorber, damping_ratio, angular_frequency)
    # time is in units of the step, so the slope of the base acceleration is its change per step
    system = system * step
    system[6, 7] = 1.0
    advance = expm(system)[:6]
    states = np.zeros((base.size, 6))
    inputs = np.column_stack([base[:-1], np.diff(base)]) @ advance[:, 6:].T
    free = advance[:, :6].T
    for k in range(base.size - 1):
        states[k + 1] = states[k] @ free + inputs[k]
    results = {
        "relative_displacement_m": states[:, 0],
        "absolute_displacement_m": states[:, 0] + states[:, 4],
        "absolute_acceleration_m_s2": states @ row[:6],
    }
    weights = np.full(base.size, 1.0)
    weights[[0, -1]] = 0.5
    peaks = {f"peak_{name}": float(np.abs(each).max()) for name, each in results.items()}
    rms = {
        f"rms_{name}": math.sqrt(float(np.average(each**2, weights=weights)))
        for name, each in results.items()
    }
    return {STROKE: float(np.abs(states[:, 2]).max()), **peaks, **rms}


def linear_system(
    absorber: Absorber, damping_ratio: float, omega: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the matrix of the equations of motion, (8, 8), and the row that gives x'' from the unknowns, (8,).

    x'' is the absolute acceleration of the structure. The unknowns are v and v' of the structure relative to the base,
    q and q' of the absorber relative to the structure, and displacement, velocity, acceleration a and jerk of the base.
    The equations are v'' = x'' − a, x'' = −2ζωv' − ω²v + μ(2ζ_aγωq' + γ²ω²q), and q'' = −(2ζ_aγωq' + γ²ω²q) − x''.
    """
    link = np.zeros(8)
    own = absorber.tuning * omega
    link[[2, 3]] = own**2, 2.0 * absorber.damping_ratio * own
    row = absorber.mass_ratio * link
    row[[0, 1]] = -(omega**2), -2.0 * damping_ratio * omega
    matrix = np.zeros((8, 8))
    matrix[[0, 2, 4, 5, 6], [1, 3, 5, 6, 7]] = 1.0
    matrix[1], matrix[3] = row, -link - row
    matrix[1, 6] = -1.0
    return matrix, row
