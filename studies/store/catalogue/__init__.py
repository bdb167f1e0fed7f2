"""The catalogue of a store: its tables, their rows, whose they are, and what they may take."""
