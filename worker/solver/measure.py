"""What a meter reads on one segment: energies, mean square, time stuck, true peaks of the closed form."""

from math import inf

from worker.jit import kernel
from worker.solver.bounds import u_bend, w_bend
from worker.solver.crossing import first_crossing
from worker.solver.scene import FRICTION_LOSS, PEAK, RELATIVE_PEAK, SQUARE, STUCK, VISCOUS_LOSS, WORK_IN
from worker.solver.taylor import rate_into, slope, value
from worker.solver.windows import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS


@kernel
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


@kernel
def measure_window(meter, start, end, offset, held, sine, cosine, base, medium, friction):
    """Add a whole quiet window to a meter, from constant rows at the quadrature points."""
    r = base.frequency_ratio
    x0 = start.v + offset
    w0 = start.w
    work = 0.0
    loss = 0.0
    square = 0.0
    for i in range(GAUSS):
        g = base.gauss
        position = g[4 * i] * sine + g[4 * i + 1] * cosine
        rate = g[4 * i + 2] * sine + g[4 * i + 3] * cosine
        if held:
            x = x0
            w = 0.0
            transmitted = -r * r * position / medium.compliance
        else:
            m = medium.gauss
            j = 8 * i
            x = (m[j] * x0 + m[j + 1] * w0) + (m[j + 2] * sine + m[j + 3] * cosine)
            w = (m[j + 4] * x0 + m[j + 5] * w0) + (m[j + 6] * sine + m[j + 7] * cosine)
            transmitted = -(base.two_zeta * w + x)
        u = x - offset + position
        work += GAUSS_WEIGHTS[i] * transmitted * rate
        loss += GAUSS_WEIGHTS[i] * w * w
        square += GAUSS_WEIGHTS[i] * u * u
    t = base.window
    meter[WORK_IN] += t * work
    meter[VISCOUS_LOSS] += t * base.two_zeta * loss
    meter[SQUARE] += t * square
    if friction is not None:
        if held:
            meter[STUCK] += t
        else:
            meter[FRICTION_LOSS] += friction * abs(end.v - start.v)


@kernel
def measure_segment(meter, moved, offset, held, t, base, medium, friction, relative, shaken):
    """Add one segment of length t, whose polynomials are given and over which v changes by `moved`, to a meter."""
    r = base.frequency_ratio
    work = 0.0
    loss = 0.0
    square = 0.0
    for i in range(GAUSS):
        at = GAUSS_NODES[i] * t
        position = value(shaken, at)
        x = relative[0]
        w = 0.0
        if held:
            transmitted = -r * r * position / medium.compliance
        else:
            x = value(relative, at)
            w = slope(relative, at)
            transmitted = -(base.two_zeta * w + x)
        u = x - offset + position
        work += GAUSS_WEIGHTS[i] * transmitted * slope(shaken, at)
        loss += GAUSS_WEIGHTS[i] * w * w
        square += GAUSS_WEIGHTS[i] * u * u
    meter[WORK_IN] += t * work
    meter[VISCOUS_LOSS] += t * base.two_zeta * loss
    meter[SQUARE] += t * square
    if friction is not None:
        if held:
            meter[STUCK] += t
        else:
            meter[FRICTION_LOSS] += friction * abs(moved)  # w keeps its sign on a segment


@kernel
def find_peaks(
    meter,
    start,
    end,
    sine,
    sine_end,
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
    r = base.frequency_ratio
    u_ends = max(abs(start.v + sine), abs(end.v + sine_end))
    peak = max(meter[PEAK], u_ends)
    if u_ends + 0.125 * u2_most * t * t > peak and abs(absolute[1]) <= t * u2_most:
        rate_into(absolute, 0, scratch)
        most = u_bend(3, held, w_most, u2_most, base.two_zeta, medium.compliance, r)
        sign = 1.0 if absolute[1] > 0.0 else -1.0
        at = 0.0
        for _ in range(3):  # u' has at most three zeros on a window
            at = first_crossing(scratch, sign, at, t, most)
            if at == inf:
                break
            peak = max(peak, abs(value(absolute, at) - offset))
            sign = -sign
    meter[PEAK] = peak
    relative_peak = max(meter[RELATIVE_PEAK], abs(start.v), abs(end.v))
    if friction is None:  # with friction, |v| peaks only where a segment ends
        if abs(relative[1]) <= t * (u2_most + r * r):
            rate_into(relative, 0, scratch)
            most = w_bend(0, w_most, u2_most, base.two_zeta, medium.compliance, r)
            sign = 1.0 if relative[1] > 0.0 else -1.0
            at = 0.0
            for _ in range(3):
                at = first_crossing(scratch, sign, at, t, most)
                if at == inf:
                    break
                relative_peak = max(relative_peak, abs(value(relative, at)))
                sign = -sign
    meter[RELATIVE_PEAK] = relative_peak
