"""The edge of HTTP: limits on connections, heads and bodies, and reliable delivery of answers."""
