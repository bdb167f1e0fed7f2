"""Clusters: our own processes, jobs of a batch system, or an existing scheduler."""
