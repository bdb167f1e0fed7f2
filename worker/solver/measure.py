"""What a meter reads on one segment: energies, mean square, time stuck, true peaks of the closed form."""

from math import inf, sqrt

from worker.jit import inlined
from worker.solver.bounds import u_bend, w_bend
from worker.solver.crossing import first_crossing
from worker.solver.forms import LOSS, MEAN, SQUARED, WORK, products, quadratic
from worker.solver.scene import FRICTION_LOSS, PEAK, RELATIVE_PEAK, SQUARE, STUCK, VISCOUS_LOSS, WORK_IN
from worker.solver.shaking import base_bend
from worker.solver.taylor import curvature, rate_into, slope, value

# Gauss–Lobatto on [0, 1], 6 points: exact to degree 9. The four inner nodes, and the weights of ends, outer and inner nodes.
_OUTER, _INNER = sqrt(1.0 / 3.0 + 2.0 * sqrt(7.0) / 21.0), sqrt(1.0 / 3.0 - 2.0 * sqrt(7.0) / 21.0)
_NODES = (0.5 - 0.5 * _OUTER, 0.5 - 0.5 * _INNER, 0.5 + 0.5 * _INNER, 0.5 + 0.5 * _OUTER)
_WEIGHTS = (1.0 / 30.0, (14.0 - sqrt(7.0)) / 60.0, (14.0 + sqrt(7.0)) / 60.0)
_TOP = 13  # 0.4^14/14! = 3e-17: the terms above add nothing to an integral


@inlined
def peaks_at_ends(meter, start, end, sine_start, sine_end, span, u2_most, friction, frequency_ratio):
    """Raise the peaks by the ends of a segment; False where a peak between them may be higher still."""
    u_start = start.v + sine_start
    u_end = end.v + sine_end
    at_ends = max(abs(u_start), abs(u_end))
    peak = max(meter[PEAK], at_ends)
    bulge = 0.125 * u2_most * span * span
    if at_ends + bulge > peak:
        # the slope at one end is beyond the change it can make over the span: no extremum between
        rise = abs(u_end - u_start)
        if rise <= 0.5 * u2_most * span * span:
            return False
    v_ends = max(abs(start.v), abs(end.v))
    relative_peak = max(meter[RELATIVE_PEAK], v_ends)
    if friction is None:  # with friction, |v| peaks only where a segment ends
        w1 = u2_most + frequency_ratio * frequency_ratio
        if (
            v_ends + 0.125 * w1 * span * span > relative_peak
            and abs(end.v - start.v) <= 0.5 * w1 * span * span
        ):
            return False
    meter[PEAK] = peak
    meter[RELATIVE_PEAK] = relative_peak
    return True


@inlined
def measure_window(meter, start, end, offset, held, phase, phase_end, base, medium, friction):
    """Add a whole quiet window to a meter, by the quadratic forms of `forms.py`."""
    sine = phase.first
    cosine = phase.second
    if held:
        f = base.forms
        v = start.v
        meter[WORK_IN] += _work_at_rest(phase, phase_end, medium.compliance, base.frequency_ratio)
        moved = f[0] * sine + f[1] * cosine
        square = f[2] * (sine * sine) + (2.0 * f[3] * (sine * cosine) + f[4] * (cosine * cosine))
        meter[SQUARE] += v * (v * base.window + 2.0 * moved) + square
        meter[STUCK] += base.window
        return
    f = medium.forms
    x = start.v + offset
    p = products(x, start.w, sine, cosine)
    meter[WORK_IN] += quadratic(f, WORK, p)
    meter[VISCOUS_LOSS] += quadratic(f, LOSS, p)
    u = x + sine
    u_rate = start.w + phase.rate
    square = quadratic(f, SQUARED, products(u, u_rate, sine, cosine))
    if friction is not None:
        mean = (f[MEAN] * u + f[MEAN + 1] * u_rate) + (f[MEAN + 2] * sine + f[MEAN + 3] * cosine)
        square += offset * (offset * base.window - 2.0 * mean)
        meter[FRICTION_LOSS] += friction * abs(end.v - start.v)
    meter[SQUARE] += square


@inlined
def _work_at_rest(phase, phase_end, compliance, frequency_ratio):
    """Work of the base on a mass at rest on it: its kinetic energy, at the base's speed, grown."""
    r2 = frequency_ratio * frequency_ratio
    fallen = (phase.position - phase_end.position) * (phase.position + phase_end.position)
    return 0.5 * r2 * fallen / compliance


@inlined
def measure_segment(
    meter,
    start,
    end,
    offset,
    held,
    t,
    phase,
    phase_end,
    base,
    medium,
    friction,
    relative,
    absolute,
    shaken,
):
    """Add one segment of length t, whose polynomials are given, to a meter: Lobatto's rule, whose ends are known."""
    a, b, c, d = _NODES[0] * t, _NODES[1] * t, _NODES[2] * t, _NODES[3] * t
    u0 = start.v + phase.position
    u1 = end.v + phase_end.position
    ua, ub, uc, ud = values(absolute, a, b, c, d)
    ua -= offset
    ub -= offset
    uc -= offset
    ud -= offset
    outer = t * _WEIGHTS[0]
    middle = t * _WEIGHTS[1]
    inner = t * _WEIGHTS[2]
    meter[SQUARE] += outer * (u0 * u0 + u1 * u1) + middle * (ua * ua + ud * ud) + inner * (ub * ub + uc * uc)
    if held:
        meter[WORK_IN] += _work_at_rest(phase, phase_end, medium.compliance, base.frequency_ratio)
        meter[STUCK] += t
        return
    xa, xb, xc, xd = values(relative, a, b, c, d)
    wa, wb, wc, wd = slopes(relative, a, b, c, d)
    sa, sb, sc, sd = slopes(shaken, a, b, c, d)
    w0 = start.w
    w1 = end.w
    two_zeta = base.two_zeta
    meter[VISCOUS_LOSS] += two_zeta * (
        outer * (w0 * w0 + w1 * w1) + middle * (wa * wa + wd * wd) + inner * (wb * wb + wc * wc)
    )
    ends = (two_zeta * w0 + start.v + offset) * phase.rate + (two_zeta * w1 + end.v + offset) * phase_end.rate
    middles = (two_zeta * wa + xa) * sa + (two_zeta * wd + xd) * sd
    inners = (two_zeta * wb + xb) * sb + (two_zeta * wc + xc) * sc
    meter[WORK_IN] -= outer * ends + (middle * middles + inner * inners)
    if friction is not None:
        meter[FRICTION_LOSS] += friction * abs(end.v - start.v)  # w keeps its sign on a segment


@inlined
def values(p, a, b, c, d):
    """Values of a polynomial at four times, side by side."""
    fa = fb = fc = fd = p[_TOP]
    for i in range(_TOP):
        k = p[_TOP - 1 - i]
        fa = fa * a + k
        fb = fb * b + k
        fc = fc * c + k
        fd = fd * d + k
    return fa, fb, fc, fd


@inlined
def slopes(p, a, b, c, d):
    """Slopes of a polynomial at four times, side by side."""
    fa = fb = fc = fd = _TOP * p[_TOP]
    for i in range(_TOP - 1):
        k = (_TOP - 1 - i) * p[_TOP - 1 - i]
        fa = fa * a + k
        fb = fb * b + k
        fc = fc * c + k
        fd = fd * d + k
    return fa, fb, fc, fd


@inlined
def find_peaks(
    meter,
    start,
    end,
    phase,
    phase_end,
    offset,
    held,
    t,
    base,
    medium,
    friction,
    relative,
    absolute,
    scratch,
    w_most,
    u2_most,
):
    """Raise the peaks to the largest |u| and |v| of a segment, true extrema of its polynomials."""
    u_ends = max(abs(start.v + phase.position), abs(end.v + phase_end.position))
    peak = max(meter[PEAK], u_ends)
    if u_ends + 0.125 * u2_most * t * t > peak and abs(absolute[1]) <= t * u2_most:
        most = u_bend(3, held, w_most, u2_most, base, phase, medium.compliance)
        rate_end = end.w + phase_end.rate
        peak = max(peak, _highest(absolute, offset, rate_end, t, most, scratch))
    meter[PEAK] = peak
    relative_peak = max(meter[RELATIVE_PEAK], abs(start.v), abs(end.v))
    if friction is None:  # with friction, |v| peaks only where a segment ends
        if abs(relative[1]) <= t * (u2_most + base_bend(base, phase, 2)):
            most = w_bend(0, w_most, u2_most, base, phase, medium.compliance)
            relative_peak = max(relative_peak, _highest(relative, 0.0, end.w, t, most, scratch))
    meter[RELATIVE_PEAK] = relative_peak


@inlined
def _highest(p, offset, rate_end, t, bend, scratch):
    """Largest |p − offset| at an extremum inside a span; 0 where there is none.

    Parameters
    ----------
    rate_end : float
        Slope at the end of the span.
    bend : float
        Bound on the third derivative.
    """
    rate = p[1]
    curve = 2.0 * p[2]
    if abs(curve) > bend * t:  # the slope is monotone: one extremum where it changes sign, else none
        if rate * rate_end >= 0.0:
            return 0.0
        # a parabola through slope and curvature here and the slope there, then Newton: what is left of the error is its
        # square, and that of the height the square of that
        half = 0.5 * curve
        last = (rate_end - rate - curve * t) / (t * t)
        root = sqrt(max(half * half - last * rate, 0.0))
        at = -rate / (half + root if half > 0.0 else half - root)
        at -= slope(p, at) / curvature(p, at)
        at -= slope(p, at) / curvature(p, at)
        return abs(value(p, at) - offset)
    rate_into(p, 0, scratch)
    sign = 1.0 if rate > 0.0 else -1.0
    at = 0.0
    highest = 0.0
    for _ in range(3):  # the slope has at most three zeros on a window
        at = first_crossing(scratch, sign, at, t, bend)
        if at == inf:
            break
        highest = max(highest, abs(value(p, at) - offset))
        sign = -sign
    return highest
