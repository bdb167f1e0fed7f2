"""Computation of design points: physics, solver, steady responses, and the connection to Dask."""
