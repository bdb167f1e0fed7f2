"""Steady responses: search, measurement and classification."""
