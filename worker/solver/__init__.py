"""Event-driven solver: exact linear motion between events, which are roots of Taylor polynomials."""
