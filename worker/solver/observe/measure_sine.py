"""Observables on one segment under a harmonic excitation: peaks, sticking time, energies and squares."""

from math import sqrt

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.detection.bounds import u_derivative_bound, w_curvature_bound, w_rate_bound
from damperlab.worker.solver.excitation.excitation import has_force
from damperlab.worker.solver.motion.quadratic_forms import LOSS, MEAN, SQUARED, WORK, products, quadratic
from damperlab.worker.solver.motion.taylor import curvature, rate_into, slope, value
from damperlab.worker.solver.observe.meter import (
    FRICTION_LOSS,
    PEAK,
    RELATIVE_PEAK,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.observe.peaks import raised
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene

# Gauss–Lobatto rule on [0, 1] with 6 points, exact to degree 9.
# `_LOBATTO_NODES` are the four nodes between the ends.
# `_LOBATTO_WEIGHTS` are the weights of the ends, of the outer two and of the inner two of these nodes.
_OUTER, _INNER = sqrt(1.0 / 3.0 + 2.0 * sqrt(7.0) / 21.0), sqrt(1.0 / 3.0 - 2.0 * sqrt(7.0) / 21.0)
_LOBATTO_NODES = (0.5 - 0.5 * _OUTER, 0.5 - 0.5 * _INNER, 0.5 + 0.5 * _INNER, 0.5 + 0.5 * _OUTER)
_LOBATTO_WEIGHTS = (1.0 / 30.0, (14.0 - sqrt(7.0)) / 60.0, (14.0 + sqrt(7.0)) / 60.0)
# Order of the last Taylor term used; the next term, 0.4^12/12! = 4e-14, is below the error of the quadrature.
_TOP = 11


@inlined
def peaks_at_ends(meter: Meter, segment: Segment, scene: Scene) -> bool:
    """Raise the peaks to the values at the ends of a segment.

    If a value between the ends may be higher, change nothing and return False.
    """
    sums = meter.sums
    v_start = segment.start.v
    v_end = segment.end.v
    u_start = v_start + segment.phase.position
    u_end = v_end + segment.phase_end.position
    at_ends = max(abs(u_start), abs(u_end))
    peak = max(sums[PEAK], at_ends)
    half = 0.5 * segment.time * segment.time
    # if the displacement changes by more than `bulge`, the slope has no zero in the segment
    bulge = half * segment.bounds.u2
    if at_ends + 0.25 * bulge > peak and abs(u_end - u_start) <= bulge:
        return False
    v_ends = max(abs(v_start), abs(v_end))
    relative_peak = max(sums[RELATIVE_PEAK], v_ends)
    if scene.friction is None:  # with friction, |v| peaks only where a segment ends
        bulge = half * w_rate_bound(segment, scene.base)
        if v_ends + 0.25 * bulge > relative_peak and abs(v_end - v_start) <= bulge:
            return False
    sums[PEAK] = peak
    sums[RELATIVE_PEAK] = relative_peak
    return True


@inlined
def measure_window(meter: Meter, segment: Segment, scene: Scene) -> None:
    """Add a complete panel without events to the sums, but not to the peaks. See `motion.quadratic_forms`."""
    sums, base, regime = meter.sums, scene.base, segment.regime
    if regime.sticks:
        sums[STUCK] += base.window
    if meter.energies is not None:
        start, offset = segment.start, regime.offset
        sine = segment.phase.first
        cosine = segment.phase.second
        if regime.sticks:
            v = start.v
            f = base.forms
            sums[WORK_IN] += _work_at_rest(segment, base.frequency_ratio)
            sine = base.displacement * sine
            cosine = base.displacement * cosine
            moved = f[0] * sine + f[1] * cosine
            square = f[2] * (sine * sine) + (2.0 * f[3] * (sine * cosine) + f[4] * (cosine * cosine))
            sums[SQUARE] += v * (v * base.window + 2.0 * moved) + square
            return
        f = regime.motion.forms
        assert f is not None  # a motion for a meter with energies always has forms
        x = start.v + offset
        p = products(x, start.w, sine, cosine)
        sums[WORK_IN] += quadratic(f, WORK, p)
        sums[VISCOUS_LOSS] += quadratic(f, LOSS, p)
        u = x + segment.phase.position
        u_rate = start.w + segment.phase.rate
        square = quadratic(f, SQUARED, products(u, u_rate, sine, cosine))
        if scene.friction is not None or segment.start.slide is not None:
            mean = (f[MEAN] * u + f[MEAN + 1] * u_rate) + (f[MEAN + 2] * sine + f[MEAN + 3] * cosine)
            square += offset * (offset * base.window - 2.0 * mean)
        if scene.friction is not None:
            sums[FRICTION_LOSS] += scene.friction * abs(segment.end.v - start.v)
        sums[SQUARE] += square


@inlined
def _work_at_rest(segment: Segment, frequency_ratio: float) -> float:
    """Work of the base on a sticking mass: the increase of the kinetic energy of the mass."""
    r2 = frequency_ratio * frequency_ratio
    before = segment.phase.position
    after = segment.phase_end.position
    fallen = (before - after) * (before + after)
    return 0.5 * r2 * fallen / segment.regime.motion.compliance


@inlined
def measure_part(meter: Meter, segment: Segment, scene: Scene, curves: Curves) -> None:
    """Add a part of a panel to the sums, but not to the peaks, by Gauss–Lobatto quadrature."""
    sums, base, regime, t = meter.sums, scene.base, segment.regime, segment.time
    if regime.sticks:
        sums[STUCK] += t
    if meter.energies is not None:
        start, end, offset = segment.start, segment.end, regime.offset
        a, b = _LOBATTO_NODES[0] * t, _LOBATTO_NODES[1] * t
        c, d = _LOBATTO_NODES[2] * t, _LOBATTO_NODES[3] * t
        u0 = start.v + segment.phase.position
        u1 = end.v + segment.phase_end.position
        ua, ub, uc, ud = values(curves.absolute, a, b, c, d)
        ua -= offset
        ub -= offset
        uc -= offset
        ud -= offset
        outer = t * _LOBATTO_WEIGHTS[0]
        middle = t * _LOBATTO_WEIGHTS[1]
        inner = t * _LOBATTO_WEIGHTS[2]
        sums[SQUARE] += (
            outer * (u0 * u0 + u1 * u1) + middle * (ua * ua + ud * ud) + inner * (ub * ub + uc * uc)
        )
        if regime.sticks:
            sums[WORK_IN] += _work_at_rest(segment, base.frequency_ratio)
            return
        xa, xb, xc, xd = values(curves.relative, a, b, c, d)
        wa, wb, wc, wd = slopes(curves.relative, a, b, c, d)
        w0 = start.w
        w1 = end.w
        two_zeta = base.two_zeta
        sums[VISCOUS_LOSS] += two_zeta * (
            outer * (w0 * w0 + w1 * w1) + middle * (wa * wa + wd * wd) + inner * (wb * wb + wc * wc)
        )
        if scene.friction is not None:
            sums[FRICTION_LOSS] += scene.friction * abs(end.v - start.v)  # w keeps its sign on a segment
        if has_force(base):
            fa, fb, fc, fd = values(curves.excitation, a, b, c, d)
            ends = segment.phase.force * w0 + segment.phase_end.force * w1
            sums[WORK_IN] += outer * ends + middle * (fa * wa + fd * wd) + inner * (fb * wb + fc * wc)
            return
        sa, sb, sc, sd = slopes(curves.excitation, a, b, c, d)
        rate, rate_end = segment.phase.rate, segment.phase_end.rate
        ends = (two_zeta * w0 + start.v + offset) * rate + (two_zeta * w1 + end.v + offset) * rate_end
        middles = (two_zeta * wa + xa) * sa + (two_zeta * wd + xd) * sd
        inners = (two_zeta * wb + xb) * sb + (two_zeta * wc + xc) * sc
        sums[WORK_IN] -= outer * ends + (middle * middles + inner * inners)


@inlined
def values(p: Floats, a: float, b: float, c: float, d: float) -> tuple[float, float, float, float]:
    """Values of a polynomial at four times, in parallel."""
    fa = fb = fc = fd = p[_TOP]
    for i in range(_TOP):
        k = p[_TOP - 1 - i]
        fa = fa * a + k
        fb = fb * b + k
        fc = fc * c + k
        fd = fd * d + k
    return fa, fb, fc, fd


@inlined
def slopes(p: Floats, a: float, b: float, c: float, d: float) -> tuple[float, float, float, float]:
    """Slopes of a polynomial at four times, in parallel."""
    fa = fb = fc = fd = _TOP * p[_TOP]
    for i in range(_TOP - 1):
        k = (_TOP - 1 - i) * p[_TOP - 1 - i]
        fa = fa * a + k
        fb = fb * b + k
        fc = fc * c + k
        fd = fd * d + k
    return fa, fb, fc, fd


@inlined
def find_peaks(meter: Meter, segment: Segment, scene: Scene, curves: Curves) -> None:
    """Raise the peaks to the largest |u| and |v| of a segment, at the extrema of its polynomials and at its ends."""
    sums, start, end, t, u2 = meter.sums, segment.start, segment.end, segment.time, segment.bounds.u2
    u_ends = max(abs(start.v + segment.phase.position), abs(end.v + segment.phase_end.position))
    peak = max(sums[PEAK], u_ends)
    if u_ends + 0.125 * u2 * t * t > peak and abs(curves.absolute[1]) <= t * u2:
        most = u_derivative_bound(3, segment, scene.base)
        rate_end = end.w + segment.phase_end.rate
        offset = segment.regime.offset
        peak = max(peak, _highest(curves.absolute, offset, rate_end, t, most, curves.scratch))
    sums[PEAK] = peak
    relative_peak = max(sums[RELATIVE_PEAK], abs(start.v), abs(end.v))
    if scene.friction is None:  # with friction, |v| peaks only where a segment ends
        if abs(curves.relative[1]) <= t * w_rate_bound(segment, scene.base):
            most = w_curvature_bound(0, segment, scene.base)
            highest = _highest(curves.relative, 0.0, end.w, t, most, curves.scratch)
            relative_peak = max(relative_peak, highest)
    sums[RELATIVE_PEAK] = relative_peak


@inlined
def _highest(
    p: Floats, offset: float, rate_end: float, t: float, third_derivative: float, scratch: Floats
) -> float:
    """Largest |p − offset| at an extremum inside a span; 0 if the span contains no extremum.

    Parameters
    ----------
    rate_end : float
        Slope at the end of the span.
    third_derivative : float
        Bound on the modulus of the third derivative of p.
    """
    rate = p[1]
    curve = 2.0 * p[2]
    if abs(curve) > third_derivative * t:  # the slope is monotone
        if rate * rate_end >= 0.0:
            return 0.0
        # The first estimate is the root of a parabola for the slope.
        # The parabola matches slope and curvature at the start, and the slope at the end.
        # Two Newton steps follow, and each step squares the error of the time.
        # The error of the extremum is of second order in the error of the time.
        half = 0.5 * curve
        last = (rate_end - rate - curve * t) / (t * t)
        root = sqrt(max(half * half - last * rate, 0.0))
        at = -rate / (half + root if half > 0.0 else half - root)
        at -= slope(p, at) / curvature(p, at)
        at -= slope(p, at) / curvature(p, at)
        return abs(value(p, at) - offset)
    rate_into(p, 0, scratch)
    return raised(0.0, p, offset, scratch, t, third_derivative)
