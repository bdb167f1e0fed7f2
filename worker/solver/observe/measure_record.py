"""Observables on one segment of the response to a record: energies, squares, and the peaks of u, v and u''."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.detection.bounds import u_derivative_bound, w_curvature_bound, w_rate_bound
from damperlab.worker.solver.excitation.excitation import expand_base
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.taylor import ORDER, rate_into, slope, value
from damperlab.worker.solver.observe.measure_rubbing import measure_rubbing
from damperlab.worker.solver.observe.meter import (
    ACCELERATION_PEAK,
    ACCELERATION_SQUARE,
    FRICTION_LOSS,
    PEAK,
    RELATIVE_PEAK,
    RELATIVE_SQUARE,
    SQUARE,
    STUCK,
    VISCOUS_LOSS,
    WORK_IN,
    Meter,
)
from damperlab.worker.solver.observe.quadrature import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene


@inlined
def measure_segment(meter: Meter, segment: Segment, scene: Scene, curves: Curves) -> None:
    """Add energies and squares of one segment, and raise the peaks, from the polynomials of the segment."""
    sums, base, regime, phase, t = meter.sums, scene.base, segment.regime, segment.phase, segment.time
    start, end, offset, motion, u2 = (
        segment.start,
        segment.end,
        regime.offset,
        regime.motion,
        segment.bounds.u2,
    )
    relative, absolute, of_base, scratch = curves
    expand_base(base, phase, of_base)
    work = 0.0
    loss = 0.0
    square = 0.0
    relative_square = 0.0
    acceleration_square = 0.0
    for i in range(GAUSS):
        at = GAUSS_NODES[i] * t
        x = relative[0]
        w = 0.0
        acceleration = phase.first + phase.second * at
        if not regime.sticks:
            x = value(relative, at)
            w = slope(relative, at)
            acceleration = -motion.compliance * (base.two_zeta * w + x)
        v = x - offset
        u = v + value(of_base, at)
        work += GAUSS_WEIGHTS[i] * acceleration * slope(of_base, at)
        loss += GAUSS_WEIGHTS[i] * w * w
        square += GAUSS_WEIGHTS[i] * u * u
        relative_square += GAUSS_WEIGHTS[i] * v * v
        acceleration_square += GAUSS_WEIGHTS[i] * acceleration * acceleration
    sums[WORK_IN] += t * work / motion.compliance  # includes the work on a particle in sustained contact
    measure_rubbing(meter, segment, scene)
    sums[VISCOUS_LOSS] += t * base.two_zeta * loss
    sums[SQUARE] += t * square
    sums[RELATIVE_SQUARE] += t * relative_square
    sums[ACCELERATION_SQUARE] += t * acceleration_square
    if scene.friction is not None:
        if regime.sticks:
            sums[STUCK] += t
        else:
            sums[FRICTION_LOSS] += scene.friction * abs(end.v - start.v)  # w keeps its sign on a segment
    bulge = 0.125 * t * t
    ends = max(abs(start.v + phase.position), abs(end.v + value(of_base, t)))
    peak = max(sums[PEAK], ends)
    if ends + bulge * u2 > peak and abs(absolute[1]) <= t * u2:
        rate_into(absolute, 0, scratch)
        most = u_derivative_bound(3, segment, base)
        peak = raised(peak, absolute, offset, scratch, t, most)
    sums[PEAK] = peak
    ends = max(abs(start.v), abs(end.v))
    peak = max(sums[RELATIVE_PEAK], ends)
    if scene.friction is None:  # with friction, |v| peaks only where a segment ends
        w1 = w_rate_bound(segment, base)
        if ends + bulge * w1 > peak and abs(relative[1]) <= t * w1:
            rate_into(relative, 0, scratch)
            most = w_curvature_bound(0, segment, base)
            peak = raised(peak, relative, 0.0, scratch, t, most)
    sums[RELATIVE_PEAK] = peak
    first = phase.first
    last = phase.first + phase.second * t
    if not regime.sticks:
        first = -motion.compliance * (base.two_zeta * start.w + relative[0])
        last = -motion.compliance * (base.two_zeta * end.w + value(relative, t))
    ends = max(abs(first), abs(last))
    peak = max(sums[ACCELERATION_PEAK], ends)
    if not regime.sticks:
        most = u_derivative_bound(4, segment, base)
        if ends + bulge * most > peak:
            # u'' = −κ(2ζw + x) from the polynomial of x, because x'' and s'' might nearly cancel
            polynomial = of_base  # the coefficients of s are not needed any more
            for n in range(ORDER):
                polynomial[n] = -motion.compliance * (base.two_zeta * (n + 1) * relative[n + 1] + relative[n])
            polynomial[ORDER] = 0.0
            rate_into(polynomial, 0, scratch)
            most = u_derivative_bound(5, segment, base)
            peak = raised(peak, polynomial, 0.0, scratch, t, most)
    sums[ACCELERATION_PEAK] = peak
