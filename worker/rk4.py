"""The paper's method (Figure 2) for comparison: Runge–Kutta with fixed steps.

An impact is detected at the end of a step, when the particle is already beyond the wall. Each impact and each reversal
causes an error of first order in the step.
"""

from math import cos, pi, sin
from typing import NamedTuple

from damperlab.worker.jit import kernel
from damperlab.worker.physics.compliant_wall import wall_force
from damperlab.worker.physics.impact import rebound
from damperlab.worker.solver.events import IMPACTS, TURNS

PHASE, DISPLACEMENT, VELOCITY, PARTICLE, PARTICLE_RATE = 0, 1, 2, 3, 4


@kernel
def _acceleration(phase, v, w, frequency_ratio, two_zeta, friction):
    """Return v'' from equation (1) in relative form, with sgn(0) = 0 as in equation (2)."""
    acceleration = frequency_ratio * frequency_ratio * sin(phase) - two_zeta * w - v
    if friction is not None:
        if w > 0.0:
            acceleration -= friction
        elif w < 0.0:
            acceleration += friction
    return acceleration


class Stepped(NamedTuple):
    """State between steps: v and v' relative to the base, p and p' in absolute coordinates."""

    v: float
    w: float
    p: float
    p_rate: float


@kernel
def step_rk4(
    state, damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, first, last, counts, peaks
):
    """Integrate the cycles from `first` to `last` − 1.

    Parameters
    ----------
    state : Stepped
        State at the start of a cycle.
    damping_ratio, frequency_ratio : float
        Damping ratio ζ and frequency ratio r.
    friction : float or None
        Friction ratio γ_F; None without friction.
    particle : Particle or None
        Particle; None without a particle.
    steps_per_cycle : int
        Number of steps per cycle. The paper uses 400, which is a step of 0.001 s at 2.5 Hz.
    first, last : int
        First cycle, and the cycle after the last.
    counts : int64 array, shape (COUNTS,)
        Event counts, to which the impacts and the sign changes of v' are added.
    peaks : float64 array, shape (at least 2 last + 1, 2)
        Output array for the largest |u| and |v| at the steps of each half cycle, in rows 2 first + 1 to 2 last.

    Returns
    -------
    Stepped
        Final state.
    """
    r = frequency_ratio
    two_zeta = 2.0 * damping_ratio
    h = 2.0 * pi / (r * steps_per_cycle)
    v, w, p, p_rate = state
    for cycle in range(first, last):
        peaks[2 * cycle + 1 : 2 * cycle + 3, :] = 0.0
        for step in range(steps_per_cycle):
            half = 2 * cycle + (1 if 2 * step < steps_per_cycle else 2)
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
            peaks[half, 0] = max(peaks[half, 0], abs(u))
            peaks[half, 1] = max(peaks[half, 1], abs(v))
    return Stepped(v, w, p, p_rate)


@kernel
def march_rk4(damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, cycles, counts, peaks):
    """Integrate a number of cycles from rest, with parameters as in `step_rk4`.

    Returns
    -------
    tuple of float
        u, u', p, p' at the end.
    """
    start = Stepped(0.0, -frequency_ratio, 0.0, 0.0)
    v, w, p, p_rate = step_rk4(
        start, damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, 0, cycles, counts, peaks
    )
    return v, w + frequency_ratio, p, p_rate


@kernel
def _wall_accelerations(phase, v, w, p, p_rate, frequency_ratio, two_zeta, friction, particle):
    """Return v'' and p'' with the force of a compliant wall."""
    acceleration = _acceleration(phase, v, w, frequency_ratio, two_zeta, friction)
    gap = v + sin(phase) - p
    side = 1.0 if gap > 0.0 else -1.0
    closing = side * (w + frequency_ratio * cos(phase) - p_rate)
    depth = abs(gap) - particle.clearance_ratio
    force = side * wall_force(particle.wall.stiffness, particle.wall.damping, depth, closing)
    return acceleration - force, force / particle.mass_ratio


@kernel
def march_rk4_wall(damping_ratio, frequency_ratio, friction, particle, steps_per_cycle, cycles):
    """Integrate a particle between compliant walls from rest, with parameters as in `step_rk4`.

    Returns
    -------
    tuple of float
        u, u', p, p' at the end.
    """
    r = frequency_ratio
    z = 2.0 * damping_ratio
    h = 2.0 * pi / (r * steps_per_cycle)
    v, w, p, q = 0.0, -r, 0.0, 0.0
    for _ in range(cycles):
        for step in range(steps_per_cycle):
            start = 2.0 * pi * step / steps_per_cycle
            middle = 2.0 * pi * (step + 0.5) / steps_per_cycle
            end = 2.0 * pi * (step + 1) / steps_per_cycle
            a1, b1 = _wall_accelerations(start, v, w, p, q, r, z, friction, particle)
            w2, q2 = w + 0.5 * h * a1, q + 0.5 * h * b1
            a2, b2 = _wall_accelerations(
                middle, v + 0.5 * h * w, w2, p + 0.5 * h * q, q2, r, z, friction, particle
            )
            w3, q3 = w + 0.5 * h * a2, q + 0.5 * h * b2
            a3, b3 = _wall_accelerations(
                middle, v + 0.5 * h * w2, w3, p + 0.5 * h * q2, q3, r, z, friction, particle
            )
            w4, q4 = w + h * a3, q + h * b3
            a4, b4 = _wall_accelerations(end, v + h * w3, w4, p + h * q3, q4, r, z, friction, particle)
            v += h / 6.0 * (w + 2.0 * w2 + 2.0 * w3 + w4)
            p += h / 6.0 * (q + 2.0 * q2 + 2.0 * q3 + q4)
            w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            q += h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    return v, w + r, p, q
