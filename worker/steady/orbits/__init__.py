"""Periodic orbits that a run may tend to."""
