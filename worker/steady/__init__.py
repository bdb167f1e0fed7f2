"""Steady responses: found, measured, classified."""
