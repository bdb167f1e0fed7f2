"""Contact of particle and structure: transitions at events on rigid walls; `compliant` covers compliant walls."""
