"""The linear motion between events: Taylor polynomials and their integrals, first roots, compliant contact."""
