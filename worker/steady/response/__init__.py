"""Measures of a steady response, and the errors of these measures."""
