"""Studies, plans, cubes and queries. This package needs no compiler, no cluster and no web framework."""
