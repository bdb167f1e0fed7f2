"""Access control: hosts, origins, callers, rate limits, and the audit log."""
