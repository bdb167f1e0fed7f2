"""A prototype identified from one time history: the table, what is asked of it, and what came out."""
