"""What a meter reads on one segment: true peaks of the closed form, time stuck, and where asked energies and mean square."""

from math import sqrt
from typing import Any, NamedTuple

from damperlab.worker.jit import inlined
from damperlab.worker.solver.detection.bounds import u_bend, w_bend
from damperlab.worker.solver.excitation.base import base_bend
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.quadratic_forms import LOSS, MEAN, SQUARED, WORK, products, quadratic
from damperlab.worker.solver.motion.taylor import curvature, rate_into, slope, value
from damperlab.worker.solver.state import (
    FRICTION_LOSS,
    PEAK,
    RELATIVE_PEAK,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
)

# Gauss–Lobatto on [0, 1], 6 points: exact to degree 9. The four inner nodes, and the weights of ends, outer and inner nodes.
_OUTER, _INNER = sqrt(1.0 / 3.0 + 2.0 * sqrt(7.0) / 21.0), sqrt(1.0 / 3.0 - 2.0 * sqrt(7.0) / 21.0)
_NODES = (0.5 - 0.5 * _OUTER, 0.5 - 0.5 * _INNER, 0.5 + 0.5 * _INNER, 0.5 + 0.5 * _OUTER)
_WEIGHTS = (1.0 / 30.0, (14.0 - sqrt(7.0)) / 60.0, (14.0 + sqrt(7.0)) / 60.0)
_TOP = 13  # 0.4^14/14! = 3e-17: the terms above add nothing to an integral


class Segment(NamedTuple):
    """A stretch of the march without an event inside.

    Attributes
    ----------
    start, end : State
        At its ends.
    phase, phase_end : Phase
        The base there.
    held : bool
        Whether friction holds the mass.
    offset : float
        Of the centre of the motion: ±γ_F in slip, else 0.
    span : float
        Length [1/ω_n].
    w_most, u2_most : float
        Bounds on |w| and |u''|.
    """

    start: Any
    end: Any
    phase: Any
    phase_end: Any
    held: bool
    offset: float
    span: float
    w_most: float
    u2_most: float


class Curves(NamedTuple):
    """Addresses of the polynomials of a segment, TERMS coefficients each: of x, of x + s, of s, and one to work in."""

    relative: Any
    absolute: Any
    shaken: Any
    scratch: Any


@inlined
def peaks_at_ends(sums, segment, friction, frequency_ratio):
    """Raise the peaks by the ends of a segment; False where a peak between them may be higher still."""
    v_start = segment.start.v
    v_end = segment.end.v
    u_start = v_start + segment.phase.position
    u_end = v_end + segment.phase_end.position
    at_ends = max(abs(u_start), abs(u_end))
    peak = max(sums[PEAK], at_ends)
    half = 0.5 * segment.span * segment.span
    # the slope at one end is beyond the change it can make over the span: no extremum between
    bulge = half * segment.u2_most
    if at_ends + 0.25 * bulge > peak and abs(u_end - u_start) <= bulge:
        return False
    v_ends = max(abs(v_start), abs(v_end))
    relative_peak = max(sums[RELATIVE_PEAK], v_ends)
    if friction is None:  # with friction, |v| peaks only where a segment ends
        bulge = half * (segment.u2_most + frequency_ratio * frequency_ratio)
        if v_ends + 0.25 * bulge > relative_peak and abs(v_end - v_start) <= bulge:
            return False
    sums[PEAK] = peak
    sums[RELATIVE_PEAK] = relative_peak
    return True


@inlined
def measure_window(sums, energies, segment, base, medium, friction):
    """Add a whole quiet window to a meter, by the quadratic forms of `quadratic_forms.py`; its peaks are not looked at."""
    if segment.held:
        sums[STUCK] += base.window
    if energies is not None:
        start, offset = segment.start, segment.offset
        sine = segment.phase.first
        cosine = segment.phase.second
        if segment.held:
            f = base.forms
            v = start.v
            sums[WORK_IN] += _work_at_rest(segment, medium.compliance, base.frequency_ratio)
            moved = f[0] * sine + f[1] * cosine
            square = f[2] * (sine * sine) + (2.0 * f[3] * (sine * cosine) + f[4] * (cosine * cosine))
            sums[SQUARE] += v * (v * base.window + 2.0 * moved) + square
            return
        f = medium.forms
        x = start.v + offset
        p = products(x, start.w, sine, cosine)
        sums[WORK_IN] += quadratic(f, WORK, p)
        sums[VISCOUS_LOSS] += quadratic(f, LOSS, p)
        u = x + sine
        u_rate = start.w + segment.phase.rate
        square = quadratic(f, SQUARED, products(u, u_rate, sine, cosine))
        if friction is not None:
            mean = (f[MEAN] * u + f[MEAN + 1] * u_rate) + (f[MEAN + 2] * sine + f[MEAN + 3] * cosine)
            square += offset * (offset * base.window - 2.0 * mean)
            sums[FRICTION_LOSS] += friction * abs(segment.end.v - start.v)
        sums[SQUARE] += square


@inlined
def _work_at_rest(segment, compliance, frequency_ratio):
    """Work of the base on a mass at rest on it: its kinetic energy, at the base's speed, grown."""
    r2 = frequency_ratio * frequency_ratio
    before = segment.phase.position
    after = segment.phase_end.position
    fallen = (before - after) * (before + after)
    return 0.5 * r2 * fallen / compliance


@inlined
def measure_part(sums, energies, segment, base, medium, friction, curves):
    """Add a segment that is no whole window to a meter: Lobatto's rule, whose ends are known; no peaks."""
    t = segment.span
    if segment.held:
        sums[STUCK] += t
    if energies is not None:
        start, end, offset = segment.start, segment.end, segment.offset
        rate = segment.phase.rate
        rate_end = segment.phase_end.rate
        a, b, c, d = _NODES[0] * t, _NODES[1] * t, _NODES[2] * t, _NODES[3] * t
        u0 = start.v + segment.phase.position
        u1 = end.v + segment.phase_end.position
        ua, ub, uc, ud = values(curves.absolute, a, b, c, d)
        ua -= offset
        ub -= offset
        uc -= offset
        ud -= offset
        outer = t * _WEIGHTS[0]
        middle = t * _WEIGHTS[1]
        inner = t * _WEIGHTS[2]
        sums[SQUARE] += (
            outer * (u0 * u0 + u1 * u1) + middle * (ua * ua + ud * ud) + inner * (ub * ub + uc * uc)
        )
        if segment.held:
            sums[WORK_IN] += _work_at_rest(segment, medium.compliance, base.frequency_ratio)
            return
        xa, xb, xc, xd = values(curves.relative, a, b, c, d)
        wa, wb, wc, wd = slopes(curves.relative, a, b, c, d)
        sa, sb, sc, sd = slopes(curves.shaken, a, b, c, d)
        w0 = start.w
        w1 = end.w
        two_zeta = base.two_zeta
        sums[VISCOUS_LOSS] += two_zeta * (
            outer * (w0 * w0 + w1 * w1) + middle * (wa * wa + wd * wd) + inner * (wb * wb + wc * wc)
        )
        ends = (two_zeta * w0 + start.v + offset) * rate + (two_zeta * w1 + end.v + offset) * rate_end
        middles = (two_zeta * wa + xa) * sa + (two_zeta * wd + xd) * sd
        inners = (two_zeta * wb + xb) * sb + (two_zeta * wc + xc) * sc
        sums[WORK_IN] -= outer * ends + (middle * middles + inner * inners)
        if friction is not None:
            sums[FRICTION_LOSS] += friction * abs(end.v - start.v)  # w keeps its sign on a segment


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
def find_peaks(sums, segment, base, medium, friction, curves):
    """Raise the peaks to the largest |u| and |v| of a segment, true extrema of its polynomials."""
    start, end, held, t = segment.start, segment.end, segment.held, segment.span
    u_ends = max(abs(start.v + segment.phase.position), abs(end.v + segment.phase_end.position))
    peak = max(sums[PEAK], u_ends)
    if u_ends + 0.125 * segment.u2_most * t * t > peak and abs(curves.absolute[1]) <= t * segment.u2_most:
        most = u_bend(3, held, segment.w_most, segment.u2_most, base, segment.phase, medium.compliance)
        rate_end = end.w + segment.phase_end.rate
        peak = max(peak, _highest(curves.absolute, segment.offset, rate_end, t, most, curves.scratch))
    sums[PEAK] = peak
    relative_peak = max(sums[RELATIVE_PEAK], abs(start.v), abs(end.v))
    if friction is None:  # with friction, |v| peaks only where a segment ends
        if abs(curves.relative[1]) <= t * (segment.u2_most + base_bend(base, segment.phase, 2)):
            most = w_bend(0, segment.w_most, segment.u2_most, base, segment.phase, medium.compliance)
            highest = _highest(curves.relative, 0.0, end.w, t, most, curves.scratch)
            relative_peak = max(relative_peak, highest)
    sums[RELATIVE_PEAK] = relative_peak


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
    return raised(0.0, p, offset, scratch, t, bend)
