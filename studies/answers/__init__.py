"""Functions that answer questions about the cube of a study. Each takes a Dataset and returns a Dataset."""
