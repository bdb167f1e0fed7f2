"""Parameters of a prototype estimated from a time history."""
