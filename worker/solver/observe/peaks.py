"""Largest |u| and |v| of a segment, from its polynomials alone."""

from damperlab.worker.jit import kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.extrema import raised
from damperlab.worker.solver.motion.taylor import curvature_bound, rate_into, value
from damperlab.worker.solver.observe.meter import PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.scene import Curves, Scene


@kernel
def largest(polynomial: Floats, offset: float, t: float, peak: float, scratch: Floats) -> float:
    """Return the larger of `peak` and the largest |p − offset| over [0, t]."""
    ends = max(abs(polynomial[0] - offset), abs(value(polynomial, t) - offset))
    peak = max(peak, ends)
    curvature = curvature_bound(polynomial, t)
    if ends + 0.125 * t * t * curvature <= peak or abs(polynomial[1]) > t * curvature:
        return peak
    rate_into(polynomial, 0, scratch)
    most = curvature_bound(scratch, t)
    return raised(peak, polynomial, offset, scratch, t, most)


@kernel
def raise_peaks(meter: Meter, t: float, offset: float, scene: Scene, curves: Curves) -> None:
    """Raise the peaks of |u| and |v| to the largest values of a segment of length t."""
    sums, scratch = meter.sums, curves.scratch
    sums[PEAK] = largest(curves.absolute, offset, t, sums[PEAK], scratch)
    if scene.friction is None:
        sums[RELATIVE_PEAK] = largest(curves.relative, offset, t, sums[RELATIVE_PEAK], scratch)
    else:  # with friction, |v| peaks only where a segment ends
        ends = max(abs(curves.relative[0] - offset), abs(value(curves.relative, t) - offset))
        sums[RELATIVE_PEAK] = max(sums[RELATIVE_PEAK], ends)
