"""Reproduction of the paper: sections that compute its figures and tables again, and the complete report."""
