"""Computation of design points: physics, solver, steady responses, and execution with Dask."""
