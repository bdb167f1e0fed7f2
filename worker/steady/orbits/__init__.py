"""Periodic orbits to which a run may tend."""
