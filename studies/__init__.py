"""What is asked and what is answered: studies, plans, cubes and queries; no compiler, no cluster, no web."""
