"""Accuracy and stability of the solver: error against run time, extreme cases. Imported only on demand."""
