"""Search for the first event in a span, and proofs that a span contains no event."""
