"""Reuse of earlier studies: their points, the run times of their blocks, and differences between solvers."""
