"""Functions that answer questions about the cube of a study.

Each function takes a Dataset and returns a Dataset.
"""
