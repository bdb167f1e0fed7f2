"""Computes answers in processes with time limits, and divides the processes fairly between callers."""
