"""Identification of a prototype from one time history: the table, the definition of the fit, and the result."""
