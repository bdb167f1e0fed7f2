"""Parameters of a prototype estimated from its measured response."""
