"""Accuracy and stability of the solver: error against run time, and extreme cases.

This package is imported only on demand.
"""
