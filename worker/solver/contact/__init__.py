"""Contact of particle and structure: transitions at events with rigid walls; compliant walls are in `compliant`."""
