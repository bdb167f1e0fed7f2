"""Largest |u| and |v| of a segment, from its polynomials alone."""

from math import inf

from damperlab.worker.jit import inlined, kernel
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import curvature_bound, rate_into, value
from damperlab.worker.solver.observe.meter import PEAK, RELATIVE_PEAK, Meter
from damperlab.worker.solver.scene import Curves, Scene

_MOST_EXTREMA = 8  # largest number of extrema in one segment, which is shorter than a tenth of a period


@inlined
def raised(
    peak: float, polynomial: Floats, less: float, rate: Floats, t: float, rate_curvature: float
) -> float:
    """Return the largest of `peak` and all extrema of |polynomial − less| inside a segment of length t.

    `rate` contains the coefficients of the derivative of the polynomial, and `rate_curvature` is a bound on
    the second derivative of `rate`.
    """
    sign = 1.0 if rate[0] > 0.0 else -1.0
    at = 0.0
    for _ in range(_MOST_EXTREMA):
        at = first_crossing(rate, sign, at, t, rate_curvature)
        if at == inf:
            break
        peak = max(peak, abs(value(polynomial, at) - less))
        sign = -sign
    return peak


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
