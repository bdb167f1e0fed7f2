"""Identification of a prototype from one time history: the table, the question, and the result."""
