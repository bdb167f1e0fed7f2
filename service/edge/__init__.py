"""Handling of HTTP connections: limits on connections, heads and bodies, and reliable delivery of answers."""
