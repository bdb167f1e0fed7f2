"""One study from its claim to its end."""
