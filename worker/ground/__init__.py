"""Responses to ground motion: response of a design to a record, comparison of dampers, and sensitivity to the start."""
