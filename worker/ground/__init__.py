"""Responses to ground motion: one design under one record, comparison with a tuned mass damper, and sensitivity."""
