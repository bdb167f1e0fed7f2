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
def derivative_bounds(x_most, w_most, acceleration_most, two_zeta, compliance, frequency_ratio):
    """Largest |u'''|, |u''''|, |u'''''| and |w''|, |w'''|, |w''''| over the same span, by differentiating the motion."""
    r2 = frequency_ratio * frequency_ratio
    w1 = acceleration_most + r2
    u3 = compliance * (two_zeta * w1 + w_most)
    w2 = u3 + r2 * frequency_ratio
    u4 = compliance * (two_zeta * w2 + w1)
    w3 = u4 + r2 * r2
    u5 = compliance * (two_zeta * w3 + w2)
    w4 = u5 + r2 * r2 * frequency_ratio
    return u3, u4, u5, w2, w3, w4
