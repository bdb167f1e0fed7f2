"""Contact of particle and structure: transitions at events, and compliant walls in `compliant`."""
