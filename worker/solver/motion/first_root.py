"""First zero crossing of a smooth function, located by bounds on its curvature instead of by samples.

An interval is dismissed only if a bound on the curvature proves that the function stays positive in this
interval. Newton's method is used only if the same bound proves that the function is monotone in the interval.
Every other interval is halved. Two close roots (a grazing impact) are found if the function between them is
below zero by more than rounding. If three or more roots coincide within rounding, a later root may be
returned.
"""

from math import inf, sqrt

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.taylor import curvature_bound, slope, value

# Relative width of an interval in which curvature changes the function by less than the rounding error.
_FINEST = 1e-9
_MAX_STEPS = 400
_FEW_STEPS = 32  # most searches need no more steps; later steps use a bound over a shorter interval


@inlined
def _newton(polynomial: Floats, sign: float, low: float, high: float, t: float) -> float:
    """Find the root in [low, high] of a monotonically falling function, by Newton's method within this bracket."""
    width = high - low
    for _ in range(60):
        f = sign * value(polynomial, t)
        d = sign * slope(polynomial, t)
        if f > 0.0:
            low = t
        else:
            high = t
        if f == 0.0:
            return t
        t_next = t - f / d
        if not (low <= t_next <= high):
            t_next = 0.5 * (low + high)
            if t_next in (low, high):
                return high
        step = t_next - t
        t = t_next
        # |curvature| · width ≤ 2 |slope| on a monotone bracket, so the next error is at most step²/width
        if step * step <= 1e-16 * t * width:
            return t
    return t


@inlined
def first_crossing(polynomial: Floats, sign: float, start: float, end: float, curvature: float) -> float:
    """First time in [start, end] at which sign · p falls through zero.

    Parameters
    ----------
    polynomial : array, shape (TERMS,)
        Coefficients of p. If the previous event (contact just opened, slip just begun) made the lowest coefficients
        zero, the caller drops these coefficients first. Otherwise a root soon after the trivial root at 0 would be
        missed.
    sign : float
        ±1. The function sign · p is positive, or zero and rising, just after `start`.
    start, end : float
        Search interval.
    curvature : float
        Bound on |p''| over the interval.

    Returns
    -------
    float
        Time of the crossing; inf if there is no crossing; 0 if `start` is 0 and the function is negative there, or zero
        and falling.

    Notes
    -----
    At most 400 intervals are examined. Motions within a panel need only a few intervals, but a cluster of
    four or five roots in a hundredth of the interval would need more than 400. If 400 intervals are not
    sufficient, the result is `end` if the function is negative at `end`, else inf.
    """
    if start == 0.0:
        f0 = sign * polynomial[0]
        d0 = sign * polynomial[1]
        if f0 < 0.0 or (f0 == 0.0 and d0 < 0.0):
            return 0.0
        if f0 + min(0.0, d0 * end) - 0.5 * curvature * end * end > 0.0:
            return inf
    else:
        f0 = sign * value(polynomial, start)
        d0 = sign * slope(polynomial, start)
    # The given bound follows from the size of the motion.
    # Where the function is small, the bound from its coefficients is far sharper.
    curvature = min(curvature, curvature_bound(polynomial, end))
    low = start
    high = end
    # the first bracket ends just beyond the root of tangent or parabola, so that short flights need no halving
    if d0 < 0.0:
        high = min(high, start - 1.5 * f0 / d0)
    elif start == 0.0 and sign * polynomial[2] < 0.0:
        falling = -2.0 * sign * polynomial[2]
        high = min(high, 1.5 * (d0 + sqrt(d0 * d0 + 2.0 * falling * f0)) / falling)
    if high <= low:
        return low
    finest = _FINEST * (high - low)
    local = curvature
    for step in range(_MAX_STEPS):
        if step >= _FEW_STEPS:
            local = min(curvature, curvature_bound(polynomial, high))
        middle = 0.5 * (low + high)
        radius = 0.5 * (high - low)
        f = sign * value(polynomial, middle)
        d = sign * slope(polynomial, middle)
        turning = local * radius  # largest change of the slope from the middle
        clear = f - (abs(d) + 0.5 * turning) * radius > 0.0
        if not clear and abs(d) > turning:
            if d > 0.0:
                clear = True
            else:
                guess = middle - f / d  # root of the tangent
                # The root is inside, because f(high) <= f + d radius + curvature radius²/2 < 0.
                # So the function need not be evaluated at the end.
                if guess + 0.5 * turning * radius / abs(d) < high:
                    return _newton(polynomial, sign, low, high, max(guess, low))
                if sign * value(polynomial, high) > 0.0:
                    clear = True
                else:
                    return _newton(polynomial, sign, low, high, min(max(guess, low), high))
        if not clear and radius <= finest:
            if sign * value(polynomial, high) < 0.0:
                return high
            clear = True  # a touch within rounding is not a crossing
        if clear:
            if high >= end:
                return inf
            low = high
            high = min(end, low + 4.0 * radius)
        else:
            high = middle
    # the function is zero within rounding in the remaining interval, so the sign at its end decides
    return end if sign * value(polynomial, end) < 0.0 else inf


@inlined
def first_beyond(polynomial: Floats, offset: float, limit: float, end: float, curvature: float) -> float:
    """First time in [0, end] at which |p + offset| exceeds a limit; inf if there is no such time.

    `curvature` is a bound on |p''| over the interval. The lowest coefficient of p is changed.
    """
    polynomial[0] += offset + limit
    below = first_crossing(polynomial, 1.0, 0.0, end, curvature)
    polynomial[0] -= 2.0 * limit
    return min(below, first_crossing(polynomial, -1.0, 0.0, min(below, end), curvature))
