"""Extrema of a displacement inside a segment."""

from math import inf

from damperlab.worker.jit import inlined
from damperlab.worker.solver.addresses import Floats
from damperlab.worker.solver.motion.first_root import first_crossing
from damperlab.worker.solver.motion.taylor import value

_MOST = 8  # largest number of extrema in one segment, which is shorter than a tenth of a period


@inlined
def raised(
    peak: float, polynomial: Floats, less: float, rate: Floats, t: float, rate_curvature: float
) -> float:
    """Return the largest of `peak` and all extrema of |polynomial − less| inside a segment.

    Parameters
    ----------
    peak : float
        Largest value so far.
    polynomial, rate : array, shape (TERMS,)
        Coefficients of the displacement, and of its rate.
    less : float
        Constant that is subtracted from the displacement.
    t : float
        Length of the segment.
    rate_curvature : float
        Bound on the rate's second derivative.
    """
    sign = 1.0 if rate[0] > 0.0 else -1.0
    at = 0.0
    for _ in range(_MOST):
        at = first_crossing(rate, sign, at, t, rate_curvature)
        if at == inf:
            break
        peak = max(peak, abs(value(polynomial, at) - less))
        sign = -sign
    return peak
