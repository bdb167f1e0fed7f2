"""Bounds on the motion across the rest of a window, from its start alone: what makes it safe to skip a search."""

from worker.jit import kernel


@kernel
def motion_bounds(x, w, span, two_zeta, compliance, frequency_ratio):
    """Largest |x|, |w| and |u''| over a span of slip.

    Parameters
    ----------
    x, w : float
        Start, relative to the base and to the shifted spring centre.
    span : float
        Length, at most a window (`windows.LARGEST_WINDOW`), so that the denominator below stays above 0.5.

    Returns
    -------
    x_most, w_most, acceleration_most : float

    Notes
    -----
    |w(t)| ≤ |w₀| + T (κ(2ζ W + X) + r²) and |x(t)| ≤ |x₀| + T W, solved for W.
    """
    square = frequency_ratio * frequency_ratio
    w_most = (abs(w) + span * (compliance * abs(x) + square)) / (1.0 - compliance * span * (two_zeta + span))
    x_most = abs(x) + span * w_most
    return x_most, w_most, compliance * (two_zeta * w_most + x_most)


@kernel
def u_bend(order, held, w_most, u2_most, two_zeta, compliance, frequency_ratio):
    """Bound on the derivative of u of an order from 2 to 5 over the same span, by differentiating the motion."""
    r = frequency_ratio
    if held:
        return r**order
    if order == 2:
        return u2_most
    w1 = u2_most + r * r
    u3 = compliance * (two_zeta * w1 + w_most)
    if order == 3:
        return u3
    w2 = u3 + r * r * r
    u4 = compliance * (two_zeta * w2 + w1)
    if order == 4:
        return u4
    w3 = u4 + r * r * r * r
    return compliance * (two_zeta * w3 + w2)


@kernel
def w_bend(dropped, w_most, u2_most, two_zeta, compliance, frequency_ratio):
    """Bound on the second derivative of w/t^dropped (0, 1 or 2) over the same span: 2/(dropped + 2)! of that of w."""
    r = frequency_ratio
    if dropped == 0:
        return u_bend(3, False, w_most, u2_most, two_zeta, compliance, r) + r * r * r
    if dropped == 1:
        return (u_bend(4, False, w_most, u2_most, two_zeta, compliance, r) + r * r * r * r) / 3.0
    return (u_bend(5, False, w_most, u2_most, two_zeta, compliance, r) + r * r * r * r * r) / 12.0
