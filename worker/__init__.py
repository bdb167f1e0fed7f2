"""How a design point is computed: physics, solver, steady states, and the Dask door."""
