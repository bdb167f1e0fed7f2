"""The edge of HTTP: connections that may not last for ever, heads and bodies that may not grow, answers that arrive."""
