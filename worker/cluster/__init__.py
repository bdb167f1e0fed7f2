"""Dask clusters whose workers are local processes, jobs of a batch system, or workers of an existing scheduler."""
