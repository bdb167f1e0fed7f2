"""Reuse of the points of earlier studies, prediction of run times, and comparison between solvers."""
