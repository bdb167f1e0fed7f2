"""Identification of a prototype: the measurement, known values, parameters to estimate, and the result."""
