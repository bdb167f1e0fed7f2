"""Steady responses: finding, measuring, classifying."""
