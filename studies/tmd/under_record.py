"""The structure with a tuned mass damper under a ground motion. The system is linear, so it is integrated exactly from
sample to sample.
"""

import math

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.tmd.absorber import Absorber

STEPS = 40
"""Fewest steps per period of the structure: an extremum at its frequency is then at most (π/40)²/2 = 0.3 % above the
samples.
"""
STROKE = "peak_stroke_m"
"""Largest displacement of the absorber against the structure. It is not a variable of a suite, whose dampers have a
clearance instead.
"""


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
        The tuned mass damper; without mass it has no effect.
    damping_ratio, angular_frequency : float
        ζ and ω_n [rad/s] of the structure.
    motion : GroundMotion
        Of the base; linear between samples.
    scale, tail_s : float
        Factor on the record, and free vibration after it [s].

    Returns
    -------
    dict of float
        By the names of a ground-motion suite's variables, and `STROKE`, in SI units.
    """
    from scipy.linalg import expm  # the light client imports this module, and has no scipy

    ground = scale * motion.acceleration_m_s2
    parts = max(1, math.ceil(motion.step_s * angular_frequency * STEPS / (2.0 * math.pi)))
    step = motion.step_s / parts
    places = np.arange((ground.size - 1) * parts + 1) / parts
    base = np.interp(places, np.arange(ground.size), ground)
    # after the record the base has no acceleration: it continues at its final velocity
    base = np.concatenate([base, np.zeros(round(tail_s / step))])
    system, row = linear_system(absorber, damping_ratio, angular_frequency)
    # in units of the step, so that the slope is per step
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
    """Give the matrix of the motion, (8, 8), and the row that gives the absolute acceleration x'' from the unknowns,
    (8,).

    Unknowns are v and v' of the structure against its base, q and q' of the absorber against the structure, and
    displacement, velocity, acceleration and jerk of the base. The equations are v'' = x'' − a with
    x'' = −2ζωv' − ω²v + μ(2ζ_aγωq' + γ²ω²q), and q'' = −(2ζ_aγωq' + γ²ω²q) − x''.
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
