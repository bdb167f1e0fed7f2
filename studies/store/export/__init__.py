"""Access to a cube for other programs: as a single file, over a network, or with the library Zarr."""
