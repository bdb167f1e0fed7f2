"""Computing a design point: physics, solver, steady states, and the interface to Dask."""
