"""Observables of u'' on one segment: ∫u''² and the largest |u''|.

The polynomial of x + s is computed from the forces on the mass, so x'' and s'' do not cancel in u''.
"""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.taylor import acceleration_into, value
from damperlab.worker.solver.observe.energies import GAUSS, GAUSS_NODES, GAUSS_WEIGHTS
from damperlab.worker.solver.observe.meter import ACCELERATION_PEAK, ACCELERATION_SQUARE, Meter
from damperlab.worker.solver.observe.peaks import largest


@kernel
def measure_acceleration(
    meter: Meter, t: float, absolute: Floats, acceleration: Floats, scratch: Floats
) -> None:
    """Add ∫u''² of a segment of length t, and raise the peak of |u''|, if u'' is measured.

    u'' jumps where slip stops or reverses and where the particle meets, joins or leaves a wall. At a jump,
    each of the two adjacent segments uses its own end value, and neither segment includes the impulse between
    the two. The work array `acceleration` receives the coefficients of u''.
    """
    if meter.acceleration is not None:
        add_square(meter, t, absolute, acceleration)
        peak = meter.sums[ACCELERATION_PEAK]
        meter.sums[ACCELERATION_PEAK] = largest(acceleration, 0.0, t, peak, scratch)


@kernel
def add_square(meter: Meter, t: float, absolute: Floats, acceleration: Floats) -> None:
    """Add ∫u''² of a segment of length t, and write the coefficients of u'' into `acceleration`."""
    acceleration_into(absolute, acceleration)
    square = 0.0
    for i in range(GAUSS):
        a = value(acceleration, GAUSS_NODES[i] * t)
        square += GAUSS_WEIGHTS[i] * a * a
    meter.sums[ACCELERATION_SQUARE] += t * square
