"""Event-driven solver: the motion between events is linear and exact, and events are roots of Taylor polynomials."""
