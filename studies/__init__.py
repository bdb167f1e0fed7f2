"""Studies, plans, cubes and queries, without compiler, cluster and web."""
