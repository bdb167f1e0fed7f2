"""The paper's own method (its Figure 2), for comparison: fixed-step Runge–Kutta, impacts noticed at the ends of steps.

Its error is of first order in the step wherever there is an event: a step straddles the turn or the impact, and the
particle is already beyond the wall when the impact is noticed.
"""

from math import cos, pi, sin

import numpy as np

from worker.jit import kernel
from worker.physics.impact import rebound
from worker.solver.scene import IMPACTS, TURNS

PHASE, DISPLACEMENT, VELOCITY, PARTICLE, PARTICLE_RATE = 0, 1, 2, 3, 4


@kernel
def _acceleration(phase, v, w, frequency_ratio, two_zeta, friction):
    """v'' of equation (1) in relative form, with sgn(0) = 0 as in equation (2)."""
    acceleration = frequency_ratio * frequency_ratio * sin(phase) - two_zeta * w - v
    if friction is not None:
        if w > 0.0:
            acceleration -= friction
        elif w < 0.0:
            acceleration += friction
    return acceleration


@kernel
def march_rk4(damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, cycles, counts, peaks):
    """March from rest with a fixed step.

    Parameters
    ----------
    damping_ratio, frequency_ratio : float
        ζ and r.
    friction : float or None
        γ_F.
    particle : Particle or None
        The particle.
    steps_per_cycle : int
        400 in the paper: 0.001 s at 2.5 Hz.
    cycles : int
        Excitation cycles.
    counts : int64 array, shape (COUNTS,)
        Impacts and sign changes of v', added to.
    peaks : float64 array, shape (cycles, 2)
        Filled with the largest sampled |u| and |v| of each cycle.

    Returns
    -------
    tuple of float
        u, u', p, p' at the end.
    """
    r = frequency_ratio
    two_zeta = 2.0 * damping_ratio
    h = 2.0 * pi / (r * steps_per_cycle)
    v = 0.0
    w = -r
    p = 0.0
    p_rate = 0.0
    for cycle in range(cycles):
        peak = 0.0
        relative_peak = 0.0
        for step in range(steps_per_cycle):
            start = 2.0 * pi * step / steps_per_cycle
            middle = 2.0 * pi * (step + 0.5) / steps_per_cycle
            end = 2.0 * pi * (step + 1) / steps_per_cycle
            a1 = _acceleration(start, v, w, r, two_zeta, friction)
            w2 = w + 0.5 * h * a1
            a2 = _acceleration(middle, v + 0.5 * h * w, w2, r, two_zeta, friction)
            w3 = w + 0.5 * h * a2
            a3 = _acceleration(middle, v + 0.5 * h * w2, w3, r, two_zeta, friction)
            w4 = w + h * a3
            a4 = _acceleration(end, v + h * w3, w4, r, two_zeta, friction)
            v += h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
            w_before = w
            w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            if w_before * w < 0.0:
                counts[TURNS] += 1
            u = v + sin(end)
            if particle is not None:
                p += h * p_rate
                u_rate = w + r * cos(end)
                gap = u - p
                outward = (u_rate - p_rate) * gap > 0.0
                if abs(gap) >= particle.clearance_ratio and outward:
                    jump, p_rate = rebound(u_rate, p_rate, particle.restitution, particle.mass_ratio)
                    w += jump
                    counts[IMPACTS] += 1
            peak = max(peak, abs(u))
            relative_peak = max(relative_peak, abs(v))
        peaks[cycle, 0] = peak
        peaks[cycle, 1] = relative_peak
    return v, w + r, p, p_rate


def empty_peaks(cycles: int) -> np.ndarray:
    """Room for the peaks of a number of cycles."""
    return np.empty((cycles, 2))
