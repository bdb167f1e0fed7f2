"""Reproduction of the paper: sections that compute its figures and tables again, and their report."""
