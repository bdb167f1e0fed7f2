"""The linear motion between events: Taylor polynomials, the propagator of a panel, first roots, extrema."""
