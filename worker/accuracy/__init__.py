"""How accurate the solver is and how stable: error against run time, extreme cases. Imported only on demand."""
