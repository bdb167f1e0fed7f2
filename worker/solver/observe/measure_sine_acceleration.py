"""Observables of u'' on one segment under a harmonic excitation, on request: ∫u''² and the largest |u''|."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.detection.bounds import u_derivative_bound
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.taylor import acceleration_into, rate_into, value
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, ACCELERATION_SQUARE, Meter
from damperlab.worker.solver.observe.quadrature import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS
from damperlab.worker.solver.regime import Segment
from damperlab.worker.solver.scene import Curves, Scene


@inlined
def measure_acceleration(meter: Meter, segment: Segment, scene: Scene, curves: Curves) -> None:
    """Add ∫u''² of a segment and raise the peak of |u''|, overwriting the polynomial of the excitation.

    u'' jumps where slip stops or reverses and where the particle meets, joins or leaves a wall. At such a time, each of
    the two adjacent segments uses its own end value, and neither includes the impulse between them.
    """
    sums, base, t = meter.sums, scene.base, segment.time
    acceleration, scratch = curves.excitation, curves.scratch
    acceleration_into(curves.absolute, acceleration)
    square = 0.0
    for i in range(GAUSS):
        a = value(acceleration, GAUSS_NODES[i] * t)
        square += GAUSS_WEIGHTS[i] * a * a
    sums[ACCELERATION_SQUARE] += t * square
    ends = max(abs(acceleration[0]), abs(value(acceleration, t)))
    peak = max(sums[ACCELERATION_PEAK], ends)
    curvature = u_derivative_bound(4, segment, base)
    if ends + 0.125 * t * t * curvature > peak and abs(acceleration[1]) <= t * curvature:
        rate_into(acceleration, 0, scratch)
        peak = raised(peak, acceleration, 0.0, scratch, t, u_derivative_bound(5, segment, base))
    sums[ACCELERATION_PEAK] = peak
