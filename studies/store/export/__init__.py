"""Forms of a cube for others: as one file, over a network, for Zarr itself."""
