"""Definitions and answers: studies, plans, cubes and queries; no compiler, no cluster, no web."""
