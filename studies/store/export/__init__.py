"""Forms in which other programs read a cube: as one file, over a network, or by Zarr itself."""
