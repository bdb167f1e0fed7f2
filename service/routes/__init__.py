"""The routes of the HTTP service, by noun."""
