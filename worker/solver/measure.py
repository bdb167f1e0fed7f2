"""What a meter reads on one segment: energies, mean square, time stuck, true peaks of the closed form."""

from math import inf

import numpy as np

from worker.jit import kernel
from worker.solver.bounds import derivative_bounds, motion_bounds
from worker.solver.crossing import first_crossing
from worker.solver.scene import FRICTION_LOSS, PEAK, RELATIVE_PEAK, SQUARE, STUCK, VISCOUS_LOSS, WORK_IN
from worker.solver.taylor import derivative_into, slope, value

# Gauss–Legendre on [0, 1], 5 points: exact to degree 9, error below 1e-13 of the integrand on the longest window.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_NODES = 0.5 * (_NODES + 1.0)
_WEIGHTS = 0.5 * _WEIGHTS


@kernel
def measure(meter, state, t, base, medium, friction, shaken, relative, absolute, scratch):
    """Add one segment of length t, whose polynomials are given, to a meter."""
    r = base.frequency_ratio
    held = False
    offset = 0.0
    if friction is not None:
        held = state.slip == 0.0
        offset = state.slip * friction
    inertia = 1.0 / medium.compliance
    work = 0.0
    loss = 0.0
    square = 0.0
    for i in range(_NODES.size):
        at = _NODES[i] * t
        base_position = value(shaken, at)
        x = value(relative, at)
        w = 0.0
        if held:
            transmitted = -inertia * r * r * base_position
        else:
            w = slope(relative, at)
            transmitted = -(base.two_zeta * w + x)
        u = x - offset + base_position
        work += _WEIGHTS[i] * transmitted * slope(shaken, at)
        loss += _WEIGHTS[i] * w * w
        square += _WEIGHTS[i] * u * u
    meter[WORK_IN] += t * work
    meter[VISCOUS_LOSS] += t * base.two_zeta * loss
    meter[SQUARE] += t * square
    v_end = value(relative, t)
    if friction is not None:
        if held:
            meter[STUCK] += t
        else:
            meter[FRICTION_LOSS] += friction * abs(v_end - relative[0])  # w keeps its sign on a segment
    _find_peaks(meter, t, v_end, held, offset, base, medium, friction, shaken, relative, absolute, scratch)


@kernel
def _find_peaks(meter, t, x_end, held, offset, base, medium, friction, shaken, relative, absolute, scratch):
    """Raise the peaks of |u| and |v| to the largest on this segment."""
    r = base.frequency_ratio
    u_start = absolute[0] - offset
    u_end = x_end - offset + value(shaken, t)
    peak = max(meter[PEAK], abs(u_start), abs(u_end))
    relative_peak = max(meter[RELATIVE_PEAK], abs(relative[0] - offset), abs(x_end - offset))
    if held:
        u2 = r * r
        u3 = u2 * r
        w2 = 0.0
    else:
        x_most, w_most, u2 = motion_bounds(relative[0], relative[1], t, base.two_zeta, medium.compliance, r)
        u3, _u4, _u5, w2, _w3, _w4 = derivative_bounds(
            x_most, w_most, u2, base.two_zeta, medium.compliance, r
        )
    if max(abs(u_start), abs(u_end)) + 0.125 * u2 * t * t > peak or abs(absolute[1]) <= t * u2:
        derivative_into(absolute, 1, scratch)
        sign = 1.0 if absolute[1] > 0.0 else -1.0
        at = 0.0
        for _ in range(3):  # u' has at most three zeros on a window
            at = first_crossing(scratch, 0, sign, at, t, u3)
            if at == inf:
                break
            peak = max(peak, abs(value(absolute, at) - offset))
            sign = -sign
    meter[PEAK] = peak
    if friction is None:  # with friction, |v| peaks only where a segment ends
        if abs(relative[1]) <= t * (u2 + r * r):
            derivative_into(relative, 1, scratch)
            sign = 1.0 if relative[1] > 0.0 else -1.0
            at = 0.0
            for _ in range(3):
                at = first_crossing(scratch, 0, sign, at, t, w2)
                if at == inf:
                    break
                relative_peak = max(relative_peak, abs(value(relative, at)))
                sign = -sign
    meter[RELATIVE_PEAK] = relative_peak
