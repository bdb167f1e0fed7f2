"""Accuracy and stability of the solver: error against run time, and extreme cases. Imported only on demand."""
