"""The event-driven solver. It is exact between events, and locates events on Taylor polynomials of the closed form."""
