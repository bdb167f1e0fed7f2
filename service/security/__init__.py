"""Access: callers, origins, and the audit log."""
