"""Questions to a cube: Dataset in, Dataset out, one question per file."""
