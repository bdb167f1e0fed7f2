"""Maintenance of a store: verify, sweep, back up, rebuild."""
