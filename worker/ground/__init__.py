"""Responses to ground motion: one design under one record, beside a tuned mass damper, and how sure they are."""
