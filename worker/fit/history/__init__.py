"""Estimation of the parameters of a prototype from a time history."""
