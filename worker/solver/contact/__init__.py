"""Contact of particle and structure: what an event changes, on rigid walls; `compliant` for walls that give way."""
