"""Proofs that a span is free of events, and the first event otherwise."""
