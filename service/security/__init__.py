"""Access: who may send requests, from where, and the audit log."""
