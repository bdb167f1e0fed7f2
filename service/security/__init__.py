"""Who may ask, from where, and what is remembered of it."""
