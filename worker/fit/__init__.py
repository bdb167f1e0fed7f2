"""Estimation of the parameters of a prototype from its measured response."""
