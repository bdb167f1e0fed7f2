"""First crossing of zero by a smooth function, certain not to miss one whatever the sampling.

An interval is dismissed only when a bound on the curvature proves that the function stays positive on it, and handed to
Newton only when the same bound proves that it is monotone there; everything else is halved. Two roots close together
(a grazing impact) are told from none down to the rounding of the function itself.
"""

from math import inf

from worker.jit import kernel
from worker.solver.taylor import ORDER

_FINEST = 1e-9  # relative width below which curvature moves the function by less than its rounding
_MAX_STEPS = 400


@kernel
def _value_and_slope(polynomial, first, t):
    """q(t) and q'(t) of q = Σ polynomial[i] t^(i − first), i ≥ first."""
    f = polynomial[ORDER]
    d = 0.0
    for i in range(ORDER - 1, first - 1, -1):
        d = d * t + f
        f = f * t + polynomial[i]
    return f, d


@kernel
def _newton(polynomial, first, sign, low, high, t):
    """Root in [low, high] of a function that falls monotonically through zero there: Newton, kept in its bracket."""
    width = high - low
    for _ in range(60):
        f, d = _value_and_slope(polynomial, first, t)
        f *= sign
        d *= sign
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
        if step * step <= 1e-17 * t * width:
            return t
    return t


@kernel
def first_crossing(polynomial, first, sign, start, end, curvature):
    """First time in (start, end] at which sign · q falls through zero.

    Parameters
    ----------
    polynomial : array, shape (ORDER + 1,)
        Coefficients of p(t) = t^first · q(t).
    first : int
        Number of leading coefficients that are zero by the event that came before (contact just opened, slip just
        began). Dividing by t^first removes the trivial root, so that a short flight is not lost in rounding.
    sign : float
        ±1: the function is sign · q and is positive, or zero and rising, just after `start`.
    start, end : float
        Search interval.
    curvature : float
        Bound on |q''| over the interval.

    Returns
    -------
    float
        The time; inf where there is none; `start` where the function is already negative.
    """
    if start == 0.0:
        q0 = sign * polynomial[first]
        q1 = sign * polynomial[first + 1]
        if q0 < 0.0 or (q0 == 0.0 and q1 < 0.0):
            return 0.0
        if q0 + min(0.0, q1 * end) - 0.5 * curvature * end * end > 0.0:
            return inf
    else:
        q0, q1 = _value_and_slope(polynomial, first, start)
        q0 *= sign
        q1 *= sign
    low = start
    high = end
    if q1 < 0.0:  # a first bracket just beyond the root of the tangent: short flights need no halving
        guess = start - 1.5 * q0 / q1
        if guess < high:
            high = guess
            if high <= low:
                return low
    finest = _FINEST * (end - start)
    for _ in range(_MAX_STEPS):
        middle = 0.5 * (low + high)
        radius = 0.5 * (high - low)
        f, d = _value_and_slope(polynomial, first, middle)
        f *= sign
        d *= sign
        slack = 0.5 * curvature * radius * radius
        clear = f - abs(d) * radius - slack > 0.0
        if not clear and abs(d) > curvature * radius:
            if d > 0.0:
                clear = True
            else:
                at_high, _slope = _value_and_slope(polynomial, first, high)
                if sign * at_high > 0.0:
                    clear = True
                else:
                    return _newton(polynomial, first, sign, low, high, min(max(middle - f / d, low), high))
        if not clear and radius <= finest:
            at_high, _slope = _value_and_slope(polynomial, first, high)
            if sign * at_high < 0.0:
                return high
            clear = True  # a touch within rounding is no crossing
        if clear:
            if high >= end:
                return inf
            low = high
            high = min(end, low + 4.0 * radius)
        else:
            high = middle
    return inf
