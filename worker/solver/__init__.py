"""The event-driven solver: exact between events, events located on Taylor polynomials of the closed form."""
