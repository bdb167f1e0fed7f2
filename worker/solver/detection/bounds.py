"""Bounds on the motion across the rest of a window, from its start alone: what makes it safe to skip a search."""

from damperlab.worker.jit import inlined
from damperlab.worker.solver.excitation.base import base_bend


@inlined
def motion_bounds(x, w, span, base, phase, compliance):
    """Largest |x|, |w| and |u''| over a span of slip.

    Parameters
    ----------
    x, w : float
        Start, relative to the base and to the shifted spring centre.
    span : float
        Length, at most a window (`propagator.LARGEST_WINDOW`), so that the denominator below stays above 0.5.

    Returns
    -------
    x_most, w_most, acceleration_most : float

    Notes
    -----
    |w(t)| ≤ |w₀| + T (κ(2ζ W + X) + max |s''|) and |x(t)| ≤ |x₀| + T W, solved for W.
    """
    two_zeta = base.two_zeta
    shaken = base_bend(base, phase, 2)
    w_most = (abs(w) + span * (compliance * abs(x) + shaken)) / (1.0 - compliance * span * (two_zeta + span))
    x_most = abs(x) + span * w_most
    return x_most, w_most, compliance * (two_zeta * w_most + x_most)


@inlined
def u_bend(order, held, w_most, u2_most, base, phase, compliance):
    """Bound on the derivative of u of an order from 2 to 5 over the same span, by differentiating the motion."""
    two_zeta = base.two_zeta
    if held:
        return base_bend(base, phase, order)
    if order == 2:
        return u2_most
    w1 = u2_most + base_bend(base, phase, 2)
    u3 = compliance * (two_zeta * w1 + w_most)
    if order == 3:
        return u3
    w2 = u3 + base_bend(base, phase, 3)
    u4 = compliance * (two_zeta * w2 + w1)
    if order == 4:
        return u4
    w3 = u4 + base_bend(base, phase, 4)
    return compliance * (two_zeta * w3 + w2)


@inlined
def w_bend(dropped, w_most, u2_most, base, phase, compliance):
    """Bound on the second derivative of w/t^dropped (0 or 1) over the same span: 2/(dropped + 2)! of that of w."""
    if dropped == 0:
        return u_bend(3, False, w_most, u2_most, base, phase, compliance) + base_bend(base, phase, 3)
    return (u_bend(4, False, w_most, u2_most, base, phase, compliance) + base_bend(base, phase, 4)) / 3.0
